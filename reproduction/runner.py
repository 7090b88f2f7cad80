"""Doing the study's missing work on all cores of this machine."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from pathlib import Path

from reproduction.folder import Folder, Work
from reproduction.record import Record
from reproduction.unit import Unit, work
from tegotae._support.devices import available_cores
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae._support.workers import Workers, WorkersDied
from tegotae.simulation.native import forget_programs
from tegotae.systems.experiment import differing
from tegotae.systems.registry import parts_in, register

_MOST_DEATHS = 5

Results = Callable[[Sequence[list[Unit]]], Generator[tuple[Unit, Record], None, None]]
"""Does bundles of units somewhere, and yields records as they come."""


class WorkersDiedError(Exception):
    """Workers ended before their work did; it can be given to others."""


def run(
    plan: Work,
    place: Path | Folder,
    results: Results | None = None,
    most: int | None = None,
    *,
    anew: bool = False,
) -> int:
    """Do what is missing of a plan in a folder; return how many records there are then.

    Units that share a compiled program are done together, one after the other. A worker that dies
    takes the work in flight with it, which is done again: every unit's numbers depend on its
    configuration alone.

    Args:
        plan: the study.
        place: its folder.
        results: where to work; worker processes on all cores of this machine by default.
        most: units that are done together at most.
        anew: whether a study that is there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: if the folder holds another study or is in use, if a unit cannot be done or
            its record not be written, or if workers die again and again.
        KeyboardInterrupt: after Ctrl-C. This and the former say what is kept.
    """
    folder = place if isinstance(place, Folder) else Folder(place)
    with folder.claimed(plan, anew=anew):
        units = plan.units
        missing = [unit for unit in units if not folder.has(unit)]
        try:
            with reporting("study", len(units)) as reporter:
                reporter.update(len(units) - len(missing), "done before")
                with closing(_persistently(missing, results or on_cores, most)) as found:
                    for unit, record in found:
                        _require_same(unit, record)
                        folder.add(unit, record)
                        missing.remove(unit)
                        reporter.update(len(units) - len(missing), record.model)
        except (TegotaeError, KeyboardInterrupt) as stop:
            why = str(stop) or "interrupted"
            raise type(stop)(
                f"{why}; {folder.path} keeps {len(units) - len(missing)} of {len(units)} models, "
                "the same command continues from there"
            ) from None
        return len(units)


def _require_same(unit: Unit, record: Record) -> None:
    """Raise `TegotaeError` if a worker, which reads a user's files itself, read other code."""
    if names := differing(record.configuration, unit.configuration):
        raise TegotaeError(
            f"{record.model} was computed with another {', '.join(names)}: a file was edited "
            "while the study ran"
        )


def _persistently(
    missing: list[Unit], results: Results, most: int | None
) -> Generator[tuple[Unit, Record], None, None]:
    """The records of what is missing, asked for again when workers die.

    What is handed out is to be taken off `missing`.
    """
    deaths = 0
    while missing:
        try:
            with closing(results(bundles(missing, most))) as found:
                for unit, record in found:
                    yield unit, record
                    deaths = 0
        except WorkersDiedError:
            deaths += 1
            if deaths == _MOST_DEATHS:
                raise TegotaeError(
                    f"workers died {deaths} times without a result; is there enough memory?"
                ) from None


def bundles(units: Sequence[Unit], most: int | None = None) -> list[list[Unit]]:
    """Units in groups that share a compiled program, of so many at most."""
    groups: dict[object, list[Unit]] = {}
    for unit in units:
        groups.setdefault(unit.run.learner.program(unit.run.experiment), []).append(unit)
    size = most or len(units)
    return [g[i : i + size] for g in groups.values() for i in range(0, len(g), size)]


def work_all(units: list[Unit]) -> list[Record]:
    """The records of a bundle, done by a worker."""
    # A worker is a process of its own: it knows the parts that its work is made of.
    for unit in units:
        for part in (*parts_in((unit.run.experiment, unit.run.learner.algorithm)), *unit.metrics):
            register(part)
    try:
        return [work(unit) for unit in units]
    finally:
        forget_programs()  # the programs of a bundle are no other's, and a hundred of them are GiB


def on_cores(
    work_to_do: Sequence[list[Unit]], workers: int | None = None
) -> Generator[tuple[Unit, Record], None, None]:
    """Do bundles in worker processes of one core each, which compile while others compute.

    Raises:
        WorkersDiedError: if one of them dies; the others are ended.
    """
    size = min(workers or available_cores(), len(work_to_do))
    with Workers(size, max(1, available_cores() // size)) as pool:
        pending = {pool.give(work_all, bundle): bundle for bundle in work_to_do}
        for future in as_completed(pending):
            try:
                records = future.result()
            except WorkersDied:
                raise WorkersDiedError from None
            yield from zip(pending[future], records, strict=True)
