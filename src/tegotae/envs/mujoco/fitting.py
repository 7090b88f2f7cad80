"""Small changes of another author's MuJoCo model, so that limbs can be trained on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tegotae._support.errors import TegotaeError, require, unknown
from tegotae.envs._types import MjsActuator, MjSpec


def fit(
    spec: MjSpec,
    *,
    ground: bool = False,
    without: Sequence[str] = (),
    servo_nm_per_rad: float = 0.0,
) -> None:
    """Change an `MjSpec` that is not compiled yet.

    A servo gives its joint the torque `k (u - q)` at position q for the command u, within the
    motor's own limits of force; u is limited to the joint's range. What damps it is the joint's own
    damping.

    Args:
        spec: the model's.
        ground: whether to add a level floor at height 0.
        without: names of bodies and geoms to leave out.
        servo_nm_per_rad: the stiffness k of every motor of a joint [N m/rad, or N/m]; 0 for none.

    Raises:
        TegotaeError: for something to leave out that the model does not have, or servos where no
            joint has a motor.

    Example:
        >>> import mujoco  # doctest: +SKIP
        >>> fit(mujoco.MjSpec.from_file("go1.xml"), ground=True)  # doctest: +SKIP
    """
    for name in without:
        found = spec.body(name) or spec.geom(name)
        if found is None or name == "world":
            known = [part.name for part in (*spec.bodies, *spec.geoms) if part.name]
            raise unknown("body or geom of this model", name, [n for n in known if n != "world"])
        spec.delete(found)
    if ground:
        plane = require("mujoco", "mujoco").mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="tegotae/ground", type=plane, size=[0.0, 0.0, 1.0])
    if servo_nm_per_rad:
        _make_servos(spec, servo_nm_per_rad)


def _make_servos(spec: MjSpec, stiffness: float) -> None:
    """Position servos in place of the motors of joints."""
    mujoco = require("mujoco", "mujoco")
    motors = [
        each
        for each in spec.actuators
        if each.trntype == mujoco.mjtTrn.mjTRN_JOINT
        and each.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and each.biastype == mujoco.mjtBias.mjBIAS_NONE
        and each.dyntype == mujoco.mjtDyn.mjDYN_NONE
    ]
    if not motors:
        raise TegotaeError(
            "no joint of the model has a motor to make a servo of; leave servo_nm_per_rad out"
        )
    for motor in motors:
        # What the motor could do stays what the servo can do.
        most = abs(float(motor.gear[0])) * _most_force(motor)
        low, high = spec.joint(motor.target).range
        motor.ctrlrange = [0.0, 0.0]  # else it is not the joint's range that becomes it
        motor.set_to_position(stiffness, inheritrange=low < high)
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        motor.ctrllimited = low < high
        motor.forcelimited = np.isfinite(most)
        motor.forcerange = [-most, most] if np.isfinite(most) else [0.0, 0.0]


def _most_force(motor: MjsActuator) -> float:
    """The largest force of a motor, before its gear; infinite if nothing limits it."""
    gain = abs(float(motor.gainprm[0]))
    most = [scale * np.abs(each).max() for scale, each in
            ((gain, motor.ctrlrange), (1.0, motor.forcerange)) if np.any(each)]  # fmt: skip
    return float(min(most, default=np.inf))
