"""Efficiency while an episode goes on: what was climbed for how much work, apex by apex."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.measures.hopping.hopping import dies_out, left_out
from tegotae.measures.hopping.signals import cot_inverse


class Apexes(NamedTuple):
    """Totals at the apexes of hops so far: all that CoT⁻¹ over whole hops takes.

    The same hops count as in a recording of the same frames
    (`tegotae.measures.hopping.whole_hops`).

    Example:
        >>> apexes = Apexes.none(jnp.zeros(1))
        >>> for time_s in jnp.array([[1.0], [2.0], [3.0]]):
        ...     apexes = apexes.after(time_s > 0.0, time_s, 0.5 * time_s, 2.0 * time_s)
        >>> apexes.cot_inverse(jnp.array([3.2])).tolist()
        [0.25]
    """

    n_apexes: jax.Array
    """How many there were, [lanes]."""
    first: jax.Array
    """Climbed height [m] and work [J] at the first, [2, lanes]."""
    second: jax.Array
    """The same at the second."""
    last: jax.Array
    """The same at the last."""
    last_s: jax.Array
    """Time of the last [s], [lanes]; minus infinity before any."""

    @classmethod
    def none(cls, like: jax.Array) -> Apexes:
        """Before any, of the shape of an array."""
        nothing = jnp.zeros((2, *like.shape), like.dtype)
        count = jnp.zeros(like.shape, jnp.int32)
        return cls(count, nothing, nothing, nothing, jnp.full_like(like, -jnp.inf))

    def after(
        self, apex: jax.Array, time_s: jax.Array, climb_m: jax.Array, work_j: jax.Array
    ) -> Apexes:
        """The same after a tick.

        Args:
            apex: where the tick has the apex of a hop, [lanes].
            time_s: time at the tick's end [s], [lanes].
            climb_m: height climbed in flight since the release [m], [lanes].
            work_j: work since the release [J], [lanes].
        """
        now = jnp.stack([climb_m, work_j])
        return Apexes(
            jnp.where(apex, self.n_apexes + 1, self.n_apexes),
            jnp.where(apex & (self.n_apexes == 0), now, self.first),
            jnp.where(apex & (self.n_apexes == 1), now, self.second),
            jnp.where(apex, now, self.last),
            jnp.where(apex, time_s, self.last_s),
        )

    def cot_inverse(self, now_s: jax.Array) -> jax.Array:
        """CoT⁻¹ over whole hops [m/J], [lanes]: 0 without any, or where hopping has died out."""
        whole = self.n_apexes - 1
        begin = jnp.where(left_out(whole) > 0, self.second, self.first)
        climb_m, work_j = self.last - begin
        goes_on = (whole > 0) & ~dies_out(self.last_s, now_s)
        return jnp.where(goes_on, cot_inverse(climb_m, work_j), 0.0)
