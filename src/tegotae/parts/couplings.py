"""Couplings between the oscillators of several limbs: none, of neighbours, learned."""

from __future__ import annotations

import math
import reprlib
from abc import ABC, abstractmethod
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, whole_numbers
from tegotae.parts._shapes import Weights
from tegotae.parts.parameters import Part, finite
from tegotae.parts.terms.base import Signals
from tegotae.parts.weight_names import WeightName, inside, numbered


class Coupling(Part, ABC):
    """Coupling from the oscillators of the other limbs to each oscillator: a frozen dataclass.

    No coupling at all is Tegotae control's own way: what couples the limbs is the body. Everything
    else in a controller is elementwise; a coupling alone may look across the limb axis, and even it
    never across lanes.

    Source: of this library; the paper has one limb, and (V) names networks of oscillators as future
    work.
    """

    READS: tuple[str, ...] = ("sin_phase", "cos_phase")
    """Names of the signals that it reads, as for terms."""

    def check(self, limbs: int) -> None:
        """Raise `TegotaeError` if it does not fit this number of limbs."""

    def n_weights(self, limbs: int) -> int:
        """Return the number of trained parameters for a number of limbs."""
        return 0

    def weight_names(self, limbs: int) -> tuple[WeightName, ...]:
        """Return the names of the weights, in a controller file and in C; numbers by default."""
        return numbered(self.n_weights(limbs))

    def initial(self, key: jax.Array, limbs: int) -> jax.Array:
        """Return weights to start training from, shape [n_weights]; by default none couples."""
        return jnp.zeros((self.n_weights(limbs),))

    @abstractmethod
    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the input of each limb's oscillator [rad/s], shape [limbs, ...].

        Args:
            weights: n_weights arrays, each of the shape of the lanes.
            signals: those of all limbs, arrays of shape [limbs, ...].
        """


@dataclass(frozen=True)
class LearnedCoupling(Coupling):
    """A learned matrix of couplings, `Σ_j a_ij sin(φ_j - φ_i) + b_ij cos(φ_j - φ_i)` [rad/s].

    Strength and lag of each pair are `√(a² + b²)` and `atan2(-b, a)`: two weights for every ordered
    pair of different limbs, a then b, limb by limb.

    Source: Kuramoto's coupling (`Neighbours`) with trained strengths and lags.

    Example:
        >>> LearnedCoupling().n_weights(4)
        24
    """

    def n_weights(self, limbs: int) -> int:
        """Return the number of weights: two for each ordered pair."""
        return 2 * limbs * (limbs - 1)

    def weight_names(self, limbs: int) -> tuple[WeightName, ...]:
        """Return the names of the weights: a and b of each ordered pair."""
        return inside(("pair",), [(n, x) for n in range(limbs * (limbs - 1)) for x in ("a", "b")])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the sum over the other limbs."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        limbs = sine.shape[0]
        rows = iter(weights)
        inputs: list[jax.Array] = []
        for to in range(limbs):
            total = jnp.zeros_like(sine[0])
            for source in (limb for limb in range(limbs) if limb != to):
                sin_gap = sine[source] * cosine[to] - cosine[source] * sine[to]
                cos_gap = cosine[source] * cosine[to] + sine[source] * sine[to]
                total = total + next(rows) * sin_gap + next(rows) * cos_gap
            inputs.append(total)
        return jnp.stack(inputs)


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
    strength_rad_per_s: float = finite()
    lag_rad: float = finite(0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            links = tuple((to, source) for to, source in self.links)
        except (TypeError, ValueError):
            raise TegotaeError(
                f"links is {reprlib.repr(self.links)}; it must be pairs of limbs, such as "
                "((0, 1), (1, 0))"
            ) from None
        integers = tuple(whole_numbers("a link", link) for link in links)
        object.__setattr__(self, "links", integers)  # a list could not be hashed

    def check(self, limbs: int) -> None:
        """Raise `TegotaeError` for a link that names a limb that is not there, or itself."""
        for to, source in self.links:
            if to == source or not (0 <= to < limbs and 0 <= source < limbs):
                raise TegotaeError(
                    f"a link is ({to}, {source}); it must name two different limbs of 0 ... "
                    f"{limbs - 1}"
                )

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """`Σ_j κ sin(φ_j - φ_i - ψ)`."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        sin_lag, cos_lag = math.sin(self.lag_rad), math.cos(self.lag_rad)
        inputs = [jnp.zeros_like(sine[0]) for _ in range(sine.shape[0])]
        for to, source in self.links:
            sin_gap = sine[source] * cosine[to] - cosine[source] * sine[to]
            cos_gap = cosine[source] * cosine[to] + sine[source] * sine[to]
            pull = sin_gap * cos_lag - cos_gap * sin_lag
            inputs[to] = inputs[to] + self.strength_rad_per_s * pull
        return jnp.stack(inputs)
