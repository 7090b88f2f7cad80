"""Measure the robustness of learned Tegotae: all models of a study under all disturbances.

    python -m research.generalisation.run measure STUDY --out FOLDER
    python -m research.generalisation.run show    # what follows from the kept tables

tries all runs of a study's models, goes on where it was stopped, and writes the tables and figures
of docs/studies/generalisation.md.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import Place, main, markdown_table, write_rows, write_text
from research.reproduction.plan import plan
from tegotae.analysis.generalisation.disturbances import CATALOGUE, Disturbance, Tested, Wind
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import (
    MEASURES,
    Done,
    Retention,
    generalise,
    levels_survived,
    margin,
    margins,
    retention_curve,
)
from tegotae.figures.generalisation import groups_figure
from tegotae.figures.style import save_figure
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.systems.recipe import study_recipes
from tegotae.training.collection import read_runs

KEPT = Path(__file__).parents[2] / "research" / "generalisation"
GROUPS = ("V", "VG", "AR", "ART", "ARG", "ARGT", "T")
"""Architectures with a line of their own; those that learn A or R alone are in the table."""

LOOKED_AT = ("VG-gF-sector-w8", "AR-rF-reflex-w8", "ART-rF-tphif-w8", "T-Fv")
"""Models of which is shown how far they press the leg."""
STUDIED = tuple(x for x in CATALOGUE.values() if not isinstance(x, Wind))
"""Disturbances of the kept tables, which are older than wind."""
DEPLOYED = "AR-rF-reflex-w8"
"""The model of docs/deploy/index.md."""


def measure(study: Place, out: Path, only: int | None = None) -> None:
    """Disturb the runs of a study, and write the tables and figures of the page.

    Args:
        study: folder of the study.
        out: folder of the results.
        only: largest number of models.
    """
    controllers = [ControllersUnderTest.from_runs(runs) for runs in read_runs(study)]
    tables(generalise(ordered(controllers)[:only], STUDIED, out))


def ordered(controllers: Sequence[ControllersUnderTest]) -> list[ControllersUnderTest]:
    """Return the plain models first, so that a stopped run has some of every architecture."""
    plain = {experiment.name: i for i, experiment in enumerate(plan("quick").experiments)}
    return sorted(controllers, key=lambda item: plain.get(item.name, len(plain)))


def architecture(tested: Tested) -> str:
    """Return the architecture of a set's model."""
    return study_recipes()[tested.name].terms.architecture


def grouped(results: Sequence[Done]) -> dict[str, list[Done]]:
    """Return controllers by architecture, in the paper's order."""
    groups: dict[str, list[Done]] = {}
    for result in results:
        groups.setdefault(architecture(result[0]), []).append(result)
    return {name: groups[name] for name in sorted(groups, key=_place)}


def _place(name: str) -> tuple[int, str]:
    return (GROUPS.index(name) if name in GROUPS else len(GROUPS), name)


def tables(results: Sequence[Done]) -> None:
    """Write margins of models, margins of architectures, and the curves."""
    disturbances = STUDIED
    rows = [
        {"model": tested.name, **m._asdict()}
        for tested, outcome in results
        for m in margins(outcome, disturbances)
        if m.runs
    ]
    write_rows(KEPT / "margins.csv", rows, digits=3)
    groups = grouped(results)
    rows = [row for name in groups for row in of_group(name, groups[name], disturbances)]
    write_rows(KEPT / "architectures.csv", rows, digits=3)
    labelled = {f"{name} ({len(groups[name])})": groups[name] for name in GROUPS if name in groups}
    save_figure(groups_figure(labelled, disturbances), KEPT / "curves.png")
    moving = tuple(
        dataclasses.replace(disturbance, measure="moves") for disturbance in disturbances
    )
    rows = [row for name in groups for row in of_group(name, groups[name], moving)]
    write_rows(KEPT / "moving.csv", rows, digits=3)
    save_figure(groups_figure(labelled, moving), KEPT / "moving.png")
    by_name = {tested.name: tested for tested, _ in results}
    write_rows(
        KEPT / "edge.csv",
        list(edge([by_name[name] for name in LOOKED_AT if name in by_name])),
        digits=3,
    )
    deployed = {tested.name: outcome for tested, outcome in results}.get(DEPLOYED)
    if deployed is not None:
        write_text(KEPT / "deploy.md", deploy_text(deployed))
    show()


def show() -> None:
    """Write the tables of the page from the kept tables."""
    keeps, moves = (pd.read_csv(KEPT / f"{name}.csv") for name in ("architectures", "moving"))
    write_text(KEPT / "margins.md", pivoted(keeps, _bracket))
    write_text(KEPT / "moving.md", pivoted(moves, _bracket))
    write_text(KEPT / "kept.md", pivoted(keeps, _efficiency))


def of_group(name: str, members: Sequence[Done], disturbances: Sequence[Disturbance]):
    """Summarise an architecture: the margin over its runs, and the shares that it preserves."""
    for disturbance in disturbances:
        for below in (True, False):
            if not (levels := disturbance.side(below)):
                continue
            mine = [(s, o) for s, o in members if disturbance.name not in o.left_out]
            if not mine:
                continue
            survived = np.concatenate([levels_survived(o, disturbance, below) for _, o in mine])
            limits = margin(disturbance, below, survived)._asdict()
            row = {"architecture": name, "models": len(mine), **limits}
            yield row | _shares(mine, disturbance.name, levels[0])


def edge(controllers: Sequence[Tested]) -> Iterator[dict]:
    """Measure leg compression and hopping height undisturbed: medians over runs [l0]."""
    for tested in controllers:
        timing = Timing(duration_s=20.0, tick_s=0.002, frame_s=0.002)
        system = tested.controllers.system
        rollout = system.rollout(_extremes, timing)
        lowest, highest, failed = rollout.run(tested.weights, system.scenario(), tested.body)
        yield {
            "model": tested.name,
            "runs": len(lowest),
            "failed": int(failed.sum()),
            "shortest_leg_l0": float(np.median(lowest)),
            "highest_l0": float(np.median(highest)),
        }


def _extremes(trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing):
    """Return least and largest height in the second half, over the leg's length, and failures."""
    settled = trajectory.height_m[timing.n_frames // 2 :] / body.rest_length_m
    return settled.min(axis=0), settled.max(axis=0), trajectory.failed[-1]


def _shares(members: Sequence[Done], condition: str, level: float) -> dict[str, float]:
    """Return the preserved shares at the first level, and the share that still hops at the last."""
    shares: dict[str, list[np.ndarray]] = {"keeps": [], "moves": [], "efficiency": []}
    for _, outcome in members:
        table = outcome.table
        rows = table[(table["condition"] == condition) & np.isclose(table["level"], level)]
        shares["keeps"].append(rows["keeps"][rows["had"]])
        shares["moves"].append(rows["moves"][rows["moved"]])
        shares["efficiency"].append(rows["efficiency"][np.isfinite(rows["efficiency"])])
    pooled = {name: np.concatenate(parts).astype(float) for name, parts in shares.items()}
    result = {"first_level": level}
    for name in MEASURES:
        result[name] = float(pooled[name].mean()) if len(pooled[name]) else np.nan
    efficiency = pooled["efficiency"]
    result["efficiency"] = float(np.median(efficiency)) if len(efficiency) else np.nan
    return result


def deploy_text(outcome: Retention) -> str:
    """Tabulate the disturbances of one model for docs/deploy/index.md, in Markdown."""
    head = ("condition", "level", "still hop", "keep their limit cycle", "efficiency kept")
    lines = []
    for row in retention_curve(outcome).to_dict("records"):
        if row["condition"] in ("delay", "noise", "lag", "strength"):
            unit = f" {CATALOGUE[row['condition']].unit}".rstrip()
            # Under noise no hop is like the last.
            keeps = "–" if row["condition"] == "noise" else f"{row['keeps']:.2f}"
            cells = (row["condition"], f"{row['level']:g}{unit}", f"{row['moves']:.2f}", keeps)
            lines.append([*cells, f"{row['efficiency']:.2f}"])
    return markdown_table([head, *lines])


def pivoted(table: pd.DataFrame, text_of: Callable[[pd.Series], str]) -> str:
    """Return a table in Markdown: one row per condition and side, one column per architecture."""
    names = [name for name in GROUPS if name in set(table.architecture)]
    cells = table.assign(text=table.apply(text_of, axis=1))
    cells = cells.pivot(index=["condition", "side"], columns="architecture", values="text")
    lines = [["condition", *names]]
    for disturbance in STUDIED:
        for side, below in (("below", True), ("above", False)):
            if (disturbance.name, side) in cells.index:
                texts = cells.loc[(disturbance.name, side), names].fillna("–")
                ends = f"{disturbance.neutral:g} → {disturbance.side(below)[-1]:g}"
                lines.append([f"{disturbance.name} {ends}", *texts])
    return markdown_table(lines)


def _bracket(row: pd.Series) -> str:
    if np.isnan(row.survived):
        return "–"
    return f"{row.survived:g} … {row.failed:g}" if np.isfinite(row.failed) else "all"


def _efficiency(row: pd.Series) -> str:
    return "–" if np.isnan(row.efficiency) else f"{row.efficiency:.3g}"


if __name__ == "__main__":
    main(measure, show)
