"""`tegotae gait judge`: how well controllers walk, at frequencies of your choice."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from tegotae._support.files import output_file
from tegotae.cli.options import UNSET
from tegotae.cli.tables import print_rows

if TYPE_CHECKING:
    from tegotae.studies.gaits.judge import Judged
    from tegotae.systems.legged import Legged


@dataclass(frozen=True, kw_only=True)
class Judge:
    """Judge controllers of bodies with legs: falls, speed, cost of transport, time to lock, gait.

    Every controller is released from the same random phases. Numbers are means over the runs of a
    set with their 95 % intervals; a single run has none.
    """

    place: Annotated[str, tyro.conf.Positional]
    """A controller file of `tegotae train`, a folder of them, or a system's name, such as
    quadruped-c."""
    omega: Annotated[tuple[float, ...], UNSET] = ()
    """Frequencies ω [rad/s]; the one trained at by default."""
    starts: int = 32
    """How many releases of each controller."""
    seed: int = 1
    """Of the random phases at release."""
    csv: Annotated[Path | None, UNSET] = None
    """Also write a row per controller and frequency to this file."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae._support.tables import write_csv
        from tegotae.studies.gaits.judge import judge

        if self.csv is not None:
            output_file(self.csv)
        sets = subjects(self.place)
        found = [
            (name, labels, judge(legged, weights, self.omega, self.starts, seed=self.seed))
            for name, labels, legged, weights in sets
        ]
        if self.csv is not None:
            write_csv(self.csv, columns(found), digits=6)
        titles = ("controller", "ω", "runs", "upright", "locked", "locks in", "speed", "CoT")
        print_rows((*titles, "slip", "gait"), (row for each in found for row in _rows(*each)))
        units = {each.legged.units for _, _, each in found}
        print("Lengths and times are in " + " or ".join(" and ".join(pair) for pair in units) + ".")


def subjects(place: str) -> list[tuple[str, tuple[str, ...], Legged, np.ndarray]]:
    """Sets of controllers: name, labels of its runs, system, weights [runs, n_weights].

    Raises:
        TegotaeError: if there is none, or its body has one leg.
    """
    from tegotae.systems.legged import require_legs
    from tegotae.systems.legged_systems import settling
    from tegotae.systems.resolve import resolve
    from tegotae.training.collection import sets_of

    found = resolve(place)
    if found.legged is not None:
        return [(place, ("",), found.legged, np.array([found.legged.weights]))]
    require_legs(found.body)
    return [
        (
            each.name,
            each.labels,
            settling(each.system, each.weights[0]),
            each.weights,
        )
        for each in sets_of(found)
    ]


def columns(found: list[tuple[str, tuple[str, ...], Judged]]) -> dict[str, list[Any]]:
    """A row per controller and frequency."""
    rows: dict[str, list[Any]] = {"controller": [], "run": [], "omega": []}
    for name, labels, judged in found:
        measures = judged.measures
        for run, label in enumerate(labels):
            for at, omega in enumerate(judged.omega):
                gait, share = judged.commonest(run, at)
                own = {"controller": name, "run": label, "omega": float(omega)}
                own |= {title: float(x[run, at]) for title, x in measures.items()}
                for title, value in (own | {"gait": gait, "gait_share": share}).items():
                    rows.setdefault(title, []).append(value)
    return rows


def _rows(name: str, labels: tuple[str, ...], judged: Judged) -> list[tuple[str, ...]]:
    from tegotae.measures.hopping.statistics import interval

    measures = judged.measures
    shown = ("upright", "locked", "lock_time_s", "speed_m_per_s", "cost_of_transport", "slip")
    rows = []
    for at, omega in enumerate(judged.omega):
        gaits = Counter(judged.commonest(run, at)[0] for run in range(len(labels)))
        told = ", ".join(f"{gait} ({count})" for gait, count in gaits.most_common())
        numbers = []
        for title in shown:
            own = interval(measures[title][:, at])
            sure = "" if np.isnan(own.low) else f" ({own.low:.3g} … {own.high:.3g})"
            numbers.append("–" if np.isnan(own.mean) else f"{own.mean:.3g}{sure}")
        at_omega = "–" if np.isnan(omega) else f"{omega:g}"
        rows.append((name, at_omega, str(len(labels)), *numbers, told))
    return rows
