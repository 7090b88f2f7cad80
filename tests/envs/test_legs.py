"""Feet of any MuJoCo model go where they are commanded to, and say what they bear."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

import jax.numpy as jnp
import mujoco

import tegotae as tg
from jointed import jointed_robot
from places import ROOT
from refusals import refused
from sprung import sprung_robot
from tegotae.cli import main
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.chains import Chains, direct, has_closed_form, kinematics, solved
from tegotae.envs.mujoco.env import ModelBatch, ModelEnv
from tegotae.envs.mujoco.legs import legs_of
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import foot_place, started
from tegotae.envs.wires import look_up
from tegotae.envs.wrapper import Pilot
from tegotae.parts.scaled import in_si
from tegotae.parts.terms import BalancedFoot, Signals, TiltReaction
from tegotae.parts.units import Units
from tegotae.simulation.integrators import decide, held, with_oscillator
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.models.suggesting import lowest_feet
from tegotae_robots.models.suggesting_legs import suggest_legs, workspace
from tegotae_robots.robot import RobotController

KINDS = [(seed, 2 + seed % 4, 1 + seed % 4, seed % 3 == 0) for seed in range(10)]
"""Seed, joints of a leg, legs, and whether the last joint slides."""
MODELS = [*KINDS[:4], *(pytest.param(kind, marks=pytest.mark.thorough) for kind in KINDS[4:])]


def robot(seed: int, joints: int, legs: int, slide: bool):
    model = mujoco.MjModel.from_xml_string(jointed_robot(seed, joints, legs, slide))
    feet = [f"foot{leg}" for leg in range(legs)]
    return model, legs_of(model, feet)


def posed(model, legs, joints):
    """MuJoCo's data with the legs' joints somewhere, [legs, joints]."""
    data = started(model)
    data.qpos[model.jnt_qposadr[legs.joints]] = joints
    mujoco.mj_forward(model, data)
    return data


def places(model, legs, data):
    """Return places of feet from the trunk, in its axes, [legs, 3]."""
    feet = np.array([foot_place(model, data, foot) for foot in legs.feet])
    return (feet - data.xpos[1]) @ data.xmat[1].reshape(3, 3)


def drawn(legs, share: float, lanes: int = 32):
    """Joints within a share of their limits, [lanes, legs, joints]."""
    low, high = share * legs.chains.low, share * legs.chains.high
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    draw = np.random.default_rng(1).uniform(low, high, (lanes, *legs.start.shape))
    return legs.start + unit * draw


@pytest.mark.parametrize("kind", MODELS)
def test_a_foot_is_where_mujoco_has_it(kind):
    model, legs = robot(*kind)
    joints = drawn(legs, 1.0)
    begin = places(model, legs, started(model))
    for row, place in zip(joints, legs.places_of(joints), strict=True):
        assert place == pytest.approx(
            places(model, legs, posed(model, legs, row)) - begin, abs=1e-5
        )


@pytest.mark.parametrize("kind", MODELS)
def test_a_foot_goes_to_any_place_within_reach(kind):
    _, legs = robot(*kind)
    expected = legs.places_of(drawn(legs, 0.4))
    joints = legs.joints_at(expected)
    missed = np.linalg.norm(legs.places_of(joints) - expected, axis=2)
    assert np.median(missed) < 1e-4 * legs.length_m
    assert np.quantile(missed, 0.95) < 0.01 * legs.length_m
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    moved = (joints - legs.start) / unit
    assert (moved >= legs.chains.low - 1e-6).all()
    assert (moved <= legs.chains.high + 1e-6).all()


def test_a_place_near_the_start_is_met_as_closely_as_eight_steps_promise():
    _, legs = robot(*KINDS[5])
    assert not has_closed_form(legs.chains)
    expected = legs.places_of(drawn(legs, 0.2, lanes=64))
    missed = np.linalg.norm(legs.places_of(legs.joints_at(expected)) - expected, axis=2)
    assert np.quantile(missed, 0.95) < 1e-5 * legs.length_m


@pytest.mark.parametrize("lanes", [0, 1, 32, 33, 70])
def test_lanes_side_by_side_have_the_joints_that_they_have_alone(lanes):
    _, legs = robot(*KINDS[0])
    places = legs.places_of(np.resize(drawn(legs, 0.4), (70, *legs.joints.shape)))
    alone = np.array([legs.joints_at(place[None])[0] for place in places])
    np.testing.assert_array_equal(legs.joints_at(places[:lanes]), alone[:lanes])


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind[1] == 3])
def test_a_force_on_a_foot_is_felt_in_the_torques_that_balance_it(kind):
    model, legs = robot(*kind)
    joints, force = drawn(legs, 0.3), np.array([3.0, -2.0, 10.0])
    torques = np.zeros_like(joints)
    for lane, row in enumerate(joints):
        data = posed(model, legs, row)
        trunk = data.xmat[1].reshape(3, 3)
        for leg, foot in enumerate(legs.feet):
            jacobian, body = np.zeros((3, model.nv)), model.body(foot).id
            mujoco.mj_jac(model, data, jacobian, None, foot_place(model, data, foot), body)
            own_dofs = model.jnt_dofadr[legs.joints[leg]]
            torques[lane, leg] = -jacobian[:, own_dofs].T @ (trunk @ force)
    assert np.median(np.abs(legs.forces_n(joints, torques) - force)) < 0.2


def test_a_place_out_of_reach_is_approached_and_not_left_to_chance():
    _, legs = robot(1, 3, 2, False)
    far = np.full((1, 2, 3), 5.0)
    joints = legs.joints_at(far)
    assert np.isfinite(joints).all()
    assert (np.linalg.norm(far - legs.places_of(joints), axis=2)
            < np.linalg.norm(far, axis=2)).all()  # fmt: skip


def planar(seed: int, joints: int, legs: int = 4) -> Chains:
    """Legs of random lengths, anywhere, that bend in a plane; a first of three joints turns it."""
    draw = np.random.default_rng(seed)
    basis = np.linalg.qr(draw.normal(size=(legs, 3, 3)))[0]
    along = draw.uniform(-0.1, 0.1, (legs, 4, 3))
    along[:, :, 0] += [0.0, 0.15, 0.15 + 0.2 * draw.choice([-1.0, 1.0]), 0.15]
    along[:, :, 2] += [0.0, 0.0, -0.4, -0.8]
    sides = draw.choice([-1.0, 1.0], (2, legs, 1))
    axis = [basis[:, 0], sides[0] * basis[:, 1], sides[1] * basis[:, 1]][3 - joints :]
    points = np.einsum("lpk,lkx->lpx", along, basis)[:, 3 - joints :]
    turn = np.full((legs, joints), 1.2)
    numbers = np.stack(axis, 1), points[:, :-1], 0.0 * turn, points[:, -1], -turn, turn
    return Chains(*(np.asarray(x, np.float32) for x in numbers))


@pytest.mark.parametrize("joints", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_legs_that_bend_in_a_plane_have_a_closed_form(seed, joints):
    chains = planar(seed, joints)
    assert has_closed_form(chains)
    draw = np.random.default_rng(seed)
    joined = draw.uniform(-0.3, 0.3, (joints, len(chains.foot), 64)).astype("f")
    expected = kinematics(chains, list(joined))[0]
    result, reached = direct(chains, expected)
    assert (np.asarray(reached) == 1.0).all()
    assert np.stack(result) == pytest.approx(joined, abs=1e-4)
    place = [x - chains.foot[:, i, None] for i, x in enumerate(expected)]
    assert np.asarray(solved(chains, place)) == pytest.approx(joined, abs=1e-4)


@pytest.mark.parametrize("name", ["hexapod", "servo_quadruped", "boom_leg"])
def test_a_foot_of_an_example_goes_wherever_its_joints_can_put_it(name):
    model = mujoco.MjModel.from_xml_path(
        str(ROOT / "src" / "tegotae_robots" / "examples" / f"{name}.xml")
    )
    legs = legs_of(model, lowest_feet(model))
    expected = legs.places_of(drawn(legs, 1.0, lanes=100))
    assert legs.places_of(legs.joints_at(expected)) == pytest.approx(
        expected, abs=1e-5 * legs.length_m
    )


@pytest.mark.parametrize(
    ("low", "high"),
    [
        pytest.param((-0.5, -0.2), (0.5, 2.0), id="knee"),
        pytest.param((-0.5, -2.0), (0.5, 0.2), id="knee to the other side"),
        pytest.param((-0.5, -0.2), (4.5, 0.2), id="hip beyond half a turn"),
        pytest.param((-4.5, -0.2), (0.5, 0.2), id="hip beyond half a turn back"),
    ],
)
def test_a_closed_form_takes_the_side_and_the_turn_that_limits_allow(low, high):
    points = [[[0.0, 0.0, 0.0], [0.1, 0.0, -0.5]]]
    turns = [[[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]]
    numbers = turns, points, [[0.0, 0.0]], [[0.0, 0.0, -1.0]], [low], [high]
    chains = Chains(*(np.asarray(x, np.float32) for x in numbers))
    assert has_closed_form(chains)
    joined = np.random.default_rng(0).uniform(low, high, (200, 1, 2)).T.astype("f")
    expected = kinematics(chains, list(joined))[0]
    result, reached = direct(chains, expected)
    assert (np.asarray(reached) == 1.0).all()
    assert np.stack(kinematics(chains, result)[0]) == pytest.approx(np.stack(expected), abs=1e-5)


SPRUNG = sprung_robot()
FEET = tuple(f"foot{i}" for i in range(4))
STEP_S = 16 * mujoco.MjModel.from_xml_string(SPRUNG).opt.timestep
SETTINGS = ModelSettings(model=SPRUNG, feet=FEET, legs=True, control_s=STEP_S)


def test_actions_are_places_and_observations_say_what_feet_bear():
    env = ModelEnv(SETTINGS)
    assert env.action_names[:3] == ("foot0_x", "foot0_y", "foot0_z")
    assert env.action_space.shape == (12,)
    observation, _ = env.reset(seed=0)
    for _ in range(300):
        observation, *_ = env.step(np.zeros(12, np.float32))
    felt = dict(zip(env.observation_names, observation, strict=True))
    assert sum(felt[f"{foot}_force"] for foot in FEET) == pytest.approx(9.81, rel=0.01)
    for foot in FEET:
        assert felt[f"{foot}_estimated_force"] == pytest.approx(felt[f"{foot}_force"], abs=0.1)
    env.close()


def test_servos_meet_a_place_but_for_their_stiffness():
    sensed = sensing(SETTINGS)
    assert sensed.legs is not None
    batch = ModelBatch(sensed, 1, STEP_S, threads=1)
    batch.reset(1.0)  # in flight, so that nothing bears on the feet
    expected = np.tile([0.05, 0.02, 0.04], (1, 4, 1))
    for _ in range(40):
        observation = batch.step(expected.reshape(1, -1))
    joints = observation[0, [sensed.names.index(name) for i in range(4) for name in
                      (f"roll{i}", f"pitch{i}", f"slide{i}")]]  # fmt: skip
    assert sensed.legs.places_of(joints.reshape(1, 4, 3)) == pytest.approx(expected, abs=0.02)
    batch.close()


def test_an_imu_has_the_trunks_angles_with_their_signs():
    sensed = sensing(dataclasses.replace(SETTINGS, legs=False))
    data = started(sensed.model)
    for angle, axis, name in ((0.2, 0, "roll"), (0.3, 1, "pitch"), (0.4, 2, "yaw")):
        data.qpos[3:7] = [np.cos(angle / 2), 0, 0, 0]
        data.qpos[4 + axis] = np.sin(angle / 2)
        data.qvel[3:6] = np.eye(3)[axis]
        mujoco.mj_forward(sensed.model, data)
        observation = dict(
            zip(sensed.names, sensed.observed(data.sensordata[None])[0], strict=True)
        )
        assert observation[f"root_{name}"] == pytest.approx(np.sin(angle))
        assert observation[f"root_{name}_rate"] == pytest.approx(1.0)


def test_a_shank_that_is_named_as_foot_bears_what_its_sole_does():
    model = jointed_robot(4, 2, 1)
    observation = {}
    for foot in ("leg0_1", "foot0"):
        batch = ModelBatch(sensing(ModelSettings(model=model, feet=[foot])), 1, 0.002, threads=1)
        batch.reset(-0.5)
        felt = np.array([batch.step(np.zeros((1, 2)))[0] for _ in range(400)])
        observation[foot] = felt[:, batch.sensing.names.index(batch.sensing.contacts[0])].max()
        batch.close()
    assert observation["leg0_1"] >= observation["foot0"]
    assert observation["leg0_1"] > 0.0


def test_a_controller_in_units_does_the_same_in_proportion():
    saved = resolve("quadruped-c").controller()
    plain = suggest_legs(SETTINGS).wiring
    env = ModelEnv(SETTINGS)
    units = Units(length_m=0.5, time_s=0.25, force_n=40.0)
    ones = dataclasses.replace(plain, units=Units()).holding(saved)
    scaled = dataclasses.replace(plain, units=units).holding(saved)
    assert scaled.omega == pytest.approx(ones.omega / 0.25)
    assert scaled.scales["spring_force"] == pytest.approx(40.0 * ones.scales["spring_force"])
    names, draw = env.observation_names, np.random.default_rng(0)
    loads = [names.index(f"{foot}_estimated_force") for foot in FEET]
    pilots = []
    for wiring, second in ((ones, 0.05), (scaled, 0.05 * 0.25)):
        wires, problems = look_up(env, dataclasses.replace(wiring, step_s=second))
        assert wires is not None, problems
        pilots.append(Pilot(wires, wiring, np.asarray(wiring.weights)[:, None]))
    for _ in range(20):
        observation = np.zeros((1, len(names)))
        observation[0, loads] = draw.uniform(0.0, 1.0, 4)
        pushed = pilots[0].act(observation)
        assert pilots[1].act(40.0 * observation) == pytest.approx(0.5 * pushed, rel=1e-4, abs=1e-6)
    assert pilots[1].feedback == pytest.approx(pilots[0].feedback / 0.25, rel=1e-4)
    env.close()


def paced():
    """A law whose stride grows with the frequency, from nothing at a half of its own."""
    system = recipe("load-p@quadruped-c").experiment().system
    names = [path[-1] for path in system.controller.weight_names]
    source = {"sigma": 0.3, "stride_m": 0.4, "lift_m": 0.1, "still_rad_per_s": 1.0}
    return SavedController(system, np.array([source.get(name, 0.0) for name in names]), "paced")


LAWS = {
    "vanilla": lambda: resolve("quadruped-c").controller(),
    "learned": lambda: resolve("zoo:AR-rF+range@quadruped-c").controller(),
    "paced": paced,
}


@pytest.mark.parametrize("law", LAWS)
def test_what_is_exported_counts_in_si_and_commands_as_the_environment_was_commanded(law, tmp_path):
    units = Units(length_m=0.5, time_s=0.25, force_n=40.0)
    suggested = dataclasses.replace(suggest_legs(SETTINGS).wiring, units=units)
    wiring = suggested.holding(LAWS[law]())
    env = ModelEnv(SETTINGS)
    wires, problems = look_up(env, wiring)
    assert wires is not None, problems
    pilot = Pilot(wires, wiring, np.asarray(wiring.weights)[:, None])
    observation, load_n = np.zeros((1, len(env.observation_names))), [3.0, 20.0, 0.0, 9.0]
    for foot, load in zip(FEET, load_n, strict=True):
        observation[0, env.observation_names.index(f"{foot}_estimated_force")] = load
    (tmp_path / "robot.xml").write_text(SPRUNG)
    experiment = EnvExperiment(
        name="law",
        spec=EnvSpec(env=str(tmp_path / "robot.xml"), settings=(("legs", True), ("feet", FEET))),
        wiring=dataclasses.replace(wiring, weights=None),
    )
    saved = SavedController(
        experiment.system, np.ravel(wiring.weights), "law", task=experiment.task
    )
    robot = RobotController(saved)
    phases = np.float32([[limb.phase_rad] for limb in wiring.limbs])
    level = {name: np.zeros((4, 1), np.float32) for name in robot.senses}
    decision = robot.decide(
        np.full((4, 1), wiring.omega, "float32"),
        robot.controller.oscillator.start(jnp.asarray(phases)),
        {**level, "spring_force": np.float32(load_n)[:, None]},
    )
    places = pilot.act(observation).reshape(4, 3)[:, [0, 2]].T
    assert np.asarray(decision.command)[:, :, 0] == pytest.approx(places, abs=1e-5)
    assert np.asarray(decision.feedback) == pytest.approx(pilot.feedback, rel=1e-4)
    env.close()


def test_a_law_that_a_tilt_alarmed_makes_shorter_steps_and_so_does_its_export():
    """1 s of the law is 0.25 s of the robot, whose alarm must rise as fast in proportion."""
    units = Units(length_m=0.5, time_s=0.25, force_n=40.0)
    law = recipe("wary@quadruped-c").experiment().system
    weights = np.array([6.0, 0.4, 0.1, 0.05, *[0.0] * 6, 0.5])
    suggested = dataclasses.replace(suggest_legs(SETTINGS).wiring, units=units)
    wiring = suggested.holding(SavedController(law, weights, "wary"))
    env = ModelEnv(SETTINGS)
    wires, problems = look_up(env, wiring)
    assert wires is not None, problems
    pilot = Pilot(wires, wiring, weights[:, None])
    tilted = np.zeros((1, len(env.observation_names)))
    tilted[0, env.observation_names.index("root_pitch")] = 0.2
    steps = [pilot.act(tilted).reshape(4, 3)[:, 0] for _ in range(40)]
    scaled = in_si(wires.controller, units)
    spread = scaled.spread(tuple(weights[:, None]))
    phases = jnp.asarray([[limb.phase_rad] for limb in wiring.limbs], jnp.float32)
    state = scaled.oscillator.start(phases)
    sensed = {name: jnp.zeros((4, 1)) for name in TiltReaction.READS + BalancedFoot.READS}
    sensed |= {"pitch": jnp.full((4, 1), 0.2)}
    for row in steps:
        signals = with_oscillator(scaled, Signals(sensed), state)
        decision = decide(scaled, spread, jnp.full((4, 1), wiring.omega), signals, state, 1.0)
        assert np.asarray(decision.command)[0, :, 0] == pytest.approx(row, abs=1e-4)
        state = held(state, decision.rate, wires.step_s)
    calm = 0.4 * units.length_m
    assert 0.1 < np.abs(steps[-1]).max() / calm < 0.5
    env.close()


@pytest.mark.thorough
def test_a_walkers_law_walks_as_fast_in_proportion_on_a_robot_of_its_form(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(SPRUNG)
    where = ["--feet", *FEET, "--settings", "legs=true"]
    assert not main(["wiring", "suggest", "robot.xml", *where, "--out", "q.toml"])
    walk = tg.load("quadruped-c@q.toml").simulate(duration_s=8.0).numbers
    plain = tg.load("quadruped-c").simulate().numbers
    assert walk["lasted"] == 1.0
    assert walk["speed_m_per_s"] / np.sqrt(9.81) == pytest.approx(plain["speed_m_per_s"], rel=0.15)


@pytest.mark.parametrize(
    ("file", "feet", "together"),
    [
        ("servo_quadruped.xml", ("FL", "FR", "RL", "RR"), {"FL", "RR"}),
        pytest.param(
            *("hexapod.xml", ("LF", "LM", "LH", "RF", "RM", "RH"), {"LM", "RF", "RH"}),
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_a_law_of_four_legs_stands_on_any_number_and_neighbours_alternate(file, feet, together):
    robot = str(ROOT / "src" / "tegotae_robots" / "examples" / file)
    names = tuple(f"{foot}_foot" for foot in feet)
    settings = ModelSettings(model=robot, feet=names, legs=True, release_m=0.01)
    wiring = suggest_legs(settings).wiring.holding(resolve("quadruped-c").controller())
    begin = {foot for foot, limb in zip(feet, wiring.limbs, strict=True) if not limb.phase_rad}
    assert begin == together
    env = ModelEnv(settings)
    wires, problems = look_up(env, wiring)
    assert wires is not None, problems
    assert wires.controller.limbs == len(feet)
    pilot = Pilot(wires, wiring, np.asarray(wiring.weights)[:, None])
    observation, _ = env.reset(seed=0)
    for _ in range(round(3.0 / wires.step_s / 4)):
        observation, _, ended, *_ = env.step(pilot.act(observation[None])[0].astype(np.float32))
        assert not ended
    env.close()


def test_a_leg_on_a_boom_hops_under_a_walkers_law(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / "boom_leg.xml")
    where = ["--feet", "foot", "--settings", "legs=true"]
    assert not main(["wiring", "suggest", model, *where, "--out", "boom.toml"])
    law = "zoo:AR-rF+range@boom.toml"
    assert not main(["wiring", "transfer", law, "--omega", "40", "--out", "boom.json"])
    hops = tg.load("boom.json").simulate(duration_s=4.0).numbers
    assert hops["speed_m_per_s"] > 0.7
    assert hops["duty"] < 0.9


def test_the_workspace_of_two_links_is_what_the_law_of_cosines_says(tmp_path):
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / "boom_leg.xml")
    legs = sensing(ModelSettings(model=model, feet=["foot"], legs=True)).legs
    assert legs is not None
    along, within = workspace(legs, (0, 2))
    hip_m = legs.height_m
    x, up = np.meshgrid(along, along - hip_m, indexing="ij")
    away_m = np.hypot(x, up)
    nearest_m, furthest_m = (2.0 * 0.16 * np.cos(knee / 2.0) for knee in (2.6, 0.2))
    below = up < -0.1 * hip_m
    clearly = 0.01 + 0.005 * hip_m
    outside = (away_m < nearest_m - clearly) | (away_m > furthest_m + clearly)
    assert not within[..., 0][below & outside].any()
    inside = (away_m > nearest_m + clearly) & (away_m < furthest_m - clearly)
    assert within[..., 0][inside & (np.abs(x) < 0.1) & (up < -0.06)].all()

    suggest = ["wiring", "suggest", model, "--feet", "foot", "--settings", "legs=true"]
    out, picture = str(tmp_path / "boom.toml"), tmp_path / "boom.png"
    assert not main([*suggest, "--out", out, "--plot", str(picture)])
    assert picture.stat().st_size > 5000


@pytest.mark.parametrize(
    ("change", "feet", "message"),
    [
        ({}, (), "name the feet, --feet"),
        ({}, ("foot0", "foot0"), "foot0 is named twice in feet"),
        ({}, ("trunk",), "no actuator moves a joint between the trunk and trunk"),
        ({"model": "quadruped"}, FEET, "the leg of foot0 has no length"),
        ({"model": "leg"}, ("foot",), "servo_nm_per_rad=K"),
        ({"servo_damping_nms_per_rad": 1.0, "legs": False}, FEET, "give servo_nm_per_rad"),
    ],
)
def test_what_cannot_be_commanded_to_places_is_said_in_one_line(change, feet, message):
    refused(message, lambda: sensing(dataclasses.replace(SETTINGS, **{"feet": feet, **change})))


SERVOS = ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml"
OTHER_SERVOS = '<general name="FL_hip" joint="FL_hip" gainprm="{}" biastype="affine" biasprm="{}"/>'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<position name="FL_hip"', '<velocity name="FL_hip"', "give it one <position> actuator"),
        ('<position name="FL_hip"', '<intvelocity actrange="-1 1" name="FL_hip"', "give it one"),
        ('<position name="FL_hip" joint="FL_hip"/>', OTHER_SERVOS.format(9, "0 -18"), r"k \(u - q"),
        ('<position name="FL_hip" joint="FL_hip"/>', OTHER_SERVOS.format(9, "1 -9"), r"k \(u - q"),
        ('<body name="trunk"', '<body name="ball"><freejoint/><geom size="0.1"/></body><body'
         ' name="trunk"', "FL_foot does not hang on ball.*without=ball"),
        ('timestep="0.001"', 'gravity="0 0 0"', "no weight to take scales from"),
    ],
)  # fmt: skip
def test_a_robot_whose_feet_go_elsewhere_is_refused_in_one_line(old, new, message, tmp_path):
    file = tmp_path / "robot.xml"
    text = SERVOS.read_text(encoding="utf-8").replace(old, new, 1)
    file.write_text(text[: text.index("<keyframe>")] + "</mujoco>" if "ball" in new else text)
    feet = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
    refused(message, lambda: suggest_legs(ModelSettings(model=str(file), feet=feet, legs=True)))


def test_a_servos_range_of_commands_limits_its_joint():
    text = SERVOS.read_text(encoding="utf-8")
    old, narrow = (
        '<position name="FL_knee"',
        '<position gear="2" ctrlrange="-3 -2.5" name="FL_knee"',
    )
    model = mujoco.MjModel.from_xml_string(text.replace(old, narrow))
    legs = legs_of(model, ["FL_foot"])
    ends = legs.start[0, 2] + np.array([legs.chains.low[0, 2], legs.chains.high[0, 2]])
    np.testing.assert_allclose(ends, [-1.5, -1.25], atol=1e-6)


def test_the_foot_of_a_shank_is_the_end_that_it_stands_on():
    text = SERVOS.read_text(encoding="utf-8").replace('<geom class="foot"/>', "")
    model = mujoco.MjModel.from_xml_string(text)
    data = started(model)
    knee, along = data.body("FL_shank").xpos, data.body("FL_shank").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(foot_place(model, data, "FL_shank"), knee - 0.13 * along)


@pytest.mark.parametrize(("turn", "said"), [("1 0 0 0", False), ("0.7071 0 0 0.7071", True)])
def test_a_start_that_faces_aside_is_remarked_on(turn, said, tmp_path):
    file = tmp_path / "robot.xml"
    text = SERVOS.read_text(encoding="utf-8")
    file.write_text(text.replace("0.202 1 0 0 0", f"0.202 {turn}"))
    feet = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
    remarks = suggest_legs(ModelSettings(model=str(file), feet=feet, legs=True)).remarks
    assert any("start faces 90° from x" in remark for remark in remarks) == said


def test_units_are_above_zero():
    refused("time_s is 0", Units, time_s=0.0)
