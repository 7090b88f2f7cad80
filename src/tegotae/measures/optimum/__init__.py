"""The physical optimum of the default hopper, as a table: largest CoT⁻¹ over the hop frequency."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.tables import parse_csv, parse_numbers
from tegotae.parts.bodies import Hopper


@dataclass(frozen=True)
class Curve:
    """The optimum over hop frequency, one array [frequencies] per column.

    Args:
        columns: by name (`curve`); NaN where no gait was found.
    """

    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def interpolate(self, name: str, omega: ArrayLike) -> np.ndarray:
        """Interpolate a column at hop frequencies ω [rad/s], linearly between rows; NaN outside of
        the table.
        """
        row, values = self.columns["omega"], self.columns[name]
        return np.interp(np.asarray(omega, float), row, values, left=np.nan, right=np.nan)

    def bound(self, name: str, omega: ArrayLike) -> np.ndarray:
        """Return an upper bound at hop frequencies ω [rad/s]: that of the next row below.

        It holds for faster hops too (`certify`). NaN for slower hops than the table's.
        """
        row = np.searchsorted(self.columns["omega"], omega, side="right") - 1
        return np.where(row >= 0, self.columns[name][np.maximum(row, 0)], np.nan)


@cache
def curve() -> Curve:
    """Return the kept table of the default hopper, for the default definition of work.

    Made and proved in a clone by `python -m research.reproduction optimum-table`. Its columns:

    - `omega`: hop frequency ω [rad/s]
    - `cot_inverse`: largest CoT⁻¹ found, period 1 [m/J]
    - `upper_bound`: no gait of period 1 has more [m/J]
    - `lift_off`: lift-off velocity of the best gait found [m/s]
    - `stance_s`: time of the best gait that is not its hop's flight [s]
    - `swings`: swings down and up in that time
    - `bounces`: flights in that time, too low to count as hops
    - `converged`: starts that ended at a gait
    - `cot_inverse_two`: largest CoT⁻¹ found, period 2, ω its mean [m/J]
    - `lift_off_low`: the lower of its lift-off velocities [m/s]
    - `lift_off_high`: the higher [m/s]
    - `upper_bound_any`: no gait of any period has more, ω its mean [m/J]

    Example:
        >>> found = curve()
        >>> found["omega"].shape == found["cot_inverse"].shape
        True
    """
    text = files(__name__).joinpath("curve.csv").read_text(encoding="utf-8")
    return Curve({column: parse_numbers(cells) for column, cells in parse_csv(text).items()})


def has_table(body: object, work: str = "absolute") -> bool:
    """Return whether the kept table holds for this body and definition of work.

    Args:
        body: any body; the table is that of `Hopper()`.
        work: definition of work; the table is that of "absolute".
    """
    return work == "absolute" and isinstance(body, Hopper) and body == Hopper()


def share(cot_inverse: ArrayLike, hop_rate: ArrayLike, period: ArrayLike = 1) -> np.ndarray:
    """Return CoT⁻¹ over the largest possible one at the gait's own hop frequency, for the default
    hopper.

    A gait of period 1 is held against the best of period 1. One of a longer period is held against
    the upper bound over all periods at its mean hop frequency: its share is at least this. What was
    found is a near-optimum, and the curve is straight between its rows, so that shares slightly
    above 1 are possible.

    Args:
        cot_inverse: CoT⁻¹ by absolute work and heights climbed in flight [m/J], any shape.
        hop_rate: hop frequency, 2π times hops over time [rad/s], same shape.
        period: hops in the cycle, same shape.

    Returns:
        The share; NaN where something is NaN, or outside of the table's frequencies.

    Example:
        >>> f"{share(0.5 * curve().interpolate('cot_inverse', 4.0), 4.0):.1f}"
        '0.5'
    """
    optimum = curve()
    best = optimum.interpolate("cot_inverse", hop_rate)
    largest = np.where(np.asarray(period) == 1, best, optimum.bound("upper_bound_any", hop_rate))
    largest = np.where(np.isnan(best), np.nan, largest)
    return np.where(np.isnan(period), np.nan, cot_inverse / largest)
