"""A first wiring of a MuJoCo model, read from the model itself, with the reason of every entry."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.env import ModelBatch
from tegotae.envs.mujoco.legs import LegKinematics, drive_of
from tegotae.envs.mujoco.rigid_legs import require_open_chains
from tegotae.envs.mujoco.sensing import Sensing, is_sound, sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import (
    centre_height_m,
    chain_of,
    foot_of,
    foot_place,
    gravity_m_per_s2,
    lowest,
    scales_of,
    started,
)
from tegotae.envs.wiring import Limb, Wiring

mujoco = require("mujoco", "mujoco")

_FOOT_SHARE = 0.2
"""Feet are no higher over the lowest one than this share of the length."""
_ACROSS = 0.25
"""A joint moves its foot up or along where this share of the foot's motion is in that direction."""
_LIFT = 4.0
"""Push of a joint that stretches the leg, over what bears the weight: the paper's α / (m g)."""
_SWEEP = 0.5
"""Push of a joint that sweeps the foot back, as a share of the weight; friction bears no more."""
_STROKE = 0.1
"""Stroke of a servo's push, as a share of the length."""
_RATE = 2.5
"""ω over √(g / l), as the paper's 8 rad/s on a leg of 1 m."""
_SAMPLES = 40.0
"""Control periods in √(l / g)."""
_DROP = 0.1
"""Height of the drop test over the model's start, as a share of the length."""
_LONGEST_S, _STANDS_S = 2.0, 1.0
_GIVES_WAY = 0.6


@dataclass(frozen=True)
class Suggestion:
    """A wiring that a model suggests."""

    wiring: Wiring
    """Without weights: it is to be trained."""
    reasons: Mapping[str, str]
    """Reasons by entry: `omega`, `scales.velocity`, `limbs[0].push`."""
    remarks: tuple[str, ...]
    """Omissions and obstacles: a sentence each."""
    on_rail: bool
    """True if the trunk goes up and down only, so that no return is for distance."""
    legs: LegKinematics | None = None
    """Those whose feet are commanded to places."""


@dataclass(frozen=True)
class _Joint:
    """An actuated joint of a leg."""

    actuator: str
    joint: str
    foot: int
    """Index of the foot that it moves."""
    kind: Literal["motor", "servo"]
    gain: float
    """Torque of a motor per command; 1 of a servo."""
    start: float
    """Its position at the start [rad or m]."""
    up: float
    """Rise of the trunk over a planted foot [m per rad, or m]."""
    along: float
    """The distance of the trunk over it, in the same way."""
    low: float
    high: float


def suggest_wiring(settings: ModelSettings) -> Suggestion:
    """Suggest a first wiring of a MuJoCo model: limbs, senses, rests, pushes, scales, ω and rest
    length.

    Feet that the settings do not name are the lowest bodies that end a chain. Every actuated joint
    between the trunk and one foot is a limb, which feels the load of its foot: a spring along the
    leg where the model has one, and otherwise the contact force. A joint that stretches the leg
    pushes with four times what bears the weight, as the paper's hopper does; one that only sweeps
    the foot back pushes with half of the weight, and is left alone where the trunk is on a rail and
    goes up and down only; within the actuator's limits. The rest length is the trunk's height at
    touchdown in a drop test without control.

    It is a start for training, not a tuned gait.

    Args:
        settings: of the model; its control period does not count.

    Raises:
        TegotaeError: for a model without feet, limbs or ground, or one whose trunk cannot fall.

    Example:
        >>> from tegotae.envs.mujoco.settings import PACKAGED
        >>> suggest_wiring(PACKAGED["leg"]).wiring.limbs[1].drives  # doctest: +SKIP
        'knee'
    """
    explicit = bool(settings.feet)
    if not explicit:
        settings = replace(settings, feet=lowest_feet(sensing(settings).model))
    sensed = sensing(settings)
    model, data = sensed.model, started(sensed.model)
    feet = list(settings.feet)
    require_open_chains(model, feet)
    joints, left_out = _joints(sensed, data, feet)
    on_rail = _on_rail(model, data)
    if on_rail and any(map(_stretches, joints)):
        left_out += [
            f"{joint.actuator} is left alone: the trunk is on a rail, where a foot that sweeps "
            "moves nothing" for joint in joints if not _stretches(joint)
        ]  # fmt: skip
        joints = list(filter(_stretches, joints))
    if not joints:
        raise TegotaeError(
            "no actuator moves a joint between the trunk and a foot; add a motor or a position "
            "servo to the model, or write the wiring by hand" + "".join(f"; {x}" for x in left_out)
        )
    scales = scales_of(model, feet, limbs=len(feet))
    length, weight = scales["height"], scales["spring_force"]
    rest_m, standing = dropped(sensed, sensed.still[None], _DROP * length + settings.release_m)
    phases = phases_of(model, data, feet)
    reasons: dict[str, str] = {
        "height": "height of the first body",
        "work": "absolute work of the actuators, measured by the environment",
        "rest_length_m": "height at touchdown in a drop test without control",
        "step_s": f"{_SAMPLES:g} control periods in √(l / g), in whole time steps of the model",
        "omega": f"{_RATE:g} √(g / l), as the paper's 8 rad/s on a leg of 1 m",
        "contact_bodies": "as given" if explicit else "lowest bodies that end a chain",
        "scales.spring_force": "weight over the number of feet",
        "scales.velocity": f"√(g l), centre of mass l = {length:.3g} m over the feet",
        "scales.speed": "√(g l)",
        "scales.height": "l",
        "scales.feedback": "√(g / l)",
    }
    limbs = []
    for i, joint in enumerate(joints):
        rest, push, reason = _push(joint, weight, length)
        felt, because = _felt(sensed, joint)
        limbs.append(
            Limb(
                senses={"spring_force": felt, "velocity": "root_climb"},
                drives=joint.actuator,
                rest=rest,
                push=push,
                phase_rad=phases[joint.foot],
            )
        )
        prefix = f"limbs[{i}]"
        reasons[f"{prefix}.rest"] = (
            "no torque" if joint.kind == "motor" else "its place at the start"
        )
        reasons[f"{prefix}.push"] = reason
        reasons[f"{prefix}.spring_force"] = because
        if phases[joint.foot]:
            reasons[f"{prefix}.phase_rad"] = "half a turn behind: feet on a diagonal begin together"
    if len(feet) > 1:
        reasons["sector_rad"] = "a leg that walks pushes in stance, for half a turn"
    lift = _lift(joints, [(limb.rest, limb.push) for limb in limbs]) / weight
    if lift < 1.0:
        left_out.append(
            f"the actuators' limits let the pushes lift {lift:.2g} of the weight; the body may "
            "never leave the ground"
        )
    timestep = float(model.opt.timestep)
    second = math.sqrt(length / gravity_m_per_s2(model))
    step_s = timestep * max(1, round(second / _SAMPLES / timestep))
    wiring = Wiring(
        limbs=tuple(limbs),
        omega=rounded(_RATE * scales["feedback"]),
        scales={name: rounded(value) for name, value in scales.items()},
        sector_rad=(math.pi, math.pi) if len(feet) > 1 else None,
        step_s=step_s,
        contact_bodies=tuple(feet),
        height="root_height",
        work="work",
        rest_length_m=rounded(rest_m, 4),
    )
    stiff = max((10.0 * weight * abs(j.up) for j in joints if j.kind == "motor"), default=0.0)
    hint = f", or servos to its motors: --settings servo_nm_per_rad={stiff:.2g}" if stiff else ""
    left_out += drop_remarks(standing, f"springs{hint}")
    return Suggestion(wiring, reasons, tuple(left_out), on_rail)


def drop_remarks(standing: float, remedy: str, threshold: float = _GIVES_WAY) -> list[str]:
    """List remarks on a drop test, by the share of the height that is left."""
    if standing >= threshold:
        return []
    return [
        f"without control the trunk sinks to {standing:.0%} of its height at touchdown within "
        f"{_STANDS_S:g} s; give the joints {remedy}"
    ]


def _lift(joints: Sequence[_Joint], pushes: Sequence[tuple[float, float]]) -> float:
    """Return the vertical force of full pushes, (rest, push) each, summed over the feet [N]."""
    by_foot: dict[int, float] = {}
    for joint, (rest, push) in zip(joints, pushes, strict=True):
        if joint.kind == "servo":
            return math.inf
        if _stretches(joint):
            force = joint.gain * (push - rest) / joint.up
            by_foot[joint.foot] = max(by_foot.get(joint.foot, 0.0), force)
    return sum(by_foot.values())


def _on_rail(model: MjModel, data: MjData) -> bool:
    """Return True if no joint of the trunk moves it along the ground."""
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacBody(model, data, jacobian, None, 1)
    dofs = model.jnt_dofadr[model.jnt_bodyid == 1]
    return bool((np.abs(jacobian[:2, dofs]) < 1e-6).all())


def lowest_feet(model: MjModel) -> tuple[str, ...]:
    """Return the lowest bodies that end a chain and can touch; an unnamed body goes by its geom's
    name.
    """
    data = started(model)
    ends = set(range(1, model.nbody)) - {int(parent) for parent in model.body_parentid[1:]}
    touches = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    reach = {
        body: lowest(model, data, geoms)
        for body in sorted(ends)
        if (geoms := np.flatnonzero(touches & (model.geom_bodyid == body)).tolist())
    }
    if not reach:
        raise TegotaeError(
            "no body at the end of a chain can touch anything (contype and conaffinity are 0); "
            "name the feet: --feet BODY or GEOM"
        )
    lowest_m = min(low for low, _ in reach.values())
    limit_m = lowest_m + _FOOT_SHARE * max(centre_height_m(model, data) - lowest_m, 0.0)
    feet = []
    for body, (low, geom) in reach.items():
        if low > limit_m:
            continue
        name = model.body(body).name or model.geom(geom).name
        if not name:
            parent = model.body(int(model.body_parentid[body])).name
            raise TegotaeError(
                f"the foot on {parent or 'the model'} has no name; give its body or geom one"
            )
        feet.append(name)
    return tuple(feet)


def _joints(sensed: Sensing, data: MjData, feet: Sequence[str]) -> tuple[list[_Joint], list[str]]:
    """Return the joints that are limbs, and for other actuators the reason why they are left
    out.
    """
    chains = [chain_of(sensed.model, foot) for foot in feet]
    joints, left_out = [], []
    for name, i in zip(sensed.actuators, map(int, sensed.driven), strict=True):
        joint = _joint(sensed.model, data, feet, chains, i)
        if isinstance(joint, str):
            left_out.append(f"{name} is left alone: {joint}")
        else:
            joints.append(joint)
    return joints, left_out


def _joint(
    model: MjModel, data: MjData, feet: Sequence[str], chains: Sequence[set[int]], i: int
) -> _Joint | str:
    """Return the joint of an actuator that is a limb, or the reason why it is none."""
    if model.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_JOINT:
        return "it drives no joint"
    j, kinds = int(model.actuator_trnid[i, 0]), mujoco.mjtJoint
    if int(model.jnt_type[j]) not in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)):
        return "its joint is neither a hinge nor a slide"
    legs = [k for k, chain in enumerate(chains) if int(model.jnt_bodyid[j]) in chain]
    if len(legs) != 1:
        return f"{'several feet hang' if legs else 'no foot hangs'} on its joint"
    kind = drive_of(model, i)
    if kind is None:
        return "it is neither a motor nor a position servo"
    along, _, up = map(float, -_velocity(model, data, feet[legs[0]], j))
    if not up and not along:
        return "it moves its foot sideways"
    limited = bool(model.actuator_ctrllimited[i])
    low, high = model.actuator_ctrlrange[i] if limited else (-np.inf, np.inf)
    gear, motor = float(model.actuator_gear[i, 0]), kind == "motor"
    return _Joint(
        actuator=model.actuator(i).name,
        joint=model.joint(j).name,
        foot=legs[0],
        kind=kind,
        gain=gear * float(model.actuator_gainprm[i, 0]) if motor else 1.0,
        start=float(data.qpos[model.jnt_qposadr[j]]) * (1.0 if motor else gear),
        up=up,
        along=along,
        low=float(low),
        high=float(high),
    )


def _velocity(model: MjModel, data: MjData, foot: str, joint: int) -> np.ndarray:
    """Return the foot's velocity in the trunk's frame at a joint's speed of 1, [x, y, z]."""
    jacobian = np.zeros((3, model.nv))
    place = foot_place(model, data, foot).copy()
    mujoco.mj_jac(model, data, jacobian, None, place, foot_of(model, foot).body)
    return jacobian[:, int(model.jnt_dofadr[joint])]


def _stretches(joint: _Joint) -> bool:
    return abs(joint.up) >= _ACROSS * math.hypot(joint.up, joint.along)


def _push(joint: _Joint, weight_n: float, length_m: float) -> tuple[float, float, str]:
    """Return rest, push and the reason for the push."""
    stretches = _stretches(joint)
    lever = joint.up if stretches else joint.along
    if joint.kind == "servo":
        rest = float(np.clip(rounded(joint.start), joint.low, joint.high))
        target = rest + _STROKE * length_m / lever
        does = "stretches the leg" if stretches else "sweeps the foot back"
        reason = f"{does} by a tenth of its length"
    else:
        rest = 0.0
        share = _LIFT if stretches else _SWEEP
        target = share * weight_n * lever / joint.gain
        reason = (
            f"stretches the leg, {share:g} times what bears the weight"
            if stretches
            else f"sweeps the foot back, {share:g} of the weight"
        )
    push = float(np.clip(rounded(target), joint.low, joint.high))
    if not joint.low <= target <= joint.high:
        reason += f"; that would be {target:.3g}, this is the actuator's limit"
    return rest, push, reason


def _felt(sensed: Sensing, joint: _Joint) -> tuple[str, str]:
    """Return the entry that stands for the spring force F_k of a limb, and the reason."""
    spring = f"{joint.joint}_spring"
    slides = sensed.model.joint(joint.joint).type[0] == mujoco.mjtJoint.mjJNT_SLIDE
    if spring in sensed.names and slides and _stretches(joint):
        return spring if joint.up > 0.0 else f"-{spring}", "the leg's own spring, as in the paper"
    return sensed.contacts[joint.foot], "load of the limb's own foot"


def phases_of(model: MjModel, data: MjData, feet: Sequence[str]) -> list[float]:
    """Return the phases of the feet [rad], neighbours half a turn apart: a trot of four, a
    tripod of six.
    """
    ahead, aside = np.array([foot_place(model, data, foot)[:2] for foot in feet]).T
    left = aside - aside.mean() > 1e-3
    behind = (ahead[:, None] - ahead > 1e-3) & (left[:, None] == left)
    return [math.pi if odd else 0.0 for odd in (behind.sum(axis=1) + left) % 2]


def dropped(sensed: Sensing, action: np.ndarray, rise_m: float) -> tuple[float, float]:
    """Run a drop test: return the trunk's height at touchdown, and the share of it a second later.

    Args:
        sensed: the model.
        action: what is commanded all the time, [1, actions].
        rise_m: how much higher than in the model it begins [m].

    Raises:
        TegotaeError: for feet that touch nothing, or a model that is unstable.
    """
    timestep = float(sensed.model.opt.timestep)
    batch = ModelBatch(sensed, 1, timestep, threads=1)
    try:
        height = sensed.names.index("root_height")
        loads = [sensed.names.index(name) for name in sensed.contacts]
        previous = batch.reset(rise_m)[0]
        for _ in range(round(_LONGEST_S / timestep)):
            observation = batch.step(action)[0]
            if (observation[loads] > 0.0).any():
                break
            previous = observation
        else:
            raise TegotaeError(
                f"the feet ({', '.join(sensed.feet)}) touched nothing in a drop of {_LONGEST_S:g} "
                "s; a model of a robot alone takes a floor: --settings ground=true"
            )
        touched = float(previous[height])
        for _ in range(round(_STANDS_S / timestep)):
            observation = batch.step(action)[0]
        if not is_sound(observation).all():
            raise TegotaeError(
                f"the MuJoCo model is unstable: {_STANDS_S:g} s after touchdown in a drop test its "
                f"state has no bounds; its time step of {timestep:g} s must be smaller, or its "
                "springs softer"
            )
        return touched, float(observation[height]) / touched if touched > 0.0 else np.nan
    finally:
        batch.close()


def rounded(value: float, digits: int = 3) -> float:
    """Round a number to a number of significant digits."""
    return float(f"{value:.{digits}g}")
