"""`python -m research.reproduction optimum`: controllers beside the best possible gait."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np

from research.reproduction.commands.output import Output
from tegotae._support.errors import TegotaeError, require_finite
from tegotae.api.parameters import POSITIONAL
from tegotae.measures.hopping.gait import Gait, GaitSummary

if TYPE_CHECKING:
    from research.reproduction.table import StudyTable
    from tegotae.analysis.orbit import Orbit
    from tegotae.systems.controller_file import SavedController


Gaits = tuple[np.ndarray, np.ndarray]
"""Hop frequencies [rad/s] and CoT⁻¹ [m/J]."""


@dataclass(frozen=True, kw_only=True)
class Optimum(Output):
    """CoT⁻¹ over hop frequency: the optimum, its bound, and controllers."""

    tables: Annotated[tuple[Path, ...], POSITIONAL] = ()
    """Tables of `python -m research.reproduction export` (.csv); best runs and V are drawn."""
    controller: tuple[str, ...] = ()
    """Further controllers to draw, each on its limit cycle: files, or other names with weights such
    as V-sector-w4."""
    omega: float = 4.0
    """Hop frequency of the optimal force in the second panel [rad/s]."""

    def run(self) -> None:
        """Read, simulate, write, and say how near the controllers come."""
        from research.reproduction.export import read_study_csv
        from research.reproduction.figures.optimum import optimum_figure, optimum_tables
        from tegotae.analysis.orbit import find_orbit
        from tegotae.measures.optimum import curve, has_table, share
        from tegotae.parts.bodies import Hopper
        from tegotae.systems.resolve import resolve
        from tegotae.systems.zoo import stem
        from tegotae.training.collection import controller_of

        self.check_out()
        require_finite("omega", self.omega, above=0.0)
        optimum = curve()
        points: dict[str, Gaits] = {}
        longer: dict[str, Gaits] = {}
        for path in self.tables:
            table = read_study_csv(path)
            if "optimum_share" in table.metrics and np.isnan(table["optimum_share"]).all():
                raise TegotaeError(
                    f"{path} has no shares of the optimum; it must be of the paper's hopper, with "
                    "absolute work"
                )
            for series, several in ((points, False), (longer, True)):
                for name, gaits in _table_gaits(table, several=several).items():
                    previous = series.get(name, (np.array([]), np.array([])))
                    rates, values = zip(previous, gaits, strict=True)
                    series[name] = (np.concatenate(rates), np.concatenate(values))
        stances = {f"optimum, {self.omega:g} rad/s": _optimal_stance(self.omega)}
        for name in self.controller:
            saved, path = controller_of(resolve(name)), Path(stem(name))
            if not has_table(saved.system.body):
                raise TegotaeError(f"{name} is for another body than the paper's hopper")
            orbit, gait = find_orbit(saved), _gait(saved)
            name = unique_label(saved, path, {**points, **longer})
            series = points if orbit.hops == 1 else longer
            series[name] = (np.array([gait.hop_rate]), np.array([gait.cot_inverse]))
            stances[f"{name}, {gait.hop_rate:.2g} rad/s"] = first_stance(orbit)
            reached = share(gait.cot_inverse, gait.hop_rate, gait.limit_cycle_period)
            print(
                f"{path}: {gait.cot_inverse:.3f} m/J at {gait.hop_rate:.2f} rad/s, period "
                f"{orbit.hops}: {reached:.0%} of the optimum"
            )
        figure = optimum_figure(
            optimum, points, stances, max_force_n=Hopper().max_force_n, longer=longer
        )
        self.write(figure, optimum_tables(optimum, points, stances, longer))


def unique_label(saved: SavedController, path: Path, taken: Container[str]) -> str:
    """Return the label of a controller: its model, or its file where the model is ambiguous or
    unknown."""
    if saved.name is None:
        return path.stem
    return f"{saved.name} ({path.stem})" if saved.name in taken else saved.name


def _table_gaits(table: StudyTable, *, several: bool) -> dict[str, Gaits]:
    """Return the best run of each model, learned and V: mean hop frequency and CoT⁻¹ of its
    episodes; of those whose cycles have one hop in all episodes, or of the others.
    """
    best = []
    for model in np.unique(table["model"]):
        rows = np.flatnonzero(table["model"] == model)
        value = np.nan_to_num(table["cot_inverse"][rows], nan=-1.0)
        if value.max() >= 0.0:
            best.append(rows[np.argmax(value)])
    rows = np.array(best, int)
    rows = rows[(table["limit_cycle_period"][rows] > 1.0) == several]
    vanilla = table["architecture"][rows] == "V"
    names = {"best run of a learned model": rows[~vanilla], "V": rows[vanilla]}
    return {n: (table["hop_rate"][r], table["cot_inverse"][r]) for n, r in names.items() if len(r)}


def _optimal_stance(omega: float) -> dict[str, np.ndarray]:
    from research.reproduction.optimum import optimal_stances, optimise
    from tegotae.parts.bodies import Hopper

    tabulated = optimal_stances()
    if omega in tabulated:
        return tabulated[omega]
    gait = optimise(Hopper(), omega)
    return {"time_s": gait.time_s[-1], "force_n": gait.force_n[-1]}


def _gait(saved: SavedController) -> Gait:
    """Return the gait on which a controller settles, in single numbers."""
    system = saved.system
    rollout = system.rollout(GaitSummary(), system.timing_over(60.0))
    return rollout.run(saved.weights, system.scenario(), saved.body).lane()


def first_stance(orbit: Orbit) -> dict[str, np.ndarray]:
    """Time since touchdown and force, over the first stance of a limit cycle."""
    stance = np.flatnonzero(orbit.spring_force_n > 0.0)
    last = np.flatnonzero(np.diff(stance, append=np.inf) > 1)[0]
    rows = stance[: last + 1]
    return {
        "time_s": orbit.time_s[rows] - orbit.time_s[rows[0]],
        "force_n": orbit.actuator_force_n[rows],
    }
