"""The Gymnasium environments are the engine, tick by tick, and pay what can be paid by hand."""

import math
import subprocess
import sys
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from refusals import refused  # noqa: E402
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing  # noqa: E402
from tegotae.envs import (  # noqa: E402
    ENVIRONMENTS,
    HopperEnv,
    HopperSettings,
    HopReward,
    TegotaeHopperEnv,
    TegotaeHopperSettings,
)
from tegotae.measures.hopping.hopping import whole_hops  # noqa: E402
from tegotae.parts.controller import Controller  # noqa: E402
from tegotae.parts.terms.actuation import CommandedForce  # noqa: E402
from tegotae.simulation.integrators import Hold  # noqa: E402
from tegotae.systems.recipe import recipe  # noqa: E402

NAMES = list(ENVIRONMENTS)
NONE, FULL = np.zeros(1, np.float32), np.ones(1, np.float32)

SAME = {"height_m": "height_m", "velocity_m_per_s": "velocity_m_per_s", "ground_m": "ground_m"}
SAME |= {"phase_rad": "phase_rad", "actuator_force_n": "actuator_force_n"}
SAME |= {"work_j": "work_absolute_j", "climb_flight_m": "climb_flight_m"}
"""What an environment's info calls what a trajectory calls otherwise or the same."""


def rollout(env, action, steps, **reset):
    """Observations, rewards and infos of so many steps; `action` is a function of observation."""
    observation, info = env.reset(**reset)
    observations, rewards, infos, ends = [observation], [], [], []
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(action(observation))
        observations.append(observation)
        rewards.append(reward)
        infos.append(info)
        ends.append((terminated, truncated))
        if terminated or truncated:
            break
    return np.array(observations), np.array(rewards), infos, ends


def trajectory(controller, weight, duration_s, tick_s=0.001, body=None, **scenario):
    """Return the trajectory of the engine's sampled controller, every tick recorded."""
    timing = Timing(duration_s=duration_s, tick_s=tick_s, frame_s=tick_s)
    rollout = Rollout(controller=controller, integrator=Hold(), timing=timing)
    return rollout.run(np.array([[weight]]), Scenario(**{"omega": 0.0, **scenario}), body)


def assert_same_motion(infos, expected, atol):
    for message, recorded in SAME.items():
        ours = [info[message] for info in infos]
        theirs = getattr(expected, recorded)[: len(ours), 0]
        if message == "ground_m":
            # The info tells the ground that the next tick will meet, the engine that of the last.
            ours, theirs = ours[:-1], theirs[1:]
        np.testing.assert_allclose(ours, theirs, atol=atol, err_msg=message)


class TestInterface:
    @pytest.mark.parametrize("name", NAMES)
    def test_passes_gymnasiums_checker_without_a_warning(self, name):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(gymnasium.make(name).unwrapped)

    @pytest.mark.parametrize("name", NAMES)
    def test_is_registered_by_importing_its_package(self, name):
        assert name in gymnasium.registry
        assert gymnasium.make(f"tegotae.envs:{name}").spec.id == name

    @pytest.mark.parametrize("name", NAMES)
    def test_observations_and_actions_are_float32_with_finite_bounds(self, name):
        env = gymnasium.make(name)
        for space in (env.observation_space, env.action_space):
            assert space.dtype == np.float32
            assert np.isfinite([space.low, space.high]).all()

    def test_same_seed_and_actions_give_the_same_episode(self):
        env = HopperEnv(height_m=(1.1, 1.4), duration_s=0.3)
        actions = np.random.default_rng(0).uniform(-1, 1, (30, 1)).astype(np.float32)

        def episode(seed):
            queue = iter(actions)
            return rollout(env, lambda _: next(queue), 30, seed=seed)[0]

        np.testing.assert_array_equal(episode(3), episode(3))
        assert not np.array_equal(episode(3), episode(4))

    def test_every_episode_draws_its_release_from_the_range(self):
        env = HopperEnv(height_m=(1.1, 1.4))
        heights = [env.reset(seed=0 if i == 0 else None)[1]["height_m"] for i in range(20)]
        assert len(set(heights)) == 20
        assert 1.1 <= min(heights) < max(heights) <= 1.4

    def test_an_option_of_reset_stands_for_one_episode(self):
        env = HopperEnv()
        assert env.reset(options={"height_m": 1.5})[1]["height_m"] == 1.5
        assert env.reset()[1]["height_m"] == pytest.approx(1.2)

    def test_observation_is_what_was_asked_for_in_that_order(self):
        names = ("height", "velocity", "spring_force")
        env = HopperEnv(observation=names, dimensionless=False, duration_s=0.5)
        observations, _, infos, _ = rollout(env, lambda _: NONE, 50)
        height = np.array([info["height_m"] for info in infos])
        np.testing.assert_array_equal(observations[1:, 0], height.astype(np.float32))
        np.testing.assert_array_equal(
            observations[1:, 1], np.float32([info["velocity_m_per_s"] for info in infos])
        )
        spring = np.maximum(5.0 * (1.0 - height), 0.0)
        assert spring.max() > 1.0
        np.testing.assert_allclose(observations[1:, 2], spring, atol=1e-6)

    def test_dimensionless_observations_are_in_weights_and_leg_lengths(self):
        hopper = Hopper(mass_kg=0.2, rest_length_m=0.5, stiffness_n_per_m=40.0)
        settings = {"body": hopper, "height_m": 0.45, "velocity_m_per_s": 1.0}
        names = ("spring_force", "velocity", "height")
        si, _ = HopperEnv(observation=names, dimensionless=False, **settings).reset()
        pure, _ = HopperEnv(observation=names, **settings).reset()
        scales = [0.2 * 9.81, math.sqrt(9.81 * 0.5), 0.5]
        np.testing.assert_allclose(pure * scales, si, rtol=1e-6)
        np.testing.assert_allclose(si, [2.0, 1.0, 0.45], rtol=1e-6)

    def test_hopper_and_reward_may_be_given_by_their_arguments(self):
        env = HopperEnv(body={"mass_kg": 0.2}, reward={"work": "net"})
        assert env.settings.body == Hopper(mass_kg=0.2)
        assert env.settings.reward == HopReward(work="net")

    def test_observation_stays_in_its_space_whatever_happens(self):
        env = HopperEnv(
            observation=("spring_force", "velocity", "height"), velocity_m_per_s=1e5, height_m=1e5
        )
        observation, _ = env.reset()
        assert env.observation_space.contains(observation)
        assert observation[1] == 1e3  # clipped


@pytest.mark.precise
class TestAgreesWithTheEngine:
    """Tick by tick, to the rounding of float32."""

    @pytest.mark.parametrize("drop", [{}, {"drop_m": 0.2, "drop_time_s": 0.75}])
    def test_with_a_constant_force(self, drop):
        env = HopperEnv(decimation=1, duration_s=1.5, **drop)
        _, _, infos, _ = rollout(env, lambda _: 0.5 * FULL, 1500)
        expected = trajectory(Controller(CommandedForce()), 2.0, 1.5, **drop)
        assert_same_motion(infos, expected, atol=3e-6)

    @pytest.mark.parametrize(
        "actuation", ["sector", pytest.param("reflex", marks=pytest.mark.thorough)]
    )
    def test_with_the_vanilla_feedback_computed_by_the_agent(self, actuation):
        sigma, largest = 2.0, 40.0
        env = TegotaeHopperEnv(
            decimation=1,
            duration_s=2.0,
            omega=8.0,
            actuation=actuation,
            max_feedback_rad_per_s=largest,
            dimensionless=False,
        )

        def agent(observation):
            _, cosine, spring = observation
            return np.array([sigma * -cosine * spring / largest], np.float32)

        _, _, infos, _ = rollout(env, agent, 2000)
        expected = trajectory(recipe(f"V-{actuation}-w8").controller(), sigma, 2.0, omega=8.0)
        assert expected.work_absolute_j[-1, 0] > 0.1
        assert_same_motion(infos, expected, atol=2e-5)

    def test_with_a_hopper_a_tick_and_a_release_of_the_users(self):
        body = Hopper(mass_kg=0.3, stiffness_n_per_m=60.0, damping_ns_per_m=1.0, max_force_n=9.0)
        release = {"height_m": 1.1, "velocity_m_per_s": -0.5}
        env = HopperEnv(body=body, tick_s=0.002, decimation=1, duration_s=1.0, **release)
        _, _, infos, _ = rollout(env, lambda _: FULL, 500)
        expected = trajectory(Controller(CommandedForce()), 9.0, 1.0, 0.002, body, **release)
        assert_same_motion(infos, expected, atol=1e-5)

    def test_a_decimated_step_is_so_many_ticks_under_one_action(self):
        fine = TegotaeHopperEnv(decimation=1, duration_s=1.0)
        coarse = TegotaeHopperEnv(decimation=20, duration_s=1.0)
        actions = np.random.default_rng(1).uniform(-0.3, 0.3, (50, 1)).astype(np.float32)
        slow, fast = iter(actions), iter(np.repeat(actions, 20, axis=0))
        observed, paid, infos, _ = rollout(coarse, lambda _: next(slow), 50)
        seen_fine, paid_fine, infos_fine, _ = rollout(fine, lambda _: next(fast), 1000)
        np.testing.assert_array_equal(observed, seen_fine[::20])
        assert infos == infos_fine[19::20]
        np.testing.assert_allclose(paid, paid_fine.reshape(50, 20).sum(axis=1), rtol=1e-6)

    def test_a_leg_of_no_length_ends_the_episode_where_the_engine_fails(self):
        env = HopperEnv(decimation=1, height_m=6.0)
        _, _, infos, ends = rollout(env, lambda _: NONE, 20_000)
        expected = trajectory(Controller(CommandedForce()), 0.0, 3.0, height_m=6.0)
        assert ends[-1] == (True, False)
        assert len(ends) - 1 == int(expected.failed[:, 0].argmax())
        assert_same_motion(infos, expected, atol=1e-5)

    def test_an_episode_that_runs_its_time_is_truncated_then(self):
        env = HopperEnv(duration_s=0.5, decimation=25)
        _, _, infos, ends = rollout(env, lambda _: NONE, 1000)
        assert ends == [(False, False)] * 19 + [(False, True)]
        assert infos[-1]["time_s"] == pytest.approx(0.5)

    @pytest.mark.parametrize(("action", "force"), [(-1.0, 0.0), (0.0, 0.0), (0.5, 2.0), (7.0, 4.0)])
    def test_an_action_is_a_share_of_the_largest_force_and_never_pulls(self, action, force):
        env = HopperEnv(height_m=0.8)
        env.reset()
        info = env.step(np.array([action], np.float32))[-1]
        assert info["actuator_force_n"] == pytest.approx(force)


@pytest.fixture(scope="module")
def hopping():
    """Infos of the vanilla controller with σ = 2, fed back by hand, and the same on the engine."""
    env = TegotaeHopperEnv(
        omega=8.0,
        actuation="reflex",
        observation=("phase", "spring_force"),
        dimensionless=False,
        max_feedback_rad_per_s=40.0,
        decimation=1,
        tick_s=0.002,
        duration_s=12.0,
    )

    def feedback(observed):
        return np.float32([-2.0 * observed[1] * observed[2] / 40.0])

    infos = rollout(env, feedback, env.settings.n_steps)[2]
    return infos, trajectory(recipe("V-reflex-w8").controller(), 2.0, 12.0, 0.002, omega=8.0)


class TestEfficiency:
    def test_is_over_the_whole_hops_of_the_second_half_as_in_training(self, hopping):
        infos, engine = hopping
        late = slice(len(infos) // 2, None)
        hops = whole_hops(engine.apex_height_m[late], engine.ground_m[late], 1.0)
        climb, work = map(hops.over, (engine.climb_flight_m[late], engine.work_absolute_j[late]))
        assert infos[-1]["cot_inverse"] == pytest.approx(float(climb[0] / work[0]), rel=1e-3)

    def test_changes_at_apexes_alone(self, hopping):
        infos, _ = hopping
        message = np.array([info["cot_inverse"] for info in infos])
        assert (message[: len(message) // 2] == 0.0).all()
        index = np.flatnonzero(np.diff(message)) + 1
        assert len(index) > 3
        velocity = np.array([info["velocity_m_per_s"] for info in infos])
        assert (velocity[index - 1] > 0.0).all()
        assert (velocity[index] <= 0.0).all()

    def test_of_a_body_that_hops_no_more_is_none(self):
        env = HopperEnv(decimation=5, duration_s=12.0, height_m=2.0)
        assert rollout(env, lambda _: NONE, 2400)[2][-1]["cot_inverse"] == 0.0


class TestReward:
    def test_of_each_hop_is_its_climb_over_its_work(self):
        # A constant force F works F·x down and F·x up on a stroke of depth x; the hop after it
        # climbs from the rest length to the apex. Hops decay, and soon clear 1 % no more.
        env = HopperEnv(decimation=1, duration_s=2.5)
        force = 1.2
        _, rewards, infos, _ = rollout(env, lambda _: np.float32([force / 4.0]), 2500)
        height = np.array([info["height_m"] for info in infos])
        by_hand = []
        start = 0
        for paid in np.flatnonzero(rewards[:-1]):
            depth = 1.0 - height[start : paid + 1].min()
            by_hand.append((height[start + 200 : paid + 1].max() - 1.0) / (2.0 * force * depth))
            start = paid
        assert len(by_hand) == infos[-1]["hops"] == 4
        np.testing.assert_allclose(rewards[:-1][rewards[:-1] != 0.0], by_hand, rtol=1e-3)
        assert rewards[-1] == pytest.approx(np.mean(by_hand), rel=1e-3)

    def test_comes_at_the_apex(self):
        env = HopperEnv(decimation=1, duration_s=2.0)
        _, rewards, infos, _ = rollout(env, lambda _: np.float32([0.3]), 1999)
        velocity = np.array([info["velocity_m_per_s"] for info in infos])
        for paid in np.flatnonzero(rewards):
            assert velocity[paid - 1] > 0.0 >= velocity[paid]

    def test_of_hops_without_work_is_nothing(self):
        env = HopperEnv(duration_s=2.0, height_m=2.0)
        _, rewards, infos, _ = rollout(env, lambda _: NONE, 200)
        assert infos[-1]["climb_flight_m"] > 0.1
        assert not rewards.any()

    def test_of_an_episode_that_fails_has_no_mean_in_it(self):
        env = HopperEnv(decimation=1, height_m=6.0)
        assert not rollout(env, lambda _: 0.1 * FULL, 20_000)[1].any()

    def test_for_almost_no_work_is_closed_by_charging_what_the_body_loses(self):
        def total(reward):
            env = HopperEnv(duration_s=1.5, height_m=2.0, reward=reward)
            return rollout(env, lambda _: np.float32([1e-3]), 150)[1].sum()

        literal, charged = total(HopReward()), total(HopReward(charge_stored=True))
        assert literal > 10.0  # m/J; a hop without losses would make 1 / (m g) = 1.02
        assert 0.0 < charged < 2.0
        assert total(HopReward(least_work_j=0.01)) == 0.0

    @pytest.mark.parametrize(("energy", "work"), [("absolute", 3.0), ("positive", 2.0), ("net", 1)])
    def test_counts_work_as_defined(self, energy, work):
        reward = HopReward(work=energy)
        signed = np.array([2.0, -1.0], np.float32)
        assert float(np.sum(np.asarray(reward.counted(signed)))) == work


class TestRendering:
    def frame(self, **settings):
        env = TegotaeHopperEnv(render_mode="rgb_array", **settings)
        env.reset()
        return env.render()

    def test_draws_an_array_of_pixels(self):
        frame = self.frame()
        assert frame.shape == (256, 256, 3)
        assert frame.dtype == np.uint8

    def test_shows_a_higher_hopper_higher_and_another_phase_elsewhere(self):
        mass = np.array([38, 92, 160], np.uint8)

        def row(frame):
            return np.flatnonzero((frame == mass).all(axis=2).any(axis=1)).mean()

        assert row(self.frame(height_m=1.6)) < row(self.frame(height_m=1.2)) - 20
        assert not np.array_equal(self.frame(), self.frame(phase_rad=2.0))

    def test_a_window_needs_no_call_of_render(self, monkeypatch):
        matplotlib = pytest.importorskip("matplotlib")
        monkeypatch.setattr(matplotlib, "get_backend", lambda: "agg")
        matplotlib.use("agg")
        env = HopperEnv(render_mode="human")
        env.reset()
        env.step(NONE)
        assert env.render() is None
        assert matplotlib.pyplot.get_fignums()
        env.close()
        env.close()
        assert not matplotlib.pyplot.get_fignums()


class TestMisuse:
    @pytest.mark.parametrize(
        ("settings", "says"),
        [
            ({"observation": ("spring_forse",)}, "spring_force"),
            ({"observation": ("phase",)}, "no observation of this environment is called 'phase'"),
            ({"observation": ()}, "empty"),
            ({"hight_m": 1.0}, "did you mean height_m"),
            ({"omega": 8.0}, "no argument of this environment is called 'omega'"),
            ({"decimation": 0}, "at least 1"),
            ({"duration_s": 0.001}, "duration_s in steps of the agent is 0"),
            ({"tick_s": 0.5}, "too long for this hopper"),
            ({"height_m": -1.0}, "greater than 0"),
            ({"height_m": (1.3, 1.1)}, "low end"),
            ({"height_m": (1.3,)}, "two finite ends"),
            ({"drop_time_s": math.nan}, "finite"),
            ({"drop_time_s": (1.0, math.inf)}, "finite ends"),
            ({"body": 3}, "must be a Body, or the arguments of a Hopper"),
            ({"body": {"mass": 1.0}}, "did you mean mass_kg"),
            ({"body": {"mass_kg": -1.0}}, "greater than 0"),
            ({"reward": 3}, "must be a HopReward"),
            ({"render_mode": "ansi"}, "rgb_array"),
        ],
    )
    def test_of_arguments_is_told_in_one_line(self, settings, says):
        refused(says, HopperEnv, **settings)

    @pytest.mark.parametrize(
        ("settings", "says"),
        [
            ({"actuation": "sektor"}, "sector"),
            ({"actuation": recipe("ART").controller().actuation}, "without weights"),
            ({"max_feedback_rad_per_s": 0.0}, "greater than 0"),
            ({"omega": math.inf}, "finite"),
        ],
    )
    def test_of_the_oscillators_arguments_is_told_too(self, settings, says):
        refused(says, TegotaeHopperEnv, **settings)

    def test_of_the_interface_is_told(self):
        env = HopperEnv(duration_s=0.01)
        refused("call reset", env.step, NONE)
        env.reset()
        refused("shape", env.step, np.zeros(2, np.float32))
        refused("not finite", env.step, np.array([np.nan], np.float32))
        env.step(NONE)
        refused("has ended", env.step, NONE)
        refused("option of reset", env.reset, options={"mass_kg": 1.0})

    @pytest.mark.parametrize("kwargs", [{"work": "heat"}, {"least_work_j": -1.0}])
    def test_of_the_reward_is_told(self, kwargs):
        with pytest.raises(TegotaeError):
            HopReward(**kwargs)

    def test_without_gymnasium_the_extra_is_named_and_the_rest_works(self):
        program = (
            "import sys; sys.modules['gymnasium'] = None\n"
            "import tegotae\n"
            "try:\n    import tegotae.envs\n"
            "except ImportError as error:\n    print(error)"
        )
        process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        assert process.returncode == 0, process.stderr
        message = (
            "gymnasium is not installed; pip install 'tegotae[gym]', or in a clone pip install"
        )
        assert process.stdout.strip() == f"{message} '.[gym]'"


def test_settings_say_what_follows_from_them():
    settings = TegotaeHopperSettings(duration_s=5.0, tick_s=0.002, decimation=5, omega=(4.0, 8.0))
    assert settings.n_steps == 500
    assert settings.step_s == pytest.approx(0.01)
    assert settings.draws
    assert not HopperSettings().draws
