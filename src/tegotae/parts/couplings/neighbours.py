"""Oscillators coupled to some others with a fixed strength and lag."""

from __future__ import annotations

import math
import reprlib
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite, whole_numbers
from tegotae.parts._shapes import Weights
from tegotae.parts.couplings.base import Coupling
from tegotae.parts.terms.base import Signals


@dataclass(frozen=True)
class Neighbours(Coupling):
    """Kuramoto's coupling along given links, `Σ_j κ sin(φ_j - φ_i - ψ)` [rad/s].

    Args:
        links: pairs (i, j): limb i listens to limb j.
        strength_rad_per_s: κ.
        lag_rad: ψ, by which φ_j is to be ahead of φ_i.

    Raises:
        TegotaeError: for numbers that are not finite, or links that do not go with the limbs.

    Reference: Y. Kuramoto, Chemical Oscillations, Waves, and Turbulence, chapter 5.

    Example:
        >>> half = Neighbours(links=((0, 1), (1, 0)), strength_rad_per_s=2.0, lag_rad=math.pi)
        >>> phase = jnp.array([0.0, math.pi / 2])
        >>> signals = Signals({"sin_phase": jnp.sin(phase), "cos_phase": jnp.cos(phase)})
        >>> half((), signals).round(3).tolist()
        [-2.0, 2.0]
    """

    links: tuple[tuple[int, int], ...]
    strength_rad_per_s: float
    lag_rad: float = 0.0

    def __post_init__(self) -> None:
        try:
            links = tuple((to, of) for to, of in self.links)
        except (TypeError, ValueError):
            raise TegotaeError(
                f"links is {reprlib.repr(self.links)}; it must be pairs of limbs, such as "
                "((0, 1), (1, 0))"
            ) from None
        whole = tuple(whole_numbers("a link", link) for link in links)
        object.__setattr__(self, "links", whole)  # a list could not be hashed
        require_finite("strength_rad_per_s", self.strength_rad_per_s)
        require_finite("lag_rad", self.lag_rad)

    def check(self, limbs: int) -> None:
        """Raise `TegotaeError` for a link that names a limb that is not there, or itself."""
        for to, of in self.links:
            if to == of or not (0 <= to < limbs and 0 <= of < limbs):
                raise TegotaeError(
                    f"a link is ({to}, {of}); it must name two different limbs of 0 ... {limbs - 1}"
                )

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """`Σ_j κ sin(φ_j - φ_i - ψ)`."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        sin_lag, cos_lag = math.sin(self.lag_rad), math.cos(self.lag_rad)
        inputs = [jnp.zeros_like(sine[0]) for _ in range(sine.shape[0])]
        for to, of in self.links:
            sin_gap = sine[of] * cosine[to] - cosine[of] * sine[to]
            cos_gap = cosine[of] * cosine[to] + sine[of] * sine[to]
            pull = sin_gap * cos_lag - cos_gap * sin_lag
            inputs[to] = inputs[to] + self.strength_rad_per_s * pull
        return jnp.stack(inputs)
