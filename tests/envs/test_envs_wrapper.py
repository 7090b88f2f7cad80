"""Any environment with something like a contact force can be put under Tegotae control."""

import math
import runpy
import sys
import warnings
from typing import ClassVar

import numpy as np
import pytest

from places import ROOT

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.spaces import Box, Dict, Discrete  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

from refusals import refused  # noqa: E402
from tegotae import Hopper, TegotaeError  # noqa: E402
from tegotae.envs import (  # noqa: E402
    HopperEnv,
    Limb,
    MujocoContactForce,
    TegotaeHopperEnv,
    TegotaeWrapper,
    Wiring,
    action_names,
    check_wiring,
    observation_names,
)
from tegotae.systems.recipe import recipe  # noqa: E402

LEG = Limb(senses={"spring_force": "observation[0]"}, drives="action[0]", rest=0.0)
ALPHA = 4.0
EXAMPLE = ROOT / "examples" / "mujoco_hopper.py"


class TwoFeet(gymnasium.Env):
    """Two feet pressing on scales in turn, one action for each and one for nothing."""

    metadata: ClassVar = {"render_modes": []}
    observation_names = ("left", "right", "speed")
    dt = 0.01

    def __init__(self):
        self.observation_space = Box(-np.inf, np.inf, (3,), np.float64)
        self.action_space = Box(np.float32([-1, 0, -5]), np.float32([1, 2, 5]))
        self.taken = []

    def _forces(self):
        return np.array([max(0.0, math.sin(self.t)), max(0.0, -math.sin(self.t)), 0.5])

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.t = 0.0
        return self._forces(), {}

    def step(self, action):
        self.taken.append(action)
        self.t += 0.3
        return self._forces(), 0.0, False, False, {}


def two_feet(**changes):
    limbs = [
        Limb(senses={"spring_force": "left"}, drives="action[0]", rest=-1.0),
        Limb(senses={"spring_force": "right"}, drives="action[1]", phase_rad=math.pi),
    ]
    return Wiring(**{"limbs": limbs, "weights": [2.0], "omega": 5.0, **changes})


class TestControl:
    def test_of_the_hopper_is_that_of_the_hoppers_own_oscillator(self):
        # The wrapper around the force environment is the feedback environment, written otherwise.
        sigma, omega = 2.0, 8.0
        wrapped = TegotaeWrapper(
            HopperEnv(observation=("spring_force",), dimensionless=False, decimation=1),
            Wiring(
                limbs=[LEG],
                weights=[sigma],
                omega=omega,
                controller=recipe("V-reflex-w8").controller(),
                max_force=ALPHA,
                step_s=0.001,
            ),
        )
        native = TegotaeHopperEnv(
            decimation=1, omega=omega, actuation="reflex", dimensionless=False
        )
        wrapped.reset()
        (_, cosine, spring), _ = native.reset()
        for _ in range(1000):
            feedback = sigma * -cosine * spring
            (_, cosine, spring), *_, info = native.step(np.float32([feedback / 40.0]))
            *_, message = wrapped.step(np.zeros(1, np.float32))
            assert message["height_m"] == pytest.approx(info["height_m"], abs=1e-5)
            assert float(message["phase_rad"][0]) == pytest.approx(info["phase_rad"], abs=1e-4)
            assert float(message["force_share"][0]) == pytest.approx(
                -min(0.0, feedback) / ALPHA, abs=1e-5
            )
        assert info["work_j"] > 0.1

    def test_follows_the_law_of_each_limb(self):
        wiring = two_feet(controller=recipe("V-reflex-w8").controller(), max_force=4.0)
        env = TegotaeWrapper(TwoFeet(), wiring)
        observation, info = env.reset()
        phase = np.array([0.0, math.pi])
        for _ in range(50):
            forces = observation[:2]
            feedback = 2.0 * -np.cos(phase) * forces
            share = np.clip(-np.minimum(feedback, 0.0) / 4.0, 0.0, 1.0)
            observation, *_, info = env.step(np.float32([0.0, 0.0, 3.0]))
            phase = phase + 0.01 * (5.0 + feedback)
            np.testing.assert_allclose(info["feedback_rad_per_s"], feedback, atol=1e-5)
            np.testing.assert_allclose(info["phase_rad"], phase % (2 * np.pi), atol=1e-4)
            np.testing.assert_allclose(
                env.unwrapped.taken[-1], [-1.0 + 2.0 * share[0], 1.0 + share[1], 3.0], atol=1e-5
            )
            warned = [*np.sin(phase), *np.cos(phase)]
            np.testing.assert_allclose(observation[3:], warned, atol=1e-4)

    def test_of_a_sector_pushes_in_the_sector_only(self):
        env = TegotaeWrapper(TwoFeet(), two_feet(weights=[0.0]))
        env.reset()
        remainder, turns = np.zeros(3, np.float32), 2
        steps = round(turns * 2.0 * math.pi / (5.0 * 0.01))
        share = np.array([env.step(remainder)[-1]["force_share"][0] for _ in range(steps)])
        # The sector is a twentieth of a turn; its edges lie within a step, and are not rounded.
        assert share.mean() == pytest.approx(0.05, rel=0.01)
        assert share.max() == 1.0
        assert (share == 0.0).mean() > 0.9

    def test_lets_the_agent_add_to_the_feedback(self):
        env = TegotaeWrapper(TwoFeet(), two_feet(weights=[0.0], max_feedback_rad_per_s=5.0))
        env.reset()
        *_, info = env.step(np.float32([-1.0, 0.5, 0.0]))
        np.testing.assert_allclose(info["phase_rad"], [0.0, math.pi + 0.075], atol=1e-5)

    def test_takes_a_learned_controller_and_weights_of_each_limb(self):
        controller = recipe("AR-rFv-reflex-w8").controller()
        limbs = [
            Limb(senses={"spring_force": name, "velocity": "speed"}, drives=f"action[{i}]")
            for i, name in enumerate(("left", "right"))
        ]
        weights = np.random.default_rng(0).normal(size=(2, controller.n_weights))
        wiring = two_feet(
            limbs=limbs, weights=weights, controller=controller, scales={"velocity": 2}
        )
        env = TegotaeWrapper(TwoFeet(), wiring)
        env.reset()
        env.step(np.zeros(3, np.float32))
        *_, info = env.step(np.zeros(3, np.float32))
        assert info["feedback_rad_per_s"][0] != info["feedback_rad_per_s"][1]

    def test_keeps_the_interface(self):
        env = TegotaeWrapper(TwoFeet(), two_feet())
        np.testing.assert_array_equal(env.action_space.high, [1.0, 1.0, 5.0])
        assert env.observation_space.shape == (7,)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the inner environment has no bounds, and is wrapped
            check_env(env, skip_render_check=True)

    def test_reads_a_dictionary_by_its_keys(self):
        class Keyed(TwoFeet):
            observation_names = ("feet[0]", "feet[1]", "speed")

            def __init__(self):
                super().__init__()
                feet = Box(0, np.inf, (2,), np.float64)
                self.observation_space = Dict({"feet": feet, "speed": Box(0, 1, (1,), np.float64)})

            def _forces(self):
                remaining, right, speed = super()._forces()
                return {"feet": np.array([remaining, right]), "speed": np.array([speed])}

        limb = Limb(senses={"spring_force": "feet[1]"}, drives="action[0]")
        env = TegotaeWrapper(Keyed(), two_feet(limbs=[limb]))
        observation, _ = env.reset()
        assert env.observation_space.contains(observation)
        assert set(observation) == {"feet", "speed", "phase"}


class TestNames:
    def test_are_numbers_where_nothing_is_known(self):
        env = gymnasium.make("Pendulum-v1")
        assert observation_names(env) == tuple(f"observation[{i}]" for i in range(3))
        assert action_names(env) == ("action[0]",)

    def test_are_keys_where_there_are_keys(self):
        class Keyed(gymnasium.Env):
            observation_space = Dict({"a": Box(0, 1, (2,)), "b": Box(0, 1, (1,))})

        assert observation_names(Keyed()) == ("a[0]", "a[1]", "b")

    @pytest.mark.parametrize("space", [Discrete(3), Box(0, 1, (2, 2)), Dict({"a": Discrete(2)})])
    def test_are_refused_where_there_are_no_numbers(self, space):
        class Odd(gymnasium.Env):
            observation_space = space

        refused("one-dimensional Box", lambda: observation_names(Odd()))


class TestChecker:
    def test_finds_nothing_missing_where_nothing_is(self):
        assert check_wiring(TwoFeet(), two_feet()) == []

    @pytest.mark.parametrize(
        ("changes", "says"),
        [
            ({"limbs": []}, "no limbs"),
            ({"limbs": [Limb(senses={}, drives="action[0]")]}, "reads 'spring_force'"),
            (
                {"limbs": [Limb(senses={"spring_force": "lift"}, drives="action[0]")]},
                "did you mean left",
            ),
            (
                {"limbs": [Limb(senses={"spring_force": "left"}, drives="knee")]},
                "no action entry is called 'knee'",
            ),
            (
                {"limbs": [Limb(senses={"spring_force": "left", "heat": "speed"}, drives="knee")]},
                "no term of the controller reads 'heat'",
            ),
            (
                {"limbs": [Limb(senses={"spring_force": "left"}, drives="action[0]", push=3.0)]},
                "takes -1 to 1",
            ),
            (
                {"limbs": [Limb(senses={"spring_force": "left"}, drives="action[0]", rest=1.0)]},
                "no push has an effect",
            ),
            ({"limbs": [two_feet().limbs[0]] * 2}, "several limbs drive 'action[0]'"),
            ({"controller": recipe("T").controller(), "weights": np.zeros(96)}, "no oscillator"),
            (
                {"controller": recipe("AR-rFv-sector-w8").controller(), "weights": np.zeros(96)},
                "reads 'velocity'",
            ),
            ({"weights": [1.0, 2.0]}, "weights have shape (2,)"),
            ({"weights": [np.nan]}, "not all finite"),
            ({"omega": math.inf}, "omega"),
            ({"step_s": 0.0}, "step_s"),
            ({"max_force": -1.0}, "max_force"),
            ({"scales": {"spring_force": 0.0}}, "scales['spring_force']"),
            ({"observation_names": ["a", "b"]}, "2 observation names for 3 entries"),
            ({"observation_names": ["a", "b", "b"]}, "several observation entries are called 'b'"),
        ],
    )
    def test_says_what_is_missing_and_so_does_the_wrapper(self, changes, says):
        problems = check_wiring(TwoFeet(), two_feet(**changes))
        assert any(says in problem for problem in problems), problems
        assert not any("\n" in problem for problem in problems)
        with pytest.raises(TegotaeError) as error:
            TegotaeWrapper(TwoFeet(), two_feet(**changes))
        assert says in str(error.value)

    def test_says_all_that_is_missing_at_once(self):
        limb = Limb(senses={"spring_force": "lift"}, drives="knee")
        problems = check_wiring(TwoFeet(), two_feet(limbs=[limb], omega=math.nan))
        assert len(problems) == 3

    def test_asks_for_the_time_step_of_an_environment_without_one(self):
        limb = Limb(senses={"spring_force": "observation[0]"}, drives="action[0]")
        wiring = two_feet(limbs=[limb])
        (problem,) = check_wiring(gymnasium.make("MountainCarContinuous-v0"), wiring)
        assert "step_s" in problem

    @pytest.mark.parametrize(
        ("entry", "says"), [("speed", "never zero"), ("left", ""), ("nothing", "never left zero")]
    )
    def test_tries_whether_a_contact_force_looks_like_one(self, entry, says):
        class Odd(TwoFeet):
            observation_names = ("left", "nothing", "speed")

            def _forces(self):
                return super()._forces() * [1.0, 0.0, 1.0]

        limb = Limb(senses={"spring_force": entry}, drives="action[0]")
        problems = check_wiring(Odd(), two_feet(limbs=[limb]))
        assert [says in problem for problem in problems] == [True] * bool(says)

    def test_finds_a_signed_force_and_one_that_is_not_finite(self):
        wiring = two_feet(limbs=[LEG], observation_names=None)
        pendulum = gymnasium.make("Pendulum-v1")
        (problem,) = check_wiring(pendulum, two_feet(limbs=[LEG], step_s=0.05))
        assert "was negative" in problem

        class Broken(TwoFeet):
            observation_names = ("observation[0]", "b", "c")

            def _forces(self):
                return np.array([np.nan, 0.0, 0.0])

        (problem,) = check_wiring(Broken(), wiring)
        assert "not finite" in problem

    def test_does_not_run_the_environment_where_it_should_only_look(self):
        class Untouched(TwoFeet):
            def step(self, action):
                raise AssertionError("stepped")

        assert check_wiring(Untouched(), two_feet(), steps=0) == []

    def test_wants_bounds_or_numbers_of_an_unbounded_action(self):
        class Unbounded(TwoFeet):
            def __init__(self):
                super().__init__()
                self.action_space = Box(-np.inf, np.inf, (3,))

        problems = check_wiring(Unbounded(), two_feet(), steps=0)
        assert any("give push=" in problem for problem in problems)

    def test_refuses_actions_that_are_not_numbers(self):
        limb = Limb(senses={"spring_force": "observation[0]"}, drives="action[0]")
        (problem,) = check_wiring(gymnasium.make("CartPole-v1"), two_feet(limbs=[limb]))
        assert "action space" in problem


class TestMisuse:
    def test_of_the_interface_is_told(self):
        env = TegotaeWrapper(TwoFeet(), two_feet())
        refused("call reset", env.step, np.zeros(3, np.float32))
        env.reset()
        refused("shape", env.step, np.zeros(2, np.float32))

    def test_of_contact_forces_outside_mujoco_is_told(self):
        pytest.importorskip("mujoco")
        refused("no MuJoCo model", lambda: MujocoContactForce(TwoFeet(), "foot"))

    def test_without_mujoco_the_extra_is_named(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "mujoco", None)
        with pytest.raises(ImportError, match=r"pip install 'tegotae\[mujoco\]'"):
            MujocoContactForce(TwoFeet(), "foot")


class TestMujoco:
    """The example of the documentation: the legs of Gymnasium's own planar hopper."""

    @pytest.fixture
    def hopper(self):
        pytest.importorskip("mujoco")
        pytest.importorskip("imageio")
        return MujocoContactForce(gymnasium.make("Hopper-v5"), "foot")

    def test_entries_are_called_by_joint(self, hopper):
        names = observation_names(hopper)
        assert names[:5] == ("rootz", "rooty", "thigh_joint", "leg_joint", "foot_joint")
        assert names[5:] == (
            "rootx_velocity",
            *(f"{name}_velocity" for name in names[:5]),
            "foot_force",
        )
        assert action_names(hopper) == ("thigh_joint", "leg_joint", "foot_joint")

    def test_contact_force_bears_the_weight_and_is_zero_in_the_air(self, hopper):
        forces = [hopper.reset(seed=0)[0][-1]]
        forces += [hopper.step(np.zeros(3))[0][-1] for _ in range(30)]
        weight = 9.81 * hopper.unwrapped.model.body_mass.sum()
        assert forces[0] == 0.0  # released a little above the ground
        assert forces[-1] == pytest.approx(weight, rel=0.1)

    def test_a_foot_without_a_name_is_given_by_its_geom(self, hopper):
        geom = MujocoContactForce(hopper.env, "foot_geom")
        together = MujocoContactForce(geom, "foot")
        together.reset(seed=0)
        for _ in range(30):
            observation, *_ = together.step(np.zeros(3))
        assert observation[-1] == observation[-2] > 0.0

    def test_model_without_that_body_is_told(self, hopper):
        refused("did you mean foot", MujocoContactForce, hopper.env, "feet")
        refused("no body is named", MujocoContactForce, hopper.env)

    def test_names_of_other_environments_of_the_family_fit(self):
        pytest.importorskip("mujoco")
        pytest.importorskip("imageio")
        ant = observation_names(gymnasium.make("Ant-v5"))
        assert ant[0] == "root[2]"
        assert "hip_1_velocity" in ant
        assert len(set(ant)) == len(ant)

    def test_example_moves_the_hopper_forward(self, hopper, capsys):
        runpy.run_path(str(EXAMPLE))["main"](seeds=2)
        assert "Tegotae" in capsys.readouterr().out


def test_weight_of_the_default_hopper_is_a_good_scale():
    scales = {"spring_force": Hopper().weight_n}
    assert Wiring(limbs=[LEG], weights=[1.0], omega=1.0, scales=scales).scales == scales
