"""Gaits of random releases before and after a lost leg or another change."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.gaits.lesion import Aftermath
from tegotae.figures.gaits.style import MARKERS, by_side
from tegotae.figures.style import COLOURS, PAGE_IN, literal_text, new_figure, styled


@styled()
def lesion_figure(aftermath: Aftermath, note: str = "") -> Figure:
    """Draw the shares of starts that stand, and that are locked, over time (left), and the lags
    (right).

    Args:
        aftermath: what followed.
        note: the title.
    """
    figure = new_figure(PAGE_IN, 2.5)
    shares, lags = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
    _shares_lesion(shares, aftermath)
    shares.set_title(note, loc="left")
    _lags(lags, aftermath)
    return figure


def _shares_lesion(axes: Axes, aftermath: Aftermath) -> None:
    time = aftermath.legged.units[1]
    end = aftermath.legged.timing.duration_s - aftermath.lesion.at_s
    frame: Any = aftermath.frame
    stood = frame[frame["stood_before"]]
    times = np.linspace(0.0, end, 400)[:, None]
    if len(stood):
        standing = 1.0 - (stood["after_fall_time_s"].to_numpy() <= times).mean(axis=1)
        again = (stood["after_lock_time_s"].to_numpy() <= times).mean(axis=1)
        axes.plot(times, standing, color=COLOURS[0], label="standing")
        axes.plot(times, again, "--", color=COLOURS[1], label="locked for good")
        share = aftermath.share
        axes.errorbar(
            end, share.mean, [[share.mean - share.low], [share.high - share.mean]],
            color=COLOURS[0], capsize=2, lw=0.8, clip_on=False,
        )  # fmt: skip
    axes.set(xlim=(0.0, end), ylim=(-0.02, 1.04))
    axes.set_xlabel(f"time since {literal_text(aftermath.lesion.label)} [{time}]")
    axes.set_ylabel(f"share of {len(stood)} starts that stood")
    axes.legend(loc="center right")


def _lags(axes: Axes, aftermath: Aftermath) -> None:
    names, reference, frame = aftermath.legged.names, aftermath.reference, aftermath.frame
    order = [leg for leg in by_side(names) if leg != reference]
    for row, leg in enumerate(order):
        marker: Any = {
            "marker": MARKERS[row % len(MARKERS)], "color": COLOURS[row % len(COLOURS)], "ls": ""
        }  # fmt: skip
        lags_before = frame.loc[frame["stood_before"], f"before_lag_cycles_{names[leg]}"] % 1.0
        low, high = (np.full(len(frame), row + off) for off in (-0.14, 0.14))
        axes.plot(lags_before, low[: len(lags_before)], ms=3.4, mew=0.6, fillstyle="none", **marker)
        if leg in aftermath.left:
            lags_after = frame.loc[frame["stays_up"], f"after_lag_cycles_{names[leg]}"] % 1.0
            axes.plot(lags_after, high[: len(lags_after)], ms=3.0, **marker)
    axes.set_yticks(range(len(order)), [names[leg] for leg in order])
    axes.set(xlim=(-0.02, 1.02), ylim=(len(order) - 0.5, -0.5), xticks=np.linspace(0, 1, 5))
    axes.set_xlabel(f"lag behind {names[reference]} [cycles]: open before, filled after")
