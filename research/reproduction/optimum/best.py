"""The best gaits of a hopper: from the kept tables where these hold, by optimisation elsewhere."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from research.reproduction.optimum.problem import check
from research.reproduction.optimum.trajectory import optimise
from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_csv, parse_numbers
from tegotae.measures.optimum import curve, has_table
from tegotae.parts.bodies import Body

STANCES = Path(__file__).with_name("stances.csv")
"""The best stances of the default hopper."""


@cache
def optimal_stances() -> dict[float, dict[str, np.ndarray]]:
    """Return the kept best stances of the default hopper, by hop frequency [rad/s]; period 1.

    Each has `time_s` since touchdown, `height_m` over touchdown, `velocity_m_per_s`, and `force_n`
    from that time to the next.
    """
    text = STANCES.read_text(encoding="utf-8")
    columns = {column: parse_numbers(cells) for column, cells in parse_csv(text).items()}
    omegas = columns.pop("omega")
    return {
        float(omega): {name: column[omegas == omega] for name, column in columns.items()}
        for omega in np.unique(omegas)
    }


def largest_cot_inverse(
    body: Body, omega: float, *, period: int = 1, work: str = "absolute"
) -> float:
    """Return the largest CoT⁻¹ found for a body at a hop frequency [m/J].

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
        >>> f"{largest_cot_inverse(Hopper(), 4.0):.1f} m/J"
        '1.2 m/J'
    """
    check(body, omega, work)
    if period not in (1, 2):
        raise TegotaeError(f"period is {period}; the optimum is known for 1 and 2")
    if has_table(body, work):
        optimum = curve()
        if omega > optimum["omega"][-1]:
            raise TegotaeError(
                f"omega is {omega:g}; this hopper hops at {optimum['omega'][-1]:.1f} rad/s at most"
            )
        value = float(
            optimum.interpolate("cot_inverse" if period == 1 else "cot_inverse_two", omega)
        )
        if np.isfinite(value):
            return value
    return optimise(body, omega, period=period, work=work).cot_inverse
