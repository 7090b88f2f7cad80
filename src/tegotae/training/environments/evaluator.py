"""Fitness of candidates on an environment: in this process, or on worker processes."""

from __future__ import annotations

import contextlib
import multiprocessing
import time
import warnings
from collections import Counter
from ctypes import Array, c_longlong
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait

import numpy as np

from tegotae._support.engines import available_cores, require_workers
from tegotae._support.errors import TegotaeError
from tegotae._support.workers import assigned_cores, ctrl_c_held_back, end_with_parent
from tegotae.measures.objectives.evaluator import Evaluator, Generation
from tegotae.measures.objectives.objective import Scores
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import EnvRollouts, Trials

_LANES = 64
"""Candidates that are tried side by side at most."""
_IDLE = -1
"""The lane at work when none is: the controller computes, or compiles."""
_MOST_DEATHS = 3
"""Deaths in a row without any sample done, after which it is the worker that cannot work."""


class SampleWarning(UserWarning):
    """Samples failed on an environment, and count as failed."""


class EnvEvaluator(Evaluator):
    """Scores by episodes on an environment: a context manager.

    A sample whose environment raises, hangs, dies, changes its spaces, ends at once, or observes or
    pays what is not finite counts as the worst. The training goes on, and every kind of trouble is
    reported once (`SampleWarning`).

    Args:
        experiment: what is trained.
        workers: worker processes; 0 to step environments in this process, which a crash or a hang
            would take with it. One a core by default, and none for a MuJoCo model, whose physics
            has threads.

    Raises:
        TegotaeError: for a number of workers that this machine cannot have.
    """

    def __init__(self, experiment: EnvExperiment, workers: int | None = None) -> None:
        self._experiment = experiment
        if workers is None:
            workers = 0 if experiment.spec.is_model else available_cores()
        require_workers(workers, least=0)
        self._workers = workers
        self._runner: EnvRollouts | WorkerPool | None = None
        self.troubles: Counter[str] = Counter()
        """The number of failed samples, by kind of failure."""

    @property
    def repeats(self) -> int:
        """Evaluation repeats per candidate."""
        return len(self._experiment.evaluation_starts)

    def scored(self, weights: np.ndarray, per_seed: int, generation: Generation) -> Scores:
        """Evaluate rows of weights."""
        experiment, (going, rows, n_weights) = self._experiment, weights.shape
        fixed = np.tile(experiment.evaluation_starts, ((rows - per_seed) // self.repeats, 1))
        going_on = [s for s, goes in zip(generation.seeds, generation.going, strict=True) if goes]
        draws = [experiment.starts(seed, generation.number or 0) for seed in going_on]
        starts = [x for draw in draws for x in (np.repeat(draw[:1], per_seed, axis=0), fixed)]
        limit = len(generation.going) * rows
        if self._runner is None:  # groups of a fixed size, so that arithmetic is the same
            lanes = min(_LANES, -(-limit // max(1, self._workers)))
            self._runner = (
                WorkerPool(experiment, self._workers, lanes)
                if self._workers
                else EnvRollouts(experiment, lanes)
            )
        rows_of_all = weights.reshape(-1, n_weights).astype(float)
        trials = self._runner.try_out(rows_of_all, np.concatenate(starts))
        self._warn(trials)
        return Scores(
            trials.fitness.astype(np.float32).reshape(going, rows),
            trials.cot_inverse.astype(np.float32).reshape(going, rows),
            trials.failed.reshape(going, rows),
        )

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means over the last axis, in the order of summation of kept trainings."""
        return np.add.reduceat(values, [0], axis=-1)[..., 0] / values.shape[-1]

    def _warn(self, trials: Trials) -> None:
        """Warn once about each kind of error."""
        happened = Counter(trouble for trouble in trials.troubles if trouble)
        env, count = self._experiment.spec.env, len(trials.troubles)
        for trouble, times in happened.items():
            if trouble not in self.troubles:
                warnings.warn(
                    f"{env}: {trouble}; {times} of {count} samples count as failed, the training "
                    "continues",
                    SampleWarning,
                    stacklevel=2,
                )
        self.troubles += happened
        if happened and sum(happened.values()) == count:
            worst = happened.most_common(1)[0][0]
            raise TegotaeError(
                f"{env} fails with every sample: {worst}; nothing can be learned there"
            )

    def close(self) -> None:
        """Close the environments, and end the workers."""
        if self._runner is not None:
            self._runner.close()
            self._runner = None


@dataclass(eq=False)
class Job:
    """Candidates that one worker tries out together."""

    weights: np.ndarray
    """[candidates, n_weights]."""
    starts: np.ndarray
    """Seeds of their resets, [candidates, episodes]."""
    troubles: list[str]
    """Troubles of the candidates that took a worker down."""
    trials: Trials | None = None
    """Results of the job; None until it is done."""


class WorkerPool:
    """Worker processes that try out candidates of one experiment.

    A worker that dies, or whose environment takes longer than the experiment's `limit_s` over one
    step, is replaced. The sample at which that happened is marked, and the worker's others are done
    again without it. (Gymnasium's `AsyncVectorEnv` ends with the first environment that dies.)

    Args:
        experiment: what is trained.
        size: how many processes.
        lanes: how many candidates each tries out side by side.
    """

    def __init__(self, experiment: EnvExperiment, size: int, lanes: int) -> None:
        self._experiment, self.lanes = experiment, lanes
        self._workers = [_EnvWorker(experiment, lanes) for _ in range(size)]

    def try_out(self, weights: np.ndarray, starts: np.ndarray) -> Trials:
        """Evaluate candidates.

        Args:
            weights: [candidates, n_weights].
            starts: seeds of the resets, [candidates, episodes].

        Raises:
            TegotaeError: if the workers die with every sample.
        """
        blocks = [slice(i, i + self.lanes) for i in range(0, len(weights), self.lanes)]
        jobs = [Job(weights[b], starts[b], [""] * len(weights[b])) for b in blocks]
        waiting, deaths = jobs.copy(), 0
        while waiting or any(worker.job for worker in self._workers):
            for worker in self._workers:
                if worker.job is None and waiting:
                    worker.give(waiting.pop(0))
            for worker, job in self._answering():
                worker.job, answer = None, worker.answer()
                if isinstance(answer, TegotaeError):
                    raise answer
                if isinstance(answer, Trials):
                    job.trials, deaths = answer, 0
                    continue
                lane, reason = answer
                worker.end()
                worker.begin()
                waiting.insert(0, job)
                if 0 <= lane < len(job.troubles):
                    job.troubles[lane] = reason
                    continue
                deaths += 1
                if deaths >= _MOST_DEATHS:
                    raise TegotaeError(
                        f"the workers of {self._experiment.name} die before any environment is "
                        "stepped; try it in this process (--workers 0) to see why"
                    )
        return Trials.joined([job.trials for job in jobs if job.trials is not None])

    def _answering(self) -> list[tuple[_EnvWorker, Job]]:
        """Return the workers that have answered, died or hang, with their tasks."""
        busy = [(worker, worker.job) for worker in self._workers if worker.job is not None]
        ready = wait([worker.link for worker, _ in busy], timeout=0.2)
        return [(worker, job) for worker, job in busy if worker.link in ready or worker.hangs()]

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.end()


class _EnvWorker:
    """One worker process and its present task."""

    job: Job | None = None
    """Job that the worker evaluates."""

    def __init__(self, experiment: EnvExperiment, lanes: int) -> None:
        self._experiment, self._lanes, self._limit_s = experiment, lanes, experiment.limit_s
        self.begin()

    def begin(self) -> None:
        """Start its process."""
        context = multiprocessing.get_context("spawn")
        self.link, child = context.Pipe()
        # The lane whose environment is at work, and how many steps were begun.
        self._beat = context.Array(c_longlong, [_IDLE, 0], lock=False)
        arguments = (child, self._beat, self._experiment, self._lanes)
        self._process = context.Process(target=_work, args=arguments, daemon=True)
        with ctrl_c_held_back(), assigned_cores(1):
            self._process.start()
        child.close()
        self._last, self._since, self._hung = (_IDLE, 0), time.monotonic(), False

    def give(self, job: Job) -> None:
        """Give the worker a job to evaluate."""
        self.job, self._since, self._hung = job, time.monotonic(), False
        with contextlib.suppress(OSError):  # dead: noticed when its answer is read
            self.link.send((job.weights, job.starts, job.troubles))

    def hangs(self) -> bool:
        """Return whether its environment has been in one step for too long."""
        time_s, beat = time.monotonic(), (self._beat[0], self._beat[1])
        if beat != self._last or beat[0] == _IDLE:
            self._last, self._since = beat, time_s
        self._hung = time_s - self._since > self._limit_s
        return self._hung

    def answer(self) -> Trials | TegotaeError | tuple[int, str]:
        """Return a worker's scores, its error, or the lane at which it ended and how."""
        if self._hung:
            return self._beat[0], f"a step of it took longer than {self._limit_s:g} s"
        try:
            return self.link.recv()
        except (EOFError, OSError):
            self._process.join(1.0)
            return self._beat[0], f"it ended its process (status {self._process.exitcode})"

    def end(self) -> None:
        """End the process, whatever its task."""
        self.link.close()
        self._process.kill()
        self._process.join()


def _work(link: Connection, beat: Array[c_longlong], experiment: EnvExperiment, lanes: int) -> None:
    """Evaluate samples in a worker process until its parent has ended."""
    end_with_parent()

    def begin_step(lane: int) -> None:
        beat[0] = lane
        beat[1] += 1

    rollouts: EnvRollouts | None = None
    while True:
        try:
            job = link.recv()
        except (EOFError, OSError):
            return
        try:
            rollouts = rollouts or EnvRollouts(experiment, lanes, begin_step)
            link.send(rollouts.try_out(*job))
        except TegotaeError as error:
            link.send(TegotaeError(str(error)))
