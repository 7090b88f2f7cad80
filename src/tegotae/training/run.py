"""A training: what is learned, how, from which seeds; in a folder, from which it goes on.

Whatever learns leaves the same files, and goes on by the same rule: a folder belongs to one
training (`run.json`), which begins at the state in `checkpoint.npz`, if there is one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.progress import reporting
from tegotae._support.workplace import TRAINING, alone
from tegotae.systems.descriptions import check_kept
from tegotae.training.evolution import Evolution
from tegotae.training.folder import (
    claim,
    read_checkpoint,
    save_controller,
    write_checkpoint,
    write_curves,
)
from tegotae.training.learner import Learner, Trainable, TrainingState

LearnerT = TypeVar("LearnerT", bound=Learner)

_SECONDS_BETWEEN_CHECKPOINTS = 5.0


@dataclass(frozen=True, kw_only=True)
class Run(Generic[LearnerT]):
    """A training: what, how and for how long, from which seeds.

    Args:
        experiment: what is trained, on what, by what measure: on the engine, or on an environment.
        learner: how is learned and for how long: a population (`Evolution`) or an agent
            (`tegotae.training.agents.AgentLearner`).
        seeds: one training from random weights each.

    Raises:
        TegotaeError: for seeds that are no distinct numbers from 0 to 2^31 - 1, or an experiment
            that this learner cannot learn.

    Example:
        >>> from tegotae import find
        >>> Run(experiment=find("AR").experiment(), seeds=(0, 1)).learner.UNIT
        'generation'
    """

    experiment: Trainable
    learner: LearnerT = field(default_factory=Evolution)  # type: ignore[assignment]
    seeds: tuple[int, ...] = (0, 1, 2)

    def __post_init__(self) -> None:
        require_count("seeds", len(self.seeds))
        for seed in self.seeds:
            require_count("seed", seed, least=0, most=2**31 - 1)
        if len(set(self.seeds)) < len(self.seeds):
            raise TegotaeError(f"seeds are {self.seeds}; each may be given only once")
        self.learner.check(self.experiment, self.seeds)

    @property
    def configuration(self) -> JsonObject:
        """What decides the result, but for how long is learned, as JSON values."""
        return self.learner.configuration(self.experiment, self.seeds)

    @cached_property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers, and the engine."""
        return {**self.learner.software, "engine": self.learner.engine(self.experiment)}

    def learn(self) -> Iterator[TrainingState]:
        """Learn step by step, from the beginning, and keep nothing in files."""
        return self.learner.learn(self.experiment, self.seeds)


def train(
    run: Run[LearnerT],
    out: Path,
    *,
    anew: bool = False,
    on_step: Callable[[TrainingState], None] | None = None,
) -> list[Path]:
    """Train, or train on, in the folder `out`; return the controller files, one per seed.

    Written are `NAME-seedN.json` (the controllers), `curves.csv`
    (`tegotae.training.learner.CurvePoint`), `run.json` (configuration and versions) and
    `checkpoint.npz`. Interrupted (Ctrl-C), it keeps what has been learned and raises
    `KeyboardInterrupt` again; called again on the same folder, it continues from there, and ends
    in the same numbers: a population behind its last generation, an agent with the seed that was
    interrupted.

    Args:
        run: what, how and for how long, from which seeds.
        out: the folder.
        anew: whether a training that is there before is set aside, in a folder beside it.
        on_step: called with the state after each step.

    Raises:
        TegotaeError: if the folder cannot be written, is in use or holds another training.
    """
    experiment, learner, seeds = run.experiment, run.learner, run.seeds
    experiment.check()
    check_kept(learner)
    configuration, software = run.configuration, run.software
    with alone(out, TRAINING, anew=anew):
        claim(out, configuration, software)
        resumed = partial(learner.resumed, experiment, seeds)
        state = begun = read_checkpoint(out, configuration, resumed)
        saved_at = -np.inf
        with reporting(experiment.name, learner.length(seeds)) as reporter:
            try:
                for state in learner.learn(experiment, seeds, begun):
                    if time.monotonic() - saved_at > _SECONDS_BETWEEN_CHECKPOINTS:
                        write_checkpoint(out, configuration, state)
                        saved_at = time.monotonic()
                    reporter.update(state.done, state.report)
                    if on_step is not None:
                        on_step(state)
            finally:
                write_checkpoint(out, configuration, state)
                if state.points:
                    write_curves(out / "curves.csv", state.points)
                paths = [
                    save_controller(out, experiment, learned, configuration, software)
                    for learned in state.learned
                ]
        return paths
