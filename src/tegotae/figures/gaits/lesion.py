"""What follows a lesion: who stands, who is locked again, and where the lags go."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.gaits.lesion import Aftermath
from tegotae.figures.gaits.colours import MARKERS, by_side
from tegotae.figures.style import COLOURS, PAGE_IN, literal, new_figure, styled


def lesion_figure(found: Aftermath, note: str = "") -> Figure:
    """Left the shares of starts that stand, and that are locked, over time; right the lags.

    Args:
        found: what followed.
        note: the title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.5)
        shares, lags = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
        _shares(shares, found)
        shares.set_title(note, loc="left")
        _lags(lags, found)
    return figure


def _shares(axes: Axes, found: Aftermath) -> None:
    time = found.legged.units[1]
    end = found.timing.duration_s - found.lesion.at_s
    stood = found.stood
    fell = np.where(stood, found.after.fall_time_s, np.nan)[stood]
    locked = found.after.lock_time_s[stood]
    at = np.linspace(0.0, end, 400)
    if stood.any():
        standing = 1.0 - (fell[None] <= at[:, None]).mean(axis=1)
        again = (locked[None] <= at[:, None]).mean(axis=1)
        axes.plot(at, standing, color=COLOURS[0], label="standing")
        axes.plot(at, again, "--", color=COLOURS[1], label="locked for good")
        _, low, high = found.share
        axes.errorbar(
            end, found.share[0], [[found.share[0] - low], [high - found.share[0]]],
            color=COLOURS[0], capsize=2, lw=0.8, clip_on=False,
        )  # fmt: skip
    axes.set(xlim=(0.0, end), ylim=(-0.02, 1.04))
    axes.set_xlabel(f"time since {literal(found.lesion.label)} [{time}]")
    axes.set_ylabel(f"share of {int(stood.sum())} starts that stood")
    axes.legend(loc="center right")


def _lags(axes: Axes, found: Aftermath) -> None:
    names, reference = found.legged.names, found.reference
    order = [leg for leg in by_side(names) if leg != reference]
    for row, leg in enumerate(order):
        colour, marker = COLOURS[row % len(COLOURS)], MARKERS[row % len(MARKERS)]
        before = found.before.lag[leg][found.stood] % 1.0
        axes.plot(before, np.full(before.size, row - 0.14), marker, color=colour, ms=3.4,
                  mew=0.6, fillstyle="none")  # fmt: skip
        if leg in found.left:
            after = found.after.lag[found.left.index(leg)][found.stays] % 1.0
            axes.plot(after, np.full(after.size, row + 0.14), marker, color=colour, ms=3.0)
    axes.set_yticks(range(len(order)), [names[leg] for leg in order])
    axes.set(xlim=(-0.02, 1.02), ylim=(len(order) - 0.5, -0.5), xticks=np.linspace(0, 1, 5))
    axes.set_xlabel(f"lag behind {names[reference]} [cycles]: open before, filled after")
