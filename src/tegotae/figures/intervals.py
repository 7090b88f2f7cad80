"""Means of measured quantities with their intervals, a panel a quantity."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.figures.style import COLOURS, PAGE_IN, literal_text, new_figure, styled
from tegotae.measures.statistics import Interval

_ACROSS = 3


@styled()
def intervals_figure(names: Sequence[str], cells: Mapping[str, Iterable[Interval]]) -> Figure:
    """Draw each controller's mean as a dot, with a line over its 95 % interval.

    Args:
        names: of the controllers, or of what else has a row.
        cells: their means by the label of the quantity.
    """
    rows = math.ceil(len(cells) / _ACROSS)
    figure = new_figure(PAGE_IN, rows * (0.8 + 0.2 * len(names)))
    panels = figure.subplots(rows, _ACROSS, sharey=True, squeeze=False).ravel()
    for panel, (label, values) in zip(panels, cells.items(), strict=False):
        draw_intervals(panel, names, values)
        panel.set_xlabel(literal_text(label))
        panel.margins(y=0.3)
    panels[0].invert_yaxis()
    for panel in panels[len(cells) :]:
        panel.set_visible(False)
    return figure


def draw_intervals(axes: Axes, names: Sequence[str], means: Iterable[Interval]) -> None:
    """Draw means as dots, a row each, with lines over their 95 % intervals."""
    mean, low, high = np.array([(x.mean, x.low, x.high) for x in means]).T
    ends, rows = np.nan_to_num([mean - low, high - mean]), np.arange(len(names))
    axes.errorbar(mean, rows, xerr=ends, fmt="o", ms=3, color=COLOURS[0])
    axes.set_yticks(rows, [literal_text(name) for name in names])
