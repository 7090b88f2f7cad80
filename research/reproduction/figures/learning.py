"""Figure of the merit over the training frequency: learned feedback, V, and short laws."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.learning.primary import best_law
from research.reproduction.learning.runs import LAW, where
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.measures.statistics import POSITIVE, interval

_COLOURS: dict[str, str] = {
    "AR": COLOURS[0],
    "ART": COLOURS[4],
    "ARG": COLOURS[3],
    "ARGT": COLOURS[5],
}


def learning_figure(readings: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw merit over ω_t in each body, means over runs with their 95 % intervals.

    Args:
        readings: runs of `research.reproduction.learning.runs.read_runs`, by what the body is
        called.
    """
    with styled():
        figure = new_figure(PAGE_IN, 3.2)
        panels = figure.subplots(1, len(readings), sharey=True, squeeze=False)[0]
        for axes, (body, runs) in zip(panels, readings.items(), strict=True):
            kinds = {
                name: where(runs, runs.architecture == name) for name in ("V", *LEARNED_FEEDBACK)
            }
            for law in dict.fromkeys(("clock", best_law(runs))):
                kinds[law] = where(runs, (runs.architecture == LAW) & (runs.drive == law))
            for name, rows in kinds.items():
                _draw(axes, name, rows)
            axes.set(title=body, xlabel=r"$\omega_t$ [rad/s]")
        panels[0].set(ylabel="merit [m/J]", ylim=(0.0, None))
        handles = {h.get_label(): h for axes in panels for h in axes.get_lines()}
        figure.legend(handles=list(handles.values()), loc="outside lower center", ncols=4)
        return figure


def _draw(axes: Axes, name: str, rows: pd.DataFrame) -> None:
    """Draw means of a kind over ω_t, and their intervals; V's three drives are no sample of
    runs.
    """
    intervals = [
        (w, interval(x.merit.to_numpy(), within=POSITIVE)) for w, x in rows.groupby("omega_t")
    ]
    omegas, means = zip(*intervals, strict=True)
    colour = _COLOURS.get(name, "black")
    line = "-" if name == "V" or name in _COLOURS else ":" if name == "clock" else "--"
    label = name if line == "-" else f"{name}, short law"
    axes.plot(omegas, [x.mean for x in means], line, color=colour, lw=1.2, label=label)
    if name != "V":
        low, high = [x.low for x in means], [x.high for x in means]
        axes.fill_between(omegas, low, high, color=colour, alpha=0.12, lw=0)
