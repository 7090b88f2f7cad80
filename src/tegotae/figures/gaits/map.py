"""Maps of gaits over two parameters: which gait, where starts disagree, and what it costs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.gaits.map import NO_BODY, Cells, GaitMap
from tegotae.figures.gaits.colours import HATCHES, THIN, by_side, gait_colour
from tegotae.figures.gaits.labels import label
from tegotae.figures.maps import quantities
from tegotae.figures.style import PAGE_IN, new_figure, styled
from tegotae.measures.gaits.names import (
    AS_RELEASED,
    NO_GAIT,
    NOT_LOCKED,
    STANDING,
)

_PALE = 0.55
"""How far towards white the colour of a cell is whose starts disagree."""
_COMMON = 0.002
"""Share of the cells below which a gait is not in the legend."""


def map_figure(found: GaitMap, note: str = "") -> Figure:
    """The gait of most starts, pale where they disagree; one lag of it; and its cost of transport.

    The lag is that of the next leg on the reference leg's side: of four legs the fore leg's behind
    the hind one's. Of a body that does not travel, the time to lock is in the cost's place.

    Args:
        found: the map.
        note: the title.
    """
    cells = found.cells
    with styled():
        figure = new_figure(PAGE_IN, 3.1)
        gaits, lag, cost = figure.subplots(1, 3, sharex=True, sharey=True)
        _gaits(figure, gaits, found, cells)
        gaits.set_title(note, loc="left")
        _lag(figure, lag, found, cells)
        _quantity(figure, cost, found, cells)
        gaits.set_ylabel(label(found.y, found.legged))
        for axes in (gaits, lag, cost):
            axes.set_xlabel(label(found.x, found.legged))
            axes.spines[["top", "right"]].set_visible(True)
            axes.set_facecolor("0.92")
    return figure


def _gaits(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    colours = np.array([_rgb(name) for name in cells.gait.ravel()]).reshape(*cells.gait.shape, 3)
    split = (cells.share < 1.0)[..., None]
    shown = np.where(split, colours + _PALE * (1.0 - colours), colours)
    axes.pcolormesh(*_grid(found), shown, rasterized=True)
    for name, hatch in HATCHES.items():
        if (cells.gait == name).sum() > 1 and min(cells.gait.shape) > 1:
            inside = (cells.gait == name).astype(float)
            area = axes.contourf(*_grid(found), inside, (0.5, 1.5), hatches=[hatch], colors="none")
            area.set(**THIN)
    names, counts = np.unique(cells.gait, return_counts=True)
    listed = [
        str(names[i])
        for i in np.lexsort((-counts, np.isin(names, (*NO_GAIT, NO_BODY))))
        if counts[i] >= _COMMON * cells.gait.size
    ]
    handles = [
        Patch(facecolor=_rgb(n), edgecolor="0.4", lw=0.4, label=n, hatch=HATCHES.get(n), **THIN)
        for n in listed
    ]
    if split.any():
        handles.append(Patch(fill=False, lw=0, label="(pale where starts disagree)"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=1.2)


def _lag(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    names, reference = found.legged.names, found.legged.reference
    order = by_side(names)
    leg = order[(order.index(reference) + 1) % len(order)]
    # Lags of what does not lock, or of starts that only share a name, would say nothing.
    locked = ~np.isin(cells.gait, (NOT_LOCKED, STANDING, AS_RELEASED))
    values = np.ma.masked_invalid(np.where(locked, cells.lag[..., leg], np.nan))
    mesh = axes.pcolormesh(*_grid(found), values, cmap="twilight", vmin=0, vmax=1, rasterized=True)
    bar = figure.colorbar(mesh, ax=axes, location="top", aspect=30, ticks=np.linspace(0, 1, 5))
    bar.set_label(f"lag of {names[leg]} behind {names[reference]} [cycles]")


def _quantity(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    travels = np.isfinite(cells.cost_of_transport).any()
    values = cells.cost_of_transport if travels else cells.lock_time_s
    known = values[np.isfinite(values)]
    # A body that hardly moves has any cost: the scale ends where nine tenths of the cells do.
    low, high = np.quantile(known, (0.0, 0.9)) if known.size else (0.0, 1.0)
    mesh = axes.pcolormesh(
        *_grid(found),
        np.ma.masked_invalid(values),
        cmap=quantities(),
        vmin=low,
        vmax=high,
        rasterized=True,
    )
    what = "cost of transport" if travels else f"time to lock [{found.legged.units[1]}]"
    figure.colorbar(mesh, ax=axes, location="top", aspect=30, label=what, extend="max")


def _grid(found: GaitMap) -> tuple[np.ndarray, np.ndarray]:
    return np.array(found.x.values), np.array(found.y.values)


def _rgb(name: str) -> tuple[float, float, float]:
    return to_rgb("#FFFFFF" if name == NO_BODY else gait_colour(name))
