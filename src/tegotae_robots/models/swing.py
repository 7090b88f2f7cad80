"""Compute the work of moving a foot around its ellipse in the air: on a robot, and on its
template."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import require
from tegotae.envs._types import MjModel
from tegotae.envs.scaling import started
from tegotae.parts.bodies import Walker
from tegotae.parts.bodies.walker.mechanics import swing_work
from tegotae.parts.terms import EllipticFoot

mujoco = require("mujoco", "mujoco")

_SAMPLES, _CORRECTIONS = 400, 4
"""Samples of a cycle, and corrections of the joints at each."""
_MISSES = 1e-3
"""A foot that misses a place by more than this share of its stride does not reach it."""


def swing_of_walker(body: Walker, foot: EllipticFoot, omega: float) -> float:
    """Return the absolute work of a leg over a cycle of its foot in the air, a turn of the phase
    [J].

    Args:
        body: of the leg.
        foot: its ellipse.
        omega: rate of the phase [rad/s].

    Example:
        >>> damped = Walker(joint_damping_x_ns_per_m=1.0)
        >>> round(swing_of_walker(damped, EllipticFoot(stride_m=0.2), omega=2.0), 3)  # π B² ω
        0.251
    """
    tick_s = 2.0 * math.pi / omega / _SAMPLES
    rates = np.diff(_places_m(foot))[:, None] / tick_s
    previous = np.roll(rates, 1, axis=2)
    work = swing_work(body, jnp.asarray(previous), jnp.asarray(rates), jnp.asarray(tick_s))
    return float(np.abs(work).sum())


def swing_of_robot(
    model: MjModel,
    body: int,
    sole_m: np.ndarray,
    joints: Sequence[int],
    foot: EllipticFoot,
    omega: float,
) -> float:
    """Return the swing cost of a robot's leg, its trunk held: Σ |torque · speed| of its joints, by
    MuJoCo's inverse dynamics [J]; nan of a foot that does not reach its ellipse.

    Args:
        model: of the robot.
        body: of the foot.
        sole_m: where it is at the start, [x, y, z].
        joints: degrees of freedom of the leg.
        foot: its ellipse, around that place.
        omega: rate of the phase [rad/s].
    """
    model = copy.copy(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data, joint_ids = started(model), model.dof_jntid[joints]
    entries, limited = model.jnt_qposadr[joint_ids], model.jnt_limited[joint_ids] == 1
    offset = data.xmat[body].reshape(3, 3).T @ (sole_m - data.xpos[body])
    jacobian, step = np.zeros((3, model.nv)), np.zeros(model.nv)

    def missed(place_m: np.ndarray) -> np.ndarray:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        sole = data.xpos[body] + data.xmat[body].reshape(3, 3) @ offset
        mujoco.mj_jac(model, data, jacobian, None, sole, body)
        return place_m - sole

    poses, tick_s = [], 2.0 * math.pi / omega / _SAMPLES
    for forward, up in _places_m(foot).T:
        place_m = sole_m + np.array([forward, 0.0, up])
        for _ in range(_CORRECTIONS):
            error = missed(place_m)
            step[joints] = np.linalg.pinv(jacobian[:, joints]) @ error
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
        low, high = model.jnt_range[joint_ids].T
        past = (data.qpos[entries] < low) | (data.qpos[entries] > high)
        off = np.linalg.norm(missed(place_m)) > _MISSES * foot.stride_m
        if off or (past & limited).any():
            return math.nan
        poses.append(data.qpos.copy())
    speeds = np.zeros((_SAMPLES, model.nv))
    for k in range(_SAMPLES):
        mujoco.mj_differentiatePos(model, speeds[k], tick_s, poses[k], poses[k + 1])
    work = 0.0
    for pose, previous, current in zip(poses, np.roll(speeds, 1, axis=0), speeds, strict=False):
        data.qpos[:], data.qvel[:] = pose, 0.5 * (previous + current)
        data.qacc[:] = (current - previous) / tick_s
        mujoco.mj_inverse(model, data)
        work += tick_s * np.abs(data.qfrc_inverse[joints] * data.qvel[joints]).sum()
    return float(work)


def _places_m(foot: EllipticFoot) -> np.ndarray:
    """Forward and up, over a turn of the phase and back at its start, [2, samples + 1]."""
    phase = np.linspace(0.0, 2.0 * math.pi, _SAMPLES + 1)
    return np.asarray(foot.place(np.sin(phase), np.cos(phase)), float)
