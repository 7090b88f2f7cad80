"""Worker processes for environments that may crash or hang: what they take down is one sample."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import time
from ctypes import Array, c_longlong
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.workers import assigned_cores, ctrl_c_held_back, end_with_parent
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.training.environments.rollouts import EnvRollouts, Trials

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment

_IDLE = -1
"""The lane at work when none is: the controller computes, or compiles."""
_MOST_DEATHS = 3
"""Deaths in a row without any sample done, after which it is the worker that cannot work."""


@dataclass
class Job:
    """Candidates that one worker tries out together."""

    weights: np.ndarray
    """[candidates, n_weights]."""
    starts: np.ndarray
    """Seeds of their resets, [candidates, episodes]."""
    places: np.ndarray
    """Their numbers among all."""
    alive: np.ndarray = field(init=False)
    """Which of them have not taken a worker down."""
    troubles: list[str | None] = field(init=False)

    def __post_init__(self) -> None:
        self.alive = np.ones(len(self.weights), bool)
        self.troubles = [None] * len(self.weights)


class WorkerPool:
    """Worker processes that try out candidates of one experiment; a context manager.

    A worker that dies, or whose environment takes longer than `limit_s` over one step, is replaced.
    The sample at which that happened is marked, and the worker's others are done again without it.

    Args:
        experiment: what is trained.
        size: how many workers.
        lanes: candidates that each tries side by side.
        limit_s: longest time for one step of an environment [s].
    """

    def __init__(
        self, experiment: EnvExperiment, size: int, lanes: int, limit_s: float = 60.0
    ) -> None:
        self._experiment, self.size, self.lanes, self._limit_s = experiment, size, lanes, limit_s
        self._workers = [_EnvWorker(experiment, lanes, limit_s) for _ in range(size)]

    def try_out(self, weights: np.ndarray, starts: np.ndarray | None = None) -> Trials:
        """Scores of candidates.

        Args:
            weights: [candidates, n_weights].
            starts: seeds of the resets, [candidates, episodes]; those of the first set by default.

        Raises:
            TegotaeError: if the workers die with every sample.
        """
        n = len(weights)
        if starts is None:
            starts = np.tile(self._experiment.evaluation_starts[:1], (n, 1))
        found = Trials(np.zeros(n), np.full(n, np.nan), np.ones(n, bool), [None] * n)
        blocks = [np.arange(n)[i : i + self.lanes] for i in range(0, n, self.lanes)]
        waiting = [Job(weights[block], starts[block], block) for block in blocks]
        busy: dict[int, Job] = {}
        deaths = 0
        while waiting or busy:
            for index, worker in enumerate(self._workers):
                if index not in busy and waiting:
                    busy[index] = waiting.pop(0)
                    worker.give(busy[index])
            for index in self._answering(busy):
                job = busy.pop(index)
                answer = self._workers[index].answer()
                if isinstance(answer, Trials):
                    deaths = 0
                    _enter(found, job, answer)
                    continue
                if isinstance(answer, TegotaeError):
                    raise answer
                lane, why = answer
                self._workers[index].end()
                self._workers[index] = _EnvWorker(self._experiment, self.lanes, self._limit_s)
                if not 0 <= lane < len(job.alive):
                    deaths += 1
                    if deaths >= _MOST_DEATHS:
                        raise TegotaeError(
                            f"the workers of {self._experiment.name} die before any environment is "
                            "stepped; try it in this process (--workers 0) to see why"
                        )
                else:
                    job.alive[lane], job.troubles[lane] = False, why
                if job.alive.any():
                    waiting.insert(0, job)
                else:
                    _enter(found, job, None)
        return found

    def _answering(self, busy: dict[int, Job]) -> list[int]:
        """The workers that have an answer, are dead, or hang."""
        by_link: dict[object, int] = {self._workers[index].link: index for index in busy}
        ready = {by_link[link] for link in wait(list(by_link), timeout=0.2)}  # type: ignore[misc]
        hung = [i for i in busy if i not in ready and self._workers[i].hangs()]
        return [*sorted(ready), *hung]

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.end()

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _EnvWorker:
    """One worker process, and what it is at."""

    def __init__(self, experiment: EnvExperiment, lanes: int, limit_s: float) -> None:
        self._limit_s = limit_s
        context = multiprocessing.get_context("spawn")
        self.link, other = context.Pipe()
        # The lane whose environment is at work, and how many steps were begun.
        self._beat = context.Array(c_longlong, [_IDLE, 0], lock=False)
        arguments = (other, self._beat, experiment, lanes, os.getpid())
        self._process = context.Process(target=_work, args=arguments, daemon=True)
        with ctrl_c_held_back(), assigned_cores(1):
            self._process.start()
        other.close()
        self._last, self._since, self._hung = (_IDLE, 0), time.monotonic(), False

    def give(self, job: Job) -> None:
        """Have it try out a job."""
        self._since, self._hung = time.monotonic(), False
        with contextlib.suppress(OSError):  # dead: noticed when its answer is read
            self.link.send((job.weights, job.alive, job.starts))

    def hangs(self) -> bool:
        """Whether its environment has been at one step for too long."""
        now, at = time.monotonic(), (self._beat[0], self._beat[1])
        if at != self._last or at[0] == _IDLE:
            self._last, self._since = at, now
        self._hung = now - self._since > self._limit_s
        return self._hung

    def answer(self) -> Trials | TegotaeError | tuple[int, str]:
        """Its scores, its error, or the lane at which it ended and how."""
        if self._hung:
            return self._beat[0], f"a step of it took longer than {self._limit_s:g} s"
        try:
            return self.link.recv()
        except (EOFError, OSError):
            self._process.join(1.0)
            return self._beat[0], f"it ended its process (status {self._process.exitcode})"

    def end(self) -> None:
        """End it, whatever it is at."""
        self.link.close()
        self._process.kill()
        self._process.join()


def _work(
    link: Connection, beat: Array[c_longlong], experiment: EnvExperiment, lanes: int, parent: int
) -> None:
    """What a worker does: evaluate samples until its parent has ended."""
    end_with_parent(parent)

    def at_work(lane: int) -> None:
        beat[0] = lane
        beat[1] += 1

    rollouts: EnvRollouts | None = None
    while True:
        try:
            weights, alive, starts = link.recv()
        except (EOFError, OSError):
            return
        try:
            rollouts = rollouts or EnvRollouts(experiment, lanes, at_work)
            link.send(rollouts.try_out(weights, alive, starts))
        except TegotaeError as error:
            link.send(TegotaeError(str(error)))


def _enter(found: Trials, job: Job, answer: Trials | None) -> None:
    """Enter what came of a job among all."""
    for i, place in enumerate(job.places):
        if answer is not None and job.alive[i]:
            found.fitness[place] = answer.fitness[i]
            found.cot_inverse[place] = answer.cot_inverse[i]
            found.failed[place] = answer.failed[i]
            found.troubles[place] = answer.troubles[i]
        else:
            found.fitness[place] = FAILED_FITNESS
            found.troubles[place] = job.troubles[i]
