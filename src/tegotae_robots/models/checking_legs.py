"""Assumptions about legs, checked on the MuJoCo model: a stance, a free start, feet that follow."""

from __future__ import annotations

import copy
import math

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs.mujoco.legs import AXES, LegKinematics
from tegotae.envs.mujoco.sensing import Sensing
from tegotae.envs.scaling import foot_of, foot_place, gravity_m_per_s2, started

mujoco = require("mujoco", "mujoco")

_ELSEWHERE = "--settings start=KEYFRAME or 'start={\"JOINT\": POSITION}'"
"""Setting that chooses another start."""
_STANDS = 0.1
"""A hip of a stance is higher over its foot than this share of the leg's length."""
_LEVEL = 0.2
"""Feet of a stance are level to this share of the leg's length."""
_IN_GROUND = 0.02
"""A start is in the ground by more than this [l0]."""
_ASKED = 0.1
"""Displacement that feet are asked for [l0]."""
_FOLLOWS, _MOVES = 0.25, 0.75
"""A foot follows, or moves at all, if it misses by less than this share of the displacement."""
_SETTLES = 3.0
"""Time for that [√(l0 / g)]."""


def require_stance(legs: LegKinematics) -> None:
    """Raise TegotaeError for a start in which the robot cannot stand on its feet."""
    hips_m = legs.length_m * legs.chains.anchor[:, 0, 2]
    feet_m = legs.length_m * legs.chains.foot[:, 2]
    for foot, height in zip(legs.feet, hips_m - feet_m, strict=True):
        if height < _STANDS * legs.length_m:
            raise TegotaeError(
                f"the model's start is no stance: the first joint of {foot} is {height:.2g} m over "
                f"the foot, of a leg of {legs.length_m:.2g} m; begin elsewhere: {_ELSEWHERE}"
            )
    if (spread_m := float(np.ptp(feet_m))) > _LEVEL * legs.length_m:
        raise TegotaeError(
            f"the model's start is no stance: {legs.feet[int(np.argmax(feet_m))]} is "
            f"{spread_m:.2g} m higher than {legs.feet[int(np.argmin(feet_m))]}; "
            f"begin elsewhere: {_ELSEWHERE}"
        )


def in_ground(sensed: Sensing, release_m: float, length_m: float) -> list[str]:
    """Return a remark on a release whose feet are in the ground.

    Args:
        sensed: the model.
        release_m: how much higher than in the model it is released [m].
        length_m: length of a leg l0 [m].
    """
    contacts, fixed = started(sensed.model).contact, sensed.model.geom_bodyid == 0
    deep = max((-c.dist for c in contacts if fixed[c.geom1] != fixed[c.geom2]), default=0.0)
    if deep <= release_m + _IN_GROUND * length_m:
        return []
    return [
        f"the model's start is {deep:.2g} m in the ground, which throws it up at the release; lift "
        f"it out: --settings release_m={math.ceil(100.0 * deep) / 100.0:.2f}"
    ]


def followed(sensed: Sensing, length_m: float) -> list[str]:
    """Return remarks on feet that do not follow in MuJoCo, the trunk held in the air.

    All feet are asked for a tenth of l0 up, and forward; the inverse kinematics sets the servos.

    Args:
        sensed: the model, with legs.
        length_m: length of a leg l0 [m].

    Raises:
        TegotaeError: for a foot that misses by most of what it is asked for.
    """
    legs, remarks = sensed.legs, list[str]()
    assert legs is not None
    reference = _settled(sensed, np.zeros((len(legs.feet), len(AXES))), length_m)
    for axis, direction in ((2, "up"), (0, "forward")):
        places = np.zeros((1, len(legs.feet), len(AXES)))
        places[..., axis] = _ASKED * length_m
        targets = legs.places_of(legs.joints_at(places))[0]
        went = _settled(sensed, targets, length_m) - reference
        missed_m = np.linalg.norm(went - targets, axis=1)
        worst = int(np.argmax(np.nan_to_num(missed_m, nan=np.inf)))
        message = (
            f"asked {targets[worst, axis]:.2g} m {direction}, {legs.feet[worst]} goes "
            f"{went[worst, axis]:.2g} m {direction} and misses by {missed_m[worst]:.2g} m, "
            "the trunk held in the air; check the stiffness and the limits of its servos, and "
            "what the leg collides with"
        )
        if not missed_m[worst] <= _MOVES * _ASKED * length_m:
            raise TegotaeError(message)
        remarks += [message] if missed_m[worst] > _FOLLOWS * _ASKED * length_m else []
    return remarks


def _settled(sensed: Sensing, places_m: np.ndarray, length_m: float) -> np.ndarray:
    """Return where feet settle that are commanded to places, in the trunk's axes [m], [feet, 3]."""
    model = copy.copy(sensed.model)
    fixed = model.geom_bodyid == 0
    model.geom_contype[fixed] = model.geom_conaffinity[fixed] = 0
    data, action = started(model), sensed.still[None]
    action[0, : places_m.size] = places_m.ravel()
    data.ctrl[:] = sensed.held
    data.ctrl[sensed.driven] = sensed.controls(action)[0]
    bodies = [foot_of(model, foot).body for foot in sensed.feet]
    points = [
        data.xmat[body].reshape(3, 3).T @ (foot_place(model, data, foot) - data.xpos[body])
        for foot, body in zip(sensed.feet, bodies, strict=True)
    ]
    origin, trunk = data.xpos[1].copy(), data.xmat[1].reshape(3, 3).copy()
    begin, joints, dofs = data.qpos.copy(), int(model.body_jntnum[1]), int(model.body_dofnum[1])
    held = slice(0, int(model.jnt_qposadr[joints]))  # legs have joints after those of the trunk
    steps = round(_SETTLES * math.sqrt(length_m / gravity_m_per_s2(model)) / model.opt.timestep)
    path = np.zeros((steps, len(bodies), 3))
    for step in path:
        mujoco.mj_step(model, data)
        data.qpos[held], data.qvel[:dofs] = begin[held], 0.0
        mujoco.mj_kinematics(model, data)
        for k, (body, point) in enumerate(zip(bodies, points, strict=True)):
            step[k] = data.xpos[body] + data.xmat[body].reshape(3, 3) @ point
    return (path[steps // 2 :].mean(axis=0) - origin) @ trunk
