"""The study's folder: what it is for, its records, and who is writing to it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Protocol

import msgspec

from research.reproduction.plan import belongs_to_study, united
from research.reproduction.record import Record, read_record
from research.reproduction.unit import FORMAT, Unit, record_key
from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Document
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder, write_atomically
from tegotae._support.workplace import STUDY, alone, locked
from tegotae.study import Study
from tegotae.systems.controller_file import SUFFIX


class Work(Protocol):
    """Work of a folder."""

    @property
    def units(self) -> list[Unit]:
        """All units of the work."""
        ...

    @property
    def document(self) -> Document:
        """Return the identity of the study, as JSON values."""
        ...


class StudyDocument(msgspec.Struct):
    """Checked entries of a study's description; the whole description has to equal that of a
    plan.
    """

    format: int
    scale: str
    seeds: Annotated[int, msgspec.Meta(ge=1, le=10**6)]
    algorithm: AlgorithmDocument
    stopping: StoppingDocument
    experiments: dict[str, Document]
    metrics: dict[str, Document] = {}


class AlgorithmDocument(msgspec.Struct):
    """Description of the learning algorithm."""

    name: str
    population: Annotated[int, msgspec.Meta(ge=1)]


class StoppingDocument(msgspec.Struct):
    """Description of the stopping rule."""

    generations: int


class Folder:
    """A folder that holds one study.

    Args:
        path: where it is.
    """

    SCHEMA: type = StudyDocument
    """Required entries of a study's description."""
    COMMAND = "python -m research.reproduction"
    """The command that such a folder is for."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def records(self) -> Path:
        """Folder of the records."""
        return self.path / "records"

    @contextmanager
    def claimed(self, plan: Work, *, restart: bool = False) -> Iterator[None]:
        """Keep others out, and make the folder this plan's or see that it is.

        Args:
            plan: what the folder is for.
            restart: whether a study that is there before is set aside, in a folder beside it.

        Raises:
            TegotaeError: if it cannot be written, is in use, or holds another study.
        """
        with alone(self.path, STUDY, restart=restart):
            self._claim(plan)
            yield

    def _claim(self, plan: Work) -> None:
        if (self.path / "study.json").exists():
            try:
                united(self.document, plan.document)
            except TegotaeError as error:
                raise TegotaeError(
                    f"{self.path} holds a study with {error}; choose another folder, or start "
                    "again with --restart"
                ) from None
        output_folder(self.records)
        self.describe(plan.document)

    def describe(self, document: Document) -> None:
        """Write the purpose into the folder, beside the experiments that it has already.

        Raises:
            TegotaeError: if the folder has records of no known plan, holds another study, or
                cannot be written.
        """
        place = self.path / "study.json"
        if place.exists():
            existing = self.document
            document = united(existing, document)
            if document == existing:
                return
        elif any(self.records.iterdir()):
            raise TegotaeError(
                f"{self.path} holds records but no study.json; choose another folder"
            )
        write_atomically(place, json.dumps(document, indent=1) + "\n")

    @property
    def document(self) -> Document:
        """Description of the folder's study.

        Raises:
            TegotaeError: if there is no study, or its description is damaged.
        """
        place = self.path / "study.json"
        try:
            document = documents.fitted(documents.read(place), dict)
            kind = "python -m research.reproduction" + " readings" * ("choices" in document)
            if "scale" in document and kind != self.COMMAND:
                raise TegotaeError(f"{self.path} is a folder of {kind}; look at it with that")
            if document.get("format", FORMAT) != FORMAT:
                raise TegotaeError(
                    f"{place} is of another version of tegotae, whose studies have other numbers; "
                    "choose another folder"
                )
            documents.fitted(document, self.SCHEMA)
        except FileNotFoundError:
            raise TegotaeError(
                f"{self.path} holds no study; start one with {self.COMMAND} run"
            ) from None
        except DamagedDocumentError as error:
            raise TegotaeError(f"{place} is damaged: {error}; choose another folder") from None
        return document

    def study(self, cells: Sequence[Unit]) -> Study:
        """Return the study of these units, measured into the folder's records."""
        return Study(self.records, cells, suffix=SUFFIX)

    def all(self) -> tuple[list[Record], list[str]]:
        """Return the study's complete records, in the order of their names, and the errors of the
        others.

        Raises:
            TegotaeError: if there is no study.
        """
        document = self.document
        records, problems = [], []
        for path in sorted(self.records.glob(f"*{SUFFIX}")):
            try:
                record = _read_named(path)
            except DamagedDocumentError as error:
                problems.append(f"{error}; run the study again to replace it")
                continue
            if self.is_of(document, record.configuration):
                records.append(record)
            else:
                problems.append(f"{path.name} is of another study; it is left out")
        return records, problems

    def is_of(self, document: Document, configuration: Document) -> bool:
        """Return whether a record of this configuration belongs to the study of this document."""
        return belongs_to_study(document, configuration)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other runs out; the lock goes with the process, however that ends.

        Raises:
            TegotaeError: if another run is at work in this folder.
        """
        with locked(self.path):
            yield


def _read_named(path: Path) -> Record:
    """Return the record at a place, if it has the content that its name promises."""
    record = read_record(path)
    try:
        key = record_key(record.configuration)
    except (KeyError, TypeError):
        key = ""
    if path.name != f"{key}{SUFFIX}":
        raise DamagedDocumentError(f"{path.name} is damaged: it holds another configuration")
    return record
