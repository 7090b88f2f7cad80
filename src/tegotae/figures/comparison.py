"""Models side by side: a metric with its interval, and learning curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled


def comparison_figure(
    rows: Sequence[str], metrics: Mapping[str, Sequence[tuple[float, float, float]]]
) -> Figure:
    """Mean and interval of each metric, one row a model, one panel a metric.

    Args:
        rows: names of the models, from top to bottom.
        metrics: per panel label one (mean, low, high) per row; NaN where undefined.
    """
    with styled():
        figure = new_figure(PAGE_IN, 0.6 + 0.17 * len(rows))
        panels = np.atleast_1d(figure.subplots(1, len(metrics), sharey=True))
        places = np.arange(len(rows))[::-1]
        for panel, (label, values) in zip(panels, metrics.items(), strict=True):
            for place, (mean, low, high) in zip(places, values, strict=True):
                if np.isnan(mean):
                    panel.text(0.03, place, "–", va="center", transform=panel.get_yaxis_transform())
                    continue
                panel.plot([low, high], [place, place], color="0.55", lw=2.2)
                panel.plot([mean], [place], "o", color=COLOURS[0], ms=3.2)
            panel.set_xlabel(label)
            panel.grid(axis="y", color="0.92", lw=0.5)
        panels[0].set_yticks(places, rows)
        panels[0].set_ylim(-0.6, len(rows) - 0.4)
    return figure


def learning_curves_figure(curves: Mapping[str, np.ndarray], label: str) -> Figure:
    """Mean over seeds, and their range, of a measure per generation.

    Args:
        curves: per model an array of shape [generations, seeds].
        label: what is drawn, with its unit.
    """
    with styled():
        columns = 4
        lines = -(-len(curves) // columns)
        figure = new_figure(PAGE_IN, 0.5 + 1.15 * lines)
        panels = np.atleast_2d(figure.subplots(lines, columns, sharex=True, sharey=True))
        for panel, (name, values) in zip(panels.flat, curves.items(), strict=False):
            x = np.arange(len(values))
            panel.fill_between(x, values.min(axis=1), values.max(axis=1), color="0.8", lw=0)
            panel.plot(x, values.mean(axis=1), color=COLOURS[0])
            panel.set_title(name)
        for panel in list(panels.flat)[len(curves) :]:
            panel.set_visible(False)
        figure.supxlabel("generation", fontsize=8)
        figure.supylabel(label, fontsize=8)
    return figure
