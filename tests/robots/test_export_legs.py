"""Exported laws on a robot's legs: the inverse kinematics in C are those of the package."""

import ctypes
import dataclasses
import importlib
import subprocess

import mujoco
import numpy as np
import pytest

import tegotae as tg
from compiled import FLAGS, needs_gcc
from jointed import jointed_robot
from places import ROOT
from refusals import refused
from sprung import sprung_robot
from tegotae.cli import main
from tegotae.envs.command import over_feet
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.legs import legs_of
from tegotae.envs.mujoco.sensing import leg_odometry
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.c import Export
from tegotae_robots.c.legs import leg_pieces
from tegotae_robots.live import LiveController
from tegotae_robots.models.suggesting_legs import suggest_legs
from tegotae_robots.robot import compiled

ROBOTS = {
    "servo_quadruped": [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")],
    "hexapod": [f"{leg}_foot" for leg in ("LF", "LM", "LH", "RF", "RM", "RH")],
    "sprung": [f"foot{i}" for i in range(4)],
    "boom_leg": ["foot"],
}
TURN_RAD = 2.0 * np.pi
pytestmark = needs_gcc


SLOW = {"servo_quadruped", "hexapod"}
"""Robots whose wiring takes long to suggest."""


@pytest.fixture(
    scope="module",
    params=[pytest.param(x, marks=[pytest.mark.thorough] if x in SLOW else []) for x in ROBOTS],
)
def exported(request, tmp_path_factory):
    """A walker's law on a robot, its C in a folder, and the C as a library."""
    folder, feet = tmp_path_factory.mktemp(request.param), ROBOTS[request.param]
    model = ROOT / "src" / "tegotae_robots" / "examples" / f"{request.param}.xml"
    if request.param == "sprung":
        model = folder / "sprung.xml"
        model.write_text(sprung_robot())
    where = ["--feet", *feet, "--settings", "legs=true"]
    wiring, law = str(folder / "legs.toml"), str(folder / "law.json")
    assert not main(["wiring", "suggest", str(model), *where, "--out", wiring])
    assert not main(["wiring", "transfer", f"quadruped-c@{wiring}", "--out", law])
    assert not main(["export", "c", law, "--out", str(folder / "c")])
    command = ["gcc", *FLAGS, "-O2", "-shared", "-fPIC", "tegotae.c", "-lm", "-o", "tegotae.so"]
    subprocess.run(command, check=True, cwd=folder / "c")
    export = Export(resolve(law).controller(), tick_s=0.01)
    return export, folder / "c", ctypes.CDLL(str(folder / "c" / "tegotae.so"))


def pointer(array: np.ndarray):
    return array.ctypes.data_as(ctypes.c_void_p)


def places_within(export, share: float) -> np.ndarray:
    """Places of feet that turning or sliding joints by a share of their range leads to."""
    legs, draw = export.legs, np.random.default_rng(1)
    room = np.minimum(np.minimum(legs.chains.high, -legs.chains.low), 0.5)
    moved = share * room * draw.uniform(-1.0, 1.0, (64, *room.shape))
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    return legs.places_of(legs.start + unit * moved)


def test_joints_in_c_put_the_feet_where_the_law_has_them(exported):
    export, _, library = exported
    legs, places = export.legs, places_within(export, 0.5)
    places[..., 1] = 0.0  # the law commands ahead and up alone
    expected = legs.joints_at(places)
    for place, golden in zip(places, expected, strict=True):
        out = np.zeros((5, export.limbs), np.float32)
        out[:2] = place[:, [0, 2]].T
        joints = np.zeros(golden.shape, np.float32)
        library.tegotae_joints(pointer(out), pointer(joints))
        assert joints == pytest.approx(golden, abs=1e-6)


@pytest.mark.parametrize("joints", [1, 4])
def test_legs_without_a_closed_form_go_to_c_whatever_their_number_of_joints(joints):
    model = mujoco.MjModel.from_xml_string(jointed_robot(1, joints, 2))
    pieces = leg_pieces(legs_of(model, ["foot0", "foot1"]))
    assert [piece.name for piece in pieces] == ["nearer", "load"]


def test_a_place_out_of_reach_gives_joints_within_their_limits(exported):
    export, _, library = exported
    legs = export.legs
    unit = np.where(legs.chains.slides, legs.length_m, 1.0)
    for far_m in (3.4e38, -3.4e38, 10.0):
        out = np.full((5, export.limbs), far_m, np.float32)
        joints = np.zeros(legs.joints.shape, np.float32)
        library.tegotae_joints(pointer(out), pointer(joints))
        assert np.isfinite(joints).all()
        assert (joints >= legs.start + unit * legs.chains.low - 1e-5).all()
        assert (joints <= legs.start + unit * legs.chains.high + 1e-5).all()


def test_loads_in_c_are_those_of_the_torques(exported):
    export, _, library = exported
    legs, draw = export.legs, np.random.default_rng(2)
    joints = np.ascontiguousarray(legs.joints_at(places_within(export, 0.5)), np.float32)
    torques = draw.uniform(-2.0, 2.0, joints.shape).astype(np.float32)
    golden = np.maximum(legs.forces_n(joints, torques)[..., 2], 0.0)
    for angles, pulls, loads in zip(joints, torques, golden, strict=True):
        felt = np.zeros(export.limbs, np.float32)
        library.tegotae_loads(pointer(angles), pointer(pulls), pointer(felt))
        assert felt == pytest.approx(loads, rel=1e-4, abs=1e-4 * np.abs(golden).max())


def test_the_check_of_an_export_finds_a_leg_that_is_another(exported, tmp_path):
    _, folder, _ = exported
    source = (folder / "tegotae.c").read_text()
    length = source.split("LENGTH_M = ")[1].split(";")[0]
    for name, text in (("same", source), ("other", source.replace(f"= {length}", "= 0.5f"))):
        (tmp_path / f"{name}.c").write_text(text)
        words = [*FLAGS, "-O1", f"-I{folder}", f"{name}.c", folder / "test_tegotae.c", "-lm"]
        subprocess.run(["gcc", *words, "-o", name], check=True, cwd=tmp_path)
        ran = subprocess.run([tmp_path / name], capture_output=True, text=True)
        assert ran.returncode == (name == "other"), ran.stdout


def saved_law(name: str, folder, **settings) -> SavedController:
    """A law with some weights on a robot, in `law.json` of a folder."""
    settings = {"feet": ROBOTS["sprung"], "legs": True, **settings}
    model = folder / "sprung.xml"
    model.write_text(sprung_robot())
    wiring = suggest_legs(ModelSettings(model=str(model), **settings)).wiring
    spec = EnvSpec(env=str(model), settings=tuple(settings.items())).for_wiring(wiring)
    experiment = EnvExperiment.from_recipe(recipe(f"{name}@quadruped-c"), spec, wiring)
    weights = np.random.default_rng(0).uniform(0.01, 0.3, experiment.controller.n_weights)
    saved = SavedController(experiment.system, weights, "law", task=experiment.task)
    save(saved, folder / "law.json")
    return saved


@pytest.mark.parametrize(
    ("name", "axes", "settings"),
    [
        ("clock-s", 3, {}),
        ("clock-p", 2, {}),
        ("wary", 2, {}),
        ("raibert", 3, {"command": [0, 0, 0]}),
    ],
)
def test_a_law_goes_to_c_that_steps_aside_whose_stride_grows_or_that_is_wary_or_commanded(
    tmp_path, name, axes, settings, monkeypatch
):
    saved_law(name, tmp_path, **settings)
    assert not main(["export", "c", str(tmp_path / "law.json"), "--out", str(tmp_path / "c")])
    words = ["gcc", *FLAGS, "-O1", "tegotae.c", "test_tegotae.c", "-lm", "-o", "check"]
    subprocess.run(words, check=True, cwd=tmp_path / "c")
    checked = subprocess.run(["./check"], cwd=tmp_path / "c", capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
    assert ("foot_y_m" in (tmp_path / "c" / "tegotae.h").read_text()) == (axes == 3)
    # The example of a node sends feet no further than their reach, to the side too.
    monkeypatch.syspath_prepend(ROOT / "examples" / "hardware")
    node = importlib.import_module("commanded_law").CommandedLaw(tmp_path / "c")
    if name == "raibert":
        joints = np.zeros((4, len(node.joints) // 4))
        node.odometry(joints, joints, np.zeros(3))
        node.command(0.3, 0.1, 0.2)
    felt = dict.fromkeys(importlib.import_module("legged_link").IMU, 0.9)
    for _ in range(30 if name == "raibert" else 1):  # a placed foot goes on its way
        node.step(felt, 0.01)
    places = np.abs(node.outputs.reshape(-1)[: axes * 4])
    assert places.max() <= np.float32(0.01)
    assert places[-4:].max() > 0.005


def test_a_body_without_hips_that_turn_refuses_a_law_that_steps_aside(capsys):
    assert main(["simulate", "clock-s@quadruped-c"]) == 2
    assert "foot_y, and a Walker takes foot_x and foot_z" in capsys.readouterr().err


def test_commands_and_odometry_in_c_are_those_of_the_environment(tmp_path):
    saved = saved_law("raibert", tmp_path, command=[0, 0, 0])
    assert not main(["export", "c", str(tmp_path / "law.json"), "--out", str(tmp_path / "c")])
    command = ["gcc", *FLAGS, "-O1", "-shared", "-fPIC", "tegotae.c", "-lm", "-o", "tegotae.so"]
    subprocess.run(command, check=True, cwd=tmp_path / "c")
    library = ctypes.CDLL(str(tmp_path / "c" / "tegotae.so"))
    export = Export(saved, tick_s=0.01)
    legs, draw = export.legs, np.random.default_rng(3)
    row = {name: export.senses.index(name) for name in export.senses}
    senses = np.zeros((len(row), export.limbs), np.float32)
    library.tegotae_command(pointer(senses), *map(ctypes.c_float, (0.4, -0.1, 0.2, 0.2 + TURN_RAD)))
    expected = over_feet(np.array([[0.4, -0.1, 0.6]]), legs.feet_m[:, :2])[0]
    assert pytest.approx(expected, abs=1e-6) == senses[[row["commanded_x"], row["commanded_y"]]].T
    fastest = np.linalg.norm(expected, axis=1).max()
    assert senses[row["commanded_speed"]] == pytest.approx(np.full(export.limbs, fastest))
    joints, rates = legs.start[None], draw.normal(size=(1, *legs.start.shape))
    joints = joints + draw.uniform(-0.05, 0.05, joints.shape)
    turning = draw.normal(size=(1, 3))
    golden = leg_odometry(legs, joints, rates, turning)[0]
    arrays = (np.ascontiguousarray(x[0], np.float32) for x in (joints, rates, turning))
    library.tegotae_odometry(pointer(senses), *map(pointer, arrays))
    odometry = senses[[row["odometry_x"], row["odometry_y"]]].T
    assert odometry == pytest.approx(golden, rel=1e-4, abs=1e-5)


def test_a_live_controller_takes_commands_and_stops_without(tmp_path):
    native = compiled(saved_law("raibert", tmp_path, command=[0, 0, 0]))
    live = LiveController(native)
    measuring = LiveController(dataclasses.replace(native, feet_m=()))
    senses = dict.fromkeys((*live.senses, "commanded_x", "commanded_y", "commanded_speed"), 0.0)
    for command in (None, (0.4, -0.1, 0.6)):
        if command is not None:
            live.command(*command)
            expected = over_feet(np.array([command]), np.array(native.feet_m))[0]
            senses["commanded_x"], senses["commanded_y"] = expected.T
            senses["commanded_speed"] = np.linalg.norm(expected, axis=1).max()
        for _ in range(30):
            expected = measuring.step(senses, dt_s=0.01)
            measured = {name: x for name, x in senses.items() if "commanded" not in name}
            assert live.step(measured, dt_s=0.01) == pytest.approx(expected, abs=1e-6)
    refused("takes no command", measuring.command, 0.1)
    refused("left_m_per_s is nan", live.command, 0.1, float("nan"))
    live.command(0.4, -0.1, 0.2, heading_error_rad=0.2 + TURN_RAD)
    assert live.step(measured, dt_s=0.01) == pytest.approx(measuring.step(senses, dt_s=0.01), 1e-5)


def test_a_law_with_commands_is_simulated_under_one_and_another_law_refuses_it(tmp_path):
    saved_law("raibert", tmp_path, command=[0, 0, 0])
    robot = tg.load(str(tmp_path / "law.json"))
    path = tmp_path / "path.csv"
    path.write_text(
        "time_s,forward_m_per_s,left_m_per_s,yaw_rate_rad_per_s\n0,0.1,0,0\n0.2,0,0,-0.5\n"
    )
    for command in (path, (str(path),)):
        table = robot.simulate(command=command, duration_s=0.4).table
        assert table.commanded_forward.max() == 0.1
        assert table.commanded_yaw_rate.iloc[-1] == -0.5
    assert "followed" in robot.evaluate(command=("0.1", "0", "0"), starts=1).table.columns
    refused("it must be three numbers", robot.simulate, command=(0.1, 0.2))
    saved_law("clock-s", tmp_path)
    plain = tg.load(str(tmp_path / "law.json"))
    refused("takes no command", plain.simulate, command=(0.1, 0.0, 0.0))
