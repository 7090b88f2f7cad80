"""Fronts: the least cost of transport over speed, a line per family."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from tegotae.figures.gaits.colours import gait_colour
from tegotae.figures.style import COLUMN_IN, new_figure, styled
from tegotae.systems.tuned import FORCED

_FREE = ("vanilla", "cosine", "vanilla ellipse")
_SHADES = ("0.0", "0.45", "0.7")
"""Their greys: colours are those of gaits."""


def front_figure(table: Mapping[str, np.ndarray], note: str = "") -> Figure:
    """Cost of transport over speed, each family's.

    Solid lines are of legs with feedback, dashed ones of legs that are forced into a gait. A speed
    that a family does not reach interrupts its line.

    Args:
        table: fronts of a system (`tegotae.measures.fronts.table.COLUMNS`).
        note: the title.
    """
    family, speed, cost = table["family"], table["speed"], table["cost_of_transport"]
    names = list(dict.fromkeys(family.tolist()))
    with styled():
        figure = new_figure(COLUMN_IN, 3.0)
        axes = figure.subplots()
        for name in sorted(names, key=lambda name: name not in _FREE):
            own = family == name
            order = np.argsort(speed[own])
            x, y = speed[own][order], cost[own][order]
            apart = np.flatnonzero(np.diff(x) > _APART) + 1
            x, y = (np.insert(values, apart, np.nan) for values in (x, y))
            forced = name.startswith(FORCED)
            colour = (
                gait_colour(name.removeprefix(FORCED)) if forced else _SHADES[_FREE.index(name)]
            )
            axes.plot(
                x,
                y,
                "--" if forced else "-",
                color=colour,
                lw=0.7 if forced else 1.4,
                marker="." if forced else "o",
                ms=2.5,
                label=name,
            )
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.yaxis.set_minor_formatter(ScalarFormatter())
        axes.set(xlabel="speed [√(g l0)]", ylabel="cost of transport", title=note)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2)
    return figure


_APART = 0.1001
"""Speeds farther apart than two bins are not joined [√(g l0)]."""
