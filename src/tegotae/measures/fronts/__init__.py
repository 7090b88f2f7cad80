"""Fronts of speed and cost, as tables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import require_known
from tegotae._support.tables import parse_csv, parse_numbers

COLUMNS = (
    *(
        "family",
        "speed",
        "cost_of_transport",
        "omega",
        "sigma",
        "offset",
        "stride",
        "lift",
        "press",
    ),
    *("shift", "upright", "steady", "locked", "speed_spread", "gait", "gait_share", "duty_factor"),
)
"""Columns of a table; empty cells of settings that a family does not have.

- `family`: what drives the legs
- `speed`: mean speed of all starts [√(g l0)]
- `cost_of_transport`: mean power / (weight · mean speed)
- `omega`: frequency ω [√(g / l0)]
- `sigma`: gain σ, or c of the cosine law [√(g / l0) / (m g)]
- `offset`: o of the cosine law
- `stride`: stride B [l0]
- `lift`: lift A [l0]
- `press`: press A′ [l0]
- `shift`: shift δ [rad]
- `upright`: share of the unseen starts that do not fall
- `steady`: share of them whose speed is steady
- `locked`: share of them whose legs lock into one gait
- `speed_spread`: standard deviation of the speed over the starts [√(g l0)]
- `gait`: the gait of most starts
- `gait_share`: the share of the starts that have it
- `duty_factor`: mean share of the stride in stance
"""

NEAR = 0.06
"""Largest distance of a point of a front from a speed that it covers [√(g l0)]."""
_TEXT = ("family", "gait")


@dataclass(frozen=True)
class SpeedFront:
    """The least cost of transport over speed of one family on one system.

    Args:
        system: the legged system.
        family: what drives the legs, such as "vanilla", "cosine" or "forced trot".
        columns: those of `COLUMNS`, by rising speed, [points].
    """

    system: str
    family: str
    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def cost_at(self, speed: ArrayLike) -> np.ndarray:
        """Return the cost of transport at speeds [√(g l0)], linear between points; NaN beyond them.

        Args:
            speed: any shape.
        """
        speeds, cost = self.columns["speed"], self.columns["cost_of_transport"]
        return np.interp(np.asarray(speed, float), speeds, cost, left=np.nan, right=np.nan)

    def reaches(self, speed: float) -> bool:
        """Return whether a point lies within `NEAR` of a speed: elsewhere a cost is a guess."""
        return bool((np.abs(self.columns["speed"] - speed) <= NEAR).any())

    def nearest(self, speed: float) -> dict[str, float]:
        """Return the numbers of the point nearest to a speed, without its text columns."""
        k = int(np.abs(self.columns["speed"] - speed).argmin())
        return {n: float(column[k]) for n, column in self.columns.items() if n not in _TEXT}


def front(system: str, family: str = "vanilla") -> SpeedFront:
    """Load a kept front.

    Made by `tegotae gait front`.

    Args:
        system: its name, such as "quadruped-c".
        family: such as "vanilla", "cosine" or "forced trot".

    Raises:
        TegotaeError: for a system or family without one.

    Example:
        >>> found = front("quadruped-c")
        >>> bool(found.cost_at(0.4) < 1.0)
        True
    """
    table = front_table(system)
    families = list(dict.fromkeys(table["family"].tolist()))
    require_known(f"front of {system}", family, families)
    rows = table["family"] == family
    columns = {name: values[rows] for name, values in table.items()}
    order = np.argsort(columns["speed"])
    return SpeedFront(system, family, {name: values[order] for name, values in columns.items()})


@cache
def front_table(system: str) -> dict[str, np.ndarray]:
    """Return all kept fronts of a system, one array [points] per column of `COLUMNS`.

    Raises:
        TegotaeError: for a system without fronts.
    """
    folder = files("tegotae.measures.fronts")
    names = sorted(f.name.removesuffix(".csv") for f in folder.iterdir() if f.name.endswith(".csv"))
    require_known("system with a front", system, names)
    table = parse_csv((folder / f"{system}.csv").read_text(encoding="utf-8"))
    return {
        name: np.asarray(values, str) if name in _TEXT else parse_numbers(values)
        for name, values in table.items()
    }
