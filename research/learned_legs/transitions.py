"""Map gaits over speed: learned laws swept up and down in ω, beside vanilla feedback.

    python -m research.learned_legs.transitions NAME ...  # files, or folders of them; a minute

Each is swept by the gait laboratory's `sweep`, from the slowest frequency to the fastest and back,
without a new release. The table and the figure go to `research/learned_legs`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from research.frame import Names, main, write_rows
from research.learned_legs.figures import FAMILIES
from tegotae._support.progress import reporting
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.analysis.gaits.sweep import DOWN, UP, GaitSweep, sweep
from tegotae.figures.gaits.style import gait_colour
from tegotae.figures.style import COLUMN_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.lags import circular_mean
from tegotae.measures.gaits.names import NO_GAIT
from tegotae.systems.legged import settling
from tegotae.systems.resolve import resolve
from tegotae.systems.vanilla import legged_named

FOLDER = Path(__file__).resolve().parents[2] / "research" / "learned_legs"
LEVELS = np.linspace(1.0, 3.6, 14)
"""Frequencies of the sweep [√(g / l0)]."""
DWELL = 60.0
"""Duration of each level [√(l0 / g)]."""
STARTS = 4
"""Random releases at either end."""


def swept(names: list[str]) -> list[dict[str, Any]]:
    """Return one row per controller, direction and level."""
    runs = [("V", legged_named("quadruped-c"))]
    for name in names:
        for path, saved in resolve(name).weighted():
            runs.append((path.stem, settling(saved.system, saved.weights)))
    rows = []
    with reporting("sweeps", len(runs)) as reporter:
        for index, (label, legged) in enumerate(runs, 1):
            result = sweep(legged, LEVELS, dwell_s=DWELL, starts=STARTS)
            rows += rows_of(label, result)
            reporter.update(index, label)
    return rows


def rows_of(label: str, result: GaitSweep) -> list[dict[str, Any]]:
    """Return the gait of most starts at each level, on each way."""
    rows = []
    bistable = set(result.bistable.tolist())
    for (direction, omega), group in result.frame.groupby(
        ["direction", "omega_rad_per_s"], sort=False
    ):
        names, counts = np.unique(group["gait"].to_numpy(str), return_counts=True)
        lag = group["lag_cycles_LF"].dropna().to_numpy()
        rows.append(
            {
                "run": label,
                "way": direction,
                "omega": omega,
                "gait": str(names[counts.argmax()]),
                "starts": int(counts.max()),
                "locked": float(np.mean(~group["gait"].isin(NO_GAIT[1:]))),
                "lag_LF": float(circular_mean(lag, axis=0)) if lag.size else np.nan,
                **{
                    name: group[name].mean()
                    for name in ("speed_m_per_s", "cost_of_transport", "flight_share")
                },
                "differs": omega in bistable,
            }
        )
    return rows


def run_label(label: str) -> str:
    """Return a controller file's label in the figure: family and run."""
    name, separator, _ = label.partition("+range@")
    return f"{FAMILIES[name][0]}, run {label.rpartition('seed')[2]}" if separator else label


def figure() -> None:
    """Write `transitions.png`: the gaits of every run, on the way up and below it down."""
    table = read_csv(FOLDER / "transitions.csv")
    labels = list(dict.fromkeys(table["run"].tolist()))
    names: list[str] = []
    with styled():
        drawn = new_figure(COLUMN_IN, 0.9 + 0.22 * len(labels))
        axes = drawn.subplots()
        for row, label in enumerate(labels):
            for direction, low in ((UP, 0.42), (DOWN, 0.06)):
                mask = (table["run"] == label) & (table["way"] == direction)
                for omega, gait in zip(
                    parse_numbers(table["omega"][mask]), table["gait"][mask], strict=True
                ):
                    name = str(gait)
                    width = LEVELS[1] - LEVELS[0]
                    axes.bar(omega, 0.34, width, row + low, color=gait_colour(name), lw=0)
                    names += [name] if name not in names else []
        axes.set_yticks(0.4 + np.arange(len(labels)), [run_label(label) for label in labels])
        axes.set(xlabel="frequency ω [√(g/l0)]", ylim=(0.0, len(labels)))
        keys = [Line2D([], [], marker="s", ls="", color=gait_colour(n), label=n) for n in names]
        drawn.legend(handles=keys, loc="outside lower center", ncols=2)
        save_figure(drawn, FOLDER / "transitions.png")


def run(names: Names = ()) -> None:
    """Sweep named controllers, and draw; without a name, draw the kept table."""
    if names:
        write_rows(FOLDER / "transitions.csv", swept(names), digits=4)
    figure()


if __name__ == "__main__":
    main(run)
