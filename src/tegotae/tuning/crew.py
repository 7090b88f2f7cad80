"""Worker processes that each do one job at a time."""

from __future__ import annotations

import multiprocessing
import os
import signal
import traceback
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from tegotae.devices import available_cores, require_workers
from tegotae.errors import TegotaeError

CORES = "TEGOTAE_CORES"


class Crew:
    """Processes for pure functions, sharing the cores; a context manager.

    A worker ends when the pipe to it breaks, so none outlives a killed parent by more than a job.

    Raises:
        TegotaeError: for a size below one, or beyond what this machine can bear.
    """

    def __init__(self, size: int) -> None:
        require_workers(size)
        self._pipes: dict[int, Connection] = {}
        context = multiprocessing.get_context("spawn")
        before = os.environ.get(CORES)
        os.environ[CORES] = str(max(1, available_cores() // size))
        try:
            self._processes = [self._hire(context, worker) for worker in range(size)]
        finally:
            os.environ.pop(CORES) if before is None else os.environ.update({CORES: before})
        self._idle = list(range(size))

    def _hire(self, context: Any, worker: int) -> Any:
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,), daemon=True)
        process.start()
        theirs.close()
        self._pipes[worker] = ours
        return process

    @property
    def has_idle(self) -> bool:
        """Whether a worker waits for a job."""
        return bool(self._idle)

    def give(self, function: Callable[..., Any], *arguments: Any) -> int:
        """Let an idle worker do this; returns its number."""
        worker = self._idle.pop()
        with suppress(OSError):  # a dead worker is noticed where its answer is awaited
            self._pipes[worker].send((function, arguments))
        return worker

    def next_answer(self) -> tuple[int, Any]:
        """Wait for the first worker that is done: its number and what its function returned.

        Raises:
            TegotaeError: as the function did, or if the worker's process has ended.
            RuntimeError: if the function failed otherwise, with its traceback.
        """
        busy = {pipe: n for n, pipe in self._pipes.items() if n not in self._idle}
        pipe = wait(list(busy))[0]
        assert isinstance(pipe, Connection)
        worker = busy[pipe]
        try:
            answer, wrong = pipe.recv()
        except (EOFError, OSError):
            self._processes[worker].join()
            raise TegotaeError(
                f"a worker process has ended (exit code {self._processes[worker].exitcode}), "
                "perhaps for want of memory; what is done is kept: go on with fewer workers"
            ) from None
        if isinstance(wrong, TegotaeError):
            raise wrong
        if wrong is not None:
            raise RuntimeError(f"a worker failed: {wrong.strip().splitlines()[-1]}\n{wrong}")
        self._idle.append(worker)
        return worker, answer

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.terminate()
        for process in self._processes:
            process.join()


def _serve(pipe: Connection) -> None:
    # Ctrl-C reaches the whole process group; the parent decides what becomes of it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            try:
                answer = function(*arguments), None
            except TegotaeError as error:
                answer = None, error
            except Exception:
                answer = None, traceback.format_exc()
            pipe.send(answer)
