"""Scales by which networks divide signals: those of a MuJoCo model, or of a body of this
package."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require, unknown
from tegotae.envs._types import AnyEnv, MjData, MjModel
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.fields import unwrapped
from tegotae.parts.units import Units

_STANDS = math.sqrt(0.5)
"""A geom whose axis is at least so far upright stands, 45°."""


def model_scales(
    env: AnyEnv, *, feet: Sequence[str] | None = None, limbs: int = 1
) -> dict[str, float]:
    """Return the scales of a limb's signals, from the masses and lengths of a MuJoCo model.

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
    """Return the scales of a compiled MuJoCo model (`MjModel`)."""
    gravity, weight = gravity_m_per_s2(model), weight_n(model)
    data = started(model)
    geoms = np.flatnonzero(model.geom_bodyid > 0).tolist()
    if feet is not None:
        geoms = [i for foot in feet for i in foot_of(model, foot).geoms]
    if not geoms:
        raise TegotaeError("the feet of the model have no geoms to stand on; give scales=")
    length = centre_height_m(model, data) - lowest(model, data, geoms)[0]
    if length <= 0.0:
        raise TegotaeError("the model's centre of mass is not above its feet; give scales=")
    speed = math.sqrt(gravity * length)
    return {
        "spring_force": weight / limbs,
        "velocity": speed,
        "speed": speed,
        "height": length,
        "feedback": math.sqrt(gravity / length),
    }


def body_scales(body: Body | Interface) -> dict[str, float]:
    """Return the divisors of a body's signals for networks, and √(g/l0) as that of `feedback`, in
    SI units.

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
    scales = {**body.sense(state, ground_m).scales, "feedback": body.rate_scale}
    values = {name: np.unique(np.asarray(scale)) for name, scale in scales.items()}
    return {name: float(scale[0]) for name, scale in values.items() if scale.size == 1}


def units_of(body: Body) -> Units:
    """Return Froude's units of a body: l0, √(l0 / g) and its weight, for a hopper or a walker.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> round(units_of(Hopper()).force_n, 3)
        0.981
    """
    base: Any = unwrapped(body)
    length, gravity = float(base.rest_length_m), float(base.gravity_m_per_s2)
    weight_n = float(base.mass_kg) * gravity
    return Units(length_m=length, time_s=math.sqrt(length / gravity), force_n=weight_n)


def gravity_m_per_s2(model: MjModel) -> float:
    """Return the magnitude of gravity [m/s²]."""
    return float(np.linalg.norm(model.opt.gravity))


def weight_n(model: MjModel) -> float:
    """Return the weight of all bodies [N].

    Raises:
        TegotaeError: without gravity or masses.
    """
    weight = gravity_m_per_s2(model) * float(model.body_mass.sum())
    if weight <= 0.0:
        raise TegotaeError("the model has no weight to take scales from: no gravity, or no masses")
    return weight


class Foot(NamedTuple):
    """A part of a MuJoCo model that touches the ground: a body, or a geom of one."""

    body: int
    """The body, or that of the geom."""
    geoms: list[int]
    """Those of the body and of what hangs on it, or the geom."""


def foot_of(model: MjModel, name: str) -> Foot:
    """Return the body of this name, or else the geom.

    Raises:
        TegotaeError: if there is none that can move.
    """
    bodies = {model.body(i).name: i for i in range(1, model.nbody) if model.body(i).name}
    if name in bodies:
        parts = {bodies[name]}
        for body in range(bodies[name] + 1, model.nbody):  # children come after their parents
            parts |= {body} if int(model.body_parentid[body]) in parts else set()
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, [*parts]))
        return Foot(bodies[name], geoms.tolist())
    moving = np.flatnonzero(model.geom_bodyid > 0).tolist()
    geoms = {model.geom(i).name: i for i in moving if model.geom(i).name}
    if name not in geoms:
        raise unknown("body or geom of this model", name, [*bodies, *geoms])
    return Foot(int(model.geom_bodyid[geoms[name]]), [geoms[name]])


def chain_of(model: MjModel, foot: str) -> set[int]:
    """Return the bodies between a foot and the trunk, which is excluded."""
    body, chain = foot_of(model, foot).body, set()
    while body > 1:
        chain.add(body)
        body = int(model.body_parentid[body])
    # A body of one piece, such as a mass on a slide with a geom as its foot, is its own leg.
    return chain or {foot_of(model, foot).body}


def foot_place(model: MjModel, data: MjData, foot: str) -> np.ndarray:
    """Return the place of a foot: the middle of its lowest geom in the world [m], [x, y, z].

    Of a capsule or a cylinder that stands more than it lies, such as a shank, it is the middle of
    the lower end.
    """
    body, geoms = foot_of(model, foot)
    if not geoms:
        return data.xpos[body]
    geom, kinds = lowest(model, data, geoms)[1], require("mujoco", "mujoco").mjtGeom
    along = data.geom_xmat[geom].reshape(3, 3)[:, 2]
    long = int(model.geom_type[geom]) in (int(kinds.mjGEOM_CAPSULE), int(kinds.mjGEOM_CYLINDER))
    stands = long and abs(along[2]) > _STANDS
    end = np.sign(along[2]) * float(model.geom_size[geom, 1]) * along
    return data.geom_xpos[geom] - end * stands


def started(model: MjModel) -> MjData:
    """Return MuJoCo's data at the model's start: its first keyframe, or else its zero."""
    mujoco = require("mujoco", "mujoco")
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data


def centre_height_m(model: MjModel, data: MjData) -> float:
    """Return the height of the centre of mass of all bodies [m]."""
    return float(np.average(data.xipos[1:, 2], weights=model.body_mass[1:]))


def lowest(model: MjModel, data: MjData, geoms: Sequence[int]) -> tuple[float, int]:
    """Return the lowest height of geoms [m], a lower bound for an ellipsoid or a cylinder, and the
    geom that has it."""
    return min((float(data.geom_xpos[i][2]) - _below(model, data, i), i) for i in geoms)


def _below(model: MjModel, data: MjData, geom: int) -> float:
    """Return the depth of a geom below its centre [m]."""
    size, kinds = model.geom_size[geom], require("mujoco", "mujoco").mjtGeom
    axis = data.geom_xmat[geom].reshape(3, 3)[2]
    if int(model.geom_type[geom]) == int(kinds.mjGEOM_MESH):
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return -float((model.mesh_vert[first : first + count] @ axis).min())
    axis = np.abs(axis)
    reach = {
        int(kinds.mjGEOM_SPHERE): size[0],
        int(kinds.mjGEOM_CAPSULE): size[0] + size[1] * axis[2],
        int(kinds.mjGEOM_BOX): size @ axis,
    }
    return float(reach.get(int(model.geom_type[geom]), model.geom_rbound[geom]))
