"""Maps of a quantity over two others, in which what has no value says why."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.typing import ColorType

from tegotae.figures.style import SEQUENTIAL
from tegotae.measures.hopping.gait import (
    AT_REST,
    FAILED,
    REGIMES,
    UNSETTLED,
)
from tegotae.parts._shapes import AnyArray

_FILL = {AT_REST: "0.9", UNSETTLED: "white", FAILED: "black"}
_HATCH = {AT_REST: "/////", UNSETTLED: None, FAILED: None}
_HATCH_COLOUR = "0.55"


def quantities() -> Colormap:
    """The sequential colour map without its darkest part, which would pass for black."""
    colours = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.12, 1.0, 256))
    return LinearSegmentedColormap.from_list("quantities", colours)


def draw_regimes(axes: Axes, x: np.ndarray, y: np.ndarray, regime: AnyArray) -> None:
    """Colour the cells without limit cycle: hatched at rest, white unsettled, black failed.

    Args:
        x: values along the horizontal axis, shape [columns].
        y: values along the vertical axis, shape [rows].
        regime: indices into `REGIMES`, shape [rows, columns].
    """
    for kind, colour in _FILL.items():
        cells = np.ma.masked_where(regime != kind, np.ones(regime.shape))
        axes.pcolormesh(x, y, cells, cmap=ListedColormap([colour]), rasterized=True)
    rests = regime == AT_REST
    if rests.any():
        # Contours reach only to the middle of the outer cells.
        wide = np.pad(rests.astype(float), 1, mode="edge")
        hatched = axes.contourf(
            _outer(x), _outer(y), wide, levels=[0.5, 1.5], colors="none", hatches=[_HATCH[AT_REST]]
        )
        hatched.set(edgecolor=_HATCH_COLOUR, linewidth=0.0)
    axes.set(xlim=_edges(x), ylim=_edges(y))
    axes.spines[["top", "right"]].set_visible(True)


def draw_quantity(
    axes: Axes, x: np.ndarray, y: np.ndarray, value: AnyArray, regime: AnyArray, **how: Any
) -> QuadMesh:
    """Draw a quantity where there is a limit cycle, and elsewhere the regime; returns the mesh.

    Args:
        value: shape [rows, columns], NaN where undefined.
        how: limits and colours, as for matplotlib's `pcolormesh`.
    """
    draw_regimes(axes, x, y, regime)
    shown = np.ma.masked_where((regime <= UNSETTLED) | ~np.isfinite(value), value)
    how.setdefault("cmap", quantities())
    return axes.pcolormesh(x, y, shown, rasterized=True, **how)


def draw_categories(
    axes: Axes, x: np.ndarray, y: np.ndarray, category: np.ndarray, number: int
) -> list[tuple[float, float, float, float]]:
    """Colour the cells by category, in steps of lightness; returns the colours.

    Args:
        category: 0 ... number - 1, or -1 for none, shape [rows, columns].
        number: how many categories there are.
    """
    # The most common category first, in the middle of the scale; its neighbours far from it.
    steps = [0.5, 1.0, 0.0, 0.75, 0.25, 0.88][:number]
    colours = [quantities()(step) for step in steps]
    if number:
        cells = np.ma.masked_where(category < 0, category)
        mesh = axes.pcolormesh(x, y, cells, cmap=ListedColormap(colours), rasterized=True)
        mesh.set_clim(-0.5, number - 0.5)
    return colours


def category_patch(colour: ColorType, label: str) -> Patch:
    """A category's handle in the legend."""
    return Patch(facecolor=colour, edgecolor=_HATCH_COLOUR, lw=0.5, label=label)


def regime_legend(figure: Figure, present: AnyArray, *more: Artist, **how: Any) -> None:
    """Say below the panels what the colours without a value mean.

    Args:
        present: regimes that occur.
        more: further handles.
    """
    patches = [
        Patch(
            facecolor=_FILL[kind], hatch=_HATCH[kind], edgecolor=_HATCH_COLOUR, lw=0.5,
            label=REGIMES[kind],
        )
        for kind in (AT_REST, UNSETTLED, FAILED)
        if np.any(present == kind)
    ]  # fmt: skip
    handles = [*more, *patches]
    if handles:
        how.setdefault("ncols", 3)
        figure.legend(handles=handles, loc="outside lower center", handlelength=1.6, **how)


def _outer(x: np.ndarray) -> np.ndarray:
    """The values, and one more at the outer edge of either end."""
    low, high = _edges(x)
    return np.concatenate([[low], x, [high]])


def _edges(x: np.ndarray) -> tuple[float, float]:
    """The outer edges of cells centred at these values."""
    return float(x[0] - 0.5 * (x[1] - x[0])), float(x[-1] + 0.5 * (x[-1] - x[-2]))
