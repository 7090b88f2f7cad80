"""Results: a table, the recording of one run, a figure with its numbers, or files.

All have the same members: `.table`, `.plot(path)`, `.save(path)`, `.to_dict()`.
"""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, ClassVar

import pandas as pd

from tegotae._support import tables
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder, output_file, write_atomically
from tegotae.measures.statistics import UNDEFINED

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure

    from tegotae.figures.animation import Animation
    from tegotae.figures.style import Table as Columns
else:  # matplotlib is slow to import
    MatplotlibFigure = Animation = Any

DIGITS = 9
"""Significant digits in a file: more than single precision has."""
NUMBERS = (".csv", ".parquet", ".json")
"""Endings of files of numbers."""


@dataclass(frozen=True, repr=False)
class Film:
    """Animation that a notebook shows."""

    content: bytes
    """GIF, or what the path says."""
    path: Path | None = None
    """Written file, if any."""

    def __repr__(self) -> str:
        return str(self.path or f"a film of {len(self.content)} bytes")

    def _repr_html_(self) -> str:
        content = b64encode(self.content).decode()
        suffix = ".gif" if self.path is None else self.path.suffix.lower()
        if suffix in (".mp4", ".webm"):
            return f'<video controls src="data:video/{suffix[1:]};base64,{content}"></video>'
        return f'<img src="data:image/{suffix[1:]};base64,{content}">'


@dataclass(frozen=True, repr=False, kw_only=True)
class Table:
    """Numbers, one row per run, metric or name, the text about them, and their figures."""

    ENDINGS: ClassVar[tuple[str, ...]] = ()
    """Endings of the file that `save` writes, if it writes one file only."""
    REPLACES: ClassVar[bool] = False
    """True if an existing file may be written over."""
    raw: Any = None
    """Result of the computation, such as a `tegotae.analysis.simulation.Result`."""
    title: str = ""
    """Outcome in a few words."""
    notes: Sequence[str] = ()
    """Sentences below the tables. The file of the result, whose name is not known yet, is in them
    FILE with its ending."""
    rows: Any = ()
    """Numbers: columns by name, or rows; or a function that makes them."""
    views: Sequence[pd.DataFrame] = ()
    """Tables for people; their index names the rows."""
    data: Any = None
    """Content of the document."""
    draw: Callable[[], Mapping[str, MatplotlibFigure]] | None = None
    """Function that draws the figures, by name."""
    figure_tables: Mapping[str, Columns] | Callable[[], Mapping[str, Columns]] = field(
        default_factory=dict
    )
    """Tables that are written beside a picture, by name; "" is the main one."""

    @property
    def table(self) -> pd.DataFrame:
        """Numbers, one row per run or sample."""
        rows = self.rows() if callable(self.rows) else self.rows
        return pd.DataFrame(dict(rows) if isinstance(rows, Mapping) else rows)

    def texts(self) -> list[pd.DataFrame]:
        """Return the tables for people; their index names the rows."""
        return [*self.views]

    def to_dict(self) -> JsonObject:
        """Return all as JSON values: null for an undefined number."""
        return as_json(self.data)

    def figures(self) -> Mapping[str, MatplotlibFigure]:
        """Draw the figures, by name, the most telling one first."""
        return {} if self.draw is None else self.draw()

    def plot(self, path: Path | str | None = None) -> MatplotlibFigure:
        """Draw the figure, and write it to a file (.png, .pdf, .svg) if there is a path.

        Args:
            path: the file; further figures and the figure's tables go beside it.

        Raises:
            TegotaeError: for a result without figures, another ending, or a file that cannot be
                written.
        """
        return self._plotted(path)[0]

    def _plotted(self, path: Path | str | None) -> tuple[MatplotlibFigure, list[Path]]:
        from tegotae.figures.style import save_figure, write_tables

        figures = self.figures()
        if not figures:
            raise TegotaeError("there is no picture of this; its numbers can be written")
        first, paths = next(iter(figures)), []
        if path is not None:
            path = Path(path)
            for name, figure in figures.items():
                sibling = path.with_name(f"{path.stem}-{name}{path.suffix}")
                paths.append(save_figure(figure, path if name == first else sibling))
            paths += write_tables(path, self._tables())
        return figures[first], paths

    def _tables(self) -> Mapping[str, Columns]:
        return self.figure_tables() if callable(self.figure_tables) else self.figure_tables

    def save(self, path: Path | str) -> list[Path]:
        """Write a file or a folder; the ending decides.

        Args:
            path: a file of numbers (.csv, .parquet), the whole document (.json), a picture (.png,
                .pdf, .svg), or a folder for all of it.

        Raises:
            TegotaeError: for another ending, or if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".json":
            write_atomically(path, json.dumps(self.to_dict(), allow_nan=False) + "\n")
        elif path.suffix == ".parquet":
            tables.write_parquet(path, dict(self.table))
        elif path.suffix == ".csv":
            tables.write_csv(path, dict(self.table), digits=DIGITS)
        elif path.suffix and not path.is_dir():
            return self._plotted(path)[1]
        else:
            return self._fill(path)
        return [path]

    def _fill(self, folder: Path) -> list[Path]:
        """Write figures, numbers and document into a folder."""
        from tegotae.figures.style import save_figure

        drawn = [save_figure(x, folder / f"{name}.png") for name, x in self.figures().items()]
        return [
            *drawn,
            *(path for x in ("csv", "json") for path in self.save(folder / f"numbers.{x}")),
        ]

    def __repr__(self) -> str:
        parts = [text.reset_index().to_string(index=False) for text in self.texts()]
        return "\n".join(filter(None, [self.title, *parts, *self.notes]))

    def _repr_html_(self) -> str:
        notes = (f"<p>{escape(note)}</p>" for note in self.notes)
        parts = [text.reset_index().to_html(index=False, border=0) for text in self.texts()]
        title = escape(self.title).replace("\n", "<br>")
        return "".join([f"<b>{title}</b>" if title else "", *parts, *notes])


@dataclass(frozen=True, repr=False, kw_only=True)
class Recording(Table):
    """Recording of one rollout. Its table is the time series; `raw` is the simulator's result."""

    name: str
    """Name of the controller."""
    numbers: Mapping[str, Any]
    headings: Mapping[str, str]
    """Numbers that the screen shows, with their headings."""
    settings: Mapping[str, Any]
    """Options of the rollout."""
    limbs: pd.DataFrame | None = None
    """Numbers of each limb."""
    film: Callable[[], Animation]
    """Function that makes the animation."""
    window: Callable[[], None] | None = None
    """Function that opens a viewer, of a MuJoCo model."""

    def texts(self) -> list[pd.DataFrame]:
        values = [(heading, self.numbers.get(x)) for x, heading in self.headings.items()]
        entries = [(heading, number) for heading, number in values if number is not None]
        numbers = pd.DataFrame(entries, columns=["quantity", "value"])
        texts = [frame.map(short) for frame in (self.limbs, numbers) if frame is not None]
        return [frame.set_index(frame.columns[0]) for frame in texts if len(frame)]

    def to_dict(self) -> JsonObject:
        header = {"name": self.name, "outcome": self.title, "settings": self.settings}
        return as_json({**header, **self.numbers})

    def view(self) -> None:
        """Show the rollout in MuJoCo's viewer until its window is closed.

        Raises:
            TegotaeError: for another body than a MuJoCo model, or without a screen.
        """
        if self.window is None:
            raise TegotaeError(
                f"{self.name} is on no MuJoCo model, which a viewer shows; use --animate hop.gif"
            )
        self.window()

    def animate(self, path: Path | str | None = None) -> Film:
        """Make an animation, and write it to a file if there is a path.

        Args:
            path: the file (.gif; of one leg also .webp, and .mp4 and .webm, which need ffmpeg).

        Raises:
            TegotaeError: for another ending, or a file that cannot be written.
        """
        from tegotae.figures.animation import write_animation

        if path is not None:
            written_path = write_animation(self.film, path)
            return Film(written_path.read_bytes(), written_path)
        with TemporaryDirectory() as folder:
            return Film(write_animation(self.film, Path(folder) / "film.gif").read_bytes())


@dataclass(frozen=True, repr=False, kw_only=True)
class Figure(Table):
    """Figure, and the numbers that it shows; its table is the main one of `figure_tables`."""

    settings: Mapping[str, Any]
    """Options of the figure."""

    @property
    def table(self) -> pd.DataFrame:
        return pd.DataFrame(dict(self._tables()[""]))

    def to_dict(self) -> JsonObject:
        header = {"outcome": self.title, "remarks": self.notes}
        return as_json({"settings": self.settings, **header, **(self.data or {})})

    def save(self, path: Path | str) -> list[Path]:
        """Write a file or a folder; the ending decides.

        Args:
            path: a picture (.png, .pdf, .svg), with its tables and its document beside it; a file
                of numbers (.csv, .parquet), the document (.json), or a folder for all of it.

        Raises:
            TegotaeError: for another ending, or if it cannot be written.
        """
        path, paths = Path(path), super().save(path)
        if path.suffix and not path.is_dir() and path.suffix not in NUMBERS:
            paths += super().save(path.with_suffix(".json"))
        return paths


@dataclass(frozen=True, repr=False, kw_only=True)
class Files(Table):
    """Files in memory until they are saved."""

    write: Callable[[Path], Sequence[Path] | None]
    """Function that writes the one file of a name, or several, which it returns, into a folder."""
    files: Mapping[str, str] = field(default_factory=dict)
    """Texts by their paths in a folder, where they are texts."""

    def save(self, path: Path | str) -> list[Path]:
        """Write the file of this name, or into the folder of this name.

        Args:
            path: the file or the folder; a file of numbers (.csv) or the document (.json) where
                the files themselves have other endings.

        Raises:
            TegotaeError: for another ending, or if it is there already or cannot be written.
        """
        path = Path(path)
        if path.suffix in NUMBERS and path.suffix not in self.ENDINGS:
            return super().save(path)
        check_new_file(path, self.ENDINGS, replaces=self.REPLACES)
        return [*(self.write(path) or [path])]


@dataclass(frozen=True, repr=False, kw_only=True)
class TomlFile(Files):
    """File of TOML, in memory until it is saved."""

    ENDINGS = (".toml",)


@dataclass(frozen=True, repr=False, kw_only=True)
class JsonFile(Files):
    """File of JSON, in memory until it is saved."""

    ENDINGS = (".json",)


def check_new_file(path: Path | str, endings: Sequence[str], *, replaces: bool = False) -> None:
    """Raise `TegotaeError` before long work for a file that cannot be written.

    Args:
        path: the file, or a folder if there are no endings.
        endings: endings that the file may have.
        replaces: True if an existing file may be written over.
    """
    path = Path(path)
    if not endings:
        check_folder(path)
        return
    if path.suffix not in endings:
        raise TegotaeError(f"{path} must end in {' or '.join(endings)}")
    output_file(path)
    if path.exists() and not replaces:
        raise TegotaeError(f"{path} exists already; name another file with --out")


def short(value: Any) -> str:
    """Return a cell of a table for people: a number, a text, or several of them.

    Example:
        >>> short(0.123456), short((1.0, math.nan)), short([]), short(None)
        ('0.1235', '1, –', '-', '–')
    """
    if value is None or isinstance(value, float):
        return UNDEFINED if value is None or math.isnan(value) else f"{value:.4g}"
    if isinstance(value, Iterable) and not isinstance(value, str):
        return ", ".join(map(short, value)) or "-"
    return str(value)
