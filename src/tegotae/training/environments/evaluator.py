"""Scores candidates by episodes on an environment, in worker processes or in this one."""

from __future__ import annotations

import warnings
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.devices import available_cores, require_workers
from tegotae._support.errors import TegotaeError, require_count
from tegotae.training.environments.rollouts import EnvRollouts, Trials
from tegotae.training.environments.worker_pool import WorkerPool
from tegotae.training.evaluator import Evaluator, Generation, Scores

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment

_LANES = 64
"""Candidates that are tried side by side at most."""


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
        require_count("workers", workers, least=0)
        if workers:
            require_workers(workers)
        self._workers = workers
        self._runner: EnvRollouts | WorkerPool | None = None
        self.troubles: Counter[str] = Counter()
        """The number of failed samples, by kind of failure."""

    def evaluate(self, candidates: np.ndarray, who: Generation) -> Scores:
        """Scores of every candidate of the seeds that are going."""
        (seeds, per_seed, n_weights), going = candidates.shape, who.going
        starts = self._starts(per_seed, who)
        # Whoever meets the evaluation set does so as several candidates.
        times = np.array([len(each) for each in starts[0]])
        wanted = np.repeat(np.asarray(candidates[going], float), times, axis=1)
        met = np.concatenate([np.concatenate(of_seed) for of_seed in starts])
        trials = self._tried(wanted.reshape(-1, n_weights), met, seeds * int(times.sum()))
        self._warn(trials)
        begin = np.cumsum(times) - times

        def spread(values: np.ndarray, empty: float, together: np.ufunc = np.add) -> np.ndarray:
            whole = np.full((seeds, per_seed), empty, values.dtype)
            found = together.reduceat(values.reshape(-1, times.sum()), begin, axis=1)
            whole[going] = found / times if together is np.add else found
            return whole

        return Scores(
            spread(trials.fitness.astype(np.float32), 0.0),
            spread(trials.cot_inverse.astype(np.float32), np.nan),
            spread(trials.failed, True, np.logical_or),
        )

    def _starts(self, per_seed: int, who: Generation) -> list[list[np.ndarray]]:
        """Seeds of the starts of each seed that goes and its candidates, [times, episodes] each."""
        own = self._experiment
        fixed = own.evaluation_starts
        if who.generation is None:
            return [[fixed] * per_seed] * int(who.going.sum())
        return [
            [own.starts(seed, who.generation)] * (per_seed - 1) + [fixed]
            for seed, goes in zip(who.seeds, who.going, strict=True)
            if goes
        ]

    def _tried(self, weights: np.ndarray, starts: np.ndarray, most: int) -> Trials:
        """All of them, some at a time; always as many lanes, so that arithmetic is the same."""
        if self._runner is None:
            lanes = min(_LANES, -(-most // max(1, self._workers)))
            self._runner = (
                WorkerPool(self._experiment, self._workers, lanes, self._experiment.limit_s)
                if self._workers
                else EnvRollouts(self._experiment, lanes)
            )
        if isinstance(self._runner, WorkerPool):
            return self._runner.try_out(weights, starts)
        lanes = self._runner.lanes
        parts = [
            self._runner.try_out(weights[i : i + lanes], starts=starts[i : i + lanes])
            for i in range(0, len(weights), lanes)
        ]
        return Trials(
            np.concatenate([part.fitness for part in parts]),
            np.concatenate([part.cot_inverse for part in parts]),
            np.concatenate([part.failed for part in parts]),
            [trouble for part in parts for trouble in part.troubles],
        )

    def _warn(self, trials: Trials) -> None:
        """Say once of each kind of trouble that it happened."""
        happened = Counter(trouble for trouble in trials.troubles if trouble is not None)
        for trouble, count in happened.items():
            if trouble not in self.troubles:
                warnings.warn(
                    f"{self._experiment.spec.env}: {trouble}; {count} of "
                    f"{len(trials.troubles)} samples count as failed, the training continues",
                    SampleWarning,
                    stacklevel=2,
                )
        self.troubles += happened
        if happened and sum(happened.values()) == len(trials.troubles):
            worst = happened.most_common(1)[0][0]
            raise TegotaeError(
                f"{self._experiment.spec.env} fails with every sample: {worst}; nothing can be "
                "learned there"
            )

    def close(self) -> None:
        """Close the environments, and end the workers."""
        if self._runner is not None:
            self._runner.close()
            self._runner = None
