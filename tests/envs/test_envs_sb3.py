"""Stable-Baselines3 takes the environments as they are, and a batch as a faster DummyVecEnv."""

import sys
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.env_checker import check_env  # noqa: E402
from stable_baselines3.common.evaluation import evaluate_policy  # noqa: E402
from stable_baselines3.common.monitor import Monitor  # noqa: E402
from stable_baselines3.common.vec_env import DummyVecEnv  # noqa: E402

from refusals import refused  # noqa: E402
from tegotae.envs import ENVIRONMENTS, make_sb3  # noqa: E402

NAME = "tegotae/TegotaeHopper-v0"
SETTINGS = {"duration_s": 1.2, "decimation": 30, "height_m": (1.1, 6.0), "omega": (6.0, 10.0)}
LANES, STEPS = 5, 100
ACTIONS = np.random.default_rng(0).uniform(-0.4, 0.4, (STEPS, LANES, 1)).astype(np.float32)


@pytest.mark.parametrize("name", list(ENVIRONMENTS))
def test_its_checker_passes_the_single_environments_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, render_mode="rgb_array"), skip_render_check=False)


def test_batch_is_step_by_step_what_a_dummy_vec_env_does():
    ours = make_sb3(NAME, LANES, **SETTINGS)
    theirs = DummyVecEnv([lambda: Monitor(gymnasium.make(NAME, **SETTINGS))] * LANES)
    ours.seed(7)
    theirs.seed(7)
    np.testing.assert_array_equal(ours.reset(), theirs.reset())
    finished = 0
    for actions in ACTIONS:
        observation, reward, process, infos = ours.step(actions)
        observation_, reward_, done_, infos_ = theirs.step(actions)
        np.testing.assert_allclose(observation, observation_, atol=1e-5)
        np.testing.assert_allclose(reward, reward_, atol=1e-5)
        np.testing.assert_array_equal(process, done_)
        for lane in np.flatnonzero(process):
            mine, second = infos[lane], infos_[lane]
            np.testing.assert_allclose(
                mine["terminal_observation"], second["terminal_observation"], atol=1e-5
            )
            assert mine["TimeLimit.truncated"] == second["TimeLimit.truncated"]
            assert mine["episode"]["l"] == second["episode"]["l"]
            assert mine["episode"]["r"] == pytest.approx(second["episode"]["r"], abs=1e-4)
            for message, value in mine["telemetry"].items():
                assert value == pytest.approx(second[message], abs=1e-4), message
        finished += process.sum()
    assert finished > 5


def test_batch_trains_and_evaluates_an_agent():
    envs = make_sb3(NAME, 4, **SETTINGS)
    agent = PPO("MlpPolicy", envs, n_steps=64, batch_size=64, n_epochs=1, device="cpu", seed=0)
    agent.learn(256)
    assert agent.ep_info_buffer is not None
    assert len(agent.ep_info_buffer) > 0
    mean, _ = evaluate_policy(agent, envs, n_eval_episodes=4)
    assert np.isfinite(mean)


def test_options_and_seeds_are_spent_by_one_reset():
    envs = make_sb3("tegotae/Hopper-v0", 3, observation=("height",), height_m=(1.1, 1.2))
    envs.set_options({"height_m": 1.5})
    np.testing.assert_array_equal(envs.reset(), np.full((3, 1), 1.5, np.float32))
    envs.seed(5)
    first = envs.reset()
    envs.seed(5)
    np.testing.assert_array_equal(envs.reset(), first)
    assert not np.array_equal(envs.reset(), first)
    assert first.max() <= 1.2


def test_attributes_are_those_of_the_batch():
    envs = make_sb3("tegotae/Hopper-v0", 3, render_mode="rgb_array")
    assert envs.get_attr("render_mode") == ["rgb_array"] * 3
    assert envs.has_attr("settings")
    assert not envs.has_attr("no_such_thing")
    envs.set_attr("note", 1)
    assert envs.get_attr("note", [0, 2]) == [1, 1]
    envs.reset()
    assert envs.render().shape == (512, 512, 3)
    envs.close()


@pytest.mark.parametrize(
    ("act", "says"),
    [
        (lambda envs: envs.step(np.zeros((2, 1))), r"must be \(3, 1\)"),
        (lambda envs: envs.set_attr("note", 1, indices=0), "share their attributes"),
        (lambda envs: envs.env_method("reset"), "no method 'reset'"),
        (lambda _: make_sb3("tegotae/Hopper-v0", 0), "at least 1"),
        (lambda _: make_sb3("tegotae/Hopper-v0", 1, render_mode="human"), "rgb_array"),
        (lambda _: make_sb3("tegotae/Hopper-v0", 1, observation=("phase",)), "phase"),
    ],
)
def test_misuse_is_told(act, says):
    refused(says, lambda: act(make_sb3("tegotae/Hopper-v0", 3)))


def test_without_stable_baselines3_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.delitem(sys.modules, "tegotae.envs.sb3", raising=False)
    with pytest.raises(ImportError, match=r"pip install 'tegotae\[sb3\]'"):
        make_sb3("tegotae/Hopper-v0", 2)
