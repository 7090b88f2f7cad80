"""OutputOptions of a command: the printed result, and its files."""

from __future__ import annotations

import dataclasses
import json
import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tegotae.api.parameters import Option, hints_of, leaves
from tegotae.api.results import NUMBERS, Figure, Files, Recording, Table, check_new_file
from tegotae.cli.console import print_rows, print_text
from tegotae.cli.program import Command
from tegotae.systems.zoo import is_zoo_name, stem


@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Way of showing a result, and the files that are written."""

    json: bool = False
    """Print one JSON object."""
    csv: Path | None = None
    """Write the numbers (.csv, .parquet) or all of the result (.json)."""
    plot: Path | None = None
    """Write a figure (.png, .pdf, .svg); further figures and their tables go beside it."""
    out: Path | None = None
    """Folder for all figures, the numbers and the document."""
    animate: Path | None = None
    """Write an animation (.gif, .webp; .mp4 and .webm need ffmpeg)."""
    view: bool = False
    """Open MuJoCo's viewer, for a robot or another MuJoCo model."""

    def check(self, result_class: type[Table]) -> None:
        """Raise `TegotaeError` before long work for a file that cannot be written.

        Args:
            result_class: class of the result.
        """
        pictures = [self.plot]
        if self.csv is not None:
            check_new_file(self.csv, NUMBERS, replaces=True)
        if self.out is not None:
            if issubclass(result_class, Files):
                check_new_file(self.out, result_class.ENDINGS, replaces=result_class.REPLACES)
            elif self.out.suffix in NUMBERS:
                check_new_file(self.out, NUMBERS, replaces=True)
            elif self.out.suffix and not self.out.is_dir():
                pictures.append(self.out)
            else:
                check_new_file(self.out, ())
        for picture in filter(None, pictures):
            from tegotae.figures.style import figure_file

            figure_file(picture)
        if self.animate is not None:
            from tegotae.figures.animation import animation_file

            animation_file(self.animate)

    def with_default_file(self, command: Command, name: str) -> OutputOptions:
        """Return the same, with the usual file of a command if no other output is named."""
        if not command.out or self.json or self.csv or self.plot or self.out:
            return self
        return dataclasses.replace(self, out=Path(command.out.format(name=file_stem(name))))

    def show(self, result: Table) -> None:
        """Print a result, and then write its files: a picture may fail."""
        if self.json:
            print(json.dumps(result.to_dict(), allow_nan=False), flush=True)
        else:
            _print(result, self.out)
        paths = [] if self.csv is None else [*result.save(self.csv)]
        if self.plot is not None:
            result.plot(self.plot)
            paths.append(self.plot)
        if self.out is not None:
            paths += result.save(self.out)
        if self.animate is not None and isinstance(result, Recording):
            result.animate(self.animate)
            paths.append(self.animate)
        if self.view and isinstance(result, Recording):
            result.view()
        if paths and not self.json:
            print("wrote " + ", ".join(map(str, paths)))


def _print(result: Table, file: Path | None) -> None:
    if result.title:
        print(result.title)
    for table in result.texts():
        keys, cells = table.index.nlevels, table.reset_index()
        print_rows(map(str, cells.columns), cells.to_numpy(str), key=keys)
    ending = "" if file is None else file.suffix
    for note in result.notes:
        if ending in result.ENDINGS:
            note = note.replace(f"FILE{ending}", shlex.quote(str(file)))
        print_text(note)
    sys.stdout.flush()


def result_of(function: Callable[..., Any]) -> type[Table]:
    """Return the class of the result of a function."""
    return hints_of(function)["return"]


def output_options(command: Command) -> dict[str, Option]:
    """Return the options of `OutputOptions` that the result of a command has."""
    options = {
        option.name: dataclasses.replace(option, heading="") for option in leaves(OutputOptions())
    }
    result_class = result_of(command.load())
    if not command.pictures:
        del options["plot"]
    if not issubclass(result_class, Recording):
        del options["animate"], options["view"]
    contents = ""
    if endings := result_class.ENDINGS:
        contents = f"File of the result ({', '.join(endings)})."
    elif issubclass(result_class, Figure) and Path(command.out).suffix:
        contents = "Picture (.png, .pdf, .svg), its numbers beside it; or a folder for all."
    elif issubclass(result_class, Files):
        contents = "Folder for the files."
    if command.out:
        contents = (
            f"{contents or options['out'].description} Named after command and name by default."
        )
    if contents:
        options["out"] = dataclasses.replace(options["out"], description=contents)
    return options


_LONGEST_STEM = 80
"""Letters of a name that are a part of a file's name, which has few."""


def file_stem(name: str) -> str:
    r"""Return a name as a part of a file's name.

    Example:
        >>> file_stem("runs/art/ART-rF-w8-seed0.json"), file_stem("mine.py:hopper")
        ('ART-rF-w8-seed0', 'hopper')
        >>> file_stem("zoo:ART-rF-tphif-w8/3"), file_stem("zoo:AR-rF+range@go1.toml")
        ('ART-rF-tphif-w8-3', 'AR-rF+range-go1')
    """
    if is_zoo_name(name):
        name = stem(name)
    last = re.split(r"[/\\:]", name)[-1]
    plain = re.sub(r"\.(json|zip|onnx|py|toml|xml|csv|npz|parquet)$", "", last)
    return re.sub(r"[^\w.+-]+", "-", plain)[:_LONGEST_STEM].strip("-.")
