"""What it takes to move a foot around its ellipse in the air: on a robot, and on its template."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import require
from tegotae.envs._types import MjModel
from tegotae.envs.scaling import started
from tegotae.parts.bodies import Walker
from tegotae.parts.bodies.walker.mechanics import swing_work

mujoco = require("mujoco", "mujoco")

_SAMPLES, _CORRECTIONS = 400, 4
"""Of a cycle, and of the joints at each."""
_MISSES = 1e-3
"""A foot that misses a place by more than this share of its stride does not reach it."""


@dataclass(frozen=True)
class SwungEllipse:
    """A foot's path (`tegotae.parts.terms.EllipticFoot`), unshifted, at a rate of its phase."""

    stride_m: float
    lift_m: float
    press_m: float
    omega: float

    @property
    def tick_s(self) -> float:
        """From one place to the next [s]."""
        return 2.0 * math.pi / self.omega / _SAMPLES

    @property
    def places_m(self) -> np.ndarray:
        """Forward and up, over a cycle and back at its start, [samples + 1, 2]."""
        phase = np.linspace(0.0, 2.0 * math.pi, _SAMPLES + 1)
        high = np.where(np.sin(phase) > 0.0, self.lift_m, self.press_m)
        return np.stack([self.stride_m * np.cos(phase), high * np.sin(phase)], axis=1)


def swing_of_walker(body: Walker, path: SwungEllipse) -> float:
    """Absolute work of a leg over a cycle in the air [J].

    Args:
        body: of the leg.
        path: of its foot.

    Example:
        >>> damped = Walker(joint_damping_x_ns_per_m=1.0)
        >>> round(swing_of_walker(damped, SwungEllipse(0.2, 0.0, 0.0, omega=2.0)), 3)  # π B² ω
        0.251
    """
    rates = np.diff(path.places_m, axis=0).T[:, None] / path.tick_s
    before = np.roll(rates, 1, axis=2)
    work = swing_work(body, jnp.asarray(before), jnp.asarray(rates), jnp.asarray(path.tick_s))
    return float(np.abs(work).sum())


def swing_of_robot(
    model: MjModel, body: int, sole_m: np.ndarray, joints: Sequence[int], path: SwungEllipse
) -> float:
    """The same of a robot's leg, its trunk held: Σ |torque · speed| of its joints, by MuJoCo's
    inverse dynamics [J]; nan of a foot that does not reach the path.

    Args:
        model: of the robot.
        body: of the foot.
        sole_m: where it is at the start, [x, y, z].
        joints: degrees of freedom of the leg.
        path: of the foot, around that place.
    """
    model = copy.copy(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data, own = started(model), model.dof_jntid[joints]
    entries, limited = model.jnt_qposadr[own], model.jnt_limited[own] == 1
    at = data.xmat[body].reshape(3, 3).T @ (sole_m - data.xpos[body])
    jacobian, step = np.zeros((3, model.nv)), np.zeros(model.nv)

    def missed(place_m: np.ndarray) -> np.ndarray:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        sole = data.xpos[body] + data.xmat[body].reshape(3, 3) @ at
        mujoco.mj_jac(model, data, jacobian, None, sole, body)
        return place_m - sole

    poses = []
    for forward, up in path.places_m:
        place_m = sole_m + np.array([forward, 0.0, up])
        for _ in range(_CORRECTIONS):
            error = missed(place_m)
            step[joints] = np.linalg.pinv(jacobian[:, joints]) @ error
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
        low, high = model.jnt_range[own].T
        past = (data.qpos[entries] < low) | (data.qpos[entries] > high)
        off = np.linalg.norm(missed(place_m)) > _MISSES * path.stride_m
        if off or (past & limited).any():
            return math.nan
        poses.append(data.qpos.copy())
    speeds = np.zeros((_SAMPLES, model.nv))
    for k in range(_SAMPLES):
        mujoco.mj_differentiatePos(model, speeds[k], path.tick_s, poses[k], poses[k + 1])
    work = 0.0
    for pose, before, after in zip(poses, np.roll(speeds, 1, axis=0), speeds, strict=False):
        data.qpos[:], data.qvel[:] = pose, 0.5 * (before + after)
        data.qacc[:] = (after - before) / path.tick_s
        mujoco.mj_inverse(model, data)
        work += path.tick_s * np.abs(data.qfrc_inverse[joints] * data.qvel[joints]).sum()
    return float(work)
