"""Sections of a recording: the lags whenever the reference leg's phase passes zero."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp

from tegotae.measures.gaits.lags import TURN, apart
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing

_NEWTON_STEPS = 3


@dataclass(frozen=True)
class Sections:
    """An `Engine`'s summary: lags at the sections after a frame, [cycles, limbs, lanes].

    NaN of sections that the recording does not reach, or after a fall.

    Args:
        first: the frame to begin with.
        cycles: how many sections.
        reference: the leg whose phase makes them.
    """

    first: int
    cycles: int
    reference: int = 0

    needs = ("phase_rad", "failed")

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[jax.Array, jax.Array]:
        """The lags, and those in the end, [limbs, lanes]."""
        phase = jnp.asarray(trajectory.phase_rad)
        lag = lags_at_sections(phase[self.first :], self.cycles, self.reference)
        last = (phase[-1, self.reference][None] - phase[-1]) / TURN % 1.0
        fell = trajectory.failed[-1]
        return jnp.where(fell[None, None], jnp.nan, lag), jnp.where(fell[None], jnp.nan, last)


@partial(jax.jit, static_argnums=(1, 2))
def lags_at_sections(phase_rad: AnyArray, cycles: int, reference: int = 0) -> jax.Array:
    """Lags whenever the reference leg's phase passes zero, `(φ_ref - φ_i) / 2π` there.

    Between frames phases go along cubics through the four frames around.

    Args:
        phase_rad: [frames, limbs, lanes]; frames shorter than half a turn.
        cycles: how many sections, from the first one on; NaN where the recording ends before.
        reference: the leg.

    Returns:
        [cycles, limbs, lanes] [cycles], in [0, 1).

    Example:
        >>> turns = 0.1 + 0.01 * jnp.arange(300.0)[:, None, None] - jnp.array([[[0.0], [0.25]]])
        >>> lags_at_sections(TURN * turns % TURN, 2)[:, 1, 0].round(3).tolist()
        [0.25, 0.25]
    """
    phase = jnp.asarray(phase_rad) / TURN
    begun = phase[:1] % 1.0
    turns = jnp.concatenate([begun, begun + jnp.cumsum(apart(phase[1:], phase[:-1]), axis=0)])
    own = turns[:, reference]
    levels = jnp.floor(own[0])[None] + 1.0 + jnp.arange(cycles, dtype=own.dtype)[:, None]
    return jax.vmap(lambda level: _at(turns, own, level))(levels)


def _at(turns: jax.Array, own: jax.Array, level: jax.Array) -> jax.Array:
    """The lags where the reference leg has made so many turns, [limbs, lanes]."""
    past = own >= level[None]
    after = jnp.argmax(past, axis=0)
    last = len(own) - 1
    there = past.any(axis=0) & (after >= 2) & (after < last)
    at = jnp.clip(after - 1, 1, last - 2)

    def near(x: jax.Array, offset: int) -> jax.Array:
        index = jnp.broadcast_to(at + offset, x.shape[1:])[None]
        return jnp.take_along_axis(x, index, axis=0)[0]

    four = [near(own, k) - level for k in (-1, 0, 1, 2)]
    share = -four[1] / (four[2] - four[1])
    for _ in range(_NEWTON_STEPS):
        value, slope = jax.jvp(lambda s: _cubic(four, s), (share,), (jnp.ones_like(share),))
        share = share - value / slope
    legs = _cubic([near(turns, k) for k in (-1, 0, 1, 2)], share[None])
    return jnp.where(there[None], (level[None] - legs) % 1.0, jnp.nan)


def _cubic(four: list[jax.Array], s: jax.Array) -> jax.Array:
    """The cubic through values at -1, 0, 1 and 2, at s."""
    a, b, c, d = four
    return (
        -a * s * (s - 1.0) * (s - 2.0) / 6.0
        + b * (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0
        - c * (s + 1.0) * s * (s - 2.0) / 2.0
        + d * (s + 1.0) * s * (s - 1.0) / 6.0
    )
