"""A training: what is learned, how, from which seeds; in a folder, from which it goes on.

Whatever learns leaves the same files, and goes on by the same rule: a folder belongs to one
training (`run.json`), which begins at the state in `checkpoint.npz`, if there is one.
"""

from __future__ import annotations

import dataclasses
import io
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec
import numpy as np
import pandas as pd

from tegotae._support import documents
from tegotae._support.documents import (
    DamagedDocumentError,
    Json,
    JsonObject,
    differing,
    fitted,
    parse_json,
)
from tegotae._support.engines import check_jax, require_engine
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.files import read_arrays, write_atomically
from tegotae._support.progress import reporting
from tegotae._support.tables import parse_csv, parse_numbers, write_csv
from tegotae._support.workplace import TRAINING, alone
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.descriptions import check_kept
from tegotae.systems.experiment import Trainable
from tegotae.training.evolution import Evolution
from tegotae.training.learner import (
    CurvePoint,
    LearnedController,
    Learner,
    TrainingState,
)

LearnerT = TypeVar("LearnerT", bound=Learner)

_SECONDS_BETWEEN_CHECKPOINTS = 5.0
COLUMNS = CurvePoint._fields
"""The columns of `curves.csv`."""
_MOST_BYTES = 2**30
"""Size limit of an unpacked checkpoint [bytes]."""
_OTHER = "choose another folder with --out, or start again with --restart"
_REMEDY = "remove it to train anew, or choose another folder with --out"


@dataclass(frozen=True, kw_only=True)
class Run(Generic[LearnerT]):
    """A training: experiment, learner, seeds and length.

    Args:
        experiment: what is trained, on what, by what measure: on the engine, or on an environment.
        learner: learning algorithm and its budget: a population (`Evolution`), an agent
            (`tegotae.training.agents.learner.AgentLearner`), or a `Learner` of your own.
        seeds: one training from random weights each.

    Raises:
        TegotaeError: for seeds that are no distinct numbers from 0 to 2^31 - 1, an experiment that
            this learner cannot learn, or settings of JAX with which results would be others.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> Run(experiment=recipe("AR").experiment(), seeds=(0, 1)).learner.UNIT
        'generation'
    """

    experiment: Trainable
    learner: LearnerT = field(default_factory=Evolution)  # type: ignore[assignment]
    seeds: tuple[int, ...] = (0, 1, 2)

    def __post_init__(self) -> None:
        check_jax()
        require_count("seeds", len(self.seeds))
        for seed in self.seeds:
            require_count("seed", seed, least=0, most=2**31 - 1)
        if len(set(self.seeds)) < len(self.seeds):
            raise TegotaeError(f"seeds are {self.seeds}; each may be given only once")
        self.learner.check(self)

    @property
    def configuration(self) -> JsonObject:
        """Return the settings that decide the result, except the duration, as JSON values."""
        return self.learner.configuration(self)

    @cached_property
    def software(self) -> dict[str, str]:
        """Versions of the programs that decide the numbers, and the engine."""
        return {**self.learner.software, "engine": self.learner.engine(self.experiment)}

    def learn(self) -> Iterator[TrainingState]:
        """Learn step by step, from the beginning, and keep nothing in files."""
        return self.learner.learn(self)


def train(
    run: Run[LearnerT],
    out: Path,
    *,
    restart: bool = False,
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
        restart: whether a training that is there before is set aside, in a folder beside it.
        on_step: called with the state after each step.

    Raises:
        TegotaeError: if the folder cannot be written, is in use or holds another training.
    """
    experiment, learner = run.experiment, run.learner
    experiment.check()
    check_kept(learner)
    configuration, software = run.configuration, run.software
    with alone(out, TRAINING, restart=restart):
        claim(out, configuration, software)
        state = begun = read_checkpoint(out, run)
        saved_at = -np.inf
        with reporting(experiment.name, learner.length(run)) as reporter:
            try:
                for state in learner.learn(run, begun):
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


class _NamedEntry(msgspec.Struct):
    name: str


class _Configuration(msgspec.Struct):
    experiment: _NamedEntry
    algorithm: _NamedEntry


class _Software(msgspec.Struct):
    engine: str


class _RunDocument(msgspec.Struct):
    configuration: _Configuration
    software: _Software


def run_document(folder: Path) -> dict[str, Any]:
    """Read `run.json` of a folder: `configuration` and `software`.

    Raises:
        FileNotFoundError: if there is none.
        TegotaeError: if it cannot be read, or is damaged.
    """
    path = folder / "run.json"
    try:
        document: Any = documents.read(path)
        fitted(document, _RunDocument)
    except DamagedDocumentError as error:
        raise TegotaeError(
            f"{path} is damaged: {error}; choose another folder with --out"
        ) from None
    return document


def claim(out: Path, configuration: Mapping[str, Json], software: Mapping[str, str]) -> None:
    """Write the purpose of the folder into `run.json`, or check that its content belongs to this
    training.

    Args:
        out: the folder.
        configuration: of the training.
        software: versions of the programs that decide its numbers, and the engine.

    Raises:
        TegotaeError: if the folder holds another training, one that another engine or other
            versions of the programs have begun, or cannot be written.
    """
    expected = json.loads(json.dumps(configuration))
    if any(out.glob("checkpoint*")) or any(out.glob("*-seed*.json")):
        try:
            begun = run_document(out)
        except FileNotFoundError:
            raise TegotaeError(
                f"{out} holds a training but no run.json; choose another folder with --out"
            ) from None
        if names := differing(begun["configuration"], expected):
            name = begun["configuration"]["experiment"]["name"]
            raise TegotaeError(
                f"{out} holds a training of {name} that differs in {', '.join(names)}; {_OTHER}"
            )
        holder = f"{out} holds a training"
        theirs = begun["software"]
        require_engine(theirs["engine"], holder, _OTHER, software["engine"])
        changed = [name for name in software if theirs.get(name, software[name]) != software[name]]
        if changed:  # the rest would have other bits
            recorded = ", ".join(f"{name} {theirs[name]}" for name in changed)
            installed = ", ".join(f"{name} {software[name]}" for name in changed)
            raise TegotaeError(
                f"{holder} made with {recorded}, and here is {installed}, whose numbers may "
                f"differ; install those versions, {_OTHER}"
            )
    document = {"configuration": expected, "software": dict(software)}
    write_atomically(out / "run.json", json.dumps(document, indent=1) + "\n")


def write_checkpoint(out: Path, configuration: Mapping[str, Json], state: TrainingState) -> None:
    """Write the state from which the training continues into `checkpoint.npz`, if there is one.

    Args:
        out: the folder.
        configuration: of the training.
        state: what it has come to.
    """
    if state.arrays:
        stream = io.BytesIO()
        points = np.array(state.points, "float64")
        text = np.array(json.dumps(configuration))
        np.savez(stream, allow_pickle=False, configuration=text, points=points, **state.arrays)
        write_atomically(out / "checkpoint.npz", stream.getvalue())


def read_checkpoint(out: Path, run: Run[Any]) -> TrainingState:
    """Read the state that the training in a folder resumes from; the initial one, if there is no
    checkpoint.

    Args:
        out: the folder.
        run: the training.

    Raises:
        TegotaeError: for a checkpoint of another training, or that cannot be used.
    """
    path = out / "checkpoint.npz"
    if not path.exists():
        return TrainingState()
    try:
        arrays = read_arrays(path, _MOST_BYTES)
        document = fitted(parse_json(str(arrays.pop("configuration"))), dict)
        if names := differing(document, json.loads(json.dumps(run.configuration))):
            raise TegotaeError(
                f"{path} is of a training that differs in {', '.join(names)}; {_REMEDY}"
            )
        rows = arrays.pop("points").tolist()
        points = tuple(CurvePoint(int(row[0]), *row[1:]) for row in rows)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (TypeError, ValueError, KeyError) as error:
        if isinstance(error, TegotaeError) and not isinstance(error, DamagedDocumentError):
            raise
        raise TegotaeError(f"{path} is damaged; {_REMEDY}") from None
    try:
        return run.learner.resumed(run, points, arrays)
    except (TypeError, ValueError, KeyError) as error:
        if isinstance(error, TegotaeError):
            raise
        raise TegotaeError(
            f"{path} is of another version of this learner, from which it cannot continue; {_OTHER}"
        ) from None


def write_curves(path: Path, points: Sequence[CurvePoint]) -> None:
    """Write the points of all seeds, each seed's together.

    Args:
        path: the file.
        points: of all seeds, in any order.
    """
    rows = pd.DataFrame(points, columns=COLUMNS).sort_values(["seed", "step"])
    write_csv(path, {name: rows[name] for name in COLUMNS}, digits=6)


def curves_of(path: Path) -> pd.DataFrame:
    """Return the columns `COLUMNS` of a `curves.csv`, one row per point.

    Args:
        path: the file.

    Raises:
        TegotaeError: for a file that cannot be read or is no such table.
    """
    try:
        cells = parse_csv(path.read_text(encoding="utf-8"))
        if tuple(cells) != COLUMNS:
            raise ValueError(f"its columns are not {', '.join(COLUMNS)}")
        points = pd.DataFrame({name: parse_numbers(column) for name, column in cells.items()})
        if not np.isfinite(points["simulated_s"]).all():
            raise ValueError("a simulated time is missing")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    return points


def save_controller(
    out: Path,
    experiment: Trainable,
    learned: LearnedController,
    configuration: Mapping[str, Json],
    software: Mapping[str, str],
) -> Path:
    """Write `NAME-seedN.json`, the controller that the training of one seed ended in.

    Args:
        out: the folder.
        experiment: what was trained.
        learned: what it has come to.
        configuration: how it was trained.
        software: versions of the programs that made it.
    """
    path = out / f"{experiment.name}-seed{learned.outcome['seed']}.json"
    training = {name: entry for name, entry in configuration.items() if name != "experiment"}
    saved = SavedController(
        dataclasses.replace(experiment.system, controller=learned.controller),
        learned.weights,
        name=experiment.name,
        experiment=experiment if experiment.task is None else None,  # type: ignore[arg-type]
        task=experiment.task,
        training={**training, **learned.outcome},
        software=dict(software),
    )
    controller_file.save(saved, path)
    return path
