"""Worker processes for pure functions: of the study."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from types import FrameType
from typing import ParamSpec, TypeVar

from tegotae._support.errors import require_count

P = ParamSpec("P")
T = TypeVar("T")

CORES = "TEGOTAE_CORES"
"""Environment variable: on how many cores a process computes."""

WorkersDied = BrokenProcessPool
"""Exception of a result whose worker has ended before its work; all other workers are then ended
too."""


class Workers:
    """Worker processes that compile while others compute; a context manager.

    They end when this process does, or leaves early: none outlives a killed parent by more than
    moments. Ctrl-C reaches this process alone, which decides what becomes of them.

    Args:
        size: how many processes.
        cores: on how many cores each computes; as this process, by default.

    Raises:
        TegotaeError: for a size below one.

    Example:
        >>> with Workers(1) as workers:  # doctest: +SKIP
        ...     workers.give(max, 1, 2).result()
        2
    """

    def __init__(self, size: int, cores: int | None = None) -> None:
        require_count("workers", size)
        self.size = size
        self._pool = ProcessPoolExecutor(
            size,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=end_with_parent,
        )
        self._cores = cores

    def give(self, function: Callable[P, T], *arguments: P.args, **keywords: P.kwargs) -> Future[T]:
        """Let a worker do this, as soon as one is free."""
        # Processes are started with the first work, and inherit both for good.
        with ctrl_c_held_back(), assigned_cores(self._cores):
            return self._pool.submit(function, *arguments, **keywords)

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            # A shutdown alone would wait for the work in flight, and forgets the processes.
            for process in list((self._pool._processes or {}).values()):
                process.kill()  # of an author's code, which may hold other signals back
        self._pool.shutdown(cancel_futures=True)


@contextmanager
def assigned_cores(cores: int | None) -> Iterator[None]:
    """Set, in the environment of processes started within, how many cores to compute on."""
    previous = os.environ.get(CORES)
    if cores is not None:
        os.environ[CORES] = str(cores)
    try:
        yield
    finally:
        if previous is None:
            os.environ.pop(CORES, None)
        else:
            os.environ[CORES] = previous


@contextmanager
def ctrl_c_held_back() -> Iterator[None]:
    """Delay Ctrl-C until the end of the block; processes started within never receive it.

    The mask is what they inherit. It does not keep the signal from other threads of this process,
    for which Python interrupts the main one: a worker that is half started would then be left
    without what it is to read.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    handler = signal.getsignal(signal.SIGINT)
    defers = threading.current_thread() is threading.main_thread() and callable(handler)
    held: list[tuple[int, FrameType | None]] = []
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    if defers:
        signal.signal(signal.SIGINT, lambda number, frame: held.append((number, frame)))
    try:
        yield
    finally:
        if defers:
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)
        if held and callable(handler):
            handler(*held[-1])


def end_with_parent() -> None:
    """End this worker when its parent is killed; it would wait for work for ever."""
    parent = multiprocessing.parent_process()
    assert parent is not None  # it is called in workers alone

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
