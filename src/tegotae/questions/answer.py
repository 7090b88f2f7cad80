"""Answers: a table of runs with its summary, or the recording of one run.

All are shown, drawn and written by the same words: `print(x)`, `x.plot()`, `x.save(folder)`.
"""

from __future__ import annotations

import dataclasses
import json
import math
from base64 import b64encode
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pandas as pd

from tegotae._support import tables
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder, output_file, write_atomically
from tegotae.measures.hopping import statistics
from tegotae.measures.hopping.statistics import UNDEFINED, Interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tegotae.figures.style import Table

DIGITS = 9
"""Significant digits of what is written: more than single precision has."""


@dataclass(frozen=True)
class Column:
    """A measured quantity: its name in files, and how people read it."""

    name: str
    label: str
    unit: str = ""
    range: statistics.Range = statistics.UNBOUNDED
    """Least and largest possible value."""
    more_is_better: bool | None = None
    shown: bool = True
    """On the screen; files have all."""

    @property
    def heading(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


def columns(*rows: tuple[Any, ...]) -> tuple[Column, ...]:
    """Columns, each by the arguments of `Column`."""
    return tuple(Column(*row) for row in rows)


@dataclass(frozen=True, repr=False)
class Film:
    """An animation, which a notebook shows."""

    content: bytes
    """A GIF, or an MP4 where its path says so."""
    path: Path | None = None
    """The file that was written, if any."""

    def __repr__(self) -> str:
        return str(self.path or f"a film of {len(self.content)} bytes")

    def _repr_html_(self) -> str:
        content = b64encode(self.content).decode()
        if self.path is not None and self.path.suffix == ".mp4":
            return f'<video controls src="data:video/mp4;base64,{content}"></video>'
        return f'<img src="data:image/gif;base64,{content}">'


class AnswerBase:
    """What a question gives."""

    ENDING: ClassVar[str] = ""
    """Of the one file that `save` writes, if it is not a folder."""

    @classmethod
    def check_file(cls, file: Path) -> None:
        """Raise `TegotaeError` before long work for a file or a folder that cannot be written."""
        (output_file if cls.ENDING else check_folder)(file)

    @property
    def title(self) -> str:
        """The outcome in a few words."""
        return ""

    def frame(self) -> pd.DataFrame:
        """The numbers, a row a run or a sample."""
        raise NotImplementedError

    def texts(self) -> list[pd.DataFrame]:
        """Tables as people read them; their index names the rows."""
        raise NotImplementedError

    @property
    def notes(self) -> list[str]:
        """Sentences below the tables."""
        return []

    def document(self) -> JsonObject:
        """All as JSON values: null for what is undefined."""
        raise NotImplementedError

    def figures(self) -> dict[str, Figure]:
        """Pictures by name, the most telling one first; none by default."""
        return {}

    def plot(self, path: Path | str | None = None) -> Figure:
        """The picture, written to a file (.png, .pdf, .svg) if one is named; others go beside it.

        Raises:
            TegotaeError: for an answer without pictures, another ending, or a file that cannot be
                written.
        """
        from tegotae.figures.style import save_figure

        figures = self.figures()
        if not figures:
            raise TegotaeError("there is no picture of this; its numbers can be written")
        first = next(iter(figures))
        if path is not None:
            path = Path(path)
            for name, figure in figures.items():
                beside = path.with_name(f"{path.stem}-{name}{path.suffix}")
                save_figure(figure, path if name == first else beside)
        return figures[first]

    def write(self, path: Path | str) -> Path:
        """Write the numbers (.csv, .parquet), or all as a document (.json).

        Raises:
            TegotaeError: if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".json":
            write_atomically(path, json.dumps(self.document(), allow_nan=False) + "\n")
        elif path.suffix == ".parquet":
            tables.write_parquet(path, dict(self.frame()))
        else:
            tables.write_csv(path, dict(self.frame()), digits=DIGITS)
        return path

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Write pictures, numbers and document into a folder.

        Args:
            folder: made if it is not there.
            format: of the pictures, png, svg or pdf.

        Raises:
            TegotaeError: if it cannot be written.
        """
        from tegotae.figures.style import save_figure

        folder = Path(folder)
        written = [
            save_figure(x, folder / f"{name}.{format}") for name, x in self.figures().items()
        ]
        return [*written, *(self.write(folder / f"numbers.{x}") for x in ("csv", "json"))]

    def __repr__(self) -> str:
        parts = [text.reset_index().to_string(index=False) for text in self.texts()]
        return "\n".join(filter(None, [self.title, *parts, *self.notes]))

    def _repr_html_(self) -> str:
        said = (f"<p>{escape(note)}</p>" for note in self.notes)
        parts = [text.reset_index().to_html(index=False, border=0) for text in self.texts()]
        title = escape(self.title).replace("\n", "<br>")
        return "".join([f"<b>{title}</b>" if title else "", *parts, *said])


def check_output(path: Path | None, *endings: str) -> None:
    """Raise `TegotaeError` before long work if a file could not be written.

    Args:
        path: the file, if one is asked for.
        endings: that it may have.
    """
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise TegotaeError(f"cannot write {str(path)!r}; the name ends in {' or '.join(endings)}")
    output_file(path)


@dataclass(frozen=True, repr=False, kw_only=True)
class TableAnswer(AnswerBase):
    """An answer that is a table, and what is said of it."""

    raw: Any = None
    """What it was made from, such as a `tegotae.systems.simulation.Result`."""
    outcome: str = ""
    """In a few words."""
    remarks: Sequence[str] = ()
    """Sentences below the tables."""
    table: Any = ()
    """The numbers: columns by name, or rows; or a function that makes them."""
    shown: Sequence[pd.DataFrame] = ()
    """Tables as people read them; their index names the rows."""
    data: Any = None
    """What the document says."""

    @property
    def title(self) -> str:
        return self.outcome

    @property
    def notes(self) -> list[str]:
        return [*self.remarks]

    def frame(self) -> pd.DataFrame:
        """The numbers."""
        table = self.table() if callable(self.table) else self.table
        return pd.DataFrame(dict(table) if isinstance(table, Mapping) else table)

    def texts(self) -> list[pd.DataFrame]:
        return [*self.shown]

    def document(self) -> JsonObject:
        return as_json(self.data)


@dataclass(frozen=True, repr=False, kw_only=True)
class DrawnAnswer(TableAnswer):
    """A table with pictures."""

    drawn: Callable[[], dict[str, Figure]]
    """Draws them, by name."""

    def figures(self) -> dict[str, Figure]:
        return self.drawn()


@dataclass(frozen=True, repr=False, kw_only=True)
class RecordedRun(TableAnswer):
    """One run, closely. `raw`, what the simulator gave, chooses the figures
    (`tegotae.questions.pictures`), and `table` is the time series."""

    name: str
    """Of the controller."""
    numbers: Mapping[str, Any]
    columns: tuple[Column, ...]
    """Which of the numbers are shown."""
    settings: Any
    """The options."""
    limbs: pd.DataFrame | None = None
    """What is known of each limb."""

    def texts(self) -> list[pd.DataFrame]:
        known = [(c.heading, self.numbers.get(c.name)) for c in self.columns]
        shown = [(heading, number) for heading, number in known if number is not None]
        numbers = pd.DataFrame(shown, columns=["quantity", "value"])
        made = [frame.map(short) for frame in (self.limbs, numbers) if frame is not None]
        return [frame.set_index(frame.columns[0]) for frame in made if len(frame)]

    def document(self) -> JsonObject:
        settings = dataclasses.asdict(self.settings)
        about = {"name": self.name, "outcome": self.outcome, "settings": settings}
        return as_json({**about, **self.numbers})

    def figures(self) -> dict[str, Figure]:
        from tegotae.questions.pictures import figures

        return figures(self.raw, f"{self.name}: {self.outcome}")

    def animate(self, path: Path | str | None = None) -> Film:
        """Make an animation, and write it to a file (.gif; of one leg also .mp4, which needs
        ffmpeg) if one is named.

        Raises:
            TegotaeError: for another ending, or a file that cannot be written.
        """
        from tegotae.questions.pictures import animate

        if path is not None:
            written = animate(self.raw, Path(path))
            return Film(written.read_bytes(), written)
        with TemporaryDirectory() as folder:
            return Film(animate(self.raw, Path(folder) / "film.gif").read_bytes())


@dataclass(frozen=True, repr=False, kw_only=True)
class Picture(TableAnswer):
    """A figure, and the numbers that it shows."""

    ENDING = ".png"

    drawn: Callable[[], Figure]
    """Draws it."""
    tables: Mapping[str, Table]
    """What the figure shows: the main table, named "", and others."""
    settings: Any
    """The options."""

    def document(self) -> JsonObject:
        """The settings, and what was found; the tables are files of their own."""
        said = {"outcome": self.outcome, "remarks": self.remarks}
        return as_json({"settings": dataclasses.asdict(self.settings), **said, **(self.data or {})})

    def frame(self) -> pd.DataFrame:
        """The main table of what the figure shows."""
        return pd.DataFrame(dict(self.tables[""]))

    def figures(self) -> dict[str, Figure]:
        return {"figure": self.drawn()}

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Write the picture as the file of this name, and beside it its tables and its document."""
        from tegotae.figures.style import save_figure, write_tables

        file = Path(folder)
        written = [save_figure(self.plot(), file), *write_tables(file, self.tables)]
        return [*written, self.write(file.with_suffix(".json"))]


def short(value: Any) -> str:
    """A cell of a table as people read it."""
    if isinstance(value, float):
        return UNDEFINED if math.isnan(value) else f"{value:.4g}"
    return str(value)


@dataclass(frozen=True, repr=False)
class Answer(AnswerBase):
    """What was measured of runs, and its mean over them."""

    table: pd.DataFrame
    """Rows named by `controller`, `run` and more, such as the frequency or the start."""
    columns: tuple[Column, ...]
    """What was measured."""
    groups: tuple[str, ...] = ("controller",)
    """Name a row of the summary. Runs are independent; over all else, such as starts, the mean of a
    run is taken first."""
    trained: Mapping[str, Hashable] = field(default_factory=dict)
    """Of each controller all that decides what its training drew, None if that is not known: where
    it is equal, runs are paired."""
    exact: frozenset[str] = frozenset()
    """Controllers that no other run would differ from, as a search finds them."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """The options of each controller."""
    remarks: tuple[str, ...] = ()
    base: str = ""
    """The controller that others are compared with, if any."""

    @classmethod
    def joined(cls, answers: Sequence[Answer]) -> Answer:
        """One of several answers to the same question."""
        return dataclasses.replace(
            answers[0],
            table=pd.concat([answer.table for answer in answers], ignore_index=True),
            columns=tuple({c.name: c for answer in answers for c in answer.columns}.values()),
            trained={name: x for answer in answers for name, x in answer.trained.items()},
            exact=frozenset[str]().union(*(answer.exact for answer in answers)),
            settings={name: x for answer in answers for name, x in answer.settings.items()},
        )

    def frame(self) -> pd.DataFrame:
        """The table."""
        return self.table

    def summary(self) -> pd.DataFrame:
        """Mean over runs of each column with its 95 % interval; of texts, the commonest ones."""
        groups = self._grouped()
        cells = {c.name: [_mean(c, rows) for rows in groups.values()] for c in self.columns}
        runs = [rows["run"].nunique() for rows in groups.values()]
        return self._indexed(list(groups), {"runs": runs, **cells})

    def differences(self) -> pd.DataFrame:
        """Each controller minus the base at equal other groups, run by run where these are paired.

        Raises:
            TegotaeError: if nothing can be compared with the base.
        """
        groups = self._grouped()
        pairs = {
            key: (rows, groups[self.base, *key[1:]])
            for key, rows in groups.items()
            if key[0] != self.base and (self.base, *key[1:]) in groups
        }
        if not pairs:
            raise TegotaeError(f"nothing compares with {self.base}: no frequency is the same")
        how = [self._compared_as(key[0], rows) for key, (rows, _) in pairs.items()]
        numeric = [c for c in self.columns if self.table[c.name].dtype.kind in "fi"]
        cells = {
            c.name: [_difference(c, *p, kind) for p, kind in zip(pairs.values(), how, strict=True)]
            for c in numeric
        }
        return self._indexed(list(pairs), {"runs": how, **cells})

    def texts(self) -> list[pd.DataFrame]:
        tables = [self._texts(self.summary(), better=False)]
        if self.base:
            more = self._texts(self.differences(), better=True)
            tables.append(more.rename_axis(index={"controller": f"minus {self.base}"}))
        return tables

    @property
    def notes(self) -> list[str]:
        more = [] if not self.base else COMPARED
        if self.base and self.exact:
            more = [*more, EXACTLY]
        return [*self.remarks, *more]

    def document(self) -> JsonObject:
        settings = {name: dataclasses.asdict(x) for name, x in self.settings.items()}
        document = {"settings": settings, "rows": self.table.to_dict("records")}
        document["summary"] = self.summary().reset_index().to_dict("records")
        if self.base:
            rows = self.differences().reset_index().assign(minus=self.base)
            document["differences"] = rows.to_dict("records")
        return as_json(document)

    def figures(self) -> dict[str, Figure]:
        from tegotae.figures.intervals import intervals_figure

        shown = [c for c in self.columns if c.shown and self.table[c.name].dtype.kind in "fi"]
        frame = self.summary()
        names = [", ".join(map(short, key)) for key in frame.index]
        return {"intervals": intervals_figure(names, {c.heading: frame[c.name] for c in shown})}

    def _grouped(self) -> dict[tuple[Any, ...], pd.DataFrame]:
        rows = self.table.groupby(list(self.groups), sort=False, dropna=False)
        return {tuple(None if pd.isna(x) else x for x in key): part for key, part in rows}  # type: ignore[attr-defined]

    def _indexed(self, keys: list[tuple[Any, ...]], cells: Mapping[str, Any]) -> pd.DataFrame:
        index = pd.MultiIndex.from_tuples(keys, names=self.groups)
        return pd.DataFrame({name: pd.Series(x, index, object) for name, x in cells.items()})

    def _compared_as(self, name: str, rows: pd.DataFrame) -> str:
        ours, theirs = self.trained.get(name), self.trained.get(self.base)
        if ours is not None and ours == theirs and len(rows["run"].unique()) > 1:
            return PAIRED
        return EXACT if {name, self.base} & self.exact else INDEPENDENT

    def _texts(self, frame: pd.DataFrame, *, better: bool) -> pd.DataFrame:
        shown = [column for column in self.columns if column.shown and column.name in frame]
        cells = {c.heading: [_shown(c, cell, better) for cell in frame[c.name]] for c in shown}
        how = [str(runs) for runs in frame["runs"]]
        if better:
            methods = frame[[column.name for column in shown]].map(lambda cell: cell.method)
            used = [" and ".join(dict.fromkeys(filter(None, row))) for row in methods.to_numpy()]
            how = [f"{runs}, {row or 'no interval'}" for runs, row in zip(how, used, strict=True)]
        keys = [frame.index.get_level_values(name).map(short) for name in frame.index.names]
        whole = {"interval" if better else "runs": how, **cells}
        return pd.DataFrame(whole, index=pd.MultiIndex.from_arrays(keys, names=frame.index.names))


PAIRED, INDEPENDENT, EXACT = "paired runs", "independent runs", "one run is exact"
"""How two sets of runs are compared."""
COMPARED = [
    "+ is better and - is worse, where the interval of the difference leaves zero out.",
    "Runs are paired, seed by seed, where they share what is random: controller, algorithm and "
    "conditions.",
]
EXACTLY = (
    "A gain that a search found is exact: no other run would differ. Against it the interval is "
    "that of the other runs alone; between two exact ones there is none."
)


def _of_runs(column: Column, rows: pd.DataFrame) -> np.ndarray:
    """Of every run the mean over its rows, [runs]."""
    runs = [run.to_numpy(float)[None] for _, run in rows.groupby("run", sort=False)[column.name]]
    return np.array([statistics.mean_defined(values)[0] for values in runs])


def _mean(column: Column, rows: pd.DataFrame) -> Interval | str:
    if rows[column.name].dtype.kind not in "fi":
        counts = Counter(rows[column.name]).most_common()
        return ", ".join(f"{value} ({count})" for value, count in counts)
    return statistics.interval(_of_runs(column, rows), within=column.range)


def _difference(column: Column, rows: pd.DataFrame, base: pd.DataFrame, how: str) -> Interval:
    values, baseline = _of_runs(column, rows), _of_runs(column, base)
    if how == PAIRED:
        return statistics.paired_difference(values, baseline, within=column.range)
    exact = how == EXACT
    return statistics.difference(values, baseline, single_is_exact=exact, within=column.range)


def _shown(column: Column, cell: Interval | str, better: bool) -> str:
    """A mean with its interval; of a difference with whether it is for the better."""
    if isinstance(cell, str):
        return cell
    clear = better and column.more_is_better is not None and (cell.low > 0.0 or cell.high < 0.0)
    mark = (" +" if (cell.mean > 0.0) == column.more_is_better else " -") if clear else ""
    return f"{cell}{mark}"
