"""A model of a robot on legs alone gets what it needs to stand: floor, servos, start, commands."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from places import ROOT
from programs import main
from refusals import refused
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.robot_file import load_robot
from tegotae.envs.scaling import foot_place, started
from tegotae_robots.models.suggesting_legs import suggest_legs
from tegotae_robots.models.suggesting_settings import suggest_settings

EXAMPLES = ROOT / "src" / "tegotae_robots" / "examples"
SERVOS = (EXAMPLES / "servo_quadruped.xml").read_text(encoding="utf-8")
FEET = ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
MOTORS = re.sub('<geom name="floor".*?/>', "", SERVOS).replace('<position kp="20"', "<motor")
MOTORS = MOTORS.replace("<position", "<motor").replace("-1.8 1.8", "-5 5")
"""The quadruped as public models of robots are: with motors, without a floor."""
STANCE = "0.75 -1.35"
LOW = MOTORS.replace('qpos="0 0 0.202', 'qpos="0 0 0.1')
"""Its keyframe is in the ground."""
ASKEW = MOTORS.replace(STANCE, "1.5 -0.4", 2)
"""Its keyframe is no stance."""

FIXED = re.sub("<keyframe>.*</keyframe>", "", MOTORS, flags=re.DOTALL).replace("<freejoint/>", "")
STRETCHED = MOTORS.replace('range="-60 90"', 'range="85 90"').replace('"-140 -20"', '"-30 -20"')
"""Its legs are level."""


def suggested(model: str, *names: str, **settings):
    base = ModelSettings(model=model, **settings)
    return base, suggest_settings(base, names)


def test_motors_become_servos_that_bear_the_weight_on_a_floor_that_is_added():
    base, suggestion = suggested(MOTORS)
    assert suggestion.values["ground"]
    # Of 24.5 N on legs of 0.188 m.
    assert suggestion.values["servo_nm_per_rad"] == pytest.approx(3.0 * 24.5 * 0.188, rel=0.05)
    assert "start" not in suggestion.values
    assert suggestion.values.keys() == suggestion.reasons.keys()
    (*remarks,) = suggest_legs(replace(base, **suggestion.values)).remarks
    assert remarks == []


def test_heavier_rotors_are_damped_more():
    _, light = suggested(MOTORS)
    _, heavy = suggested(MOTORS.replace('armature="0.002"', 'armature="0.02"'))
    name = "servo_damping_nms_per_rad"
    assert heavy.values[name] > 1.5 * light.values[name]


def test_a_start_in_the_ground_is_lifted_and_one_that_is_no_stance_is_replaced():
    for model, reason in ((LOW, "with the feet on the floor"), (ASKEW, "feet under their hips")):
        base, suggestion = suggested(model, "servo_nm_per_rad", servo_nm_per_rad=20.0)
        assert reason in suggestion.reasons["start"]
        sensed = sensing(replace(base, feet=FEET, **suggestion.values))
        assert sensed.legs is not None
        assert sensed.legs.height_m > 0.4 * sensed.legs.length_m
        places = [foot_place(sensed.model, started(sensed.model), foot) for foot in FEET]
        # Feet are spheres of 14 mm.
        assert [place[2] for place in places] == pytest.approx([0.014] * 4, abs=0.01)


def test_settings_that_are_given_stay():
    _, suggestion = suggested(MOTORS, "servo_nm_per_rad", "noise", servo_nm_per_rad=30.0, noise=0.0)
    assert not {"servo_nm_per_rad", "servo_damping_nms_per_rad", "noise"} & suggestion.values.keys()
    assert suggestion.values["ground"]


@pytest.mark.parametrize(
    ("model", "names"),
    [(MOTORS, ("legs",)), ("quadruped", ()), ("leg", ()), (FIXED, ())],
    ids=["legs are given", "legs of two joints", "one leg", "a trunk that is fixed"],
)
def test_for_any_other_model_there_are_none(model, names):
    assert not suggested(model, *names)[1].values


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (
            MOTORS.replace("<motor name", '<velocity kv="1" name', 1),
            "neither by motors alone nor by position servos alone; .* legs=false",
        ),
        (STRETCHED, "no stance was found for the legs of FL_foot, FR_foot, RL_foot, RR_foot"),
    ],
)  # fmt: skip
def test_what_cannot_stand_is_refused_in_a_line(model, message):
    refused(message, lambda: suggested(model))


def test_one_command_makes_the_robots_file_and_says_how_to_walk(tmp_path, capsys):
    file = tmp_path / "dog.toml"
    assert not main(
        ["wiring", "suggest", str(EXAMPLES / "servo_quadruped.xml"), "--out", str(file)]
    )
    assert "command = [0.0, 0.0, 0.0]  # forward, left" in Path(file).read_text(encoding="utf-8")
    assert "--command" in capsys.readouterr().out
    spec, wiring = load_robot(file)
    assert len(wiring.limbs) == 4
    assert {"legs", "noise", "release_m", "command"} <= dict(spec.settings).keys()
    assert "ground" not in dict(spec.settings)
