"""Footfall diagrams: which foot is on the ground when (Hildebrand)."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tegotae.analysis.gaits.simulate import GaitRun
from tegotae.figures.gaits.colours import by_side
from tegotae.figures.style import COLUMN_IN, new_figure, styled

STRIDES = 6.0
"""How many of the last strides are drawn."""


def footfall_figure(run: GaitRun, note: str = "") -> Figure:
    """The stances of every leg over the last strides, and their duty factors beside them.

    Args:
        run: the rollout.
        note: the title.
    """
    names, end = run.legged.names, float(run.trajectory.time_s[-1])
    long = STRIDES * run.stride_s if np.isfinite(run.stride_s) else 0.25 * end
    begin = max(0.0, end - long)
    rows = by_side(names)
    with styled():
        figure = new_figure(COLUMN_IN, 0.75 + 0.22 * len(names))
        axes = figure.subplots()
        for row, leg in enumerate(rows):
            for stance in run.stances[leg]:
                if stance.liftoff_s > begin:
                    start = max(stance.touchdown_s, begin)
                    axes.barh(row, stance.liftoff_s - start, left=start, height=0.62, color="0.15")
        axes.set_yticks(range(len(rows)), [names[leg] for leg in rows])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlim(begin, end)
        axes.set_xlabel(f"time [{run.legged.units[1]}]")
        duty = axes.secondary_yaxis("right")
        shown = run.found.duty_factor[:, 0]
        duty.set_yticks(range(len(rows)), [f"{shown[leg]:.2f}" for leg in rows])
        duty.set_ylabel("duty factor")
        for side in (axes, duty):
            side.tick_params(axis="y", length=0)
            side.spines["left" if side is axes else "right"].set_visible(False)
        axes.set_title(note)
    return figure
