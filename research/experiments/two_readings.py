"""The study in two bodies, side by side: that of the study's own reading, and the calibrated one.

    python -m research.experiments.two_readings

reads the tables of both studies (`make study-tables`, `make study-tables READING=calibrated`), and
writes `two_readings.md` and `two_readings.png` to `research/reproduction/kept/study-calibrated`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from research.frame import main, markdown_table
from research.reproduction.export import read_study_csv
from research.reproduction.readings.named import reading_named
from research.reproduction.table import ARCHITECTURES, StudyTable
from tegotae import Hopper
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.statistics import Interval, interval
from tegotae.systems.recipe import recipe

KEPT = Path(__file__).resolve().parents[1] / "reproduction" / "kept"
READINGS = {
    "the study": (
        KEPT / "study" / "paper.csv",
        Hopper().weight_n,
    ),
    "calibrated": (
        KEPT / "study-calibrated" / "calibrated.csv",
        reading_named("calibrated").applied(recipe("V-sector-w8").experiment()).body.weight_n,
    ),
}
"""The table of each reading, and the weight of its body [N]."""

METRICS = {
    "efficiency": "$m g$ CoT⁻¹",
    "gain": "CoT⁻¹ over V's",
    "t0_s": "$T_0$ [s]",
    "t1_s": "$T_1$ [s]",
    "cpgu": "CPGu",
    "limit_cycle_share": "settles (share)",
}
"""Compared metrics, with their labels. Efficiency is weight times height climbed over work; the
gain, CoT⁻¹ over the mean of V, stands in its place in the figure."""

PLACES = tuple((name, "F") for name in ARCHITECTURES) + tuple(
    (name, "Fv") for name in ("AR", "ART", "ARG", "ARGT", "T")
)
"""Architecture and input."""


def summary(table: StudyTable, weight_n: float) -> dict[tuple[str, str, str], Interval]:
    """Return the mean and interval over runs, by metric, architecture and input; all designs
    count alike.
    """
    scales = {
        "efficiency": weight_n,
        "gain": 1.0 / _mean(table.where(architecture="V")["cot_inverse"].astype(float)),
    }
    results = {}
    for architecture, observation in PLACES:
        rows = table.where(architecture=architecture, observation=observation)
        for metric in METRICS:
            values = rows["cot_inverse" if metric in scales else metric].astype(float)
            values = values * scales.get(metric, 1.0)
            runs = rows["run"].astype(int)
            # A run of each design at once: their mean is one value, so that runs alone vary.
            with np.errstate(invalid="ignore"):
                means = [_mean(values[runs == run]) for run in np.unique(runs)]
            results[metric, architecture, observation] = interval(means)
    return results


def _mean(values: np.ndarray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else np.nan


def estimates_of_readings() -> dict[str, dict[tuple[str, str, str], Interval]]:
    """Return the summary of each reading, by its name."""
    return {
        name: summary(read_study_csv(path), weight) for name, (path, weight) in READINGS.items()
    }


def draw(readings: dict[str, dict[tuple[str, str, str], Interval]]) -> Figure:
    """Draw one panel per metric and a pair of marks per architecture, one for each reading."""
    with styled():
        metrics = {name: label for name, label in METRICS.items() if name != "efficiency"}
        figure = new_figure(PAGE_IN, 1.2 * len(metrics) + 0.5)
        panels = figure.subplots(len(metrics), 1, sharex=True)
        positions = np.arange(len(PLACES))
        for panel, (metric, label) in zip(panels, metrics.items(), strict=True):
            for shift, marker, colour, estimates in zip(
                (-0.13, 0.13), "os", COLOURS, readings.values(), strict=False
            ):
                row = [estimates[metric, *place] for place in PLACES]
                mean, low, high = (
                    np.array([getattr(estimate, name) for estimate in row])
                    for name in ("mean", "low", "high")
                )
                panel.vlines(positions + shift, low, high, color=colour, lw=1.0)
                filled = {} if marker == "o" else {"mfc": "white"}
                panel.plot(
                    positions + shift, mean, marker, color=colour, ms=4, clip_on=False, **filled
                )
            panel.set_ylabel(label)
            panel.set_ylim(0.0, 1.0 if metric in ("cpgu", "limit_cycle_share") else None)
            panel.axvline(len(ARCHITECTURES) - 0.5, color="0.7", lw=0.6)
        panels[-1].set_xticks(positions, [name for name, _ in PLACES])
        for place, caption in ((0, "input $F_k$"), (len(ARCHITECTURES), r"input $F_k, \dot y$")):
            panels[0].text(
                place - 0.4, 1.04, caption, transform=panels[0].get_xaxis_transform(), va="bottom"
            )
        marks = [
            Line2D([], [], color=COLOURS[0], marker="o", ls="", ms=4, label="the study's reading"),
            Line2D(
                *([], []), color=COLOURS[1], marker="s", mfc="white", ls="", ms=4,
                label="the calibrated reading",
            ),
        ]  # fmt: skip
        figure.legend(handles=marks, loc="outside lower center", ncols=2)
        figure.align_ylabels(panels)
    return figure


def text(readings: dict[str, dict[tuple[str, str, str], Interval]]) -> str:
    """Return the page's table: efficiency, settling and transients of both, by architecture."""
    metrics = ("efficiency", "t0_s", "t1_s")
    lines = [["", *(f"{METRICS[m]}, {r}" for m in metrics for r in readings)]]
    for architecture, observation in PLACES:
        name = architecture + (r" on $F_k, \dot y$" if observation == "Fv" else "")
        cells = [
            _cell(estimates[metric, architecture, observation], 2 if metric == "efficiency" else 1)
            for metric in metrics
            for estimates in readings.values()
        ]
        lines.append([name, *cells])
    return markdown_table(lines)


def _cell(estimate: Interval, digits: int) -> str:
    if np.isnan(estimate.mean):
        return "–"
    return f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"


@dataclass(frozen=True)
class TwoReadings:
    """Write the table and the figure."""

    out: Path = KEPT / "study-calibrated"
    """Folder of the table and the figure."""

    def run(self) -> None:
        """Write the table and the figure."""
        readings = estimates_of_readings()
        (self.out / "two_readings.md").write_text(text(readings), encoding="utf-8")
        save_figure(draw(readings), self.out / "two_readings.png")
        print(text(readings), end="")


if __name__ == "__main__":
    main(TwoReadings)
