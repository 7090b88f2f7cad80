"""Settings under which a model of a robot alone can walk: a floor, servos, a stance, commands."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.legs import drive_of
from tegotae.envs.mujoco.sensing import Sensing, sensing
from tegotae.envs.mujoco.settings import ModelSettings, compiled_model
from tegotae.envs.scaling import chain_of, foot_of, foot_place, lowest, started, weight_n
from tegotae_robots.models.checking_legs import require_stance
from tegotae_robots.models.suggesting import dropped, lowest_feet, rounded

mujoco = require("mujoco", "mujoco")

_JOINTS = 3
"""Driven joints of a leg whose foot can go in every direction."""
_STIFFNESS, _STIFFER, _RAISES = 3.0, 1.5, 4
"""Stiffness of servos [m g l0 / rad], the factor by which it is raised, and how often at most."""
_SAG = 0.15
"""Share of its height by which a trunk may sink on its servos."""
_DAMPING_RATIO = 0.4
"""Damping of a servo over the critical one of the legs' median inertia about a joint."""
_NOISE_RAD, _RELEASE = 0.02, 0.1
"""Noise of the start, and height of the release over it [l0]."""
_TALL = 0.25
"""Least height of the hips over the feet in a stance, as a share of the leg's length."""
_BALANCE = 0.25
"""The centre of mass of a stance is beyond its feet by less than this share of the leg's length."""
_BELOW = 0.05
"""No part of a stance is lower than the feet by more than this share of the leg's length."""
_OFF_FLOOR = 0.02
"""Feet of a start are on the floor to this share of l0."""
_LIFTED = "the first keyframe that is a stance, with the feet on the floor [rad]"
_BENT = 0.7
"""Height of a hip over its foot in a stance that is searched, as a share of its largest one."""
_MARGIN = 0.1
"""Distance of a joint from its limits in a start at the limit, as a share of its range."""
_GRID = 49
"""Angles per joint in the search for a stance, 7.5° apart in a full turn."""


@dataclass(frozen=True)
class SuggestedSettings:
    """Settings of a model that were not given, with their reasons by name."""

    values: Mapping[str, Any]
    reasons: Mapping[str, str]


def suggest_settings(settings: ModelSettings, names: Sequence[str]) -> SuggestedSettings:
    """Suggest the settings by which a free robot on legs can stand and take commands.

    It is on legs if at least two feet have three driven joints each of their own, and its first
    body is free. For any other model, or one whose setting `legs` is given, there are none.

    A start is the first keyframe that is a stance, or the zero of the joints if that is one, or a
    stance that is searched: every foot under its hip, knees behind. Servos have the stiffness
    3 m g l0, more if the trunk sinks by over a tenth of its height in a drop test, and the damping
    ratio 0.4 with the median inertia of the legs about a joint, that of the rotors included.

    Args:
        settings: of the model.
        names: names of the settings that the user gave, which are left as they are.

    Raises:
        TegotaeError: for a robot that has no stance, or whose motors are of several kinds.

    Example:
        >>> settings = ModelSettings(model="robot.xml")  # doctest: +SKIP
        >>> suggest_settings(settings, ()).reasons["start"]  # doctest: +SKIP
        'the keyframe home'
    """
    nothing = SuggestedSettings({}, {})
    model = compiled_model(settings.spec())
    if "legs" in names or int(model.jnt_type[0]) != int(mujoco.mjtJoint.mjJNT_FREE):
        return nothing
    feet = tuple(settings.feet) or _ends(model)
    if len(feet) < 2 or any(len(_joints(model, feet, foot)) < _JOINTS for foot in feet):
        return nothing
    values: dict[str, Any] = {}
    reasons: dict[str, str] = {}

    def suggest(name: str, value: Any, reason: str) -> None:
        if name not in names:
            values[name], reasons[name] = value, reason

    suggest("legs", True, "every foot has three driven joints of its own")
    if not (model.geom_contype[model.geom_bodyid == 0] != 0).any():
        suggest("ground", True, "the model has no floor")
    motors = _has_motors(model, feet)
    if motors:
        suggest("servo_nm_per_rad", 1.0, "")
    settings = replace(settings, **values)
    start, feet, reason = _stance(settings, feet)
    if start:
        suggest("start", start, reason)
    settings = replace(settings, **values, feet=feet)
    sensed = sensing(settings)
    assert sensed.legs is not None
    length = sensed.legs.height_m
    if motors and "servo_nm_per_rad" not in names:
        suggest("servo_damping_nms_per_rad", 0.0, "")
        for name, (value, reason) in _servos(settings, sensed, length).items():
            suggest(name, value, reason)
    suggest("noise", _NOISE_RAD, "spread of the starts [rad]")
    suggest("release_m", rounded(_RELEASE * length, 2), "a tenth of l0")
    suggest("command", [0.0, 0.0, 0.0], "forward, left [m/s], yaw rate [rad/s]: it stands")
    return SuggestedSettings(values, reasons)


def _ends(model: MjModel) -> tuple[str, ...]:
    """Return the bodies at the end of a chain of three driven joints that can touch."""
    ends = set(range(1, model.nbody)) - {int(parent) for parent in model.body_parentid[1:]}
    touches = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    named = [
        model.body(body).name
        for body in sorted(ends)
        if model.body(body).name and (touches & (model.geom_bodyid == body)).any()
    ]
    return tuple(foot for foot in named if len(_joints(model, named, foot)) >= _JOINTS)


def _joints(model: MjModel, feet: Sequence[str], foot: str) -> list[int]:
    """Return the driven joints that a foot alone hangs on, from the trunk on."""
    others = {body for other in feet if other != foot for body in chain_of(model, other)}
    alone = chain_of(model, foot) - others
    on_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    driven = sorted({int(joint) for joint in model.actuator_trnid[on_joint, 0]})
    return [joint for joint in driven if int(model.jnt_bodyid[joint]) in alone]


def _has_motors(model: MjModel, feet: Sequence[str]) -> bool:
    """Return True if motors drive the legs, False if servos do.

    Raises:
        TegotaeError: for both, or anything else.
    """
    legs = {joint for foot in feet for joint in _joints(model, feet, foot)}
    kinds = {
        drive_of(model, i)
        for i in range(model.nu)
        if int(model.actuator_trnid[i, 0]) in legs
        and int(model.actuator_trntype[i]) == int(mujoco.mjtTrn.mjTRN_JOINT)
    }
    if kinds not in ({"motor"}, {"servo"}):
        raise TegotaeError(
            "the joints of the legs are driven neither by motors alone nor by position servos "
            "alone; give all of them <motor> or all of them <position>, or add --settings "
            "legs=false to wire the joints"
        )
    return kinds == {"motor"}


def _stance(
    settings: ModelSettings, ends: Sequence[str]
) -> tuple[str | dict[str, float], tuple[str, ...], str]:
    """Return the start, empty for the model's own, the feet, and the reason for the start."""
    if settings.start:
        return "", _feet(settings, ends), ""
    for start, reason in _starts(settings, ends):
        candidate = replace(settings, start=start) if start else settings
        feet = _feet(candidate, ends)
        if len(feet) > 1 and _stands(candidate := replace(candidate, feet=feet)):
            on_floor = _on_floor(candidate) if isinstance(start, str) else {}
            return (on_floor, feet, _LIFTED) if on_floor else (start, feet, reason)
    raise TegotaeError(
        f"no stance was found for the legs of {', '.join(settings.feet or ends)}: no keyframe is "
        "one, and with the feet under their hips, or the joints at zero, the robot does not stand; "
        "give one: --settings 'start={\"JOINT\": POSITION}'"
    )


def _on_floor(settings: ModelSettings) -> dict[str, float]:
    """Return the joints of a start whose feet are not at height 0 of the floor that is added [rad];
    empty if they are, or for a model with a floor."""
    if not settings.ground:
        return {}
    sensed = sensing(settings)
    model, data, legs = sensed.model, started(sensed.model), sensed.legs
    assert legs is not None
    feet = [geom for foot in sensed.feet for geom in foot_of(model, foot).geoms]
    if abs(lowest(model, data, feet)[0]) < _OFF_FLOOR * legs.height_m:
        return {}
    joints = [int(joint) for joint in legs.joints[legs.joints >= 0]]
    angles = data.qpos[model.jnt_qposadr[joints]]
    names = [model.joint(joint).name for joint in joints]
    return {name: round(float(x), 4) for name, x in zip(names, angles, strict=True)}


def _starts(
    settings: ModelSettings, ends: Sequence[str]
) -> Iterator[tuple[str | dict[str, float], str]]:
    """List starts to try: the model's own, its further keyframes, one that is searched, and joints
    at zero or a limit."""
    yield "", ""
    for key in settings.spec().keys[1:]:
        if key.name:
            yield key.name, "the first keyframe that is a stance"
    reason = "no keyframe is a stance; feet under their hips, knees behind [rad]"
    yield _searched(settings, tuple(settings.feet) or tuple(ends)), reason
    model = compiled_model(settings.spec())
    joints = [joint for end in ends for joint in _joints(model, ends, end)]
    angles = {model.joint(j).name: float(np.clip(0.0, *_inside(model, j))) for j in joints}
    yield angles, "no keyframe is a stance; joints at zero, or at the limit next to it [rad]"


def _feet(settings: ModelSettings, ends: Sequence[str]) -> tuple[str, ...]:
    """Return the lowest ends of legs at a start."""
    if settings.feet:
        return tuple(settings.feet)
    model = compiled_model(settings.spec())
    return tuple(foot for foot in lowest_feet(model) if foot in ends)


def _stands(settings: ModelSettings) -> bool:
    """Return True if a start is a stance: on the feet alone, the centre of mass over them."""
    try:
        sensed = sensing(settings)
        assert sensed.legs is not None
        require_stance(sensed.legs)
    except TegotaeError:
        return False
    model, legs = sensed.model, sensed.legs
    data = started(model)
    on_feet = [geom for foot in sensed.feet for geom in foot_of(model, foot).geoms]
    touches = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    parts = np.flatnonzero(touches & (model.geom_bodyid > 0)).tolist()
    centres = [float(data.geom_xpos[geom, 2]) for geom in set(parts) - set(on_feet)]
    lowest_m = lowest(model, data, on_feet)[0]
    others_m = min(centres, default=math.inf)
    tall = legs.height_m >= _TALL * legs.length_m
    feet_m = np.array([foot_place(model, data, foot)[:2] for foot in sensed.feet])
    centre_m = np.average(data.xipos[1:, :2], axis=0, weights=model.body_mass[1:])
    beyond_m = np.maximum(feet_m.min(axis=0) - centre_m, centre_m - feet_m.max(axis=0))
    balanced = bool((beyond_m < _BALANCE * legs.length_m).all())
    return tall and balanced and others_m >= lowest_m - _BELOW * legs.length_m


def _searched(settings: ModelSettings, feet: Sequence[str]) -> dict[str, float]:
    """Return angles of joints with the feet under their hips [rad].

    The last two joints of each leg are searched on a grid, the others are where they are least
    turned.
    """
    model = compiled_model(replace(settings, start={}).spec())
    data = mujoco.MjData(model)
    mujoco.mj_resetData(model, data)
    rows = [_joints(model, feet, foot) for foot in feet]
    pairs = np.array([row[-2:] for row in rows])
    for row in rows:
        for joint in row[:-2]:
            data.qpos[model.jnt_qposadr[joint]] = np.clip(0.0, *_range(model, joint))
    grids = [[np.linspace(*_range(model, joint), _GRID) for joint in pair] for pair in pairs]
    foot_m = np.zeros((_GRID, _GRID, len(feet), 3))
    knee_m = np.zeros((_GRID, _GRID, len(feet)))
    for i, k in np.ndindex(_GRID, _GRID):
        for pair, (first, second) in zip(pairs, grids, strict=True):
            data.qpos[model.jnt_qposadr[pair]] = first[i], second[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        hips, knees = data.xanchor[pairs[:, 0]], data.xanchor[pairs[:, 1]]
        places = np.array([foot_place(model, data, foot) for foot in feet])
        foot_m[i, k], knee_m[i, k] = places - hips, (knees - hips)[:, 0]
    start: dict[str, float] = {}
    for leg, (pair, grid) in enumerate(zip(pairs, grids, strict=True)):
        place = foot_m[:, :, leg]
        deep = -place[..., 2]
        missed = np.hypot(place[..., 0], deep - _BENT * deep.max()) / deep.max()
        ahead = knee_m[..., leg] > 0.0
        i, k = np.unravel_index(np.argmin(missed + 0.1 * ahead), missed.shape)
        for joint, angle in zip(pair, (grid[0][i], grid[1][k]), strict=True):
            start[model.joint(int(joint)).name] = round(float(angle), 3)
        for joint in rows[leg][:-2]:
            angle = float(data.qpos[model.jnt_qposadr[joint]])
            start[model.joint(joint).name] = round(angle, 3)
    return start


def _inside(model: MjModel, joint: int) -> tuple[float, float]:
    """Return the range of a joint less a margin [rad]."""
    low, high = _range(model, joint)
    margin = _MARGIN * (high - low)
    return low + margin, high - margin


def _range(model: MjModel, joint: int) -> tuple[float, float]:
    """Return the range of a joint, at most half a turn from zero [rad]."""
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
    return max(float(low), -np.pi), min(float(high), np.pi)


def _servos(
    settings: ModelSettings, sensed: Sensing, length_m: float
) -> dict[str, tuple[float, str]]:
    """Return stiffness and damping of servos on which the trunk stands, with their reasons."""
    assert sensed.legs is not None
    joints = sensed.legs.joints[sensed.legs.joints >= 0]
    inertia = float(np.median(_inertia(sensed.model, started(sensed.model))[joints]))
    moment_nm = weight_n(sensed.model) * length_m
    tried = list[tuple[float, float, float, float]]()
    for share in _STIFFNESS * _STIFFER ** np.arange(_RAISES + 1):
        stiffness = rounded(share * moment_nm, 2)
        damping = rounded(2.0 * _DAMPING_RATIO * math.sqrt(stiffness * inertia), 2)
        servos = {"servo_nm_per_rad": stiffness, "servo_damping_nms_per_rad": damping}
        model = sensing(replace(settings, **servos))
        standing = dropped(model, model.still[None], _RELEASE * length_m)[1]
        tried.append((share, stiffness, damping, standing))
        if standing >= 1.0 - _SAG:
            break
    # What falls over does so on stiffer servos, too.
    best = tried[-1] if tried[-1][3] >= 1.0 - _SAG else tried[0]
    share, stiffness, damping, standing = best
    sinks = f"{share:.2g} m g l0; the trunk sinks by {max(1.0 - standing, 0.0):.0%} of its height"
    ratio = f"damping ratio {_DAMPING_RATIO:g} with the joints' median inertia, {inertia:.2g} kg m²"
    return {
        "servo_nm_per_rad": (stiffness, sinks),
        "servo_damping_nms_per_rad": (damping, ratio),
    }


def _inertia(model: MjModel, data: MjData) -> np.ndarray:
    """Return the inertia about each joint, all others held, rotors included [kg m²], [joints]."""
    diagonal, result = np.zeros(model.nv), np.zeros(model.nv)
    for dof, unit in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, result, unit)
        diagonal[dof] = result[dof]
    return diagonal[model.jnt_dofadr]
