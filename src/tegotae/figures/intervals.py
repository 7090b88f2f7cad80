"""Means of measured quantities with their intervals, a panel a quantity."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
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
    place = np.arange(len(names))
    figure = new_figure(PAGE_IN, rows * (0.8 + 0.2 * len(names)))
    panels = figure.subplots(rows, _ACROSS, sharey=True, squeeze=False).ravel()
    for panel, (label, values) in zip(panels, cells.items(), strict=False):
        means = list(values)
        mean = np.array([cell.mean for cell in means])
        ends = np.array([(cell.mean - cell.low, cell.high - cell.mean) for cell in means])
        panel.errorbar(mean, place, xerr=np.nan_to_num(ends.T), fmt="o", color=COLOURS[0])
        panel.set_xlabel(literal_text(label))
        panel.set_yticks(place, [literal_text(name) for name in names])
        panel.margins(y=0.3)
    panels[0].invert_yaxis()
    for panel in panels[len(cells) :]:
        panel.set_visible(False)
    return figure
