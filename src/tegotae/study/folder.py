"""The study's folder: what it is for, its records, and who is writing to it."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tegotae.errors import TegotaeError
from tegotae.files import output_folder, write_atomically
from tegotae.study.plan import Plan
from tegotae.study.record import SUFFIX, DamagedRecordError, Record, read, write
from tegotae.study.unit import Unit


class Folder:
    """A folder that holds one study.

    Args:
        path: where it is.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def records(self) -> Path:
        """Where the records are."""
        return self.path / "records"

    def claim(self, plan: Plan) -> None:
        """Make the folder this plan's, or see that it is.

        Raises:
            TegotaeError: if it cannot be written or holds another study.
        """
        output_folder(self.path)
        output_folder(self.records)
        place = self.path / "study.json"
        if not place.exists():
            if any(self.records.iterdir()):
                raise TegotaeError(
                    f"{self.path} holds records but no study.json; choose another folder"
                )
            write_atomically(place, json.dumps(plan.document, indent=1) + "\n")
            return
        found = self.document
        if found != plan.document:
            names = sorted(
                n for n in {*found, *plan.document} if found.get(n) != plan.document.get(n)
            )
            raise TegotaeError(
                f"{self.path} holds a study with another {', '.join(names)}; choose another folder"
            )

    @property
    def document(self) -> dict:
        """What the folder's study is.

        Raises:
            TegotaeError: if there is no study, or its description is damaged.
        """
        place = self.path / "study.json"
        try:
            return json.loads(place.read_text())
        except FileNotFoundError:
            raise TegotaeError(
                f"{self.path} holds no study; start one with tegotae study run"
            ) from None
        except OSError as error:
            raise TegotaeError(f"cannot read {place}: {error.strerror}") from None
        except ValueError:
            raise TegotaeError(f"{place} is damaged; choose another folder") from None

    def place(self, unit: Unit) -> Path:
        """Where a unit's record is or will be."""
        return self.records / f"{unit.key}{SUFFIX}"

    def has(self, unit: Unit) -> bool:
        """Whether a unit's record is there and whole; a damaged one is set aside."""
        path = self.place(unit)
        if not path.exists():
            return False
        try:
            return read(path).configuration == unit.configuration
        except DamagedRecordError as error:
            self._set_aside(path, error)
            return False

    def add(self, unit: Unit, record: Record) -> None:
        """Write a unit's record."""
        write(record, self.place(unit))

    def all(self) -> tuple[list[Record], list[str]]:
        """All whole records, in the order of their names, and what is wrong with the others."""
        found, damaged = [], []
        for path in sorted(self.records.glob(f"*{SUFFIX}")):
            try:
                found.append(read(path))
            except DamagedRecordError as error:
                damaged.append(str(error))
        return found, damaged

    def _set_aside(self, path: Path, error: Exception) -> None:
        aside = output_folder(self.path / "damaged")
        os.replace(path, aside / path.name)
        print(f"{error}; it is set aside in {aside} and done again")

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other runs out; the lock goes with the process, however that ends.

        Raises:
            TegotaeError: if another run is at work in this folder.
        """
        place = self.path / ".lock"
        try:
            stream = place.open("w")
        except OSError as error:
            raise TegotaeError(f"cannot write {place}: {error.strerror}") from None
        with stream:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise TegotaeError(f"another run is at work in {self.path}; wait for it") from None
            yield
