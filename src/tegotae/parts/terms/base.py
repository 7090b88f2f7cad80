"""What a term of the controller is: an elementwise function of weights and signals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, PerCommand, PerLimb, Weights, WeightVector
from tegotae.parts.parameters import Part
from tegotae.parts.weight_names import WeightName, numbered


@dataclass(frozen=True)
class Signals:
    """All that a term may read at one instant; every array has the shape of the lanes.

    `values` holds SI quantities by name: what the body senses (such as `spring_force` [N] and
    `velocity` [m/s]), `sin_phase` and `cos_phase` where there is an oscillator, and, for the
    actuation, the Tegotae `feedback` [rad/s]. `scales` makes them dimensionless.

    Args:
        values: arrays [(limbs,) lanes] by the names of the signals.
        scales: by the same names, in the signal's units; 1 for those that are not there.

    Example:
        >>> Signals({"spring_force": jnp.array([3.0])}, {"spring_force": 1.5}).dimensionless(
        ...     "spring_force"
        ... ).tolist()
        [2.0]
    """

    values: dict[str, PerLimb]
    scales: Mapping[str, Number] = field(default_factory=dict[str, Number])

    def __getitem__(self, name: str) -> PerLimb:
        return self.values[name]

    def dimensionless(self, name: str) -> PerLimb:
        """The quantity over its scale, as a network sees it."""
        value, scale = self.values[name], self.scales.get(name, 1.0)
        # A scale may be one a lane.
        return value / (jnp.broadcast_to(scale, value.shape) if jnp.ndim(scale) else scale)

    def adding(self, scale: Number | None = None, **values: PerLimb) -> Signals:
        """The same signals and some more; `scale` belongs to each of the added ones."""
        scales = self.scales if scale is None else {**self.scales, **dict.fromkeys(values, scale)}
        return Signals({**self.values, **values}, scales)


class Term(Part, ABC):
    """One of A′, R, G or T: a frozen dataclass, called with its weights and the signals.

    A new term is a subclass with `reads`, `n_weights`, `initial` and `__call__`, and with
    `weight_names` if its weights are to have names in files and in C; nothing else needs to know of
    it. `tegotae.check_term` names what is missing.

    Source: paper equation 4, `f = G A′ R`, and Fig. 1 for T.
    """

    READS: tuple[str, ...] = ()
    """What `reads` returns, where it is always the same."""
    WEIGHTS: tuple[str, ...] = ()
    """Names of its weights, where they are always the same."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the signals that the term reads."""
        return self.READS

    @property
    def n_weights(self) -> int:
        """How many trained numbers the term has."""
        return len(self.WEIGHTS)

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """What each of its weights is, in a controller file and in C; numbers by default."""
        return tuple((name,) for name in self.WEIGHTS) or numbered(self.n_weights)

    def initial(self, key: jax.Array) -> WeightVector:
        """Random weights to start training from, shape [n_weights]."""
        return jnp.zeros((self.n_weights,))

    @abstractmethod
    def __call__(self, weights: Weights, signals: Signals) -> PerCommand:
        """The term's value, elementwise.

        Args:
            weights: n_weights arrays, each like the lanes.
            signals: what it `reads`, arrays [(limbs,) lanes].

        Returns:
            The value, [(limbs,) lanes]; of an actuation of several commands [commands, limbs,
            lanes].
        """
