"""The multiverse's folder, and what its records say under each reading."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import msgspec

from research.reproduction.folder import Folder
from research.reproduction.readings.plan import Multiverse, multiverse
from research.reproduction.record import Record
from research.reproduction.table import StudyTable, tabulate
from research.reproduction.unit import FORMAT, record_key
from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError


class MultiverseDocument(msgspec.Struct):
    """Checked entries of a multiverse's description; the whole description has to equal that of
    a plan.
    """

    format: int
    scale: str
    seeds: Annotated[int, msgspec.Meta(ge=1, le=10**6)]
    models: list[str]
    choices: dict[str, list[str]]


class MultiverseFolder(Folder):
    """A folder that holds a multiverse.

    Args:
        path: where it is.
    """

    SCHEMA = MultiverseDocument
    COMMAND = "python -m research.reproduction readings"

    def is_of(self, document: Document, configuration: Document) -> bool:
        """Return whether a record of this configuration belongs to the multiverse of this
        document."""
        shared = {"format": FORMAT, "seeds": list(range(document["seeds"]))}
        is_equal = all(configuration.get(name) == value for name, value in shared.items())
        experiment = configuration.get("experiment")
        name = experiment.get("name") if isinstance(experiment, dict) else None
        return is_equal and name in document["models"]

    def plan(self, readings: int | None = None) -> Multiverse:
        """Return the plan of the folder, with the scale's number of readings by default.

        Raises:
            TegotaeError: if the folder holds no multiverse, or one of other settings.
        """
        plan = multiverse(self.document["scale"], readings)
        if plan.document != self.document:
            raise TegotaeError(
                f"{self.path} holds a multiverse of another version; choose another folder"
            )
        return plan


def reading_tables(plan: Multiverse, records: Iterable[Record]) -> dict[int, StudyTable]:
    """Return the finished table of each reading, by its number."""
    by_key = {record_key(record.configuration): record for record in records}
    results = {}
    for number, (_, units) in enumerate(plan.by_reading):
        matching = [by_key[unit.key] for unit in units.values() if unit.key in by_key]
        if matching:
            results[number] = tabulate(matching)
    return results


def is_whole(plan: Multiverse, table: StudyTable) -> bool:
    """Return whether a reading's table has all models."""
    return set(plan.models) <= set(table["model"].tolist())
