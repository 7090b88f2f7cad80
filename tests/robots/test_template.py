"""A legged MuJoCo model gets the walker that stands for it, every number with its reason."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

import tegotae as tg
from places import ROOT
from refusals import refused
from sprung import CENTRE, DAMPING, FOOT, FRICTION, HIPS, INERTIA, STIFFNESS, sprung_robot
from tegotae.cli import main
from tegotae.envs.mujoco.settings import PACKAGED, ModelSettings
from tegotae.systems.vanilla import legged_named, legged_of
from tegotae_robots.models.step_response import StepResponse
from tegotae_robots.models.template import fit_template

ROBOT = sprung_robot()
SERVOS = ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml"
ROLL = r'<joint name="roll3".*?/>'
SLIDES = r"<(joint|position) name=\"slide\d\".*?/>"


def fitted(model: str, **settings):
    return fit_template(ModelSettings(model=model, **settings), "mine")


@pytest.fixture(scope="module")
def template():
    return fitted(ROBOT)


@pytest.fixture(scope="module")
def quadruped():
    return fit_template(PACKAGED["quadruped"], "quadruped")


def test_legs_of_known_springs_and_dampers_have_these_numbers_at_their_feet(template):
    body = template.document["body"]
    for axis, stiffness in zip("xyz", STIFFNESS, strict=True):
        assert body[f"stiffness_{axis}_n_per_m"] == pytest.approx(stiffness, rel=1e-3)
    assert body["damping_xy_ns_per_m"] == pytest.approx((DAMPING[0] + DAMPING[1]) / 2, rel=1e-3)
    assert body["damping_z_ns_per_m"] == pytest.approx(DAMPING[2], rel=1e-3)
    assert body["friction"] == FRICTION
    assert (template.length_m, template.mass_kg) == pytest.approx((1.0, 1.0))


def test_mass_and_inertia_are_those_of_trunk_and_feet_together(template):
    places = np.array([CENTRE, *((x, y, -1.0 + 0.01) for x, y in HIPS)])
    masses = np.array([1.0 - 4.0 * FOOT, *[FOOT] * 4])
    centre = masses @ places
    arms = places - centre
    inertia = INERTIA + masses @ ((arms**2).sum(1, keepdims=True) - arms**2)
    body = template.document["body"]
    assert [body[f"com_{axis}_m"] for axis in "xyz"] == pytest.approx(list(centre), rel=1e-3)
    result = [body[f"inertia_{axis}_kg_m2"] for axis in "xyz"]
    assert result == pytest.approx(list(inertia), rel=1e-3)
    assert list(zip(body["hips_x_m"], body["hips_y_m"], strict=True)) == list(HIPS)


def test_legs_of_known_mass_and_joints_have_their_price(template):
    body = template.document["body"]
    for axis, damping in (("x", DAMPING[0]), ("z", DAMPING[2])):
        assert body[f"leg_mass_{axis}_kg"] == pytest.approx(FOOT, rel=0.03)
        assert body[f"joint_damping_{axis}_ns_per_m"] == pytest.approx(damping, rel=1e-3)


@pytest.mark.parametrize("name", ["template", "quadruped"])
def test_a_foot_in_the_air_costs_what_mujocos_inverse_dynamics_say(name, request):
    ours, its = request.getfixturevalue(name).swings
    assert ours == pytest.approx(its, rel=0.05)


def test_a_foot_that_does_not_reach_its_ellipse_has_no_price_to_compare():
    short = re.sub(
        r'(name="slide\d" type="slide") ', r'\1 range="-0.01 0.01" limited="true" ', ROBOT
    )
    assert math.isnan(fitted(short).swings[1])


@pytest.mark.parametrize(
    ("length_m", "mass_kg"), [pytest.param(0.25, 12.0, marks=pytest.mark.thorough), (3.0, 0.2)]
)
def test_a_larger_or_heavier_robot_of_the_same_form_has_the_same_template(
    template, length_m, mass_kg
):
    second = fitted(sprung_robot(length_m, mass_kg))
    assert (second.length_m, second.mass_kg) == pytest.approx((length_m, mass_kg))
    for name, number in template.numbers.items():
        assert second.numbers[name].value == pytest.approx(number.value, rel=1e-3, abs=1e-6), name
    assert second.push_n / (mass_kg * 9.81) == pytest.approx(2.0)
    for name, response in template.robot.responses.items():
        assert second.robot.responses[name] == pytest.approx(response, rel=0.02)


def test_the_walker_bounces_as_the_oscillator_that_its_numbers_make(template):
    rate = math.sqrt(4.0 * STIFFNESS[2])
    travel, frequency, damping = template.walker["bounce"]
    assert travel == pytest.approx(1.0 / (4.0 * STIFFNESS[2]), rel=0.02)
    assert frequency == pytest.approx(rate, rel=0.02)
    assert damping == pytest.approx(4.0 * DAMPING[2] / (2.0 * rate), rel=0.02)


@pytest.mark.parametrize("name", ["template", "quadruped"])
def test_the_walker_bounces_and_sways_as_the_robot_does_in_mujoco(name, request):
    result = request.getfixturevalue(name)
    for direction in ("bounce", "sway"):
        (*ours, damping), (*its, robots) = (
            result.walker[direction],
            result.robot.responses[direction],
        )
        assert ours == pytest.approx(its, rel=0.05)
        # Sprung legs are damped unlike fore and aft and sideways; a walker has one number for both.
        assert damping == pytest.approx(robots, rel=0.15)
    assert result.robot.sinks < 0.001
    assert result.remarks == ()


def test_a_response_without_an_overshoot_has_no_frequency():
    time = np.linspace(0.0, 30.0, 3000)
    travel, frequency, damping = StepResponse.from_motion(time, np.exp(-time))
    assert (travel, damping) == (pytest.approx(1.0), 1.0)
    assert math.isnan(frequency)


def test_a_leg_that_does_not_move_sideways_is_as_stiff_there_as_it_is_anywhere():
    planar = re.sub(r'<(joint|position) name="roll\d".*?/>', "", ROBOT)
    body = fitted(planar).document["body"]
    assert body["stiffness_y_n_per_m"] == body["stiffness_z_n_per_m"]


SPINE = """<body name="hind"><joint name="spine" axis="0 0 1" damping="1"/>
<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-6 1e-6 1e-6"/><body name="foot2" """


def test_a_joint_that_several_feet_hang_on_is_taken_for_rigid(template):
    jointed = re.sub('<body name="foot2" ', SPINE, ROBOT)
    end = jointed.index("</body>", jointed.index('<body name="foot3"'))
    servo = '<position joint="spine" kp="50"/></actuator>'
    jointed = f"{jointed[:end]}</body>{jointed[end:]}".replace("</actuator>", servo)
    body, without = fitted(jointed).document["body"], template.document["body"]
    for name in ("x", "y", "z"):
        entry = f"stiffness_{name}_n_per_m"
        assert body[entry] == pytest.approx(without[entry], rel=1e-3)


@pytest.mark.parametrize(("weakest", "torque_nm"), [("", 1.8), ("FL", 0.9), ("RR", 1.2)])
def test_the_largest_push_is_that_of_the_weakest_joint_of_the_weakest_leg(weakest, torque_nm):
    model = SERVOS.read_text(encoding="utf-8").replace(
        f'<position name="{weakest}_knee"',
        f'<position forcerange="-{torque_nm} {torque_nm}" name="{weakest}_knee"',
    )
    lever_m = 0.13 * math.sin(1.35 - 0.75)  # the foot is below the hip, so that hips bear little
    feet = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
    assert fitted(model, feet=feet).push_n == pytest.approx(torque_nm / lever_m, rel=1e-3)


def test_legs_that_differ_are_remarked_on_and_have_their_mean():
    softer = re.sub(r'(joint="slide3" kp)="[\d.]+"', rf'\1="{0.5 * STIFFNESS[2] * 9.81}"', ROBOT)
    result = fitted(softer)
    mean = STIFFNESS[2] * 3.5 / 4.0
    assert result.document["body"]["stiffness_z_n_per_m"] == pytest.approx(mean, rel=1e-3)
    assert ["K_z is 49.1 to 98.1 N/m" in remark for remark in result.remarks] == [True]


def test_a_stance_that_is_fast_gets_a_shorter_control_tick():
    stiff = re.sub(r'(joint="slide\d" kp)="[\d.]+"', r'\1="5000"', ROBOT)
    result = fitted(stiff)
    assert result.document["ticks"] in (0.5, 0.25)
    assert legged_of(result.document).timing.tick_s < legged_named("quadruped-c").timing.tick_s


@pytest.mark.parametrize(
    ("model", "settings", "said"),
    [
        (re.sub(r'<body name="foot.*?</body>', "", ROBOT, flags=re.S), {}, "no body|has 0 legs"),
        (ROBOT, {"feet": ["foot0"]}, "has 1 legs"),
        (re.sub('kp="[^"]*"', "", ROBOT.replace("<position", "<motor")), {}, "servo_nm_per_rad=K"),
        (re.sub(ROLL, "", re.sub(r'<position name="roll3".*?/>', "", ROBOT)), {}, "foot3 2"),
        (ROBOT.replace("<freejoint/>", '<joint type="slide" axis="0 0 1"/>'), {}, "<freejoint/>"),
        (re.sub('<geom name="ground".*?/>', "", ROBOT), {}, "--settings ground=true"),
        (re.sub(SLIDES, "", ROBOT), {}, "foot0 cannot move up and down"),
        (re.sub(r'(joint="slide\d" kp)="[\d.]+"', r'\1="2"', ROBOT), {}, "the robot collapses"),
    ],
)
@pytest.mark.filterwarnings("ignore:MuJoCo")
def test_a_model_without_a_template_is_refused_in_one_line(model, settings, said):
    # A model that has lost parts of its tree has lost their actuators, too.
    if 'name="foot' not in model:
        model = re.sub("<actuator>.*</actuator>", "", model, flags=re.S)
    refused(said, fitted, model, **settings)


@pytest.fixture
def robot_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(ROBOT)
    return Path("robot.xml")


def test_the_command_writes_a_walker_whose_file_is_a_systems_name(robot_file, capsys):
    main(["fit-template", str(robot_file)])
    message = capsys.readouterr().out
    assert "servos and springs through the leg's Jacobian" in message
    assert "bounce under its weight" in message
    assert "tegotae train AR@robot.toml" in message
    text = Path("robot.toml").read_text()
    assert "# contacts of the feet with the ground" in text
    assert legged_named("robot.toml") == legged_of(tomllib.loads(text))
    assert tomllib.loads(text)["body"]["stiffness_x_n_per_m"] == STIFFNESS[0]


@pytest.mark.parametrize(
    ("command", "file", "ending"),
    [
        ("fit-template no-such-model.xml", "a.json", ".toml"),
        ("wiring suggest no-such-model.xml", "a.txt", ".toml"),
        ("identify no-such-log.csv", "a.csv.txt", ".toml"),
        ("wiring transfer quadruped-c --env no-such-model.xml", "a.toml", ".json"),
    ],
)
def test_an_ending_that_its_file_cannot_have_is_refused_before_the_model_is_read(
    command, file, ending, capsys
):
    assert main([*command.split(), "--out", file]) == 2
    assert f"{file} must end in {ending}" in capsys.readouterr().err


def test_a_file_that_is_there_or_ends_otherwise_is_not_written(robot_file):
    answer = tg.robots.fit_template(str(robot_file))
    answer.save("robot.toml")
    for name, message in (("robot.toml", "exists already"), ("robot.txt", r"must end in \.toml")):
        refused(message, answer.save, name)
    assert answer.to_dict()["sigma"] == 1.25
    refused("is no MuJoCo model", tg.robots.fit_template, "Hopper-v5")


def test_nothing_is_written_for_a_model_without_a_template(robot_file, capsys):
    robot_file.write_text(ROBOT.replace("<freejoint/>", ""))
    assert main(["fit-template", str(robot_file)]) == 2
    assert "<freejoint/>" in capsys.readouterr().err
    assert not Path("robot.toml").exists()
