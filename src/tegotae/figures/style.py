"""The style of all figures, and the tables beside them."""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from cycler import cycler
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_file, write_atomically
from tegotae._support.tables import write_csv
from tegotae.parts._shapes import AnyArray

COLUMN_IN = 3.5
"""Width of one column [in]."""
PAGE_IN = 7.16
"""Width of a page of two columns [in]."""

# Okabe and Ito's colours; of the first five neighbours also differ in lightness.
COLOURS = ("#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#009E73", "#CC79A7", "#F0E442")
"""Line colours."""
SEQUENTIAL = "viridis"
"""Colour map of quantities: monotonic in lightness."""
_INLINE_DPI = 110
"""Resolution of figures in a notebook [dots per inch]."""

STYLE: Any = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "hatch.linewidth": 0.4,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "axes.prop_cycle": cycler(color=list(COLOURS)),
}


class _InlineFigure(Figure):
    """A figure that a notebook shows, whether or not the program uses pyplot."""

    def __repr__(self) -> str:
        return f"a figure of {self.get_figwidth():g} by {self.get_figheight():g} in"

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        with styled():
            self.savefig(stream, format="png", dpi=_INLINE_DPI)
        return stream.getvalue()


def new_figure(width_in: float = COLUMN_IN, height_in: float = 2.4, **layout: Any) -> Figure:
    """Return an empty figure with a constrained layout, without a window."""
    return _InlineFigure(figsize=(width_in, height_in), layout="constrained", **layout)


styled = partial(matplotlib.rc_context, STYLE)
"""Context or decorator that gives the package's style to the figures made and saved within."""


def literal_text(name: str) -> str:
    r"""Return a name as figure text, where `$` is a plain sign and begins no formula.

    Example:
        >>> print(literal_text("cost_$5"))
        cost_\$5
    """
    printable = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name)
    return printable.replace("$", r"\$")


def figure_file(path: Path | str) -> Path:
    """Return the path of a figure to be written, after a check of its ending and folder.

    Raises:
        TegotaeError: if the format is unknown, or the folder cannot be written to.
    """
    path = Path(path)
    ending = path.suffix.lstrip(".").lower()
    if ending not in FigureCanvasBase.get_supported_filetypes().keys() - {"pgf"}:  # needs TeX
        raise TegotaeError(
            f"cannot write a figure as {path.name!r}; use an ending such as .png, .pdf or .svg"
        )
    return output_file(path)


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Write a figure, whole or not at all; the file's ending says in which format.

    Raises:
        TegotaeError: if the format is unknown or the file cannot be written.
    """
    path = figure_file(path)
    stream = io.BytesIO()
    with styled(), warnings.catch_warnings():
        # A name may have letters that the font lacks; it then has boxes in their place.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(stream, format=path.suffix.lstrip(".").lower())
    write_atomically(path, stream.getvalue())
    return path


Table = pd.DataFrame | Mapping[str, ArrayLike]
"""Columns by name."""


def long_table(
    rows: tuple[str, np.ndarray], columns: tuple[str, np.ndarray], maps: Mapping[str, AnyArray]
) -> pd.DataFrame:
    """Return maps over two axes as a table with one row per cell.

    Args:
        rows: name and values of the first axis.
        columns: name and values of the second.
        maps: arrays of shape [rows, columns].
    """
    (first, along), (second, across) = rows, columns
    cells = pd.MultiIndex.from_product([along, across], names=[first, second])
    return pd.DataFrame({name: np.ravel(x) for name, x in maps.items()}, cells).reset_index()


def write_tables(figure: Path, tables: Mapping[str, Table]) -> list[Path]:
    """Write tables as CSV beside a figure; undefined values are left empty.

    Args:
        figure: the figure's path, such as `map.png`.
        tables: by name; the one named "" becomes `map.csv`, others `map.NAME.csv`.

    Raises:
        TegotaeError: if a file cannot be written.
    """
    paths = []
    for name, table in tables.items():
        path = figure.with_suffix(f".{name}.csv" if name else ".csv")
        write_csv(path, dict(pd.DataFrame(dict(table))), digits=9)
        paths.append(path)
    return paths
