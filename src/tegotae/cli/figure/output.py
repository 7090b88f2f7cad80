"""What all figure commands write."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tegotae.cli.options import UNSET
from tegotae.systems.zoo import is_zoo_name, stem

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
    """Where a figure goes."""

    out: Annotated[Path | None, UNSET] = None
    """File of the figure (.png, .pdf or .svg); its numbers go beside it as .csv. By default the
    name is made of figure and controller, in the current folder."""

    def called(self) -> str:
        """What the figure is of, for the name of its file; nothing by default."""
        return ""

    @property
    def file(self) -> Path:
        """The file that is written, such as `surface-V-sector-w4.png`."""
        if self.out is not None:
            return self.out
        kind = type(self).__module__.rpartition(".")[2].replace("_", "-")
        return Path("-".join(filter(None, [kind, file_stem(self.called())])) + ".png")

    def check_out(self) -> None:
        """Raise `TegotaeError` before long work if the figure could not be written."""
        from tegotae.figures.style import figure_file

        figure_file(self.file)

    def write(self, figure: Figure, tables: Mapping[str, Table]) -> None:
        """Write the figure and its data, and say where."""
        from tegotae.figures.style import save_figure, write_tables

        written = [save_figure(figure, self.file), *write_tables(self.file, tables)]
        print("wrote " + ", ".join(map(str, written)))


def file_stem(name: str) -> str:
    """What something is called, as a part of a file's name.

    Example:
        >>> file_stem("runs/art/ART-rF-w8-seed0.json"), file_stem("mine.py:hopper")
        ('ART-rF-w8-seed0', 'hopper')
        >>> file_stem("zoo:ART-rF-tphif-w8/3")
        'ART-rF-tphif-w8-3'
    """
    if is_zoo_name(name):
        name = stem(name)
    last = re.split(r"[/\\\\:]", name)[-1]
    plain = re.sub(r"\.(json|zip|onnx|py)$", "", last)
    return re.sub(r"[^\w.@+-]+", "-", plain).strip("-.")
