"""Controllers with their weights: a readable JSON file, a folder of them, a study's records."""

from __future__ import annotations

import json
import os
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeGuard

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae._support.workplace import is_earlier
from tegotae.measures.evaluation import Protocol
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body, Hopper, Interface
from tegotae.parts.controller import Controller
from tegotae.parts.weight_names import flat, nested, spelled
from tegotae.study import CellResult
from tegotae.systems.descriptions import UsersPartError, describe, restore
from tegotae.systems.env_documents import EnvTask
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import OnSystem, System, usual_system
from tegotae.systems.zoo import documents as zoo_documents, is_zoo_name

FORMAT = "tegotae controller"
VERSION = 4
NOT_OURS = "is not a controller file of tegotae"


@dataclass(frozen=True)
class SavedController(OnSystem):
    """A system with its weights, and how they were found.

    Args:
        system: controller, body, frequency, release, timing and integrator.
        weights: shape [n_weights].
        name: the experiment's or model's name; None if it has none.
        experiment: what was trained, and how it is evaluated; None where the file does not say.
        task: what was trained on an environment; None of a training on the engine.
        training: settings and result of the training; numbers, strings and lists only.
        software: versions of the programs that made it.
    """

    system: System
    weights: np.ndarray
    name: str | None = None
    experiment: Experiment | None = None
    task: EnvTask | None = None
    training: JsonObject = field(default_factory=dict[str, Json])
    software: dict[str, str] = field(default_factory=dict[str, str])

    @classmethod
    def from_weights(
        cls,
        controller: Controller,
        weights: LaneNumbers,
        omega: float | None = None,
        body: Body | None = None,
        **fields: Any,
    ) -> SavedController:
        """Return a controller on a body, with the body's usual release and timing.

        Args:
            controller: the structure.
            weights: shape [n_weights].
            omega: ω [rad/s]; None without an oscillator.
            body: the body; the paper's hopper by default.
            more: further fields of the saved controller.

        Raises:
            TegotaeError: for what does not fit together.

        Example:
            >>> from tegotae.systems.recipe import recipe
            >>> controller = recipe("V-reflex-w8").controller()
            >>> SavedController.from_weights(controller, np.array([2.0]), 8.0).omega
            8.0
        """
        body = Hopper() if body is None else body
        return cls(usual_system(controller, body, omega), np.asarray(weights), **fields)


@dataclass(frozen=True)
class ControllerSet(OnSystem):
    """A system with several vectors of weights, such as one per seed of a training.

    Args:
        name: the model's name, or the file's; of several trainings also what differs in this one.
        system: the closed loop that the runs share.
        weights: shape [runs, n_weights].
        labels: one per run: its seed, or its file's name.
        training: how they were trained, the same for all, as JSON values; empty if not known.
        experiment: what was trained, and how it is evaluated; None if not known.
        task: the same of limbs that another simulator moves.
    """

    name: str
    system: System
    weights: np.ndarray
    labels: tuple[str, ...]
    training: Mapping[str, Json] = field(default_factory=dict[str, Json])
    experiment: Experiment | None = None
    task: EnvTask | None = None

    @property
    def protocol(self) -> Protocol:
        """Conditions of its evaluation: those of its experiment, from its system's release.

        What is held over a control period keeps that period (`System.evaluated_by`).
        """
        trained = Protocol() if self.experiment is None else self.experiment.protocol
        return self.system.evaluated_by(trained)


def save(saved: SavedController, path: Path | str) -> None:
    """Write a controller file.

    Args:
        saved: the system, its weights and how they were trained.
        path: the file.

    Raises:
        TegotaeError: if it cannot be written, or its weights are not finite or of the wrong number.
    """
    document = described(saved, str(path))
    write_atomically(Path(path), json.dumps(document, indent=1) + "\n")


def described(saved: SavedController, path: str) -> JsonObject:
    """Return the content of the controller's file, as JSON values.

    Args:
        saved: the system, its weights and how they were trained.
        path: the file, for errors.

    Raises:
        TegotaeError: if its weights are not finite or of the wrong number.
    """
    weights = np.asarray(saved.weights, "float64")
    _check_weights(saved.controller, weights, path)
    system, trained = describe(saved.system), None
    if isinstance(saved.system.body, Interface):  # whose release and times are not known
        system = {name: system[name] for name in ("controller", "body", "omega")}
    if saved.experiment is not None:
        trained = describe(saved.experiment)
        of_training = trained.pop("system")
        # An agent's policy limits its feedback, which its experiment's controller does not.
        trained |= {} if saved.experiment.system == saved.system else {"system": of_training}
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": saved.name,
        "system": system,
        "weights": nested(saved.controller.weight_names, weights.tolist()),
        "experiment": trained,
        "task": None if saved.task is None else msgspec.to_builtins(saved.task),
        "training": saved.training,
        "software": saved.software,
    }


def load(path: Path | str) -> SavedController:
    """Read a controller file, or a controller of the zoo.

    Args:
        path: the file, or a name of the zoo (`tegotae.systems.zoo`).

    Raises:
        TegotaeError: if there is none, or it is truncated, of another version, or not ours; or
            for a name that stands for several.
    """
    if is_zoo_name(str(path)):
        (name, document), *further = zoo_documents(str(path))
        if further:
            raise TegotaeError(f"{path} holds {1 + len(further)} controllers; name one, as {name}")
        return restored(document, name)
    path = Path(path)
    try:
        document = documents.read(path)
    except FileNotFoundError:
        raise TegotaeError(f"no controller file at {path}") from None
    except DamagedDocumentError as error:
        complaint = f"is damaged: {error}" if begins_as_ours(path) else NOT_OURS
        raise TegotaeError(f"{path} {complaint}") from None
    return restored(document, str(path))


def restored(document: Json, path: str) -> SavedController:
    """Return the controller of a document (`described`).

    Args:
        document: as it was read.
        path: the file, for errors.

    Raises:
        TegotaeError: if it is damaged, of another version, or not ours.
    """
    if not is_controller(document):
        raise TegotaeError(f"{path} {NOT_OURS}")
    if document.get("version") != VERSION:
        raise TegotaeError(
            f"{path} is of version {reprlib.repr(document.get('version'))}; "
            f"this program reads version {VERSION}"
        )
    try:
        entries = documents.fitted(document, _ControllerFile)
        system = restore(entries.system, System, "system")
        trained = entries.experiment
        if trained is not None:
            trained = restore({"system": entries.system, **trained}, Experiment, "experiment")
        weights = np.asarray(_in_order(system.controller, entries.weights), "float64")
    except UsersPartError as error:
        raise TegotaeError(f"{path} {error}") from None
    except TegotaeError as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    _check_weights(system.controller, weights, path)
    fields = entries.name, trained, entries.task, entries.training, entries.software
    return SavedController(system, weights, *fields)


def is_controller(document: Json) -> TypeGuard[JsonObject]:
    """Return whether a JSON value is a controller file's and no other document."""
    return isinstance(document, dict) and document.get("format") == FORMAT


def begins_as_ours(path: Path) -> bool:
    """Return whether an incomplete document begins like a controller file."""
    with path.open("rb") as stream:
        first = stream.read(200)
    return first.lstrip().startswith(b"{") and FORMAT.encode() in first


def controller_files(folder: Path) -> list[Path]:
    """Return the controller files in a folder and its subfolders, without other documents and those
    set aside for a new beginning.

    Raises:
        TegotaeError: if a file may be a controller's and cannot be read: empty, cut short, without
            permission.
    """
    return [file for file in _json_files(folder) if _is_controller(file)]


def _json_files(folder: Path) -> list[Path]:
    """Return all JSON files in a folder and its subfolders, except those set aside for a new
    beginning.
    """

    def refuse(error: OSError) -> None:
        raise TegotaeError(f"cannot read {error.filename}: {error.strerror}") from None

    return sorted(
        Path(place, name)
        for place, _, names in os.walk(folder, onerror=refuse)
        if not any(map(is_earlier, Path(place).relative_to(folder).parts))
        for name in names
        if name.endswith(".json")
    )


def _is_controller(path: Path) -> bool:
    """Return whether a JSON file is a controller's and no other document.

    Raises:
        TegotaeError: if that cannot be decided.
    """
    try:
        return is_controller(documents.read(path))
    except FileNotFoundError as error:  # a link to nowhere
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except DamagedDocumentError as error:
        complaint = f"damaged: {error}" if path.stat().st_size else "empty"
        raise TegotaeError(f"{path} is {complaint}; remove it from the folder") from None


_DESCRIPTION = "study.json"
"""File in a study's folder that describes the study."""
_RECORDS = "records"
"""The folder in it that has the records."""
SUFFIX = ".record.npz"
"""Suffix of a record's file."""
NOT_OF_THE_TRAINING = frozenset({"format", "experiment", "seeds", "budgets", "metrics"})
"""Entries of a record's configuration that say nothing of how was trained."""


def is_study(folder: Path) -> bool:
    """Return whether a folder holds a study."""
    return (folder / _DESCRIPTION).exists()


def controllers_of_study(folder: Path) -> tuple[tuple[Path, SavedController], ...]:
    """Return the controllers of a study's whole records, seed by seed.

    Raises:
        TegotaeError: if it has no whole record, a description that is damaged, or a part that is
            not registered.
    """
    described = documents.read(folder / _DESCRIPTION)
    experiments = described.get("experiments") if isinstance(described, dict) else None
    controllers: list[tuple[Path, SavedController]] = []
    damaged: list[str] = []
    for path in sorted((folder / _RECORDS).glob(f"*{SUFFIX}")):
        try:
            result = CellResult.read(path)
        except DamagedDocumentError as error:
            damaged.append(str(error))
            continue
        configuration = result.document
        document = configuration["experiment"]
        if isinstance(experiments, dict) and document["name"] not in experiments:
            continue  # of another study that was here
        experiment = Experiment.from_document(document)
        training = {n: x for n, x in configuration.items() if n not in NOT_OF_THE_TRAINING}
        controllers += [
            (
                path,
                SavedController(
                    experiment.system,
                    np.asarray(weights, float),
                    experiment.name,
                    experiment,
                    training={**training, "seed": seed},
                    software=result.software,
                ),
            )
            for seed, weights in zip(configuration["seeds"], result.arrays["weights"], strict=True)
        ]
    if not controllers:
        raise TegotaeError(f"{folder} has no record that is whole: {'; '.join(damaged) or 'none'}")
    return tuple(controllers)


class _ControllerFile(msgspec.Struct):
    """A controller file without its parts, whose own classes check their entries."""

    system: JsonObject
    weights: JsonObject | list[float]
    """Weights by their names, or one list in the controller's order, as the zoo stores them."""
    name: str | None
    experiment: JsonObject | None
    training: JsonObject
    software: dict[str, str]
    task: EnvTask | None = None


def _in_order(controller: Controller, weights: JsonObject | list[float]) -> list[float]:
    """Return the weights of a file in the controller's order."""
    if isinstance(weights, list):
        return weights
    paths = controller.weight_names
    values = zip(paths, flat(paths, weights), strict=True)
    return [documents.fitted(x, float, spelled(("weights", *path))) for path, x in values]


def _check_weights(controller: Controller, weights: np.ndarray, path: str) -> None:
    if weights.shape != (controller.n_weights,):
        raise TegotaeError(
            f"{path}: the controller has {controller.n_weights} weights, not shape {weights.shape}"
        )
    if not np.isfinite(weights).all():
        raise TegotaeError(f"{path}: {int((~np.isfinite(weights)).sum())} weights are not finite")
