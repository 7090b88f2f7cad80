"""What every training leaves in its folder: what it is for, a checkpoint, curves, controllers."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, differing, fitted, parse
from tegotae._support.engines import require_engine
from tegotae._support.errors import TegotaeError
from tegotae._support.files import read_arrays, write_atomically
from tegotae._support.tables import numbers, parse_csv, write_csv
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.experiment import Experiment
from tegotae.training.learner import CurvePoint, LearnedController, Trainable, TrainingState

COLUMNS = CurvePoint._fields
"""The columns of `curves.csv`."""
_MOST_BYTES = 2**30
"""What a checkpoint may unpack to [bytes]."""
_OTHER = "choose another folder with --out, or start again with --anew"
_REMEDY = "remove it to train anew, or choose another folder with --out"


class _NamedEntry(msgspec.Struct):
    name: str


class _Configuration(msgspec.Struct):
    """What every training says of itself."""

    experiment: _NamedEntry
    algorithm: _NamedEntry


class _Software(msgspec.Struct):
    engine: str


class RunDocument(msgspec.Struct):
    """What `run.json` holds."""

    configuration: dict[str, Any]
    software: dict[str, str]

    @classmethod
    def read(cls, folder: Path) -> RunDocument:
        """That of a folder.

        Raises:
            FileNotFoundError: if there is none.
            TegotaeError: if it cannot be read, or is damaged.
        """
        path = folder / "run.json"
        try:
            document = fitted(documents.read(path), cls)
            fitted(document.configuration, _Configuration)
            fitted(document.software, _Software)
        except DamagedDocumentError as error:
            raise TegotaeError(
                f"{path} is damaged: {error}; choose another folder with --out"
            ) from None
        return document


def claim(out: Path, configuration: Mapping[str, Json], software: Mapping[str, str]) -> None:
    """Write into `run.json` what the folder is for, or see that what is in it is of this training.

    Args:
        out: the folder.
        configuration: of the training.
        software: versions of the programs that decide its numbers, and the engine.

    Raises:
        TegotaeError: if the folder holds another training, one that another engine or other
            versions of the programs have begun, or cannot be written.
    """
    wanted = json.loads(json.dumps(configuration))
    if any(out.glob("checkpoint*")) or any(out.glob("*-seed*.json")):
        try:
            begun = RunDocument.read(out)
        except FileNotFoundError:
            raise TegotaeError(
                f"{out} holds a training but no run.json; choose another folder with --out"
            ) from None
        if names := differing(begun.configuration, wanted):
            name = begun.configuration["experiment"]["name"]
            raise TegotaeError(
                f"{out} holds a training of {name} that differs in {', '.join(names)}; {_OTHER}"
            )
        holder = f"{out} holds a training"
        require_engine(begun.software["engine"], holder, _OTHER, software["engine"])
        _require_versions(holder, begun.software, software)
    document = {"configuration": wanted, "software": dict(software)}
    write_atomically(out / "run.json", json.dumps(document, indent=1) + "\n")


def _require_versions(holder: str, theirs: Mapping[str, str], ours: Mapping[str, str]) -> None:
    """Raise `TegotaeError` if other versions made what is there: the rest would have other bits."""
    others = [name for name in ours if theirs.get(name, ours[name]) != ours[name]]
    if others:
        made = ", ".join(f"{name} {theirs[name]}" for name in others)
        here = ", ".join(f"{name} {ours[name]}" for name in others)
        raise TegotaeError(
            f"{holder} made with {made}, and here is {here}, whose numbers may differ; install "
            f"those versions, {_OTHER}"
        )


def write_checkpoint(out: Path, configuration: Mapping[str, Json], state: TrainingState) -> None:
    """Write into `checkpoint.npz` what the training goes on from, if that is anything.

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


def read_checkpoint(
    out: Path,
    configuration: Mapping[str, Json],
    resumed: Callable[[tuple[CurvePoint, ...], dict[str, np.ndarray]], TrainingState],
) -> TrainingState:
    """Where the training in a folder goes on; at the beginning, if there is no checkpoint.

    Args:
        out: the folder.
        configuration: of the training.
        resumed: makes a state of the points and arrays of `checkpoint.npz` (`Learner.resumed`).

    Raises:
        TegotaeError: for a checkpoint of another training, or that cannot be used.
    """
    path = out / "checkpoint.npz"
    if not path.exists():
        return TrainingState()
    try:
        arrays = read_arrays(path, _MOST_BYTES)
        document = fitted(parse(str(arrays.pop("configuration"))), dict)
        if names := differing(document, json.loads(json.dumps(configuration))):
            raise TegotaeError(
                f"{path} is of a training that differs in {', '.join(names)}; {_REMEDY}"
            )
        rows = arrays.pop("points").tolist()
        return resumed(tuple(CurvePoint(int(row[0]), *row[1:]) for row in rows), arrays)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (TypeError, ValueError, KeyError) as error:
        if isinstance(error, TegotaeError) and not isinstance(error, DamagedDocumentError):
            raise
        raise TegotaeError(f"{path} is damaged; {_REMEDY}") from None


def write_curves(path: Path, points: Sequence[CurvePoint]) -> None:
    """Write the points of all seeds, each seed's together.

    Args:
        path: the file.
        points: of all seeds, in any order.
    """
    rows = pd.DataFrame(points, columns=COLUMNS).sort_values(["seed", "step"])
    write_csv(path, {name: rows[name] for name in COLUMNS}, digits=6)


def curves_of(path: Path) -> pd.DataFrame:
    """The columns `COLUMNS` of a `curves.csv`, a row a point.

    Args:
        path: the file.

    Raises:
        TegotaeError: for a file that cannot be read or is no such table.
    """
    try:
        cells = parse_csv(path.read_text(encoding="utf-8"))
        if tuple(cells) != COLUMNS:
            raise ValueError(f"its columns are not {', '.join(COLUMNS)}")
        points = pd.DataFrame({name: numbers(column) for name, column in cells.items()})
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
        experiment=experiment if isinstance(experiment, Experiment) else None,
        task=experiment.task,
        training={**training, **learned.outcome},
        software=dict(software),
    )
    controller_file.save(saved, path)
    return path
