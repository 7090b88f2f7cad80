"""MuJoCo models as bodies: what they feel, that they move as the engine's, and that they learn."""

import dataclasses
import math
import sys

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env

from refusals import refused
from tegotae import Rollout, Scenario, Timing
from tegotae.envs import load_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.env import ModelBatch, ModelEnv
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.measures.objectives.evaluator import Generation
from tegotae.simulation.integrators import Hold
from tegotae.systems.recipe import recipe
from tegotae.systems.vanilla import legged_named
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Hopping, Return, UserObjective
from tegotae.training.environments.rollouts import EnvRollouts, environment_lanes

SIGMA, OMEGA, SECONDS = 2.753, 5.0, 10.0


def experiment(name="hopper", model="V-sector-w8", **settings):
    """A model of the package under one of the paper's controllers."""
    settings = {"duration_s": SECONDS, **settings}
    return EnvExperiment.from_recipe(
        recipe(model), EnvSpec(env=name), load_wiring(name), **settings
    )


def apexes(height, smallest=1.01):
    """Heights of the hops' apexes [m]."""
    top = (height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:]) & (height[1:-1] > smallest)
    return height[1:-1][top]


@pytest.fixture(scope="module")
def hopped():
    """The MuJoCo hopper under the vanilla controller: its record."""
    task = experiment(omega=OMEGA, objective=UserObjective("nobody:asks"))
    return EnvRollouts(task, 1).record(np.array([[SIGMA]]), 0)


def test_the_hoppers_apexes_are_within_a_centimetre_of_the_engines(hopped):
    rollout = Rollout(
        controller=recipe("V-sector-w8").controller(),
        integrator=Hold(),
        timing=Timing(duration_s=SECONDS, tick_s=0.002),
    )
    path = rollout.run([SIGMA], Scenario(omega=OMEGA, height_m=1.2))
    ours = path.apex_height_m[:, 0]
    ours = ours[np.isfinite(ours)]
    theirs = apexes(hopped.entry("root_height")[:, 0])
    assert len(theirs) == len(ours) >= 6
    np.testing.assert_allclose(theirs, ours, atol=0.01)
    work = hopped.entry("work")[-1, 0]
    assert work == pytest.approx(path.work_absolute_j[-1, 0], rel=0.1)


def test_the_spring_is_felt_where_the_leg_is_pressed_and_nowhere_else(hopped):
    height, spring = hopped.entry("root_height")[:, 0], hopped.entry("leg_spring")[:, 0]
    # Where the leg meets its stop at lift-off, that gives by a few millimetres.
    np.testing.assert_allclose(spring, 5.0 * np.maximum(1.0 - height, 0.0), atol=0.03)


def test_what_is_observed_has_the_names_of_joints_springs_actuators_and_feet():
    names = sensing(ModelSettings(model="leg", feet=["foot"])).names
    assert names[:2] == ("along", "along_velocity")
    assert {"knee_spring", "hip_force", "foot_force", "root_height", "root_upright"} <= set(names)


def test_feet_at_rest_bear_the_weight():
    feet = [f"foot{i}" for i in range(4)]
    observation = sensing(ModelSettings(model="quadruped", feet=feet))
    batch = ModelBatch(observation, 1, 70 * observation.model.opt.timestep)
    batch.reset()
    for _ in range(60):
        message = batch.step(np.zeros((1, 8)))[0]
    loads = [message[observation.names.index(f"{foot}_force")] for foot in feet]
    assert sum(loads) == pytest.approx(1.5 * 9.81, rel=0.02)
    springs = [-message[observation.names.index(f"z{i}_force")] for i in range(4)]
    assert sum(springs) == pytest.approx(1.5 * 9.81, rel=0.03)


def test_an_environment_is_one_lane_of_a_batch():
    task = experiment(duration_s=1.0)
    lanes, env = environment_lanes(task, 3), ModelEnv(model="hopper", duration_s=1.0)
    alive = np.ones(3, bool)
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(lanes.reset(0, alive)[1], observation)
    rng = np.random.default_rng(0)
    for _ in range(100):
        actions = rng.uniform(0.0, 4.0, (3, 1)).astype(np.float32)
        together, rewards, over = lanes.step(actions, alive)
        observation, reward, fallen, cut, _ = env.step(actions[1])
        np.testing.assert_array_equal(together[1], observation)
        assert (rewards[1], over[1]) == (pytest.approx(reward), fallen or cut)


def test_the_state_of_a_lane_can_be_put_into_mujocos_own_data():
    import mujoco

    observation = sensing(ModelSettings(model="leg", feet=["foot"]))
    batch = ModelBatch(observation, 2, 0.01)
    batch.reset(np.array([0.0, 0.1]))
    message = batch.step(np.zeros((2, 2)))
    data = mujoco.MjData(observation.model)
    mujoco.mj_setState(
        observation.model, data, batch.states[1], mujoco.mjtState.mjSTATE_FULLPHYSICS
    )
    assert data.time == pytest.approx(0.01)
    assert data.qpos[1] == pytest.approx(message[1, observation.names.index("height")], abs=0.005)
    assert (batch.states[0] != batch.states[1]).any()


def test_it_keeps_gymnasiums_interface():
    check_env(ModelEnv(model="leg", duration_s=0.5), skip_render_check=True)


def test_pushes_and_other_models_are_of_single_lanes():
    observation = sensing(ModelSettings(model="hopper", feet=["foot"]))
    heavy = sensing(ModelSettings(model="hopper", feet=["foot"])).model
    heavy.body_mass[:] *= 1.2
    batch = ModelBatch(observation, 2, 0.01, models=[observation.model, heavy])
    batch.reset(0.5)
    lift = np.zeros((2, 3))
    lift[1, 2] = heavy.body_mass.sum() * 9.81
    for _ in range(10):
        message = batch.step(np.zeros((2, 1)), lift)
    fall = message[:, observation.names.index("root_climb")]
    assert fall[0] == pytest.approx(-9.81 * 0.1, rel=0.01)
    assert fall[1] == pytest.approx(0.0, abs=1e-6)  # held by exactly its weight


def test_the_quadruped_walks_under_vanilla_tegotae():
    """Set C of the walkers at the size of a small robot, feet on springs."""
    second = math.sqrt(0.2 / 9.81)
    vanilla = legged_named("quadruped-a").controller
    foot = dataclasses.replace(
        vanilla.actuation, stride_m=0.04, lift_m=0.024, press_m=0.006, shift_rad=0.4
    )
    wiring = load_wiring("quadruped").reading(dataclasses.replace(vanilla, actuation=foot))
    lags = (0.0, math.pi, math.pi, 0.0)
    limbs = tuple(
        dataclasses.replace(limb, phase_rad=lag)
        for limb, lag in zip(wiring.limbs, lags, strict=True)
    )
    # σ counts the load in weights; here in newtons.
    sigma = 1.25 / second / (1.5 * 9.81)
    task = EnvExperiment(
        name="vanilla",
        spec=EnvSpec(env="quadruped"),
        wiring=dataclasses.replace(wiring, limbs=limbs, omega=2.1 / second),
        objective=UserObjective("nobody:asks"),
        duration_s=6.0,
    )
    record = EnvRollouts(task, 2).record(np.array([[sigma], [0.0]]), 0)
    assert (record.lasted == 1.0).all()
    speed = record.entry("root_forward")[-1] / 6.0 / math.sqrt(9.81 * 0.2)
    # The engine's walks with 0.19 to 0.32 √(g L) between 1.8 and 2.4; its twin a little slower.
    assert 0.15 < speed[0] < 0.4


def test_a_training_on_a_model_judges_by_efficiency_and_frequency():
    task = experiment(model="V-sector-w8", duration_s=8.0)
    assert task.objective == Hopping(settle_s=4.0)
    with task.evaluator() as evaluator:
        verdict = evaluator.evaluate(np.array([[[0.0], [SIGMA]]]), Generation.alike())
    still, hops = verdict.cot_inverse[0]
    assert still < 0.5 < 0.7 * 1.4
    assert hops > 0.2
    assert not verdict.failed.any()


def test_a_fallen_leg_has_failed_by_hopping_and_not_by_its_return():
    task = experiment("leg", "V-sector-w8", duration_s=4.0)
    assert isinstance(task.objective, Hopping)
    task = dataclasses.replace(task, objective=Return())
    with task.evaluator() as evaluator:
        verdict = evaluator.evaluate(np.array([[[0.0], [1.0]]]), Generation.alike())
    assert np.isfinite(verdict.fitness).all()
    assert not verdict.failed.any()


# Bad input.


def test_misuse_of_the_interface_is_told():
    env = ModelEnv(model="hopper")
    refused("call reset", env.step, np.zeros(1))
    env.reset()
    refused("shape", env.step, np.zeros(2))


@pytest.mark.filterwarnings("ignore:MuJoCo")
@pytest.mark.parametrize("value", [np.nan, 1e30])
def test_a_state_that_explodes_ends_the_episode_and_is_told(value):
    task = experiment(duration_s=1.0)
    lanes = environment_lanes(task, 2)
    alive = np.ones(2, bool)
    lanes.reset(0, alive)
    lanes.batch._states[1] = value
    _, reward, over = lanes.step(np.zeros((2, 1)), alive)
    assert over.tolist() == [False, True]
    assert reward[1] == 0.0
    assert lanes.troubles == ["", "its state was not finite"]


def test_without_mujoco_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"pip install 'tegotae\[mujoco\]'"):
        ModelEnv(model="hopper")


def test_training_is_timed_beside_a_plain_loop(monkeypatch):
    pytest.importorskip("stable_baselines3")
    from research.benchmarks import mujoco_training

    monkeypatch.setattr(mujoco_training, "LANES", (2,))
    rows = mujoco_training.measure_environments(steps=2)
    assert [row.lanes for row in rows] == [2, 2, 8, 8]
    assert all(0.0 < row.steps_per_core_s < math.inf for row in rows)
