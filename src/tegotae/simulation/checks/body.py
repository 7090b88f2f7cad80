"""The contract of a body."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, is_of
from tegotae._support.transforms import jit
from tegotae.parts._shapes import (
    MaskPerLane,
    Number,
    PerCommand,
    PerLane,
    PerLimb,
    Scalar,
    StateTree,
)
from tegotae.parts.bodies import (
    Body,
    Contact,
    Push,
    Sensation,
)
from tegotae.parts.channels import FORCE
from tegotae.simulation.checks import probing
from tegotae.simulation.loop import over_limbs

_TICK_S = 0.001
_TICKS = 2000
_OF_LIMBS = ("stance_share", "work_j", "touchdown_share", "force_n")
"""What of a `Contact` belongs to each limb."""
_MOTION = ("height", "velocity")
_ENERGY_TOLERANCE = 1e-3
"""Share of the energy that may be made from nothing over a rollout: integration error."""

_Worked = tuple[StateTree, PerLane]
"""A state, and the work of the actuators so far [J]."""


def check_body(body: Body) -> None:
    """Try the contract of `tegotae.parts.bodies.Body` on a few lanes.

    Checked are: a frozen dataclass of numbers that is a pytree; its properties; every method's
    shapes, types and finiteness, in float32 and float64, no lane depending on another; that
    `predict` agrees with `advance` and the velocity with the height's change, as the tick shrinks;
    and that over 2 s the energy rises by no more than the actuator's work.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> check_body(Hopper(mass_kg=0.3))
    """
    name = probing.require_part(body, Body)
    _check_pytree(name, body)
    _check_properties(name, body)
    for dtype in probing.DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_methods(name, _cast(body, dtype), dtype)
    with jax.enable_x64(True):
        _check_small_ticks(name, _cast(body, "float64"))
        _check_energy(name, _cast(body, "float64"))


@cache
def _method(name: str) -> Callable[..., StateTree]:
    """A body's method as a function of the body, which is traced as in a rollout.

    The same function for every trial of it, so that it is compiled once.
    """

    def call(body: Body, *args: object) -> StateTree:
        return getattr(body, name)(*args)

    return call


def _advance(
    body: Body, state: StateTree, force: PerCommand, ground: PerLane, tick: Scalar
) -> StateTree:
    return body.advance(state, Push(force), ground, tick)


def _sensed(body: Body, state: StateTree, ground: PerLane) -> dict[str, PerLimb]:
    return body.sense(state, ground).values


def _itself(body: Body) -> Body:
    return body


def _cast(body: Body, dtype: str) -> Body:
    def cast(x: Number) -> jax.Array:
        return jnp.asarray(x, dtype)

    return jax.tree.map(cast, body)


def _check_pytree(name: str, body: Body) -> None:
    leaves = jax.tree.leaves(body)
    if any(leaf is body for leaf in leaves):
        raise TegotaeError(
            f"{name} is no pytree; put @tegotae.parts.parameters.traceable above its @dataclass"
        )
    for leaf in leaves:
        if isinstance(leaf, bool) or not isinstance(leaf, int | float | np.number | jax.Array):
            raise TegotaeError(f"{name} has a field {leaf!r}; its fields must be numbers")
    probing.attempt(f"{name} inside a compiled program", _itself, body)


def _check_properties(name: str, body: Body) -> None:
    probing.require_names(f"{name}.SENSES", body.SENSES)
    if not body.SENSES:
        raise TegotaeError(f"{name}.SENSES is empty; name at least one sensed quantity")
    for quantity in ("max_force_n", "rest_length_m", "rate_scale"):
        probing.require_positive(f"{name}.{quantity}", getattr(body, quantity))
    body.check_tick(_TICK_S)


def _per_limb(body: Body, x: jax.Array) -> jax.Array:
    """The same for each limb."""
    return jnp.broadcast_to(x, (*body.limb_shape, *x.shape))


def _command(body: Body, share: Number, like: jax.Array) -> jax.Array:
    """A share of the largest force; or feet that are commanded to places, a little from rest."""
    if body.COMMANDS == FORCE:
        return _per_limb(body, share * jnp.asarray(body.max_force_n, like.dtype) + 0.0 * like)
    places = _per_limb(body, 0.1 * share * jnp.asarray(body.rest_length_m, like.dtype) + 0.0 * like)
    return jnp.stack([places] * len(body.COMMANDS))


def _start(body: Body, dtype: str) -> tuple[StateTree, PerLane]:
    """Lanes in flight, in stance and about to touch down, and a ground that is not at zero."""
    rest = float(body.touching_height_m)
    shares = jnp.linspace(0.9, 1.2, probing.LANES, dtype=dtype)
    ground = jnp.full_like(shares, -0.05)
    velocity = probing.lanes_of(dtype, -1.5, 1.5, 4)
    return body.release(shares * rest + ground, velocity), ground


def _check_methods(name: str, body: Body, dtype: str) -> None:
    height = probing.lanes_of(dtype, 0.9, 1.2, 5) * float(body.touching_height_m)
    velocity = probing.lanes_of(dtype, -1.0, 1.0, 6)
    state = probing.attempt(f"{name}.release", _method("release"), body, height, velocity)
    if not is_of(state, tuple) or not state:
        raise TegotaeError(
            f"{name}.release returns {state!r:.60}; it must return a tuple of arrays"
        )
    probing.require_arrays(f"{name}.release", state, dtype, before=None)
    for method, given in zip(_MOTION, (height, velocity), strict=True):
        measured = probing.attempt(f"{name}.{method}", _method(method), body, state)
        probing.require_arrays(f"{name}.{method}", measured, dtype)
        if not np.allclose(measured, given, atol=1e-5):
            raise TegotaeError(
                f"{name}.{method} of the release is {probing.listed(measured)}; "
                f"it must be {probing.listed(given)}"
            )

    state, ground = _start(body, dtype)
    force = _command(body, 0.5, ground)
    tick = jnp.asarray(_TICK_S, dtype)
    _check_sense(name, body, state, ground, dtype)
    _check_predict(name, body, state, force, ground, tick, dtype)
    _check_advance(name, body, state, force, ground, tick, dtype)

    failed = probing.attempt(f"{name}.failed", _method("failed"), body, state, ground)
    probing.require_arrays(f"{name}.failed", failed, "bool")
    energy = probing.attempt(f"{name}.energy", _method("energy"), body, state, ground)
    probing.require_arrays(f"{name}.energy", energy, dtype)
    for method in ("failed", "energy"):
        probing.require_independent(f"{name}.{method}", _method(method), body, state, ground)


def _check_sense(name: str, body: Body, state: StateTree, ground: jax.Array, dtype: str) -> None:
    what = f"{name}.sense"
    sensation = probing.attempt(what, _method("sense"), body, state, ground)
    if not isinstance(sensation, Sensation):
        raise TegotaeError(
            f"{what} returns a {type(sensation).__name__}; it must return a Sensation"
        )
    if set(sensation.values) != set(body.SENSES):
        raise TegotaeError(
            f"{what} gives {', '.join(sorted(sensation.values))}; SENSES names "
            f"{', '.join(sorted(body.SENSES))}: they must be the same"
        )
    for quantity in body.SENSES:
        felt = sensation.values[quantity]
        probing.require_arrays(f"{what}'s {quantity}", felt, dtype, before=body.limb_shape)
        if quantity not in sensation.scales:
            raise TegotaeError(
                f"{what} gives no scale for {quantity}; networks see quantity / scale, so add one"
            )
        probing.require_positive(f"{what}'s scale of {quantity}", sensation.scales[quantity])
    probing.require_independent(what, _sensed, body, state, ground)


def _check_predict(
    name: str,
    body: Body,
    state: StateTree,
    force: PerCommand,
    ground: PerLane,
    tick: Scalar,
    dtype: str,
) -> None:
    what = f"{name}.predict"
    result = probing.attempt(what, _method("predict"), body, state, force, ground, tick)
    if not is_of(result, tuple) or len(result) != 3:
        raise TegotaeError(f"{what} must return (state, stance from, stance to)")
    guess, stance_from, stance_to = result
    probing.same_structure(what, guess, state)
    probing.require_arrays(what, guess, dtype, before=None)
    shares = stance_from, stance_to
    probing.require_arrays(what, shares, dtype, before=body.limb_shape)
    if not bool(((stance_from >= 0) & (stance_from <= stance_to) & (stance_to <= 1)).all()):
        raise TegotaeError(
            f"{what} returns stance from {probing.listed(stance_from)} to "
            f"{probing.listed(stance_to)}; it must be 0 <= from <= to <= 1 (shares of the tick)"
        )
    probing.require_independent(what, _method("predict"), body, state, force, ground, tick)


def _check_advance(
    name: str,
    body: Body,
    state: StateTree,
    force: PerCommand,
    ground: PerLane,
    tick: Scalar,
    dtype: str,
) -> None:
    what = f"{name}.advance"
    result = probing.attempt(what, _advance, body, state, force, ground, tick)
    if not is_of(result, tuple) or len(result) != 2 or not is_of(result[1], Contact):
        raise TegotaeError(f"{what} must return (state, tegotae.parts.bodies.Contact)")
    end = result[0]
    contact: Contact = result[1]
    probing.same_structure(what, end, state)
    probing.require_arrays(what, end, dtype, before=None)
    for field, value in contact._asdict().items():
        event = field.startswith(("apex", "touchdown"))
        probing.require_arrays(
            f"{what}'s {field}",
            value,
            dtype,
            kind="events" if event else "finite",
            before=body.limb_shape if field in _OF_LIMBS else (),
        )
        array = np.asarray(value)
        if field.endswith("_share") and not np.all(np.isnan(array) | ((array >= 0) & (array <= 1))):
            raise TegotaeError(
                f"{what}'s {field} is {probing.listed(array)}; it must be a share, 0 ... 1"
            )
        if field.startswith("climb") and not np.all(array >= 0.0):
            raise TegotaeError(
                f"{what}'s {field} is {probing.listed(array)}; it must be at least 0"
            )
    if not np.all(np.asarray(contact.climb_flight_m) <= np.asarray(contact.climb_m) + 1e-6):
        raise TegotaeError(f"{what}'s climb_flight_m exceeds climb_m, which includes it")
    if not np.array_equal(np.isnan(contact.apex_share), np.isnan(contact.apex_height_m)):
        raise TegotaeError(f"{what}'s apex_share and apex_height_m must be NaN on the same lanes")
    probing.require_independent(what, _advance, body, state, force, ground, tick)


def _check_small_ticks(name: str, body: Body) -> None:
    """`predict` and the velocity must agree with `advance` the better the shorter the tick."""
    state, ground = _start(body, "float64")
    force = _command(body, 0.5, ground)
    released = probing.attempt(f"{name}.commanded", _method("commanded"), body, state, force)

    def seen(at: StateTree) -> list[np.ndarray]:
        """What the controller would know of a state: of it alone the guess must be right."""
        sensed = probing.attempt(f"{name}.sense", _sensed, body, at, ground)
        moves = [probing.attempt(f"{name}.{m}", _method(m), body, at) for m in _MOTION]
        return [np.asarray(x) for x in (*sensed.values(), *moves)]

    def gaps(tick_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Programs that the checks of the methods have compiled are used again."""
        tick = jnp.asarray(tick_s, "float64")
        # A body may guess from what its last tick was like.
        begun, _ = probing.attempt(f"{name}.advance", _advance, body, released, force, ground, tick)
        given = body, begun, force, ground, tick
        end, contact = probing.attempt(f"{name}.advance", _advance, *given)
        guess, _, _ = probing.attempt(f"{name}.predict", _method("predict"), *given)
        share = np.asarray(contact.stance_share).reshape(-1, probing.LANES)
        steady = np.all((share == 0.0) | (share == 1.0), axis=0)
        before, after, guessed = seen(begun), seen(end), seen(guess)
        apart = sum(
            np.abs(a - b).reshape(-1, probing.LANES).max(axis=0)
            for a, b in zip(after, guessed, strict=True)
        )
        height, velocity = before[-2:]
        slope = (after[-2] - height) / tick_s
        return (
            np.where(steady, apart / tick_s, 0.0),
            np.where(steady, np.abs(slope - velocity), 0.0),
        )

    long, short = gaps(1e-4), gaps(1e-5)
    meanings = (
        "predict does not approach advance as the tick shrinks; check its signs, units and forces",
        "velocity is not the rate of change of height; check signs and units",
    )
    for before, after, meaning in zip(long, short, meanings, strict=True):
        if not bool((after <= 0.5 * before + 1e-6).all()):
            raise TegotaeError(f"{name}.{meaning}")


def _check_energy(name: str, body: Body) -> None:
    """Over 2 s, with and without force, the energy rises by no more than the actuator's work."""
    start, ground = _start(body, "float64")
    tick = jnp.asarray(_TICK_S)

    @jit
    def excess(share: jax.Array) -> jax.Array:
        push = Push(_command(body, share, ground))

        def step(carry: _Worked, _: None) -> tuple[_Worked, tuple[PerLane, MaskPerLane]]:
            state, work = carry
            state, contact = body.advance(state, push, ground, tick)
            work = work + over_limbs(jnp.sum, contact.work_j, body)
            return (state, work), (body.energy(state, ground) - work, body.failed(state, ground))

        placed = body.commanded(start, push.mean_n)
        _, (balance, failed) = jax.lax.scan(step, (placed, jnp.zeros_like(ground)), None, _TICKS)
        first = body.energy(placed, ground)
        alive = jnp.cumsum(failed, axis=0) == 0
        scale = jnp.abs(first) + jnp.asarray(body.max_force_n * body.rest_length_m)
        return jnp.max(jnp.where(alive, (balance - first[None]) / scale[None], 0.0))

    for share, when in ((0.0, "without the actuator"), (0.5, "beyond the actuator's work_j")):
        made = float(excess(jnp.asarray(share)))
        if not made <= _ENERGY_TOLERANCE:
            raise TegotaeError(
                f"{name} makes energy from nothing, {when}: {made:.2%} of its energy within "
                f"{_TICKS * _TICK_S:g} s; check the signs of its forces, of `energy` and of work_j"
            )
