"""What all figure commands write."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Output:
    """Where a figure goes."""

    out: Path
    """The figure's file (.png, .pdf or .svg); what it shows goes beside it as .csv."""

    def check_out(self) -> None:
        """Raise `TegotaeError` before long work if the figure could not be written."""
        from tegotae.figures.style import figure_file

        figure_file(self.out)

    def write(self, figure: Figure, tables: Mapping[str, Mapping[str, Any]]) -> None:
        """Write the figure and its data, and say where."""
        from tegotae.figures.data import write_tables
        from tegotae.figures.style import save_figure

        written = [save_figure(figure, self.out), *write_tables(self.out, tables)]
        print("wrote " + ", ".join(map(str, written)))
