"""Fronts: the least cost of transport over speed, a line per family."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.gaits.colours import gait_colour, gait_marker
from tegotae.figures.style import COLUMN_IN, new_figure, styled
from tegotae.systems.tuned import FORCED

_FREE = ("vanilla", "cosine", "vanilla ellipse")
_SHADES = ("0.3", "0.55", "0.75")
"""Their greys: colours, and black, are those of gaits."""


def front_figure(table: Mapping[str, np.ndarray], note: str = "") -> Figure:
    """Cost of transport over speed, each family's.

    Solid lines are of legs with feedback, dashed ones of legs that are forced into a gait. A speed
    that a family does not reach interrupts its line.

    Args:
        table: fronts of a system (`tegotae.measures.fronts.COLUMNS`).
        note: the title.
    """
    family, speed, cost = table["family"], table["speed"], table["cost_of_transport"]
    names = list(dict.fromkeys(family.tolist()))
    with styled():
        figure = new_figure(COLUMN_IN * 1.2, 2.6 + 0.09 * len(names))
        axes = figure.subplots()
        for name in sorted(names, key=lambda name: name not in _FREE):
            own = family == name
            order = np.argsort(speed[own])
            x, y = speed[own][order], cost[own][order]
            apart = np.flatnonzero(np.diff(x) > _APART) + 1
            x, y = (np.insert(values, apart, np.nan) for values in (x, y))
            forced = name.startswith(FORCED)
            gait = name.removeprefix(FORCED)
            colour = gait_colour(gait) if forced else _SHADES[_FREE.index(name)]
            axes.plot(
                x,
                y,
                "--" if forced else "-",
                color=colour,
                lw=0.7 if forced else 1.4,
                marker=gait_marker(gait) if forced else "o",
                ms=2.5,
                label=name,
            )
        axes.set_yscale("log")
        axes.set_yticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
        axes.set_yticks([], minor=True)
        axes.set_ylim(0.8 * np.min(cost), 1.25 * np.max(cost))
        axes.set(xlabel="speed [√(g l0)]", ylabel="cost of transport", title=note)
        figure.legend(loc="outside lower center", ncols=2)
    return figure


_TICKS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0)
_APART = 0.1001
"""Speeds farther apart than two bins are not joined [√(g l0)]."""
