"""Legs that are rigid but for their servos: no closed chains, no limp joints."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from itertools import product

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.scaling import chain_of, foot_of, gravity_m_per_s2, started

_YIELDS = 0.05
"""A leg is rigid if its foot yields less than this share of the length."""


def require_open_chains(model: MjModel, feet: Sequence[str]) -> None:
    """Raise TegotaeError where an equality constraint holds a joint of a leg."""
    mujoco = require("mujoco", "mujoco")
    dense = copy.copy(model)
    dense.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
    data = started(dense)
    held = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    rows = np.reshape(data.efc_J, (data.nefc, model.nv))[held]
    for foot in feet:
        hung = np.isin(model.dof_bodyid, [*chain_of(model, foot)])
        for row in np.flatnonzero((rows[:, hung] != 0.0).any(axis=1)):
            name = model.eq(int(data.efc_id[held][row])).name
            raise TegotaeError(
                f"the equality constraint {name or 'without a name'} closes the leg of {foot}, and "
                "legs are taken for open chains, trunk to foot; model the leg without it"
            )


def require_stiff(
    model: MjModel, data: MjData, feet: Sequence[str], driven: Sequence[int], length_m: float
) -> None:
    """Raise TegotaeError for an undriven joint that yields under a foot's load.

    The load is the foot's share of the weight, on that corner of the foot which turns the joint
    most.

    Args:
        model: an `MjModel`.
        data: in its start.
        feet: bodies or geoms.
        driven: joints that actuators drive.
        length_m: length of a leg [m].
    """
    load_n = gravity_m_per_s2(model) * float(model.body_mass.sum()) / len(feet)
    for foot in feet:
        hung = np.isin(model.dof_bodyid, [*chain_of(model, foot)])
        loose = hung & ~np.isin(model.dof_jntid, driven)
        if not loose.any():
            continue
        jacobian = _at_corners(model, data, foot)[..., loose]
        joints = model.dof_jntid[loose]
        width = np.where(model.jnt_limited[joints] > 0, np.ptp(model.jnt_range[joints], 1), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):  # of joints without a spring
            turn = np.nan_to_num(np.abs(load_n * jacobian[:, 2]) / model.jnt_stiffness[joints])
        yields_m = (np.minimum(turn, width) * np.linalg.norm(jacobian, axis=1)).max(axis=0)
        if yields_m.max() > _YIELDS * length_m:
            worst = int(np.argmax(yields_m))
            raise TegotaeError(
                f"nothing drives joint {model.joint(int(joints[worst])).name}, and the foot {foot} "
                f"yields there by {yields_m[worst]:.2g} m under {load_n:.3g} N, its share of the "
                "weight, where legs are taken for rigid but for their servos; drive the joint, "
                "stiffen its spring, or model the leg without it"
            )


def _at_corners(model: MjModel, data: MjData, foot: str) -> np.ndarray:
    """Return Jacobians of a foot at the corners of its geoms' boxes, [corners, 3, nv]."""
    body, geoms = foot_of(model, foot)
    jacobians = np.zeros((8 * len(geoms), 3, model.nv))
    for i, (geom, corner) in enumerate(product(geoms, product((-1.0, 1.0), repeat=3))):
        middle, half = np.split(model.geom_aabb[geom], 2)
        place = data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ (middle + corner * half)
        require("mujoco", "mujoco").mj_jac(model, data, jacobians[i], None, place, body)
    return jacobians
