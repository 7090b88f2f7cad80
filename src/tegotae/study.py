"""A study: cells, a measure of each, and a folder with one file a cell. Stopped, it goes on.

A cell has a name, a document of all that decides its numbers, and a pure measure. What a folder
lacks is measured, in this process or in any pool, and kept as it comes: a killed study loses what
was in flight, and the same call goes on.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Generator, Hashable, Iterable, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol, cast

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Document
from tegotae._support.engines import available_cores, require_engine, selected
from tegotae._support.errors import TegotaeError
from tegotae._support.files import checksum, output_folder, read_arrays, with_checksum, write_arrays
from tegotae._support.progress import reporting
from tegotae._support.workers import Workers, WorkersDied
from tegotae.simulation.native import forget_programs

Arrays = dict[str, np.ndarray]

MOST_BYTES = 2**28
"""Largest size of an unpacked result [bytes]."""
_MOST_DEATHS = 5


class Cell(Protocol):
    """Measurement that is made once, and saved."""

    @property
    def name(self) -> str:
        """Name in messages and in the progress."""
        ...

    @property
    def document(self) -> Document:
        """All settings that determine its numbers, as JSON values."""
        ...

    @property
    def program(self) -> Hashable:
        """Cells of an equal value share compiled programs, and go to one worker."""
        return None

    def prepare(self) -> None:
        """Register the parts that a worker process needs to measure; none by default."""

    def measure(self) -> CellResult:
        """Measure and return the numbers. The result is deterministic."""
        ...


@dataclass(frozen=True)
class CellResult:
    """Result of a cell.

    Args:
        document: of the cell that was measured.
        software: versions of the programs that made it. A study adds the engine.
        arrays: by name.
    """

    document: Document
    software: dict[str, str]
    arrays: Arrays

    def write(self, path: Path) -> None:
        """Write it whole or not at all, with a checksum.

        Raises:
            TegotaeError: if it cannot be written, such as for want of space.
        """
        header = {"configuration": self.document, "software": self.software}
        write_arrays(path, with_checksum(json.dumps(header, sort_keys=True), self.arrays))

    @classmethod
    def read(cls, path: Path) -> CellResult:
        """Return the result in a file.

        Raises:
            DamagedDocumentError: if it is no result, is cut short, or its checksum is wrong.
            TegotaeError: if it cannot be opened, such as without permission.
        """
        try:
            stream = path.open("rb")
        except OSError as error:
            raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
        try:
            with stream:
                arrays = read_arrays(stream, MOST_BYTES)
            text, noted = str(arrays.pop("header")), str(arrays.pop("checksum"))
            if noted != checksum(text, arrays):
                raise ValueError("its checksum is wrong")
            header = cast(Document, documents.parse_json(text))
            if "engine" not in header["software"]:
                raise ValueError("it does not name its engine")
            return cls(header["configuration"], header["software"], arrays)
        except Exception as error:  # a flipped bit in a zip archive may raise nearly anything
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            raise DamagedDocumentError(f"{path.name} is damaged: {reason}") from None


Pool = Callable[[Sequence[Sequence[Any]]], Generator[tuple[Any, CellResult], None, None]]
"""Measures bundles of cells somewhere, and yields cell and result as they come."""


@dataclass(frozen=True)
class Study:
    """Cells of a study and their results, in a folder of one file a cell.

    Args:
        folder: the files' folder.
        cells: what is measured.
        title: what progress calls it.
        counted: what messages call the cells.
        suffix: how a file's name ends.
        remedy: what to do where the folder's results were made by another engine.

    Example:
        A study of one cell, measured in this process:

        >>> import tempfile
        >>> @dataclass(frozen=True)
        ... class Square:
        ...     x: float
        ...     name, program = "square", None
        ...     document = property(lambda self: {"x": self.x})
        ...     def prepare(self): ...
        ...     def measure(self):
        ...         return CellResult(self.document, {}, {"square": np.array(self.x**2)})
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     study = Study(Path(folder), [Square(3.0)])
        ...     study.run(run_locally)
        ...     float(study.results()[0].arrays["square"])
        9.0
    """

    folder: Path
    cells: Sequence[Cell]
    title: str = "study"
    counted: str = "models"
    suffix: str = ".record.npz"
    remedy: str = "choose another folder, or start again with --restart"

    def run(self, pool: Pool | None = None, limit: int | None = None) -> None:
        """Measure the missing cells of the folder.

        A worker that dies takes the work in flight with it, which is done again.

        Args:
            pool: where to measure; on all cores of this machine by default.
            limit: cells that are measured together at most.

        Raises:
            TegotaeError: if the folder cannot be written, a cell cannot be measured, or workers die
                again and again.
            KeyboardInterrupt: after Ctrl-C. This and the former say what is kept.
        """
        output_folder(self.folder)
        for leftover in self.folder.glob(f".*{self.suffix}.*"):  # of a run that was killed
            leftover.unlink(missing_ok=True)
        missing = [cell for cell in self.cells if self.result(cell) is None]
        total = len(self.cells)
        try:
            with reporting(self.title, total) as reporter:
                reporter.update(total - len(missing), "done before")
                with closing(_persistently(missing, pool or on_cores, limit)) as measured:
                    for cell, result in measured:
                        _require_same(cell, result)
                        result.write(self.place(cell))
                        missing.remove(cell)
                        reporter.update(total - len(missing), cell.name)
        except (TegotaeError, KeyboardInterrupt) as stop:
            raise type(stop)(
                f"{str(stop) or 'interrupted'}; {self.folder.parent} keeps "
                f"{total - len(missing)} of {total} {self.counted}, the same command continues "
                "from there"
            ) from None

    def results(self) -> list[CellResult]:
        """Return the existing results, in the order of the cells."""
        return [result for cell in self.cells if (result := self.result(cell)) is not None]

    def place(self, cell: Cell) -> Path:
        """Return the path of a cell's file, which need not exist yet."""
        return self.folder / f"{cell_key(cell.name, cell.document)}{self.suffix}"

    def result(self, cell: Cell) -> CellResult | None:
        """Return a cell's result, or None if there is none. A damaged file is set aside.

        Raises:
            TegotaeError: for a result that another engine made.
        """
        path = self.place(cell)
        if not path.exists():
            return None
        try:
            result = CellResult.read(path)
            if result.document != json.loads(json.dumps(cell.document)):
                raise DamagedDocumentError(
                    f"{path.name} is damaged: it holds another configuration"
                )
        except DamagedDocumentError as error:
            aside = output_folder(self.folder.parent / "damaged")
            os.replace(path, aside / path.name)
            print(f"{error}; it is set aside in {aside} and done again")
            return None
        require_engine(
            result.software["engine"], f"{self.folder.parent} holds a study", self.remedy
        )
        return result


def measured_in_turn(
    cells: Sequence[Cell], folder: Path | None, title: str, suffix: str
) -> list[CellResult]:
    """Measure cells that each take all cores here, one after the other, and return their results.

    Args:
        cells: what is measured.
        folder: keeps results in `records`, so that interrupted work continues from there; None
            keeps none.
        title: what progress calls it.
        suffix: how a file's name ends.
    """
    with TemporaryDirectory() as temporary:
        place = Path(temporary if folder is None else folder) / "records"
        study = Study(place, cells, title, "parts", suffix, "choose another folder")
        study.run(run_locally)
        return study.results()


def cell_key(name: str, document: Document) -> str:
    """Return the name of a cell's file: its own, and a hash of its document."""
    digest = hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()
    return f"{Path(name).name}-{digest[:12]}"


def bundles(cells: Iterable[Cell], limit: int | None = None) -> list[list[Cell]]:
    """Return cells in groups that share a compiled program, each of a maximum size."""
    groups: dict[Hashable, list[Cell]] = {}
    for cell in cells:
        groups.setdefault(cell.program, []).append(cell)
    return [
        group[i : i + (limit or len(group))]
        for group in groups.values()
        for i in range(0, len(group), limit or len(group))
    ]


def measure_all(cells: Sequence[Cell]) -> list[CellResult]:
    """Measure a bundle's cells in a worker, a process of its own, and return the results."""
    for cell in cells:
        cell.prepare()
    try:
        return [_measured(cell) for cell in cells]
    finally:
        forget_programs()  # the programs of a bundle are no other's, and a hundred of them are GiB


def run_locally(work: Sequence[Sequence[Cell]]) -> Generator[tuple[Cell, CellResult], None, None]:
    """Measure bundles in this process, one after the other."""
    for bundle in work:
        for cell in bundle:
            yield cell, _measured(cell)
        forget_programs()


def _measured(cell: Cell) -> CellResult:
    """Measure a cell; return its numbers and the engine that computed them."""
    result = cell.measure()
    return replace(result, software={"engine": selected()} | result.software)


def on_cores(
    work: Sequence[Sequence[Cell]], workers: int | None = None
) -> Generator[tuple[Cell, CellResult], None, None]:
    """Measure bundles in worker processes of one core each, which compile while others compute.

    Raises:
        WorkersDied: if one of them dies; the others are ended.
    """
    size = min(workers or available_cores(), len(work))
    with Workers(size, max(1, available_cores() // size)) as pool:
        pending = {pool.give(measure_all, bundle): bundle for bundle in work}
        for future in as_completed(pending):
            yield from zip(pending[future], future.result(), strict=True)


def _persistently(
    missing: list[Cell], pool: Pool, limit: int | None
) -> Generator[tuple[Cell, CellResult], None, None]:
    """Yield the missing results; measure again when workers die.

    What is handed out is to be taken off `missing`.
    """
    deaths = 0
    while missing:
        try:
            with closing(pool(bundles(missing, limit))) as measured:
                for cell, result in measured:
                    yield cell, result
                    deaths = 0
        except WorkersDied:
            deaths += 1
            if deaths == _MOST_DEATHS:
                raise TegotaeError(
                    f"workers died {deaths} times without a result; is there enough memory?"
                ) from None


def _require_same(cell: Cell, result: CellResult) -> None:
    """Raise `TegotaeError` if a worker, which reads a user's files itself, read other code."""
    if names := documents.differing(result.document, json.loads(json.dumps(cell.document))):
        raise TegotaeError(
            f"{cell.name} was computed with another {', '.join(names)}: a file was edited "
            "while the study ran"
        )
