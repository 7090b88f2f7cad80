"""What signals are measured against: scales of a MuJoCo model, or of a body of this package."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import ModuleType

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require, unknown
from tegotae.envs._types import AnyEnv, MjData, MjModel
from tegotae.parts.bodies import Body, Interface


def model_scales(
    env: AnyEnv, *, feet: Sequence[str] | None = None, limbs: int = 1
) -> dict[str, float]:
    """The scales of a limb's signals, from the masses and lengths of a MuJoCo model.

    With the weight W of all bodies, n limbs, and the length l, which is how high the centre of mass
    is over the lowest of the feet in the model's start:

        spring_force: W / n,   velocity: √(g l),   height: l,   feedback: √(g / l).

    Args:
        env: an environment of Gymnasium's MuJoCo family, or any that has its `model`.
        feet: the bodies or geoms that touch the ground; all by default.
        limbs: how many limbs share the weight.

    Returns:
        Scales by signal, in SI units.

    Raises:
        TegotaeError: for an environment without a MuJoCo model, or one without mass or gravity.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("Hopper-v5")  # doctest: +SKIP
        >>> model_scales(env, feet=["foot"])["spring_force"]  # doctest: +SKIP
        35.79
    """
    mujoco = require("mujoco", "mujoco")
    model = getattr(env.unwrapped, "model", None)
    if model is None or not isinstance(model, mujoco.MjModel):
        raise TegotaeError(f"{env.unwrapped} has no MuJoCo model to take scales from; give scales=")
    return scales_of(model, feet, limbs=limbs)


def scales_of(
    model: MjModel, feet: Sequence[str] | None = None, *, limbs: int = 1
) -> dict[str, float]:
    """The same of a compiled MuJoCo model (`MjModel`)."""
    mujoco = require("mujoco", "mujoco")
    gravity = float(np.linalg.norm(model.opt.gravity))
    weight = gravity * float(model.body_mass.sum())
    if weight <= 0.0:
        raise TegotaeError("the model has no weight to take scales from; give scales=")
    length = _length(mujoco, model, feet)
    speed = math.sqrt(gravity * length)
    return {
        "spring_force": weight / limbs,
        "velocity": speed,
        "speed": speed,
        "height": length,
        "feedback": math.sqrt(gravity / length),
    }


def body_scales(body: Body | Interface) -> dict[str, float]:
    """What networks divide a body's signals by, and √(g/l0) as that of `feedback`, in SI units.

    A signal whose scale differs between limbs is left out.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> for name, scale in body_scales(Hopper()).items():
        ...     print(f"{name} {scale:.3f}")
        spring_force 0.981
        velocity 3.132
        height 1.000
        feedback 3.132
    """
    if isinstance(body, Interface):
        return body.known_scales
    still = ground_m = jnp.zeros(1)
    state = body.release(still + body.touching_height_m, still)
    found = {**body.sense(state, ground_m).scales, "feedback": body.rate_scale}
    values = {name: np.unique(np.asarray(scale)) for name, scale in found.items()}
    return {name: float(scale[0]) for name, scale in values.items() if scale.size == 1}


def _length(mujoco: ModuleType, model: MjModel, feet: Sequence[str] | None) -> float:
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    geoms = [i for i in range(model.ngeom) if model.geom_bodyid[i] > 0]
    if feet is not None:
        named = {model.body(i).name: i for i in range(1, model.nbody)}
        of_geoms = {model.geom(i).name: i for i in geoms}
        for foot in feet:
            if foot not in named and foot not in of_geoms:
                raise unknown("body of this model", foot, [*named, *of_geoms])
        bodies = {named[foot] for foot in feet if foot in named}
        own = {of_geoms[foot] for foot in feet if foot not in named}
        geoms = [i for i in geoms if i in own or model.geom_bodyid[i] in bodies]
    if not geoms:
        raise TegotaeError("the feet of the model have no geoms to stand on; give scales=")
    lowest = min(float(data.geom_xpos[i][2]) - below(mujoco, model, data, i) for i in geoms)
    com = float(np.average(data.xipos[1:, 2], weights=model.body_mass[1:]))
    if com <= lowest:
        raise TegotaeError("the model's centre of mass is not above its feet; give scales=")
    return com - lowest


def below(mujoco: ModuleType, model: MjModel, data: MjData, geom: int) -> float:
    """How far a geom reaches below its centre [m]; of a mesh or an ellipsoid at most so far."""
    size, kinds = model.geom_size[geom], mujoco.mjtGeom
    axis = np.abs(data.geom_xmat[geom].reshape(3, 3)[2])
    kind = model.geom_type[geom]
    if kind == kinds.mjGEOM_SPHERE:
        return float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return float(size[0] + size[1] * axis[2])
    if kind == kinds.mjGEOM_BOX:
        return float(size @ axis)
    return float(model.geom_rbound[geom])
