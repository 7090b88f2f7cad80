"""Output files of the study's figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tegotae.figures.style import Table


@dataclass(frozen=True, kw_only=True)
class PictureFormat:
    """The format of pictures that have names of their own."""

    format: Literal["png", "svg", "pdf"] = "png"
    """Format of the pictures."""


@dataclass(frozen=True, kw_only=True)
class Output:
    """Destination of a figure."""

    out: Path | None = None
    """File of the figure (.png, .pdf or .svg); its numbers go beside it as .csv. By default the
    name is that of the command, in the current folder."""

    @property
    def file(self) -> Path:
        """The file that is written, such as `gain-map.png`."""
        kind = type(self).__module__.rpartition(".")[2].replace("_", "-")
        return Path(f"{kind}.png") if self.out is None else self.out

    def check_out(self) -> None:
        """Raise `TegotaeError` before long work if the figure could not be written."""
        from tegotae.figures.style import figure_file

        figure_file(self.file)

    def write(self, figure: Figure, tables: Mapping[str, Table]) -> None:
        """Write the figure and its data, and say where."""
        from tegotae.figures.style import save_figure, write_tables

        paths = [save_figure(figure, self.file), *write_tables(self.file, tables)]
        print("wrote " + ", ".join(map(str, paths)))
