"""Legs as chains of joints: where their feet are, the joints of a place, and what feet bear."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial, reduce
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.parts._shapes import AnyArray

STEPS = 8
"""Steps of the solution: near the start a place within reach is met to 10⁻⁵ of the leg's length."""
_DAMPED = 1e-4
"""Least damping of a step."""
_ALIGNED = 1e-5
"""Directions are parallel or at right angles to this, and a place is in a plane."""
_BENT = 0.01
"""Least share of a leg's length by which it bends in the start, and its foot is off an axis."""


class Chains(NamedTuple):
    """Legs in the model's start, in the axes of the trunk, with lengths over that of a leg.

    A leg with fewer joints than another has some without an effect.
    """

    axis: np.ndarray
    """Directions of the joints, from the trunk to the foot, [legs, joints, 3]."""
    anchor: np.ndarray
    """A point on each, likewise."""
    slides: np.ndarray
    """1 of a joint that slides, 0 of one that turns, [legs, joints]."""
    foot: np.ndarray
    """The feet, [legs, 3]."""
    low: np.ndarray
    """Limits of the joints and of their servos' commands, from the start on, [legs, joints]."""
    high: np.ndarray


class _Vector(NamedTuple):
    """Three numbers, [legs, lanes] each."""

    x: AnyArray
    y: AnyArray
    z: AnyArray

    def plus(self, other: _Vector, times: AnyArray | float = 1.0) -> _Vector:
        return _Vector(*(mine + times * its for mine, its in zip(self, other, strict=True)))

    def times(self, number: AnyArray | float) -> _Vector:
        return _Vector(*(number * mine for mine in self))

    def dot(self, other: _Vector) -> Any:
        return self.x * other.x + self.y * other.y + self.z * other.z

    def cross(self, other: _Vector) -> _Vector:
        return _Vector(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )


def _vector(numbers: np.ndarray) -> _Vector:
    """Make a vector of numbers of the legs, [legs, 3]."""
    return _Vector(*(numbers[:, i, None] for i in range(3)))


def kinematics(chains: Chains, moved: Sequence[AnyArray]) -> tuple[_Vector, list[_Vector]]:
    """The feet and the columns of their Jacobian: a product of exponentials, from the foot up."""
    foot, columns = _vector(chains.foot), list[_Vector]()
    for k in reversed(range(len(moved))):
        axis, anchor = _vector(chains.axis[:, k]), _vector(chains.anchor[:, k])
        slides = chains.slides[:, k, None]
        angle = (1.0 - slides) * moved[k]
        turned = partial(_turned, axis, jnp.sin(angle), jnp.cos(angle))
        arm = turned(foot.plus(anchor, -1.0))
        foot = anchor.plus(arm).plus(axis, slides * moved[k])
        moves = axis.cross(arm).times(1.0 - slides).plus(axis, slides)
        columns = [moves, *map(turned, columns)]
    return foot, columns


def _turned(axis: _Vector, sine: AnyArray, cosine: AnyArray, x: _Vector) -> _Vector:
    """A vector turned about an axis (Rodrigues)."""
    across = axis.cross(x)
    return x.plus(across, sine).plus(axis.cross(across), 1.0 - cosine)


def _damped(columns: Sequence[_Vector], damping: AnyArray | float, e: _Vector) -> _Vector:
    """(J Jᵀ + damping I)⁻¹ e, by the adjugate."""

    def entry(i: int, k: int) -> Any:
        return sum(column[i] * column[k] for column in columns) + damping * float(i == k)

    a, b, c = (_Vector(*(entry(i, k) for k in range(3))) for i in range(3))
    adjugate = _Vector(b.cross(c).dot(e), c.cross(a).dot(e), a.cross(b).dot(e))
    return adjugate.times(1.0 / a.dot(b.cross(c)))


def solved(chains: Chains, place: Sequence[AnyArray]) -> jax.Array:
    """The joints that put feet somewhere, or as near to it as they reach.

    Args:
        chains: the legs.
        place: from that in the start, over the leg's length, x, y and z, [legs, lanes] each.

    Returns:
        From the start on, over their unit, [joints, legs, lanes].
    """
    wanted = _vector(chains.foot).plus(_Vector(*place))
    moved = [jnp.zeros_like(wanted.x) for _ in range(chains.slides.shape[1])]
    nearest, found = [*moved], jnp.zeros_like(wanted.x)
    if has_closed_form(chains):
        nearest, found = direct(chains, wanted)
        moved = nearest
    for _ in range(STEPS):
        moved = nearer(chains, wanted, moved)
    return jnp.where(found > 0.5, jnp.stack(nearest), jnp.stack(moved))


def nearer(chains: Chains, wanted: Sequence[AnyArray], moved: Sequence[Any]) -> list[jax.Array]:
    """Joints after one step of the solution, [legs, lanes] each.

    Args:
        chains: the legs.
        wanted: where the feet shall be, over the leg's length, x, y and z.
        moved: joints from the start on, over their unit.
    """
    foot, columns = kinematics(chains, moved)
    e, free = _Vector(*wanted).plus(foot, -1.0), list[_Vector]()
    low, high = ([x[:, k, None] for k in range(len(moved))] for x in (chains.low, chains.high))
    for k, column in enumerate(columns):
        pull = column.dot(e)
        held = ((moved[k] <= low[k]) & (pull < 0.0)) | ((moved[k] >= high[k]) & (pull > 0.0))
        free.append(column.times(jnp.where(held, 0.0, 1.0)))
    step = _damped(free, 0.5 * e.dot(e) + _DAMPED, e)
    return [jnp.clip(moved[k] + column.dot(step), low[k], high[k]) for k, column in enumerate(free)]


class _Plane(NamedTuple):
    """Plane in which a leg bends, [legs, 1] or [legs, lanes] each.

    Numbers in it are along `down` and `ahead`, which are as long as each other: unit vectors of
    three joints; of two as long as the foot is from the first axis.
    """

    origin: _Vector
    """Point on the first axis."""
    side: _Vector
    """Normal to the plane; a joint that turns about it turns `down` to `ahead`."""
    down: _Vector
    ahead: _Vector
    """Along the first of three axes."""

    def coordinates(self, x: _Vector) -> tuple[Any, Any]:
        return self.down.dot(x), self.ahead.dot(x)


def _plane(chains: Chains) -> _Plane:
    """The plane of legs of two or three joints in the start."""
    side, anchor = _vector(chains.axis[:, -2]), _vector(chains.anchor[:, 0])
    arm = _vector(chains.foot).plus(anchor, -1.0)
    ahead = _vector(chains.axis[:, 0]) if chains.slides.shape[1] == 3 else arm.cross(side)
    return _Plane(anchor, side, ahead.cross(side), ahead)


def has_closed_form(chains: Chains) -> bool:
    """Return True if all legs have two joints with parallel axes, or such two after one across
    them.

    In the start they must be bent, and the foot off the first axis, which say on which side they
    bend.
    """
    joints = chains.slides.shape[1]
    if joints not in (2, 3) or chains.slides.any():
        return False
    first, second, third = chains.axis[:, 0], chains.axis[:, -2], chains.axis[:, -1]
    hip, knee = chains.anchor[:, -2], chains.anchor[:, -1]
    deviation = np.linalg.norm(np.cross(second, third), axis=1) + (np.abs(third).sum(axis=1) == 0.0)
    bent = np.abs((np.cross(knee - hip, chains.foot - knee) * second).sum(axis=1))
    if joints == 3:
        deviation += np.abs((first * second).sum(axis=1))
        arm = chains.foot - chains.anchor[:, 0]
        bent = np.minimum(bent, np.abs((np.cross(first, second) * arm).sum(axis=1)))
    return bool((deviation < _ALIGNED).all() and (bent > _BENT).all())


def direct(chains: Chains, wanted: Sequence[AnyArray]) -> tuple[list[Any], Any]:
    """Joints in closed form, of legs that have one: Go1's, for example.

    The first joint turns the plane of the leg onto the place; there thigh m₁ and shank m₂, from a
    hip to a place t away, bend by the law of cosines. With numbers of the plane as complex ones,

        cos β = (|t|² - |m₁|² - |m₂|²) / (2 |m₁| |m₂|),    t ~ e^{i q₁} m₁ (|m₁| + |m₂| e^{iβ}),

    β from m₁ to m₂, on the side of the start, or on the other if limits forbid it. Out of reach a
    leg is stretched, or folded, towards the place.

    Args:
        chains: the legs.
        wanted: where the feet shall be, over the leg's length, x, y and z.

    Returns:
        Joints from the start on [rad], within their limits, and 1 of legs whose foot is there, or
        as near to it as two joints reach, 0 of others, [legs, lanes] each.
    """
    plane, foot = _plane(chains), _vector(chains.foot)
    hip, knee = (_vector(chains.anchor[:, k]) for k in (-2, -1))
    place, rest = (x.plus(plane.origin, -1.0) for x in (_Vector(*wanted), foot))
    aside, (x, y), beside = plane.side.dot(place), plane.coordinates(place), plane.side.dot(rest)
    three, squared = chains.slides.shape[1] == 3, aside * aside + x * x - beside * beside
    turned, there = [], True
    if three:
        onto = jnp.sqrt(jnp.maximum(squared, 0.0)) * jnp.where(x < 0.0, -1.0, 1.0)
        turned = [jnp.arctan2(x * beside - aside * onto, aside * beside + x * onto)]
        x = onto
    from_hip = plane.coordinates(hip.plus(plane.origin, -1.0))
    x, y = x - from_hip[0], y - from_hip[1]
    (a, b), (c, d) = (
        plane.coordinates(knee.plus(hip, -1.0)),
        plane.coordinates(foot.plus(knee, -1.0)),
    )
    thigh, shank, cosine, sine = a * a + b * b, c * c + d * d, a * c + b * d, a * d - b * c
    longest = jnp.sqrt(thigh * shank)  # times cos β and sin β below: arctan2 divides
    unbent = 0.5 * (x * x + y * y - thigh - shank)
    if three:
        there = (squared >= 0.0) & (jnp.abs(unbent) <= longest)
    flat = jnp.clip(unbent, -longest, longest)
    up = jnp.sqrt((longest - flat) * (longest + flat)) * jnp.where(sine < 0.0, -1.0, 1.0)
    of_hip, of_knee = (plane.side.dot(_vector(chains.axis[:, k])) for k in (-2, -1))
    limits = [*zip(chains.low.T[..., None], chains.high.T[..., None], strict=True)]

    def bent(up: Any) -> tuple[list[Any], Any]:
        p, q = a * (thigh + flat) - b * up, b * (thigh + flat) + a * up  # before the hip turns
        turns = [
            of_hip * jnp.arctan2(y * p - x * q, x * p + y * q),
            of_knee * jnp.arctan2(up * cosine - flat * sine, flat * cosine + up * sine),
        ]
        return _within([*turned, *turns], limits)

    (moved, held), (mirrored, other) = bent(up), bent(-up)
    other &= ~held
    moved = [jnp.where(other, its, mine) for mine, its in zip(moved, mirrored, strict=True)]
    return moved, jnp.where(there & (held | other), 1.0, 0.0)


def _within(turns: Sequence[Any], limits: Sequence[Any]) -> tuple[list[Any], Any]:
    """Turns of at most π within limits, by a whole turn or else clipped; and if none was."""
    moved, held = list[Any](), True
    for turn, (low, high) in zip(turns, limits, strict=True):
        whole = turn + jnp.where(turn < low, 2.0 * np.pi, -2.0 * np.pi)
        outside, fits = (turn < low) | (turn > high), (whole >= low) & (whole <= high)
        moved.append(jnp.clip(jnp.where(outside & fits, whole, turn), low, high))
        held &= fits | ~outside
    return moved, held


def borne(
    chains: Chains, moved: Sequence[AnyArray], pull: Sequence[AnyArray]
) -> tuple[Any, Any, Any]:
    """The forces on feet, x, y and z, [legs, lanes] each, from what pulls at joints.

    Args:
        chains: the legs.
        moved: joints from the start on, over their unit.
        pull: torques of the servos over the leg's length, or forces.
    """
    _, columns = kinematics(chains, moved)
    pushed = (column.times(-own) for column, own in zip(columns, pull, strict=True))
    return _damped(columns, _DAMPED, reduce(_Vector.plus, pushed))


def foot_velocities(
    chains: Chains, moved: Sequence[AnyArray], rates: Sequence[AnyArray]
) -> tuple[Any, Any, Any]:
    """Velocities of feet in the axes of the trunk, J q̇, x, y and z, [legs, lanes] each.

    Args:
        chains: the legs.
        moved: joints from the start on, over their unit.
        rates: of the joints, over their unit [1/s].
    """
    _, columns = kinematics(chains, moved)
    turning = (column.times(rate) for column, rate in zip(columns, rates, strict=True))
    return reduce(_Vector.plus, turning)
