"""Legs of a model are what is assumed of them, or are refused or remarked on in one line."""

import dataclasses
import re

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from places import ROOT
from refusals import refused
from tegotae import TegotaeError
from tegotae.envs.mujoco.env import ModelEnv
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import lowest, started
from tegotae.envs.wires import look_up
from tegotae.envs.wrapper import Pilot
from tegotae.systems.resolve import resolve
from tegotae_robots.models.suggesting import suggest_wiring
from tegotae_robots.models.suggesting_legs import suggest_legs
from tegotae_robots.models.template import fit_template

ROBOT = (ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml").read_text(
    encoding="utf-8"
)
FEET = tuple(f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR"))
SOLE = '<body name="FL_foot" pos="0 0 -0.13"><geom class="foot"/>'
ANKLE = SOLE.replace(
    "<geom", '<joint name="ankle" axis="0 1 0" range="-60 60" {}/><geom pos="0.03 0 0"'
)
KEY = "0.75 -1.35  0 0.75 -1.35  0 0.75 -1.35  0 0.75 -1.35"


def with_ankle(spring: str) -> str:
    """The robot with a joint at a foot that nothing drives."""
    return ROBOT.replace(SOLE, ANKLE.format(spring)).replace(f"{KEY}", f"{KEY[:10]} 0 {KEY[10:]}")


def closed(constraint: str) -> str:
    """The robot with an equality constraint."""
    return ROBOT.replace("<keyframe>", f"<equality>{constraint}</equality><keyframe>")


def posed(key: str) -> str:
    """The robot with other angles in its keyframe."""
    return ROBOT.replace(KEY, key)


def settings(model: str, **changes) -> ModelSettings:
    return ModelSettings(**{"model": model, "feet": FEET, "legs": True, **changes})


LOOP = '<connect name="bar" body1="FL_shank" body2="trunk" anchor="0 0 0"/>'
COUPLED = '<joint name="belt" joint1="FL_knee" joint2="FL_hip"/>'
SOFT = ROBOT.replace('<position kp="20"', "<motor").replace("<position", "<motor")


@pytest.mark.parametrize(
    ("model", "changes", "message"),
    [
        (with_ankle('stiffness="0.1"'), {}, r"nothing drives joint ankle, and the foot FL_foot yi"),
        (with_ankle(""), {}, r"yields there by 0\.0\d+ m under 6\.\d+ N, its share"),
        (closed(LOOP), {}, "constraint bar closes the leg of FL_foot"),
        (closed(COUPLED), {}, "constraint belt closes the leg of FL_foot"),
        (posed(KEY.replace("-1.35", "-0.2", 1)), {}, r"FL_knee starts at -0\.2, outside its limit"),
        (posed(KEY.replace("0.75 -1.35", "-1 -2.4")), {}, r"no stance: the first joint of FL_foot"),
        (posed(KEY.replace("0.75 -1.35", "1.4 -2.4", 1)), {}, r"no stance: FL_foot is 0\.\d+ m hi"),
        (ROBOT, {"start": "walk"}, "no keyframe of this model is called 'walk'; known: stand"),
        (ROBOT, {"start": {"knee": 0.0}}, "no hinge or slide of this model is called 'knee'"),
        (ROBOT, {"start": {"FL_knee": float("nan")}}, "start is .* it must be the name of a keyf"),
        (ROBOT, {"start": 3}, "start is 3; it must be the name of a keyframe"),
        (ROBOT.replace('kp="20"', 'kp="0.05"'), {}, r"asked 0\.019 m up, .* and misses by"),
    ],
)
def test_a_model_whose_legs_are_not_as_assumed_is_refused_in_one_line(model, changes, message):
    refused(message, lambda: suggest_legs(settings(model, **changes)))


@pytest.mark.parametrize("fit", [suggest_wiring, lambda x: fit_template(x, "mine")])
def test_closed_chains_are_refused_wherever_jacobians_of_legs_are_taken(fit):
    with pytest.raises(TegotaeError, match="constraint bar closes the leg of FL_foot"):
        fit(settings(closed(LOOP), legs=False))


def test_a_stiff_spring_at_a_foot_or_a_constraint_elsewhere_leaves_a_leg_as_it_is():
    assert sensing(settings(with_ankle('stiffness="20"'))).legs is not None
    pack = '<body name="pack"><freejoint/><geom size="0.01"/></body></worldbody>'
    welded = closed('<weld body1="pack" body2="trunk"/>').replace("</worldbody>", pack)
    bent = {foot.replace("foot", "knee"): -1.35 for foot in FEET}
    assert sensing(settings(re.sub("<key .*/>", "", welded), start=bent)).legs


@pytest.mark.parametrize(
    ("model", "changes", "remarks"),
    [
        (ROBOT, {}, []),
        (ROBOT.replace("0.202 1 0", "0.15 1 0"), {}, [r"0.052 m in the ground", "release_m=0.06"]),
        (ROBOT.replace("0.202 1 0", "0.15 1 0"), {"release_m": 0.06}, []),
        (ROBOT.replace('kp="20"', 'kp="0.4"'), {}, ["the trunk held in the air", "sinks to"]),
        (SOFT, {"servo_nm_per_rad": 3.0}, ["sinks to", "servo_nm_per_rad="]),
    ],
)
def test_what_a_law_would_stumble_over_is_remarked_on_with_the_way_out(model, changes, remarks):
    message = " ".join(suggest_legs(settings(model, **changes)).remarks)
    assert all(remark in message for remark in remarks), message
    assert bool(message) == bool(remarks)


TAIL = (
    '<body name="tail" pos="-0.13 0 0"><joint name="tail" axis="0 1 0" range="-90 90"/>'
    '<geom class="link" fromto="0 0 0 -0.2 0 0" mass="0.1"/></body><body name="FL_hip"'
)


def with_tail(ctrl: str) -> str:
    """The robot with a servo that no limb drives, at 0.9 rad in the keyframe."""
    model = ROBOT.replace('<body name="FL_hip"', TAIL, 1)
    model = model.replace("</actuator>", '<position name="tail" joint="tail"/></actuator>')
    return model.replace("1 0 0 0  0 0.75", "1 0 0 0  0.9 0 0.75").replace(
        f'{KEY}"', f'{KEY}" {ctrl}'
    )


COMMANDS = f'ctrl="0 {KEY} 0.7"'


@pytest.mark.parametrize(("ctrl", "command"), [("", 0.9), (COMMANDS, 0.7)])
@pytest.mark.parametrize("legs", [True, False])
def test_an_actuator_that_no_limb_drives_keeps_the_keyframe(ctrl, command, legs):
    env = ModelEnv(settings(with_tail(ctrl), legs=legs))
    suggest, law = (suggest_legs, "quadruped-c") if legs else (suggest_wiring, "V-sector-w8")
    wiring = suggest(env.settings).wiring
    if legs:
        wiring = wiring.holding(resolve(law).controller())
    wires, problems = look_up(env, wiring)
    assert wires is not None, problems
    weights = np.zeros((wires.controller.n_weights, 2))
    acted = Pilot(wires, wiring, weights).act(np.zeros((2, len(env.observation_names))))
    assert acted[:, env.action_names.index("tail")] == pytest.approx(command)
    if legs:
        assert sensing(env.settings).controls(acted)[:, -1] == pytest.approx(command)
    env.close()


def test_a_leg_in_the_middle_is_neither_in_front_nor_behind_nor_on_a_side():
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / "hexapod.xml")
    feet = [f"{side}{place}_foot" for side in "LR" for place in "FMH"]
    limbs = suggest_legs(ModelSettings(model=model, feet=feet, legs=True)).wiring.limbs
    ends = [limb.senses["end_pitch"] for limb in limbs]
    assert ends == ["-root_pitch", "0", "root_pitch"] * 2
    assert [limb.senses["side_yaw"] for limb in limbs] == ["root_yaw"] * 3 + ["-root_yaw"] * 3
    boom = str(ROOT / "src" / "tegotae_robots" / "examples" / "boom_leg.xml")
    (limb,) = suggest_legs(ModelSettings(model=boom, feet=["foot"], legs=True)).wiring.limbs
    assert {limb.senses[name] for name in ("end_pitch", "side_roll", "side_yaw")} == {"0"}


def test_a_sense_that_is_wired_to_nothing_is_zero():
    env = ModelEnv(settings(ROBOT))
    wiring = suggest_legs(settings(ROBOT)).wiring.holding(
        resolve("zoo:AR-rF+range@quadruped-c").controller()
    )
    unfelt = [
        dataclasses.replace(limb, senses={**limb.senses, "spring_force": "0"})
        for limb in wiring.limbs
    ]
    wires, problems = look_up(env, dataclasses.replace(wiring, limbs=unfelt))
    assert wires is not None, problems
    weights = np.asarray(wiring.weights)[:, None]
    observation = np.zeros((1, len(env.observation_names)))
    observation[0, [env.observation_names.index(f"{foot}_estimated_force") for foot in FEET]] = 9.0
    felt, unloaded = look_up(env, wiring)[0], np.zeros_like(observation)
    assert felt is not None
    expected = Pilot(felt, wiring, weights).act(unloaded)
    np.testing.assert_array_equal(Pilot(wires, wiring, weights).act(observation), expected)
    env.close()


CROUCH = '<key name="crouch" qpos="0 0 0.12 1 0 0 0 {}"/></keyframe>'


def test_a_keyframe_or_joints_can_be_chosen_as_the_start():
    crouch = ROBOT.replace("</keyframe>", CROUCH.format("0 1.2 -2.3 " * 4))
    data = started(sensing(settings(crouch, start="crouch")).model)
    assert data.joint("FL_knee").qpos[0] == -2.3
    angles = {foot.replace("foot", "knee"): -1.6 for foot in FEET}
    angles |= {foot.replace("foot", "hip"): 0.8 for foot in FEET}
    sensed = sensing(settings(crouch, start=angles))
    data = started(sensed.model)
    assert data.joint("RR_knee").qpos[0] == -1.6
    moving = np.flatnonzero(sensed.model.geom_bodyid > 0).tolist()
    assert lowest(sensed.model, data, moving)[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        (
            "0.3",
            r"the robot collapses: under its weight it sinks by 0\.\d+ l0; give it stiffer ser",
        ),
        ("2", "the robot comes to rest on trunk, and not on its feet; give it stiffer servos"),
    ],
)
def test_no_template_is_fitted_to_a_robot_that_does_not_stand(stiffness, message):
    with pytest.raises(TegotaeError, match=message):
        fit_template(settings(ROBOT.replace('kp="20"', f'kp="{stiffness}"'), legs=False), "mine")
