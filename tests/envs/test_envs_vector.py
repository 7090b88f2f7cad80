"""A batch of hoppers is so many single ones, whatever the interface and its way of resetting."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from refusals import refused  # noqa: E402
from tegotae.envs import HopperVectorEnv, make_sb3  # noqa: E402

NAME = "tegotae/TegotaeHopper-v0"
# Releases from so high that some legs fail, in episodes so short that the others run out of time.
SETTINGS = {"duration_s": 1.2, "decimation": 30, "height_m": (1.1, 6.0), "omega": (6.0, 10.0)}
LANES, STEPS = 5, 100
ACTIONS = np.random.default_rng(0).uniform(-0.4, 0.4, (STEPS, LANES, 1)).astype(np.float32)


@pytest.fixture(params=["NextStep", "SameStep"], scope="module")
def pair(request):
    """Our batch and Gymnasium's loop over single environments, with the same autoreset."""
    ours = gymnasium.make_vec(NAME, LANES, autoreset_mode=request.param, **SETTINGS)
    theirs = gymnasium.make_vec(
        NAME,
        LANES,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": request.param},
        **SETTINGS,
    )
    assert isinstance(ours, HopperVectorEnv)
    yield ours, theirs
    theirs.close()


def assert_same_infos(ours, theirs):
    assert set(ours) == set(theirs)
    for name, value in theirs.items():
        if isinstance(value, dict):
            assert_same_infos(ours[name], value)
        elif value.dtype == object:
            for mine, second in zip(ours[name], value, strict=True):
                assert (mine is None) == (second is None)
                if second is not None:
                    np.testing.assert_allclose(mine, second, atol=1e-6)
        else:
            np.testing.assert_allclose(ours[name], value, atol=1e-5, err_msg=name)


def test_batch_is_step_by_step_what_gymnasium_makes_of_single_environments(pair):
    ours, theirs = pair
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    mine, remaining = ours.reset(seed=7), theirs.reset(seed=7)
    np.testing.assert_array_equal(mine[0], remaining[0])
    assert_same_infos(mine[1], remaining[1])
    terminated, truncated = 0, 0
    for actions in ACTIONS:
        mine, remaining = ours.step(actions), theirs.step(actions)
        np.testing.assert_allclose(mine[0], remaining[0], atol=1e-5)
        np.testing.assert_allclose(mine[1], remaining[1], atol=1e-5)
        np.testing.assert_array_equal(mine[2], remaining[2])
        np.testing.assert_array_equal(mine[3], remaining[3])
        assert_same_infos(mine[4], remaining[4])
        terminated, truncated = terminated + mine[2].sum(), truncated + mine[3].sum()
    assert terminated > 2
    assert truncated > 2


def test_lanes_are_reset_by_mask_where_the_user_resets_them():
    envs = gymnasium.make_vec(NAME, LANES, autoreset_mode="Disabled", **SETTINGS)
    envs.reset(seed=1)
    ended = np.zeros(LANES, bool)
    while not ended.any():
        *_, terminated, truncated, infos = envs.step(ACTIONS[0])
        ended = terminated | truncated
    refused("has ended; reset it", lambda: envs.step(ACTIONS[0]))
    previous = infos["height_m"]
    _, infos = envs.reset(options={"reset_mask": ended, "height_m": 1.25})
    np.testing.assert_array_equal(infos["height_m"][ended], np.float32(1.25))
    np.testing.assert_array_equal(infos["_height_m"], ended)
    *_, infos = envs.step(ACTIONS[0])
    assert (infos["time_s"][ended] < infos["time_s"][~ended].min()).all()
    assert (infos["height_m"][~ended] != previous[~ended]).all()


def test_options_of_reset_may_differ_between_lanes():
    envs = gymnasium.make_vec("tegotae/Hopper-v0", 3)
    _, infos = envs.reset(options={"height_m": [1.1, 1.2, 1.3]})
    np.testing.assert_allclose(infos["height_m"], [1.1, 1.2, 1.3])


def test_same_seed_gives_the_same_batch():
    envs = HopperVectorEnv(LANES, height_m=(1.1, 1.4))
    first = envs.reset(seed=3)[1]["height_m"]
    second = envs.reset()[1]["height_m"]
    np.testing.assert_array_equal(envs.reset(seed=3)[1]["height_m"], first)
    np.testing.assert_array_equal(envs.reset()[1]["height_m"], second)
    assert len({*first, *second}) == 2 * LANES
    np.testing.assert_array_equal(envs.reset(seed=[4, 3, 2, 1, 0])[1]["height_m"][1], first[0])


def test_observations_are_the_users_to_keep():
    envs = HopperVectorEnv(2, observation=("height",))
    first, _ = envs.reset()
    stored = first.copy()
    second, *_ = envs.step(np.zeros((2, 1), np.float32))
    second[:] = 99.0
    envs.step(np.zeros((2, 1), np.float32))
    np.testing.assert_array_equal(first, stored)


def test_frames_are_drawn_one_a_hopper():
    envs = HopperVectorEnv(2, render_mode="rgb_array")
    envs.reset()
    frames = envs.render()
    assert [frame.shape for frame in frames] == [(256, 256, 3)] * 2
    assert HopperVectorEnv(2).render() is None


def misuse_mask(envs):
    envs.reset()
    envs.reset(options={"reset_mask": np.ones(3)})


@pytest.mark.parametrize(
    ("act", "says"),
    [
        (lambda _: HopperVectorEnv(0), "at least 1"),
        (lambda _: HopperVectorEnv(2, render_mode="human"), "rgb_array"),
        (lambda _: HopperVectorEnv(2, autoreset_mode="never"), "NextStep"),
        (lambda _: HopperVectorEnv(2, omega=8.0), "omega"),
        (lambda envs: envs.step(np.zeros((2, 1), np.float32)), "call reset"),
        (lambda envs: envs.step(np.zeros(2, np.float32)), r"must be \(2, 1\)"),
        (lambda envs: envs.reset(seed=[1, 2, 3]), "one per lane"),
        (lambda envs: envs.reset(options={"mass_kg": 1.0}), "option of reset"),
        (lambda envs: envs.reset(options={"height_m": [1.0] * 3}), "shape"),
        (misuse_mask, "booleans of shape"),
        (lambda _: make_sb3("Hopper-v0", 2), "tegotae/Hopper-v0"),
    ],
)
def test_misuse_is_told_in_one_line(act, says):
    refused(says, lambda: act(HopperVectorEnv(2)))
