"""Where the study's controllers never were: another body, another ground, pushes, a lost leg."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kept import write_rows
from learned_legs_evaluate import runs_of
from learned_legs_plan import ADDED, TABLES, Cell
from tegotae.parts.bodies import Walker
from tegotae.studies.generalisation.catalogue import disturbances_named
from tegotae.studies.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.studies.generalisation.disturbance import Disturbance
from tegotae.studies.generalisation.kinds import Scaled
from tegotae.studies.generalisation.run import generalise
from tegotae.studies.generalisation.table import curve, margins

TRIED = tuple(f"{family}@quadruped-c" for family in ("V", "VG", "AR", "ARG", ADDED))
"""Designs that go through it, however they were trained."""
STARTS = 4
"""Random releases of every controller under every level; a leg is lost in turn."""


@dataclass(frozen=True, kw_only=True)
class Put(Disturbance):
    """A number of the body that is the level, from the release on."""

    field: str

    def lacks(self, tested: ControllersUnderTest) -> str:
        """See `Disturbance.lacks`."""
        first = self.field.partition(".")[0]
        return "" if tested.has_field(first) else f"its body has no {first}"

    def changes(
        self, tested: ControllersUnderTest, level: np.ndarray, at_s: np.ndarray
    ) -> dict[str, Any]:
        """See `Disturbance.changes`."""
        return {self.field: np.asarray(level, float)}


INERTIA = ("inertia_x_kg_m2", "inertia_y_kg_m2", "inertia_z_kg_m2")
DISTURBANCES: tuple[Disturbance, ...] = (
    *disturbances_named(
        [
            "omega=0.5/0.65/0.8/0.9/1.1/1.25/1.5/1.75/2",
            "mass=0.5/0.65/0.8/1.25/1.5/1.8",
            "friction=0.75/0.5/0.25/0.1",
            "push-aside=0.3/0.6/1/1.5",
            "lost-leg=1",
            "delay=0.008/0.016/0.032/0.064",
            "noise=0.05/0.1/0.2/0.4/0.8",
            "slope=-0.2/-0.15/-0.1/-0.05/0.05/0.1/0.15/0.2",
            "rough=0.01/0.02/0.03/0.04/0.06/0.08",
        ]
    ),
    Put(
        name="mass-ahead",
        label="mass moved ahead",
        unit="l0",
        field="com_x_m",
        levels=(-0.4, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.4),
    ),
    Scaled(name="inertia", label="inertia", fields=INERTIA, levels=(0.5, 0.75, 1.5, 2.0, 3.0)),
)
"""What undisturbed training never saw."""
LOSS = tuple(each for each in DISTURBANCES if each.name == "lost-leg")
"""What is left of it for those that were trained with a leg lost."""


def disturb_all(cells: list[Cell], folder: Path) -> None:
    """Try the families, and what was taught to lose legs; write `margins.csv` and `shares.csv`."""
    walkers = [cell for cell in cells if cell.of in TRIED and not cell.note]
    assert all(isinstance(cell.design.system.body, Walker) for cell in walkers)
    taught = {cell.name for cell in walkers if cell.loses_legs}
    controllers = [ControllersUnderTest.of(runs_of(cell, folder)[0], STARTS) for cell in walkers]
    tables: dict[str, list[dict[str, Any]]] = {"margins": [], "shares": []}
    for name, meets, lost in (("usual", DISTURBANCES, False), ("lost", LOSS, True)):
        there = [each for each in controllers if (each.name in taught) == lost]
        if not there:
            continue
        for tested, outcome in generalise(there, meets, folder / f"disturbed-{name}"):
            who = {"controller": tested.name}
            tables["shares"] += [{**who, **row} for row in curve(outcome)]
            for measure in ("keeps", "moves"):
                tables["margins"] += [
                    {**who, "measure": measure, **found._asdict()}
                    for found in margins(outcome, meets, measure)
                ]
    for name, rows in tables.items():
        write_rows(TABLES / f"{name}.csv", rows, digits=4, by=("controller",))
