"""What learned Tegotae generalises to: all models of a study under all disturbances.

    python studies/generalisation.py STUDY --out FOLDER

tries all runs of a study's models, goes on where it was stopped, and writes the tables and figures
of docs/studies/generalisation.md.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from kept import write_rows, write_text
from tegotae.figures.generalisation import groups_figure
from tegotae.figures.style import save_figure
from tegotae.parts.bodies import Body
from tegotae.simulation.rollout import (
    Scenario,
    Timing,
    Trajectory,
)
from tegotae.studies.generalisation import (
    CATALOGUE,
    ControllersUnderTest,
    Disturbance,
    Retention,
    margins,
)
from tegotae.studies.generalisation.run import Done, generalise
from tegotae.studies.generalisation.table import (
    MEASURES,
    curve,
    median_interval,
    run_margins,
)
from tegotae.studies.paper.plan import plan
from tegotae.systems.models import all_models
from tegotae.training.collection import read

KEPT = Path(__file__).parents[1] / "docs" / "_static" / "generalisation"
GROUPS = ("V", "VG", "AR", "ART", "ARG", "ARGT", "T")
"""Architectures with a line of their own; those that learn A or R alone are in the table."""

LOOKED_AT = ("VG-gF-sector-w8", "AR-rF-reflex-w8", "ART-rF-tphif-w8", "T-Fv")
"""Models of which is shown how far they press the leg."""
DEPLOYED = "AR-rF-reflex-w8"
"""The model of docs/deploy/index.md."""


def main(words: Sequence[str] | None = None) -> None:
    """Try, and write what docs/studies/generalisation.md shows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", type=int, default=None, help="so many models at most")
    given = parser.parse_args(words)
    chosen = tuple(CATALOGUE.values())
    controllers = ordered([ControllersUnderTest.of(runs) for runs in read(given.study)])[
        : given.only
    ]
    done = generalise(controllers, chosen, given.out)
    tables(done)


def ordered(controllers: Sequence[ControllersUnderTest]) -> list[ControllersUnderTest]:
    """The plain models first, so that a stopped run has something of every architecture."""
    plain = {experiment.name: i for i, experiment in enumerate(plan("quick").experiments)}
    return sorted(controllers, key=lambda each: plain.get(each.name, len(plain)))


def architecture(tested: ControllersUnderTest) -> str:
    """The architecture of a set's model."""
    return all_models()[tested.name].architecture


def grouped(done: Sequence[Done]) -> dict[str, list[Done]]:
    """Controllers by architecture, in the paper's order."""
    groups: dict[str, list[Done]] = {}
    for each in done:
        groups.setdefault(architecture(each[0]), []).append(each)
    return {name: groups[name] for name in sorted(groups, key=_place)}


def _place(name: str) -> tuple[int, str]:
    return (GROUPS.index(name) if name in GROUPS else len(GROUPS), name)


def tables(done: Sequence[Done]) -> None:
    """Write margins of models, margins of architectures, and the curves."""
    chosen = tuple(CATALOGUE.values())
    rows = [
        {"model": tested.name, "condition": m.condition, "side": m.side, "runs": m.runs}
        | {"margin": m.median, "low": m.low, "high": m.high}
        for tested, outcome in done
        for m in margins(outcome, chosen)
        if m.runs
    ]
    write_rows(KEPT / "margins.csv", rows, digits=3)
    groups = grouped(done)
    rows = [row for name in groups for row in of_group(name, groups[name], chosen)]
    write_rows(KEPT / "architectures.csv", rows, digits=3)
    write_text(KEPT / "margins.md", pivoted(rows, "margin", "low", "high"))
    write_text(KEPT / "kept.md", pivoted(rows, "efficiency"))
    shown = {f"{name} ({len(groups[name])})": groups[name] for name in GROUPS if name in groups}
    save_figure(groups_figure(shown, chosen), KEPT / "curves.png")
    moving = tuple(dataclasses.replace(each, measure="moves") for each in chosen)
    rows = [row for name in groups for row in of_group(name, groups[name], moving)]
    write_text(KEPT / "moving.md", pivoted(rows, "margin", "low", "high"))
    save_figure(groups_figure(shown, moving), KEPT / "moving.png")
    by_name = {tested.name: tested for tested, _ in done}
    write_rows(
        KEPT / "edge.csv",
        list(edge([by_name[name] for name in LOOKED_AT if name in by_name])),
        digits=3,
    )
    deployed = {tested.name: outcome for tested, outcome in done}.get(DEPLOYED)
    if deployed is not None:
        write_text(KEPT / "deploy.md", deploy_text(deployed))


def of_group(name: str, members: Sequence[Done], chosen: Sequence[Disturbance]):
    """Of one architecture, side by side: the median margin over its runs, and what they keep."""
    for each in chosen:
        for below in (True, False):
            if not (levels := each.side(below)):
                continue
            mine = [(s, o) for s, o in members if each.name not in o.left_out]
            if not mine:
                continue
            all_margins = np.concatenate([run_margins(o, each, below) for _, o in mine])
            median, low, high = median_interval(all_margins)
            row = {
                "architecture": name,
                "condition": each.name,
                "side": "below" if below else "above",
            }
            row |= {"models": len(mine), "runs": int((~np.isnan(all_margins)).sum())}
            row |= {"margin": median, "low": low, "high": high}
            yield row | _kept(mine, each.name, levels[0])


def edge(controllers: Sequence[ControllersUnderTest]) -> Iterator[dict]:
    """How far the leg is pressed and how high it hops undisturbed: medians over runs [l0]."""
    for tested in controllers:
        timing = Timing(duration_s=20.0, tick_s=0.002, frame_s=0.002)
        engine = tested.system.engine(_extremes, timing)
        least, most, failed = engine.run(tested.weights, tested.system.scenario(), tested.body)
        yield {
            "model": tested.name,
            "runs": len(least),
            "failed": int(failed.sum()),
            "shortest_leg_l0": float(np.median(least)),
            "highest_l0": float(np.median(most)),
        }


def _extremes(trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing):
    """Least and largest height in the second half, over the leg's length, and who failed."""
    settled = trajectory.height_m[timing.n_frames // 2 :] / body.rest_length_m
    return settled.min(axis=0), settled.max(axis=0), trajectory.failed[-1]


def _kept(members: Sequence[Done], condition: str, level: float) -> dict[str, float]:
    """What is kept at the first level, and the share that still hops at the last."""
    kept: dict[str, list[np.ndarray]] = {"keeps": [], "moves": [], "efficiency": []}
    for _, outcome in members:
        columns = outcome.columns
        at = (columns["condition"] == condition) & np.isclose(columns["level"], level)
        kept["keeps"].append(columns["keeps"][at & columns["had"]])
        kept["moves"].append(columns["moves"][at & columns["moved"]])
        efficiency = columns["efficiency"][at]
        kept["efficiency"].append(efficiency[np.isfinite(efficiency)])
    whole = {name: np.concatenate(parts).astype(float) for name, parts in kept.items()}
    found = {"first_level": level}
    for name in MEASURES:
        found[name] = float(whole[name].mean()) if len(whole[name]) else np.nan
    efficiency = whole["efficiency"]
    found["efficiency"] = float(np.median(efficiency)) if len(efficiency) else np.nan
    return found


def deploy_text(outcome: Retention) -> str:
    """What docs/deploy/index.md shows of one model, in Markdown."""
    head = ("condition", "level", "still hop", "keep their limit cycle", "efficiency kept")
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for row in curve(outcome):
        if row["condition"] in ("delay", "noise", "lag", "strength"):
            unit = f" {CATALOGUE[row['condition']].unit}".rstrip()
            # Under noise no hop is like the last.
            keeps = "–" if row["condition"] == "noise" else f"{row['keeps']:.2f}"
            cells = (f"{row['level']:g}{unit}", f"{row['moves']:.2f}", keeps)
            lines.append(f"| {row['condition']} | {' | '.join(cells)} | {row['efficiency']:.2f} |")
    return "\n".join(lines) + "\n"


def pivoted(rows: Sequence[dict], value: str, *ends: str) -> str:
    """A table in Markdown: a row a condition and side, a column an architecture."""
    names = [name for name in GROUPS if any(row["architecture"] == name for row in rows)]
    cells = {(row["condition"], row["side"], row["architecture"]): row for row in rows}
    lines = [f"| condition | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|"]
    for each in CATALOGUE.values():
        for side, below in (("below", True), ("above", False)):
            mine = [cells.get((each.name, side, name)) for name in names]
            if not any(mine):
                continue
            levels = each.side(below)
            arrow = f"{each.neutral:g} → {levels[-1]:g}"
            said = (_cell(row, value, *ends) for row in mine)
            lines.append(f"| {each.name} {arrow} | {' | '.join(said)} |")
    return "\n".join(lines) + "\n"


def _cell(row: dict | None, value: str, *ends: str) -> str:
    if row is None or np.isnan(row[value]):
        return "–"
    text = _number(row[value])
    return f"{text} [{', '.join(_number(row[end]) for end in ends)}]" if ends else text


def _number(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "all"


if __name__ == "__main__":
    main()
