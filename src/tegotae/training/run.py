"""A training on disk: controllers, curves, and a checkpoint from which it goes on.

Whatever learns leaves the same files, and goes on by the same rule: a folder belongs to one
training (`run.json`), and a session begins at the state in `checkpoint.npz`, if there is one.
"""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from tegotae._support.documents import DamagedDocumentError, JsonObject, differing, fitted, parse
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.files import read_arrays, write_atomically
from tegotae._support.progress import reporting
from tegotae._support.workplace import TRAINING, alone
from tegotae.training.evolution import Evolution
from tegotae.training.folder import claim, save_controller
from tegotae.training.learner import (
    LearnedController,
    Learner,
    LearningStep,
    Session,
    Trainable,
    write_curves,
)

LearnerT = TypeVar("LearnerT", bound=Learner)

_SECONDS_BETWEEN_CHECKPOINTS = 5.0
_MOST_BYTES = 2**30
"""What a checkpoint may unpack to [bytes]."""
_REMEDY = "remove it to train anew, or choose another folder with --out"


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
            require_count("seed", seed, least=0)
            if seed >= 2**31:
                raise TegotaeError(f"seed is {seed}; it must be below 2^31 ({2**31})")
        if len(set(self.seeds)) < len(self.seeds):
            raise TegotaeError(f"seeds are {self.seeds}; each may be given only once")
        self.learner.check(self.experiment)

    @property
    def configuration(self) -> JsonObject:
        """What decides the result, but for how long is learned, as JSON values."""
        return self.learner.configuration(self.experiment, self.seeds)

    @cached_property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers, and the engine."""
        return {**self.learner.software, "engine": self.learner.engine(self.experiment)}

    def session(self) -> Session:
        """The learning, not yet begun.

        Raises:
            TegotaeError: for what cannot be learned, kept or held in memory.
        """
        return self.learner.session(self.experiment, self.seeds)


def train(
    run: Run[LearnerT],
    out: Path,
    *,
    anew: bool = False,
    on_step: Callable[[LearningStep], None] | None = None,
) -> list[Path]:
    """Train, or train on, in the folder `out`; return the controller files, one per seed.

    Written are `NAME-seedN.json` (the controllers), `curves.csv`
    (`tegotae.training.learner`), `run.json` (configuration and versions) and `checkpoint.npz`.
    Interrupted (Ctrl-C), it keeps what has been learned and raises `KeyboardInterrupt` again;
    called again on the same folder, it continues from there, and ends in the same numbers: a
    population behind its last generation, an agent with the seed that was interrupted.

    Args:
        run: what, how and for how long, from which seeds.
        out: the folder.
        anew: whether a training that is there before is set aside, in a folder beside it.
        on_step: called with each new step.

    Raises:
        TegotaeError: if the folder cannot be written, is in use or holds another training.
    """
    run.experiment.check()
    session = run.session()
    with alone(out, TRAINING, anew=anew):
        claim(out, run.configuration, run.software)
        _resume(run, session, out)
        return _train(run, session, out, on_step)


def _train(
    run: Run[LearnerT], session: Session, out: Path, on_step: Callable[[LearningStep], None] | None
) -> list[Path]:
    """The same, alone in the folder."""
    saved_at = -np.inf
    paths: list[Path] = []
    with reporting(run.experiment.name, session.length) as reporter:
        try:
            for step in session.steps():
                if time.monotonic() - saved_at > _SECONDS_BETWEEN_CHECKPOINTS:
                    _checkpoint(run, session, out)
                    saved_at = time.monotonic()
                reporter.update(step.done, step.report)
                if on_step is not None:
                    on_step(step)
        finally:
            _checkpoint(run, session, out)
            if points := session.points():
                write_curves(out / "curves.csv", points)
            paths = [_save(run, each, out) for each in session.learned()]
    return paths


def _save(run: Run[LearnerT], learned: LearnedController, out: Path) -> Path:
    return save_controller(
        out,
        experiment=run.experiment,
        controller=learned.controller,
        weights=learned.weights,
        configuration=run.configuration,
        outcome=learned.outcome,
        versions=run.software,
    )


def _resume(run: Run[LearnerT], session: Session, out: Path) -> None:
    """Take up the checkpoint, if there is one.

    Raises:
        TegotaeError: for one of another training, or that cannot be used.
    """
    path = out / "checkpoint.npz"
    if not path.exists():
        return
    with _useless(path):
        arrays = read_arrays(path, _MOST_BYTES)
        found = fitted(parse(str(arrays["configuration"])), dict)
    if names := differing(found, json.loads(json.dumps(run.configuration))):
        raise TegotaeError(f"{path} is of a training that differs in {', '.join(names)}; {_REMEDY}")
    with _useless(path):
        session.restore(arrays)


@contextmanager
def _useless(path: Path) -> Iterator[None]:
    """Say in one line of a checkpoint that cannot be used what is wrong."""
    try:
        yield
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (TypeError, ValueError, KeyError) as error:
        if isinstance(error, TegotaeError) and not isinstance(error, DamagedDocumentError):
            raise
        raise TegotaeError(f"{path} is damaged; {_REMEDY}") from None


def _checkpoint(run: Run[LearnerT], session: Session, out: Path) -> None:
    if arrays := session.arrays():
        arrays["configuration"] = np.array(json.dumps(run.configuration))
        stream = io.BytesIO()
        np.savez(stream, allow_pickle=False, **arrays)  # type: ignore[arg-type]
        write_atomically(out / "checkpoint.npz", stream.getvalue())
