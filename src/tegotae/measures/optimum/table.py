"""The kept optimum of the default hopper: largest CoT⁻¹ over the hop frequency."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import numbers, parse_csv
from tegotae.measures.optimum.problem import check
from tegotae.measures.optimum.trajectory import optimise
from tegotae.parts.bodies import Body, Hopper

COLUMNS = {
    "omega": "hop frequency ω [rad/s]",
    "cot_inverse": "largest CoT⁻¹ found, period 1 [m/J]",
    "upper_bound": "no gait of period 1 has more [m/J]",
    "lift_off": "lift-off velocity of the best gait found [m/s]",
    "stance_s": "time of the best gait that is not its hop's flight [s]",
    "swings": "swings down and up in that time",
    "bounces": "flights in that time, too low to count as hops",
    "converged": "starts that ended at a gait",
    "cot_inverse_two": "largest CoT⁻¹ found, period 2, ω its mean [m/J]",
    "lift_off_low": "the lower of its lift-off velocities [m/s]",
    "lift_off_high": "the higher [m/s]",
    "upper_bound_any": "no gait of any period has more, ω its mean [m/J]",
}
"""Columns of the table."""


@dataclass(frozen=True)
class Curve:
    """The optimum over hop frequency, one array [frequencies] per column.

    Args:
        columns: those of `COLUMNS`; NaN where no gait was found.
    """

    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def at(self, name: str, omega: ArrayLike) -> np.ndarray:
        """A column at hop frequencies ω [rad/s], linear between rows; NaN outside of the table."""
        row, values = self.columns["omega"], self.columns[name]
        return np.interp(np.asarray(omega, float), row, values, left=np.nan, right=np.nan)

    def bound(self, name: str, omega: ArrayLike) -> np.ndarray:
        """An upper bound at hop frequencies ω [rad/s]: that of the next row below.

        It holds for faster hops too (`certify`). NaN for slower hops than the table's.
        """
        row = np.searchsorted(self.columns["omega"], omega, side="right") - 1
        return np.where(row >= 0, self.columns[name][np.maximum(row, 0)], np.nan)


@cache
def curve() -> Curve:
    """The kept table of the default hopper, for the default definition of work.

    Made by `python -m tegotae.measures.optimum`.

    Example:
        >>> found = curve()
        >>> found["omega"].shape == found["cot_inverse"].shape
        True
    """
    return Curve(_kept("curve.csv"))


@cache
def stances() -> dict[float, dict[str, np.ndarray]]:
    """The kept best stances of the default hopper, by hop frequency [rad/s]; period 1.

    Each has `time_s` since touchdown, `height_m` over touchdown, `velocity_m_per_s`, and `force_n`
    from that time to the next.
    """
    columns = _kept("stances.csv")
    omegas = columns.pop("omega")
    return {
        float(omega): {name: column[omegas == omega] for name, column in columns.items()}
        for omega in np.unique(omegas)
    }


def _kept(name: str) -> dict[str, np.ndarray]:
    text = files("tegotae.measures.optimum").joinpath(name).read_text(encoding="utf-8")
    return {column: numbers(cells) for column, cells in parse_csv(text).items()}


def has_table(body: object, work: str = "absolute") -> bool:
    """Whether the kept table holds for this body and definition of work.

    Args:
        body: any body; the table is that of `Hopper()`.
        work: definition of work; the table is that of "absolute".
    """
    return work == "absolute" and isinstance(body, Hopper) and body == Hopper()


def best(body: Body, omega: float, *, period: int = 1, work: str = "absolute") -> float:
    """Largest CoT⁻¹ found for a body at a hop frequency [m/J].

    From the kept table where it holds, by trajectory optimisation elsewhere.

    Args:
        body: the hopper.
        omega: hop frequency ω [rad/s]; the mean over hops for period 2.
        period: hops in a cycle, 1 or 2.
        work: definition of work, one of "absolute", "positive", "net".

    Raises:
        TegotaeError: for what `problem.check` refuses, another period, or a frequency at which no
            hop exists.
        MissingExtraError: if the table does not hold and CasADi is not installed.

    Example:
        >>> from tegotae import Hopper
        >>> f"{best(Hopper(), 4.0):.1f} m/J"
        '1.2 m/J'
    """
    check(body, omega, work)
    if period not in (1, 2):
        raise TegotaeError(f"period is {period}; the optimum is known for 1 and 2")
    if has_table(body, work):
        kept = curve()
        if omega > kept["omega"][-1]:
            raise TegotaeError(
                f"omega is {omega:g}; this hopper hops at {kept['omega'][-1]:.1f} rad/s at most"
            )
        value = float(kept.at("cot_inverse" if period == 1 else "cot_inverse_two", omega))
        if np.isfinite(value):
            return value
    return optimise(body, omega, period=period, work=work).cot_inverse


def share(cot_inverse: ArrayLike, hop_rate: ArrayLike, period: ArrayLike = 1) -> np.ndarray:
    """CoT⁻¹ over the largest possible at the gait's own hop frequency, for the default hopper.

    A gait of period 1 is held against the best of period 1. One of a longer period is held against
    the upper bound over all periods at its mean hop frequency: its share is at least this. What was
    found is a near-optimum, so that shares of up to 1.001 are possible.

    Args:
        cot_inverse: CoT⁻¹ by absolute work and heights climbed in flight [m/J], any shape.
        hop_rate: hop frequency, 2π times hops over time [rad/s], same shape.
        period: hops in the cycle, same shape.

    Returns:
        The share; NaN where something is NaN, or outside of the table's frequencies.

    Example:
        >>> f"{share(0.5 * curve().at('cot_inverse', 4.0), 4.0):.1f}"
        '0.5'
    """
    kept = curve()
    one = kept.at("cot_inverse", hop_rate)
    largest = np.where(np.asarray(period) == 1, one, kept.bound("upper_bound_any", hop_rate))
    largest = np.where(np.isnan(one), np.nan, largest)
    return np.where(np.isnan(period), np.nan, cot_inverse / largest)
