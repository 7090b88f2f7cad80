"""Lags over time: how the legs find together."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tegotae.analysis.gaits.simulate import GaitRun
from tegotae.figures.gaits.colours import by_side
from tegotae.figures.style import COLOURS, COLUMN_IN, new_figure, styled


def lags_figure(run: GaitRun, note: str = "") -> Figure:
    """The lag of every leg behind the reference leg, averaged over strides.

    A dotted line is where a lag has settled, and the vertical one when all had.

    Args:
        run: the rollout.
        note: the title.
    """
    names, reference = run.legged.names, run.legged.reference
    others = [leg for leg in by_side(names) if leg != reference]
    time = np.asarray(run.trajectory.time_s)
    with styled():
        figure = new_figure(COLUMN_IN, 2.2)
        axes = figure.subplots()
        for number, leg in enumerate(others):
            colour = COLOURS[number % len(COLOURS)]
            axes.plot(time, unwound(run.lag[:, leg]), color=colour, label=names[leg])
            final = float(run.found.lag[leg, 0] % 1.0)
            axes.axhline(final, color=colour, lw=0.6, ls=":")
        if np.isfinite(run.found.lock_time_s[0]):
            axes.axvline(float(run.found.lock_time_s[0]), color="0.5", lw=0.6)
        axes.set(xlim=(0.0, time[-1]), ylim=(0.0, 1.0), yticks=np.linspace(0.0, 1.0, 5))
        axes.set_xlabel(f"time [{run.legged.units[1]}]")
        axes.set_ylabel(f"lag behind {names[reference]} [cycles]")
        axes.legend(
            loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(others), title=note or None
        )
    return figure


def unwound(lag: np.ndarray) -> np.ndarray:
    """The lags with a gap wherever they pass from 1 to 0, so that no line crosses the picture.

    Example:
        >>> unwound(np.array([0.8, 0.95, 0.1])).tolist()
        [0.8, 0.95, nan]
    """
    drawn = np.array(lag, float)
    drawn[1:][np.abs(np.diff(lag)) > 0.5] = np.nan
    return drawn
