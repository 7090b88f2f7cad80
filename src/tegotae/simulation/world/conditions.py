"""What episodes of training meet: numbers of body and scenario that are drawn anew."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts.fields import FieldNumber


@dataclass(frozen=True)
class Condition(ABC):
    """A number that episodes of training do not have in common, and how it is drawn.

    A frozen dataclass. One of your own says its value at each share of its draws (the quantile
    function) and between which values that lies.

    Args:
        name: a field of the body ("mass_kg", "terrain.rise_m"), an entry of the scenario
            ("omega", "height_m", "velocity_m_per_s", "phase_rad", "drop_m", "drop_time_s"), or a
            initial pose of the release ("pitch_rad").
        from_s: from when on it holds [s]; of "drop_m" when the ground drops.
        until_s: until when [s]; None to the end.

    Raises:
        TegotaeError: for times that are none, or not in this order.
    """

    name: str
    from_s: float = 0.0
    until_s: float | None = None

    def __post_init__(self) -> None:
        require_finite(f"from_s of {self.name}", self.from_s, least=0.0)
        if self.until_s is not None:
            require_finite(f"until_s of {self.name}", self.until_s, above=self.from_s)

    @abstractmethod
    def at(self, share: np.ndarray) -> np.ndarray:
        """The value below which this share of its draws lies, 0 <= share < 1, entry by entry.

        Values that are themselves one a limb make an array [limbs, draws] of shares [draws].
        """

    @property
    @abstractmethod
    def extremes(self) -> tuple[FieldNumber, ...]:
        """Values between which all draws lie: numbers, or tuples of one a limb."""

    @property
    def lasts(self) -> bool:
        """Whether it holds for the whole episode."""
        return self.from_s == 0.0 and self.until_s is None


@dataclass(frozen=True, kw_only=True)
class Uniform(Condition):
    """Any value between two, all alike: `low + (high - low) u`, u uniform in [0, 1).

    What belongs to the limbs is drawn limb by limb.

    Args:
        low: the least value, in the unit of the quantity.
        high: the largest.

    Raises:
        TegotaeError: for limits that are not finite, or not in this order.

    Example:
        >>> Uniform("mass_kg", low=0.08, high=0.12).at(np.array([0.0, 0.5]))
        array([0.08, 0.1 ])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(f"the lowest {self.name}", self.low)
        require_finite(f"the highest {self.name}", self.high, least=self.low)

    def at(self, share: np.ndarray) -> np.ndarray:
        """The value at each share."""
        return self.low + (self.high - self.low) * share

    @property
    def extremes(self) -> tuple[float, ...]:
        """Both limits; one if they are the same."""
        return (self.low,) if self.low == self.high else (self.low, self.high)


@dataclass(frozen=True, kw_only=True)
class OneOf(Condition):
    """One of some values, all equally often.

    Args:
        values: numbers, or tuples of one a limb, such as which legs are present.

    Raises:
        TegotaeError: for no value, values of several lengths, or one that is not finite.

    Example:
        >>> lost = OneOf("present", values=((1.0, 1.0), (0.0, 1.0)))
        >>> lost.at(np.array([0.2, 0.7, 0.8]))
        array([[1., 0., 0.],
               [1., 1., 1.]])
    """

    values: tuple[float, ...] | tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.values:
            raise TegotaeError(f"{self.name} has no values to be one of; give at least one")
        if len({np.shape(value) for value in self.values}) > 1:
            raise TegotaeError(
                f"{self.name} is one of {self.values}; they must all be numbers, or all tuples of "
                "one number a limb"
            )
        for value in np.ravel(np.asarray(self.values, object)):
            require_finite(self.name, value)

    def at(self, share: np.ndarray) -> np.ndarray:
        """The value at each share, limb by limb if it has limbs."""
        which = (np.asarray(share) * len(self.values)).astype(int)
        chosen = np.asarray(self.values, float)[which]
        return np.moveaxis(chosen, -1, 0) if self._by_limb else chosen

    @property
    def _by_limb(self) -> bool:
        return isinstance(self.values[0], tuple)

    @property
    def extremes(self) -> tuple[FieldNumber, ...]:
        """The least and the largest number, or all values of several limbs."""
        return self.values if self._by_limb else tuple(sorted({min(self.values), max(self.values)}))
