"""A passive drop: whether a body comes to rest where nothing pushes it."""

from __future__ import annotations

import warnings
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.transforms import jit
from tegotae.parts._shapes import MaskPerLane, PerLane, Scalar, StateTree
from tegotae.parts.bodies import Body, Push
from tegotae.parts.channels import FORCE
from tegotae.parts.fields import unwrapped
from tegotae.simulation.loop import over_limbs
from tegotae.simulation.native import with_numpy_numbers

_MOST_LEFT = 0.01
"""Share of the energy of a release above standing that a passive drop may have after settling."""
_MOST_GAINED = 1e-3
"""Share of it that may be made from nothing: integration error."""


class PassiveBodyWarning(UserWarning):
    """A body hops on without a push."""


def energy_of_drop(body: Body, height_m: float, duration_s: float, tick_s: float) -> np.ndarray:
    """Simulate a drop without a push; return the energy that can lift the body off the ground.

    That is (E(t) - E_0) / (E(0) - E_0), with E_0 the energy at rest where the legs at rest just
    touch the ground.

    Args:
        body: the body, of one limb that takes a force.
        height_m: height of the release at rest [m], above that where the legs touch.
        duration_s: how long it is simulated [s].
        tick_s: control period [s].

    Returns:
        The share after every tick, shape [ticks]; NaN after a failure.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> bool(energy_of_drop(Hopper(), 1.2, 2.0, 0.002)[-1] < 0.0)
        True
    """

    @jit
    def drop(body: Body) -> jax.Array:
        ground, tick = jnp.zeros(1), jnp.asarray(tick_s)
        start, standing = (
            body.release(jnp.full(1, height), ground)
            for height in (height_m, body.touching_height_m)
        )
        lower, upper = body.energy(standing, ground), body.energy(start, ground)
        ticks = round(duration_s / tick_s)
        energy, _, stands = pushed(body, start, Push(jnp.zeros(1)), ground, tick, ticks)
        return jnp.where(stands, (energy - lower[None]) / (upper - lower)[None], jnp.nan)

    with jax.enable_x64(True):
        return np.asarray(drop(with_numpy_numbers(body, "float64")))[:, 0]


def pushed(
    body: Body, start: StateTree, push: Push, ground_m: PerLane, tick_s: Scalar, ticks: int
) -> tuple[PerLane, PerLane, MaskPerLane]:
    """Advance a body under a constant push.

    Returns:
        After every tick its energy [J], the work of the actuators so far [J], and True while it has
        not failed, [ticks, lanes] each.
    """

    def step(carry: Any, _: None) -> tuple[Any, Any]:
        state, work, stands = carry
        state, contact = body.advance(state, push, ground_m, tick_s)
        work = work + over_limbs(jnp.sum, contact.work_j, body)
        stands = stands & ~body.failed(state, ground_m)
        return (state, work, stands), (body.energy(state, ground_m), work, stands)

    begun = start, jnp.zeros_like(ground_m), jnp.ones(ground_m.shape, bool)
    return jax.lax.scan(step, begun, None, ticks)[1]


def check_passive(body: Body, height_m: float, settle_s: float, tick_s: float) -> None:
    """Drop a body of a user's own without a push, before it is trained or evaluated.

    A body of the package is not tried, nor one whose feet are placed or that has several limbs.

    Args:
        body: the body.
        height_m: height of the release [m].
        settle_s: time that the measures leave out [s].
        tick_s: control period [s].

    Raises:
        TegotaeError: for a body that gains energy: it climbs without work.

    Warns:
        PassiveBodyWarning: for a body that hops on after `settle_s`; CoT⁻¹ counts these hops.
    """
    kind = type(unwrapped(body))
    foreign = kind.__module__.partition(".")[0] != "tegotae"
    drops = height_m > float(body.touching_height_m) and settle_s >= tick_s
    if not (foreign and drops and body.limbs == 1 and body.COMMANDS == FORCE):
        return
    share = energy_of_drop(body, height_m, settle_s, tick_s)
    dropped = f"a {kind.__name__} that is dropped from {height_m:g} m without a push"
    highest = float(np.nanmax(share, initial=0.0))
    if highest > 1.0 + _MOST_GAINED:
        raise TegotaeError(
            f"{dropped} climbs without work: its energy rises to {highest:.4g} times that of the "
            "release, so every CoT⁻¹ is impossible; check the signs of its forces and of `energy`"
        )
    if share[-1] > _MOST_LEFT:
        warnings.warn(
            f"{dropped} still has {share[-1]:.0%} of its energy for hopping after the {settle_s:g} "
            "s that are left to settle: CoT⁻¹ counts hops that cost no work, and is too high; "
            "give its leg more damping at small depths, or more time to settle",
            PassiveBodyWarning,
            stacklevel=3,
        )
