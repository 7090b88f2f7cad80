"""Vary each number of a leg's law alone, and measure its effect from releases of no training.

    python -m research.learned_legs.numbers                # a minute of one core
    python -m research.learned_legs.numbers --figure-only  # table and figure of the kept rows

The laws are the runs that `research/learned_legs/run.py` selects of `decay` and of `decay-t`,

    φ̇ = ω - σ e^(-k N) (cos(φ - p) + o),

on the feet of quadruped-c, and on an ellipse that is trained, too. A trained ellipse may run half a
turn behind: the laws are written here with a stride above zero, which is the same motion. A number
is varied over its neighbourhood and set to what leaves it out: 0, and of the ellipse the system's
own. Releases, commands and durations are those of `research/learned_legs/evaluate.py`.

Written to `research/learned_legs` are `numbers.csv`, a row a law, number, value and command;
`numbers.md`; and `numbers.png`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from research.frame import main, markdown_table, write_rows, write_text
from research.learned_legs.evaluate import TEST_SEED, TIMING, USUAL, runs_of, selected
from research.learned_legs.plan import CELLS, FOLDER, TABLES
from tegotae.analysis.gaits.releases import release_all
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.statistics import mean_defined
from tegotae.parts.fields import replace
from tegotae.systems.legged import Legged

LAWS = ("decay-t", "decay")
"""The laws, the one with most numbers first."""
OMEGAS = (1.5, 2.25, 3.0)
"""Commands [rad/s]."""
FASTER = OMEGAS[1:]
"""Commands at which the laws have one gait."""
RELEASES = 8
STEPS = 33
"""Values of a number."""
ELLIPSE = {"stride": 0.2, "lift": 0.12, "press": 0.03, "shift": 0.4}
"""The feet of quadruped-c: lengths in leg lengths, and an angle [rad]."""
NUMBERS = {
    "p": "p [rad]",
    "o": "o",
    "k": "k",
    "σ": "σ",
    "stride": "stride",
    "lift": "lift",
    "press": "press",
    "shift": "shift [rad]",
}
"""The numbers in the order of the weights, and how axes call them."""
MEASURES = {
    "cost_of_transport": "CoT",
    "speed_m_per_s": "speed [√(g l0)]",
    "locked": "share locked",
    "duty_factor": "duty factor",
}
NEAR = 1.25
"""A cost of so much of the law's is near it."""


@dataclass(frozen=True)
class LawNumbers:
    """Vary the numbers of the laws, and draw the effects."""

    dir: Path = FOLDER
    """Folder of the trained laws."""
    figure_only: bool = False
    """Make table and figure of what `numbers.csv` holds."""

    def run(self) -> None:
        """Measure, and write."""
        file = TABLES / "numbers.csv"
        if not self.figure_only:
            rows = [row for name in LAWS for row in varied(name, self.dir)]
            write_rows(file, rows, digits=4)
        records = pd.read_csv(file)
        write_text(TABLES / "numbers.md", table(records))
        save_figure(figure(records), TABLES / "numbers.png")
        print(table(records))


def varied(name: str, folder: Path) -> list[dict[str, Any]]:
    """Measure every number of a law at every value: a row each and command."""
    (cell,) = (candidate for candidate in CELLS if candidate.name == f"{name}+range@quadruped-c")
    runs, legged = runs_of(cell, folder)
    weights = runs.weights[runs.labels.index(selected(cell.name))]
    weights, names = forwards(np.asarray(weights, float)), list(NUMBERS)[: len(weights)]
    laws, places = [weights], [("", "as trained", np.nan)]
    for i, number in enumerate(names):
        for kind, value in values(number, weights[i]):
            laws.append(np.where(np.arange(len(weights)) == i, value, weights))
            places.append((number, kind, value))
    results = measured(legged, np.array(laws))
    labels = [
        {"law": name, "number": number, "kind": kind, "value": value}
        for number, kind, value in places
    ]
    numbers = dict.fromkeys(NUMBERS, np.nan) | dict(zip(names, weights.tolist(), strict=True))
    return [{**labels[row["run"]], **row, **numbers} for row in results.to_dict("records")]


def forwards(law: np.ndarray) -> np.ndarray:
    """Return the same law with a stride above zero: half a turn on, lift and press change
    places."""
    if len(law) == 4 or law[4] > 0.0:
        turned = law.copy()
    else:
        turned = np.array([law[0] + np.pi, *law[1:4], -law[4], -law[6], -law[5], law[7]])
    turned[0] = (turned[0] + np.pi) % (2.0 * np.pi) - np.pi
    return turned


def values(number: str, trained: float) -> list[tuple[str, float]]:
    """Return the values of a number: angles half a turn around the trained one, others from 0 to
    twice."""
    if number == "p":
        span = trained + np.linspace(-np.pi, np.pi, STEPS)
    elif number == "shift":
        span = trained + np.linspace(-0.5 * np.pi, 0.5 * np.pi, STEPS)
    else:
        span = trained * np.linspace(0.0, 2.0, STEPS)
    return [("varied", float(x)) for x in span] + [("left out", ELLIPSE.get(number, 0.0))]


def measured(legged: Legged, laws: np.ndarray) -> pd.DataFrame:
    """Measure laws at every command: a row each."""
    timed = replace(legged, {"timing": TIMING})
    releases = release_all(timed, laws, OMEGAS, RELEASES, seed=TEST_SEED, changes=USUAL)
    duty = releases.frame.filter(like="duty_factor").to_numpy().mean(axis=1)
    stands = ~np.isfinite(releases.frame["fall_time_s"].to_numpy())
    summary = releases.summary
    summary["duty_factor"] = mean_defined(np.where(stands, duty, np.nan).reshape(-1, RELEASES))
    return pd.DataFrame(summary[["run", "omega", "upright", *MEASURES]])


def of_number(rows: Any, number: str) -> Any:
    """Return the rows in which a number is varied, beside the unchanged law."""
    return rows[(rows["number"] == number) & (rows["kind"] == "varied")]


def table(records: Any) -> str:
    """Return one row per law and number: means over the commands as trained and without the number,
    and over which values the cost stays near the law's at the faster commands.
    """
    head = ["law", "number", "trained", "CoT", "speed", "locked", "duty factor", "cost near"]
    lines = [head]
    for law in LAWS:
        rows = records[records["law"] == law]
        baseline = rows[rows["kind"] == "as trained"]
        lines.append([law, "as it is", "–", *_means(baseline), "–"])
        for number in NUMBERS:
            mine = rows[rows["number"] == number]
            if not len(mine):
                continue
            out = mine[mine["kind"] == "left out"]
            near = _near(of_number(rows, number), baseline)
            text = f"{baseline[number].iloc[0]:.2f}"
            without = f"{number} = {out['value'].iloc[0]:g}"
            lines.append([law, without, text, *_means(out), near])
    return markdown_table(lines)


def _means(rows: Any) -> list[str]:
    """Return means over the commands; for a law that falls somewhere, also how often it stays
    up.
    """
    stays = rows["upright"].mean()
    cells = [f"{rows[name].mean():.2f}" for name in MEASURES]
    walks = rows["speed_m_per_s"].min() > 0.02
    cells[0] = cells[0] if walks else "does not walk"
    cells[2] += "" if stays == 1.0 else f", {stays:.2f} stay up"
    return cells


def _near(varied: Any, baseline: Any) -> str:
    """Return the range around the trained value in which the cost stays near at the faster
    commands."""
    cost = varied.pivot_table(
        index="value", columns="omega", values="cost_of_transport", dropna=False
    )
    stays = varied.pivot_table(index="value", columns="omega", values="upright")
    base = baseline.set_index("omega")["cost_of_transport"]
    near = (cost <= NEAR * base) & (cost > 0.0) & (stays == 1.0)
    good = near[list(FASTER)].all(axis=1).to_numpy()
    value = cost.index.to_numpy()
    first = last = STEPS // 2
    while first > 0 and good[first - 1]:
        first -= 1
    while last < STEPS - 1 and good[last + 1]:
        last += 1
    return f"{value[first]:.2f} to {value[last]:.2f}"


def figure(records: Any) -> Figure:
    """Draw one column per number, one row per measure, and a line per command, the smaller law
    dashed.
    """
    with styled():
        canvas = new_figure(PAGE_IN, 4.6)
        panels = canvas.subplots(len(MEASURES), len(NUMBERS), sharex="col", sharey="row")
        for column, number in enumerate(NUMBERS):
            for row, measure in enumerate(MEASURES):
                axes = panels[row, column]
                for law, line in zip(LAWS, ("-", ":"), strict=True):
                    rows = records[records["law"] == law]
                    baseline = rows[rows["kind"] == "as trained"]
                    if not len(rows[rows["number"] == number]):
                        continue
                    for omega, colour in zip(OMEGAS, COLOURS, strict=False):
                        mine = of_number(rows, number)
                        mine = mine[mine["omega"] == omega].sort_values("value")
                        values = mine[measure].where(mine["speed_m_per_s"] > 0.02)
                        axes.plot(mine["value"], values, line, color=colour, lw=0.9)
                        if law == LAWS[0]:
                            point = baseline[baseline["omega"] == omega]
                            axes.plot(point[number], point[measure], "o", color=colour, ms=2.5)
                axes.tick_params(labelsize=5.5)
                if column == 0:
                    axes.set_ylabel(MEASURES[measure], size=7)
            panels[-1, column].set_xlabel(NUMBERS[number], size=7)
        panels[0, 0].set(yscale="log", ylim=(0.04, 4.0))
        panels[2, 0].set_ylim(-0.05, 1.05)
        handles = [
            *(
                panels[0, 0].plot([], [], color=c, label=f"ω = {w:g}")[0]
                for w, c in zip(OMEGAS, COLOURS, strict=False)
            ),
            *(
                panels[0, 0].plot([], [], s, color="0.4", label=n)[0]
                for n, s in zip(LAWS, ("-", ":"), strict=True)
            ),
        ]
        canvas.legend(handles=handles, loc="outside lower center", ncols=5)
    return canvas


if __name__ == "__main__":
    main(LawNumbers)
