"""Doing the study's missing work on all cores of this machine."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path

from tegotae.errors import TegotaeError
from tegotae.progress import reporting
from tegotae.study.folder import Folder
from tegotae.study.plan import Plan
from tegotae.study.record import Record
from tegotae.study.unit import Unit, work

_MOST_DEATHS = 5


Results = Callable[[Sequence[list[Unit]]], Iterator[tuple[Unit, Record]]]
"""Does bundles of units somewhere, and yields records as they come."""


def run(plan: Plan, path: Path, results: Results | None = None) -> int:
    """Do what is missing of a plan in a folder; return how many records there are then.

    Units that share a compiled program are done together, one after the other. A worker that dies
    takes the work in flight with it, which is done again: every unit's numbers depend on its
    configuration alone.

    Args:
        plan: the study.
        path: its folder.
        results: where to work; worker processes on all cores of this machine by default.

    Raises:
        TegotaeError: if the folder holds another study or is in use, if a unit cannot be done, or
            if workers die again and again.
    """
    folder = Folder(path)
    folder.claim(plan)
    results = on_cores if results is None else results
    with folder.locked():
        units = plan.units
        missing = [unit for unit in units if not folder.has(unit)]
        with reporting("study", len(units)) as reporter:
            reporter.update(len(units) - len(missing), "done before")
            deaths = 0
            while missing:
                try:
                    for unit, record in results(bundles(missing)):
                        folder.add(unit, record)
                        missing.remove(unit)
                        reporter.update(len(units) - len(missing), record.model)
                except BrokenProcessPool:
                    deaths += 1
                    if deaths > _MOST_DEATHS:
                        raise TegotaeError(
                            f"workers died {deaths} times; is there enough memory? {len(missing)} "
                            f"of {len(units)} units are missing, what is done is kept"
                        ) from None
        return len(units)


def bundles(units: Sequence[Unit]) -> list[list[Unit]]:
    """Units in groups that share a compiled program."""
    groups: dict[object, list[Unit]] = {}
    for unit in units:
        groups.setdefault(unit.run.training, []).append(unit)
    return list(groups.values())


def work_all(units: list[Unit]) -> list[Record]:
    """The records of a bundle."""
    return [work(unit) for unit in units]


def on_cores(work_to_do: Sequence[list[Unit]], workers: int | None = None) -> Iterator:
    """Do bundles in worker processes of one core each, which compile while others compute."""
    with _pool(min(workers or _cores(), len(work_to_do))) as pool:
        pending = {pool.submit(work_all, bundle): bundle for bundle in work_to_do}
        try:
            for future in as_completed(pending):
                yield from zip(pending[future], future.result(), strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in list((pool._processes or {}).values()):
                process.terminate()
            raise


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes of one core each, that end when this process does."""
    before = os.environ.get("TEGOTAE_CORES")
    os.environ["TEGOTAE_CORES"] = "1"  # read by the workers when they import JAX
    try:
        with ProcessPoolExecutor(
            workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_end_with_parent,
            initargs=(os.getpid(),),
        ) as pool:
            yield pool
    finally:
        if before is None:
            del os.environ["TEGOTAE_CORES"]
        else:
            os.environ["TEGOTAE_CORES"] = before


def _end_with_parent(parent: int) -> None:
    """A worker whose parent was killed would wait for work for ever."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _cores() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS or Windows
        return os.cpu_count() or 1
