"""PPO and SAC learn limbs on any environment, by the fitness, files and starts of PGPE."""

import dataclasses
import warnings
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")
torch = pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

from refusals import refused  # noqa: E402
from tegotae import TegotaeError  # noqa: E402
from tegotae.envs import load_wiring  # noqa: E402
from tegotae.envs.env_spec import EnvSpec  # noqa: E402
from tegotae.envs.mujoco.env import ModelLanes  # noqa: E402
from tegotae.envs.settings import HopReward  # noqa: E402
from tegotae.envs.wrapper import Pilot  # noqa: E402
from tegotae.systems.controller_file import load  # noqa: E402
from tegotae.systems.recipe import recipe  # noqa: E402
from tegotae.training.agents import PPOSettings, SACSettings  # noqa: E402
from tegotae.training.agents.learner import AgentLearner  # noqa: E402
from tegotae.training.agents.learning import agent_task, make_agent  # noqa: E402
from tegotae.training.agents.on_environment import PerHop  # noqa: E402
from tegotae.training.curves import (  # noqa: E402
    FITNESS,
    longest_s,
    read_curves,
)
from tegotae.training.environments.experiment import EnvExperiment  # noqa: E402
from tegotae.training.environments.objectives import Hopping, Return, UserObjective  # noqa: E402
from tegotae.training.environments.replay import replay  # noqa: E402
from tegotae.training.run import Run, train  # noqa: E402
from wired_experiment import HERE, WIRING, experiment  # noqa: E402

PPO = PPOSettings(n_envs=4, n_steps=20, batch_size=40, n_epochs=4, learning_rate=3e-3)
SAC = SACSettings(n_envs=4, learning_starts=80, gradient_steps=1, batch_size=32)


def run_of(settings, task: EnvExperiment, episodes: int = 16) -> Run:
    learner = AgentLearner(settings=settings, episodes=episodes, evaluate_every=8)
    return Run(experiment=task, seeds=(0,), learner=learner)


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """The folder and the file of a short training by PPO."""
    out = tmp_path_factory.mktemp("ppo")
    (path,) = train(run_of(PPO, experiment()), out)
    return out, path


def test_the_fitness_of_an_agent_is_that_of_its_controller_played_again(learned):
    saved = load(learned[1])
    (played,) = replay(EnvExperiment.from_controller(saved), [saved.weights])
    assert played.episode.fitness == pytest.approx(saved.training["best_fitness"], abs=1e-5)


def test_the_curve_is_of_the_fitness_over_the_time_that_was_learned_from(learned):
    curve = read_curves([learned[0]], FITNESS)
    assert curve[FITNESS].iloc[-1] > curve[FITNESS].iloc[0] + 0.3
    assert curve["simulated_s"].tolist() == pytest.approx([0.0, 6.4, 12.8])
    assert longest_s(learned[0]) == pytest.approx(12.8)


def test_a_training_that_is_done_is_left_as_it_is(learned):
    start = learned[1].read_bytes()
    train(run_of(PPO, experiment()), learned[0])
    assert learned[1].read_bytes() == start


@pytest.mark.parametrize("settings", [PPO, SAC], ids=["ppo", "sac"])
def test_an_agent_learns_a_fitness_of_ones_own_at_several_frequencies(settings, tmp_path):
    task = dataclasses.replace(
        experiment(),
        objective=UserObjective(f"{HERE / 'wired_env.py'}:pushes"),
        omegas=(6.0, 9.0),
        episodes=2,
    )
    (path,) = train(run_of(settings, task, episodes=8), tmp_path)
    assert EnvExperiment.from_controller(load(path)).omegas == (6.0, 9.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of what Stable-Baselines3 misses
        env = agent_task(task, settings).make_env()
    env.reset()
    paid = np.zeros(env.num_envs)
    over = np.zeros(env.num_envs, bool)
    for step in range(40):
        _, reward, over, _ = env.step(np.full((env.num_envs, 1), 0.2 * (-1) ** step))
        paid += reward
    assert over.all()
    assert (paid > 0.0).all()
    assert (paid < 1.0).all()  # the mean push, once


def test_an_environment_that_cannot_begin_an_episode_is_named_in_one_line():
    task = dataclasses.replace(experiment(made={"fail": "reset"}), seed=1)
    with pytest.raises(TegotaeError, match=r"cannot begin an episode: it raised .*nobody is at"):
        agent_task(task, PPO).make_env().reset()


def test_what_a_critic_senses_is_observed_or_refused():
    wide = dataclasses.replace(PPO, critic_senses=("height",))
    assert agent_task(experiment(), wide).make_env().observation_space.shape == (4,)
    wrong = dataclasses.replace(PPO, critic_senses=("heigth",))
    refused("'heigth'; did you mean height", lambda: agent_task(experiment(), wrong).make_env())


def test_a_model_with_a_learned_actuation_or_a_coupling_is_refused():
    refused("take a model without, such as AR", lambda: run_of(PPO, experiment("ART", budget=96)))


def test_hops_are_paid_at_their_apexes_and_in_the_mean_at_the_end():
    task = dataclasses.replace(
        experiment(wiring=dataclasses.replace(
            WIRING, height="height", work="work", rest_length_m=1.0
        )),
        objective=Hopping(settle_s=0.2),
    )  # fmt: skip
    paid = PerHop(task, 1, HopReward())
    time = np.linspace(0.0, 2.0, 201)
    height, work = 1.0 + 0.1 * np.sin(2.0 * np.pi * time), 0.5 * time
    observations = np.stack([time, height, work], axis=1)[:, None]
    alive = np.ones(1, bool)
    paid.begin(observations[0], alive)
    rewards = [paid.of_step(item, item, np.zeros(1), alive)[0] for item in observations[1:]]
    assert np.flatnonzero(rewards) == pytest.approx([25, 125])
    assert rewards[125] == pytest.approx(0.1 / 0.5)
    assert paid.at_the_end(alive)[0] == pytest.approx(np.mean([rewards[25], rewards[125]]))


@pytest.fixture(scope="module")
def leg():
    """The packaged leg, which has two limbs, from two starts."""
    pytest.importorskip("mujoco")
    spec = EnvSpec(env="leg", settings=(("noise", 0.02),))
    settings = {"duration_s": 0.5, "episodes": 2, "omega": 12.0, "objective": Return()}
    return EnvExperiment.from_recipe(recipe("AR"), spec, load_wiring("leg"), **settings)


def test_the_action_of_an_agent_is_the_feedback_of_its_controller_limb_by_limb(leg):
    training = agent_task(leg, PPO)
    agent, feedback = make_agent(training, seed=3)
    env: Any = agent.get_env()
    inputs = env.reset()
    for _ in range(5):
        inputs = env.step(np.zeros((4, 2)))[0]
    action = agent.predict(inputs, deterministic=True)[0]
    wires = dataclasses.replace(leg.wires, controller=training.controller)
    pilot = Pilot(wires, leg.wiring, np.repeat(feedback.flat()[:, None], 4, axis=1))
    pilot._oscillator = env._pilot._oscillator
    pilot.act(env._seen)
    assert np.abs(pilot.feedback).max() > 0.1
    assert pytest.approx(pilot.feedback, abs=1e-3) == 40.0 * action.T
    env.close()


def test_a_lane_that_begins_again_begins_as_the_others_did(leg):
    settings = dataclasses.replace(leg.spec.model_settings, duration_s=0.5)
    lanes = ModelLanes(settings, 2, threads=1)
    first = state = lanes.reset(0, np.ones(2, bool))
    for _ in range(10):
        state, *_ = lanes.step(np.zeros((2, 2)), np.ones(2, bool))
    again = lanes.reset(0, np.array([True, False]))
    assert again[0] == pytest.approx(first[0])
    assert again[1] == pytest.approx(state[1])
    distinct = lanes.reset(np.array([4, 5]), np.ones(2, bool))
    assert not np.allclose(distinct[0], distinct[1])
    lanes.close()


def test_a_lane_whose_episode_is_over_stands_still_and_costs_no_work(leg):
    lanes = ModelLanes(leg.spec.model_settings, 2, threads=1)
    first_lane = np.array([True, False])
    start = state = lanes.reset(0, np.ones(2, bool))
    push = np.full((2, 2), 5.0)
    for _ in range(5):
        state, *_ = lanes.step(push, first_lane)
    assert state[1] == pytest.approx(start[1])
    assert state[0, -1] > 0.0
    alone = ModelLanes(leg.spec.model_settings, 1, threads=1)
    reference = alone.reset(0, first_lane[:1])
    for _ in range(5):
        reference, *_ = alone.step(push[:1], first_lane[:1])
    assert (reference[0] == state[0]).all()
    lanes.close()
    alone.close()
