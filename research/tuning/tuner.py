"""The search: trials of settings, evaluated seed by seed in parallel, pruned, and never lost."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, as_completed, wait
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from research.tuning.spaces import Space, space_of
from research.tuning.spaces.base import Settings
from research.tuning.storage import opened
from research.tuning.task import TuningTask
from tegotae._support.documents import CODE
from tegotae._support.engines import available_cores, require_workers
from tegotae._support.errors import TegotaeError, require, require_count
from tegotae._support.progress import Reporter, reporting
from tegotae._support.workers import Workers, WorkersDied
from tegotae.systems.experiment import Experiment
from tegotae.systems.registry import code_noted, kinds

if TYPE_CHECKING:
    from optuna.study import Study
    from optuna.trial import FrozenTrial, Trial

T = TypeVar("T")

P_PRUNED = 0.1
"""A trial is given up once it is worse than the best one at this p-value."""


def tune(
    algorithm: str,
    task: TuningTask,
    storage: Path,
    *,
    trials: int,
    workers: int = 1,
    restart: bool = False,
) -> list[FrozenTrial]:
    """Evaluate settings until there are `trials` of them, those of earlier calls included.

    A trial's value is the mean, over experiments and seeds, of the best fitness found within the
    task's budget. Values are reported one by one; a trial is pruned once a signed-rank test over
    what it has in common with the best trial says that it is worse
    (`optuna.pruners.WilcoxonPruner`).
    The next settings are drawn by `optuna.samplers.TPESampler`.

    Everything is in the storage file as soon as it is known: interrupted or killed, and called
    again, it continues from there.

    Args:
        algorithm: its name, as `space_of` takes it.
        task: what settings are evaluated on.
        storage: an Optuna journal, made if it does not exist.
        trials: evaluated settings in all, completed or pruned.
        workers: processes, each with its share of the cores.
        restart: whether a tuning that is in the file is set aside, in one beside it.

    Returns:
        all trials of the study.

    Raises:
        TegotaeError: for a count below one, a budget too small for the algorithm, or a storage file
            that is not of this tuning.
        MissingExtraError: without Optuna.
    """
    optuna = require("optuna", "tune")
    require_count("trials", trials)
    require_workers(workers)
    space = space_of(algorithm)
    for experiment in task.experiments:
        task.episodes(experiment, minimum=space.least_episodes)
    code = code_noted(kinds()[algorithm]) if algorithm in kinds() else None
    attributes = {} if code is None else {CODE: code}
    configuration = {"algorithm": algorithm, **attributes, **task.configuration}
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with opened(storage, configuration, restart=restart) as study:
        _prepare(optuna, study, space)
        if _evaluated(study) < trials:
            with _pool(workers) as pool, reporting(f"tune {algorithm}", trials) as reporter:
                _search(study, space, task, trials, pool, reporter)
        return study.get_trials()


def evaluate_settings(
    space: Space, settings: Sequence[Settings], task: TuningTask, *, workers: int = 1
) -> np.ndarray:
    """Return the fitness of each setting on all of a task's trainings, shape [settings, instances].

    Args:
        space: the algorithm's search space.
        settings: settings of the algorithm.
        task: experiments, seeds and budget.
        workers: worker processes.
    """
    values = np.full((len(settings), task.instances), np.nan)
    jobs = [(row, job) for row in range(len(settings)) for job in task.jobs(space.seeds_at_once)]
    with _pool(workers) as pool, reporting("evaluate", len(jobs)) as reporter:
        futures = {
            pool.give(space.learn, settings[row], *_training(task, job)): (row, job)
            for row, job in jobs
        }
        for count, future in enumerate(as_completed(futures), 1):
            row, (model, seeds) = futures[future]
            values[row, [_instance(task, model, seed) for seed in seeds]] = _answer(future)
            reporter.update(count)
    return values


def _pool(workers: int) -> Workers:
    """Return processes that share the cores."""
    require_workers(workers)
    return Workers(workers, cores=max(1, available_cores() // workers))


def _answer(future: Future[T]) -> T:
    """Return the result of a worker.

    Raises:
        TegotaeError: as the worker did, or if its process has ended.
    """
    try:
        return future.result()
    except WorkersDied:
        raise TegotaeError(
            "a worker process has ended, perhaps for lack of memory; finished work is kept: "
            "continue with fewer workers"
        ) from None


def _prepare(optuna: ModuleType, study: Study, space: Space) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        study.pruner = optuna.pruners.WilcoxonPruner(p_threshold=P_PRUNED)
        # Seeded by the trials so far: one seed would draw the same settings after every restart.
        study.sampler = optuna.samplers.TPESampler(
            seed=len(study.trials), multivariate=True, constant_liar=True
        )
    if not study.trials:
        study.enqueue_trial(dict(space.first))


def _evaluated(study: Study) -> int:
    return sum(t.state.name in ("COMPLETE", "PRUNED") for t in study.get_trials(deepcopy=False))


@dataclass
class _Attempt:
    """A trial that a worker is at."""

    trial: Trial
    settings: Settings
    jobs: list[tuple[int, tuple[int, ...]]]
    values: list[float]


def _search(
    study: Study, space: Space, task: TuningTask, trials: int, pool: Workers, reporter: Reporter
) -> None:
    attempts: dict[Future[list[float]], _Attempt] = {}

    def go_on(attempt: _Attempt) -> None:
        job = _training(task, attempt.jobs[0])
        attempts[pool.give(space.learn, attempt.settings, *job)] = attempt

    while True:
        while len(attempts) < pool.size and _evaluated(study) + len(attempts) < trials:
            trial = study.ask()
            attempt = _Attempt(trial, space.suggest(trial), task.jobs(space.seeds_at_once), [])
            trial.set_user_attr("settings", repr(attempt.settings))
            go_on(attempt)
        if not attempts:
            return
        for future in wait(attempts, return_when=FIRST_COMPLETED).done:
            attempt, values = attempts.pop(future), _answer(future)
            model, seeds = attempt.jobs.pop(0)
            for seed, value in zip(seeds, values, strict=True):
                attempt.trial.report(value, _instance(task, model, seed))
            attempt.values += values
            if attempt.jobs and not attempt.trial.should_prune():
                go_on(attempt)
                continue
            _finish(study, attempt)
            reporter.update(_evaluated(study), _note(study))


def _training(
    task: TuningTask, job: tuple[int, tuple[int, ...]]
) -> tuple[TuningTask, Experiment, tuple[int, ...]]:
    """Return task, experiment and seeds, as `Space.learn` takes them."""
    number, seeds = job
    return task, task.experiments[number], tuple(task.first_seed + seed for seed in seeds)


def _instance(task: TuningTask, model: int, seed: int) -> int:
    """Return the number under which a training's value is reported: the same in every trial."""
    return model * task.seeds + seed


def _finish(study: Study, attempt: _Attempt) -> None:
    from optuna.trial import TrialState

    if attempt.jobs:
        study.tell(attempt.trial, state=TrialState.PRUNED)
    else:
        study.tell(attempt.trial, float(np.mean(attempt.values)))


def _note(study: Study) -> str:
    values = [trial.value for trial in study.get_trials(deepcopy=False) if trial.value is not None]
    return f"best {max(values):.4f}" if values else ""
