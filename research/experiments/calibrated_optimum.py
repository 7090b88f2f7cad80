"""Compare the study in the calibrated body with the best gait that any force can have.

    python -m research.experiments.calibrated_optimum               # 4 minutes; extra `optimum`
    python -m research.experiments.calibrated_optimum --drawn-only  # from the kept table of gaits

Its flight is damped, so that no bound is proved: the line is the best that trajectory optimisation
found. Written to the tables of the calibrated study are `optimum.csv`, a row a hop frequency, and
`optimum.png`, with the best run of each model of the study.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from research.frame import main, write_rows
from research.reproduction.export import read_study_csv as read_study
from research.reproduction.optimum import optimise
from research.reproduction.readings.named import reading_named
from research.reproduction.table import StudyTable
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.systems.recipe import recipe

FOLDER = Path(__file__).resolve().parents[2] / "research" / "reproduction/kept/study-calibrated"
BODY = reading_named("calibrated").applied(recipe("V-sector-w8").experiment()).body
"""Body of `make reproduce READING=calibrated`."""
OMEGAS = (2.0, 3.0, 4.0, *np.arange(5.0, 10.01, 0.25).tolist(), 11.0, 12.0, 13.0, 14.0)
"""Hop frequencies [rad/s]."""
COLUMNS = ("omega", "cot_inverse", "lift_off", "swings", "converged")


@dataclass(frozen=True)
class CalibratedOptimum:
    """Optimise, and draw the study beside it."""

    starts: int = 6
    """Random starts of each shape of gait."""
    drawn_only: bool = False
    """Draw from the table that is kept."""

    def run(self) -> None:
        """Run the whole study."""
        if not self.drawn_only:
            write_rows(FOLDER / "optimum.csv", [self._row(omega) for omega in OMEGAS], digits=6)
        columns = read_csv(FOLDER / "optimum.csv", COLUMNS)
        omega, best = parse_numbers(columns["omega"]), parse_numbers(columns["cot_inverse"])
        gaits = best_runs(read_study(FOLDER / "calibrated.csv"))
        save_figure(draw(omega, best, gaits), FOLDER / "optimum.png")
        for name, (rate, value) in gaits.items():
            share = value / np.interp(rate, omega, best)
            print(
                f"{name}: {len(share)} models, median {np.median(share):.1%} of the best known "
                f"gait, most {share.max():.1%}, {np.mean(share > 0.98):.0%} within 2 %"
            )

    def _row(self, omega: float) -> dict[str, float]:
        optimum = optimise(BODY, omega, starts=self.starts)
        row = {
            "omega": omega,
            "cot_inverse": optimum.cot_inverse,
            "lift_off": float(optimum.lift_off_m_per_s.max()),
            "swings": sum(stance.swings for stance in optimum.shape),
            "converged": optimum.converged,
        }
        print(f"{omega:5.2f} rad/s: {optimum.cot_inverse:.4f} m/J", flush=True)
        return row


def best_runs(table: StudyTable) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Hop frequency [rad/s] and CoT⁻¹ [m/J] of each model's best run, if it hops alike each time.

    Best is the training fitness, which a user knows; of V, whose runs are releases, CoT⁻¹.
    """
    indices = []
    for model in np.unique(table["model"]):
        rows = np.flatnonzero(table["model"] == model)
        is_v = table["architecture"][rows[0]] == "V"
        value = table["cot_inverse" if is_v else "best_fitness"][rows].astype(float)
        indices.append(rows[np.argmax(np.nan_to_num(value, nan=-np.inf))])
    rows = np.array(indices)
    rows = rows[table["limit_cycle_period"][rows].astype(float) == 1.0]
    kinds = {
        "with an oscillator": ~np.isin(table["architecture"][rows], ("V", "T")),
        "V": table["architecture"][rows] == "V",
        "single network T": table["architecture"][rows] == "T",
    }
    columns = (table["hop_rate"].astype(float), table["cot_inverse"].astype(float))
    return {name: tuple(column[rows[mask]] for column in columns) for name, mask in kinds.items()}


def draw(
    omega: np.ndarray, best: np.ndarray, gaits: dict[str, tuple[np.ndarray, np.ndarray]]
) -> Figure:
    """Draw CoT⁻¹ over hop frequency: the best known gait as a line, the study's models as marks."""
    with styled():
        figure = new_figure(0.6 * PAGE_IN, 2.8)
        axes = figure.subplots()
        axes.plot(omega, best, color="black", lw=1.2, label="best known gait, period 1")
        marks = (("o", COLOURS[0]), ("s", COLOURS[1]), ("^", COLOURS[4]))
        for (name, points), (marker, colour) in zip(gaits.items(), marks, strict=True):
            axes.plot(*points, ls="", marker=marker, ms=3.5, mew=0, color=colour, alpha=0.8,
                      label=name)  # fmt: skip
        axes.set(xlim=(2.0, 14.0), ylim=(0.0, 0.45))
        axes.set_xlabel("hop frequency [rad/s]")
        axes.set_ylabel("CoT⁻¹ [m/J]")
        figure.legend(loc="outside lower center", ncols=2)
    return figure


if __name__ == "__main__":
    main(CalibratedOptimum)
