"""Walkers that lose a leg in mid-gait: the margin of the mass, and who goes on.

    python -m research.lost_leg.run bodies  # vanilla feedback, leg by leg, with the margins
    python -m research.lost_leg.run report  # table and figure

Tables and the figure are in `research/lost_leg`. Laws that react to the loss are in `react.py`.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from research.frame import main, markdown_table, write_rows, write_text
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.lags import support_margin_m
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Step
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import Legged, random_phases
from tegotae.systems.vanilla import SYSTEMS, walking

FOLDER = Path("runs/lost_leg")
TABLES = Path(__file__).resolve().parents[2] / "research" / "lost_leg"
STARTS = 64
"""Random releases of each case."""
TIMING = Timing(duration_s=100.0, tick_s=0.008, frame_s=0.08)
"""Timing of a release; the leg is lost at half of it."""
FAST = EllipticFoot(stride_m=0.264, lift_m=0.045, press_m=0.0, shift_rad=0.647)
"""Small quick steps, at which a walker can go on with three legs."""
OMEGA, SIGMA = 8.5, 1.9
MOVED = {"com_x_m": 0.326, "com_y_m": -0.206}
"""Position of the mass for the loss of the left hind leg."""


LEAST_WAY = 0.5
"""Largest distance in the last quarter [l0] for which an upright body counts as standing."""


def quick() -> Legged:
    """Return quadruped C with small quick steps."""
    return walking("quadruped C, quick", Walker(), FAST, SIGMA, OMEGA)


def quick_hexapod() -> Legged:
    """Return the hexapod with the same steps."""
    return walking("hexapod, quick", SYSTEMS["hexapod"]().body, FAST, SIGMA, OMEGA)


BODIES: dict[str, tuple[Any, dict[str, float]]] = {
    "C, ω 2": (SYSTEMS["quadruped-c"], {}),
    "C, quick": (quick, {}),
    "C, quick, mass moved": (quick, MOVED),
    "C, quick, mass ahead": (quick, {"com_x_m": 0.326}),
    "C, quick, mass behind": (quick, {"com_x_m": -0.326}),
    "hexapod, ω 2": (SYSTEMS["hexapod"], {}),
    "hexapod, quick": (quick_hexapod, {}),
}
"""Vanilla walkers that lose each leg in turn: systems, and numbers of their bodies."""


@needing("x_m", "y_m", "yaw_rad", "foot_x_m", "foot_y_m", "work_absolute_j", "failed", "time_s")
def _around_loss(path: Any, scenario: Any, body: Any, timing: Timing) -> dict[str, Any]:
    """Return distances and work before and after the loss, each over a quarter of the
    recording, and falls.
    """
    frames = path.x_m.shape[0]
    ends = [frames // 4, frames // 2 - 1, 3 * frames // 4, frames - 1]
    work = path.work_absolute_j

    def distance(a: int, b: int) -> Any:
        return jnp.hypot(path.x_m[b] - path.x_m[a], path.y_m[b] - path.y_m[a])

    def ahead(a: int, b: int) -> Any:
        """Return the mean distance of the feet ahead of the mass."""
        x = (path.foot_x_m - path.x_m[:, None])[a:b].mean(axis=1)
        y = (path.foot_y_m - path.y_m[:, None])[a:b].mean(axis=1)
        yaw = path.yaw_rad[a:b]
        return (x * jnp.cos(yaw) + y * jnp.sin(yaw)).mean(axis=0)

    fell = jnp.take_along_axis(path.time_s, jnp.argmax(path.failed, axis=0)[None], 0)[0]
    return {
        "feet": ahead(ends[0], ends[1]),
        "feet_after": ahead(ends[2], ends[3]),
        "before": distance(ends[0], ends[1]),
        "after": distance(ends[2], ends[3]),
        "work_before": work[ends[1]] - work[ends[0]],
        "work": work[ends[3]] - work[ends[2]],
        "time": path.time_s[ends[3]] - path.time_s[ends[2]],
        "stood": ~path.failed[ends[1]],
        "stays": ~path.failed[-1],
        "fell": fell - path.time_s[ends[1]],
    }


def leg_loss_rows(
    name: str, legged: Legged, runs: dict[str, Any], **body: float
) -> list[dict[str, Any]]:
    """Return one row per run and leg: whether it walks on after losing the leg in mid-gait. All
    lanes in one rollout.

    Args:
        name: what is walking.
        legged: the system.
        runs: weights by the name of a run.
        body: numbers of the body that are otherwise.
    """
    names, limbs = legged.names, legged.body.limbs
    cases = [(run, leg) for run in runs for leg in range(limbs)]
    presence = np.array([[float(leg != k) for _, leg in cases] for k in range(limbs)])
    phase = np.tile(random_phases(limbs, STARTS), (1, len(cases)))
    changes = {"present": Step(np.repeat(presence, STARTS, axis=1), from_s=0.5 * TIMING.duration_s)}
    scenario = with_changes(legged.scenario(phase), legged.body, {**body, **changes})
    weights = np.repeat([runs[run] for run, _ in cases], STARTS, axis=0)
    results = legged.rollout(_around_loss, TIMING).run(weights, scenario, legged.body)
    results = {n: np.asarray(x, float).reshape(len(cases), STARTS) for n, x in results.items()}
    intact = dataclasses.replace(legged.body, **body)
    rows = []
    for case, (run, leg) in enumerate(cases):
        outcome = {n: x[case] for n, x in results.items()}
        stood, stays = outcome["stood"] > 0.0, outcome["stays"] > 0.0
        walks = stays & (outcome["after"] > LEAST_WAY)
        rows.append(
            {
                "body": name,
                "run": run,
                "leg": names[leg],
                "margin": support_margin_m(intact, (leg,)),
                "margin_of_feet": _margin_of_feet(intact, leg, outcome["feet"][stood]),
                "feet": _median(outcome["feet"][stood]),
                "feet_after": _median(outcome["feet_after"][walks]),
                "margin_after": _margin_of_feet(intact, leg, outcome["feet_after"][walks]),
                "stood": int(stood.sum()),
                "stays_up": int(stays.sum()),
                "walks_on": int(walks.sum()),
                "speed_before": _median(4.0 * outcome["before"][stood] / TIMING.duration_s),
                "cost_before": _median(outcome["work_before"][stood] / outcome["before"][stood]),
                "speed": _median((outcome["after"] / outcome["time"])[walks]),
                "cost_of_transport": _median(outcome["work"][walks] / outcome["after"][walks]),
                "falls_after": _median(outcome["fell"][stood & ~stays]),
            }
        )
    return rows


def _margin_of_feet(body: Walker, leg: int, ahead_m: np.ndarray) -> float:
    """Return the margin of feet at these distances before the mass, without a leg; NaN if none
    stood.
    """
    if not len(ahead_m):
        return math.nan
    return support_margin_m(dataclasses.replace(body, com_x_m=-_median(ahead_m)), (leg,))


def _median(values: np.ndarray) -> float:
    return float(np.median(values)) if len(values) else math.nan


def bodies() -> None:
    """Let vanilla walkers lose each leg in turn, and write the table."""
    for name, (make, body) in BODIES.items():
        legged = make()
        rows = leg_loss_rows(name, legged, {"": legged.weights}, **body)
        write_rows(TABLES / "bodies.csv", rows, digits=4, by=("body",))


def report() -> None:
    """Write the table in Markdown, and the figure."""
    table = pd.read_csv(TABLES / "bodies.csv")
    write_text(TABLES / "bodies.md", markdown(table))
    with styled():
        save_figure(draw(table), TABLES / "lost_leg.png")


def markdown(table: pd.DataFrame) -> str:
    """Return a row per leg as Markdown."""
    titles = ("walker", "leg lost", "margin of hips", "of feet", "stay up, walk on",
              "speed before, after", "CoT after", "falls after")  # fmt: skip
    lines = [titles]
    for row in table.itertuples():
        survivors = f"{row.stays_up}, {row.walks_on} of {row.stood}"
        speeds = f"{rounded(row.speed_before)}, {rounded(row.speed)}"
        cells = (row.body, row.leg, rounded(row.margin), rounded(row.margin_of_feet), survivors,
                 speeds, rounded(row.cost_of_transport), rounded(row.falls_after, 1))  # fmt: skip
        lines.append(cells)
    return markdown_table(lines)


def rounded(value: float, digits: int = 2) -> str:
    """Return a number without a negative zero, or a dash for none."""
    return "–" if math.isnan(value) else f"{round(value, digits) + 0.0:.{digits}f}"


def draw(table: pd.DataFrame) -> Figure:
    """Draw the share of the starts that walk on over the margin, one mark a walker and leg."""
    figure = new_figure(PAGE_IN, 2.8)
    axes = figure.subplots()
    for number, (name, rows) in enumerate(table.groupby("body", sort=False)):
        axes.plot(
            rows.margin_of_feet + 0.004 * (number - 5), rows.walks_on / rows.stood.clip(lower=1),
            "os^DvPX"[number], ms=5, alpha=0.8, color=COLOURS[number % 7], label=name,
        )  # fmt: skip
    axes.axvline(0.0, color="0.7", lw=0.6)
    axes.set_xlabel("margin of the mass inside the mean places of the remaining feet [l0]")
    axes.set_ylabel("share that walks on")
    axes.set_ylim(-0.05, 1.05)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")
    return figure


if __name__ == "__main__":
    main(bodies, report)
