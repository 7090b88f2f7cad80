"""Controllers on disk: a readable JSON file, self-describing, without pickle."""

from __future__ import annotations

import dataclasses
import json
import reprlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypedDict, TypeGuard, Unpack

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body, Hopper, Interface
from tegotae.parts.controller import Controller
from tegotae.parts.weight_names import flat, nested, spelled
from tegotae.systems.controller_set import EnvTask
from tegotae.systems.descriptions import (
    UsersPartError,
    describe,
    entry,
    restore,
)
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import System, usual_system
from tegotae.systems.zoo import documents as zoo_documents
from tegotae.systems.zoo import is_zoo_name

FORMAT = "tegotae controller"
VERSION = 4


class _More(TypedDict, total=False):
    """Fields of a `SavedController` beside its system and weights."""

    name: str | None
    experiment: Experiment | None
    task: EnvTask | None
    training: JsonObject
    software: dict[str, str]


@dataclass(frozen=True)
class SavedController:
    """A system with its weights, and how they were found.

    Args:
        system: controller, body, frequency, release, timing and integrator.
        weights: shape [n_weights].
        name: the experiment's or model's name; None if it has none.
        experiment: what was trained, and how it is evaluated; None where the file does not say.
        task: what was trained on an environment; None of a training on the engine.
        training: settings and result of the training; numbers, strings and lists only.
        software: versions of the programs that made it.

    Raises:
        TegotaeError: for an experiment on another system.
    """

    system: System
    weights: np.ndarray
    name: str | None = None
    experiment: Experiment | None = None
    task: EnvTask | None = None
    training: JsonObject = field(default_factory=dict[str, Json])
    software: dict[str, str] = field(default_factory=dict[str, str])

    @classmethod
    def of(
        cls,
        controller: Controller,
        weights: LaneNumbers,
        omega: float | None = None,
        body: Body | None = None,
        **more: Unpack[_More],
    ) -> SavedController:
        """A controller on a body, released and timed as is usual for the body.

        Args:
            controller: the structure.
            weights: shape [n_weights].
            omega: ω [rad/s]; None without an oscillator.
            body: the body; the paper's hopper by default.
            more: further fields of the saved controller.

        Raises:
            TegotaeError: for what does not fit together.

        Example:
            >>> from tegotae.systems.models import build
            >>> SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0).omega
            8.0
        """
        body = Hopper() if body is None else body
        return cls(usual_system(controller, body, omega), np.asarray(weights), **more)

    def replaced(self, **changes: object) -> SavedController:
        """The same weights in another system: other fields of the system or its release.

        Raises:
            TegotaeError: for what does not fit together.
        """
        return dataclasses.replace(self, system=self.system.replaced(changes))

    @property
    def controller(self) -> Controller:
        """The structure."""
        return self.system.controller

    @property
    def body(self) -> Body:
        """The body, which moves here (`System.mechanics`)."""
        return self.system.mechanics

    @property
    def omega(self) -> float | None:
        """The frequency [rad/s]; None without an oscillator."""
        return self.system.omega


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
    """What a file of the controller holds, as JSON values.

    Args:
        saved: the system, its weights and how they were trained.
        path: the file, for errors.

    Raises:
        TegotaeError: if its weights are not finite or of the wrong number.
    """
    weights = np.asarray(saved.weights, "float64")
    _check_weights(saved.controller, weights, path)
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": saved.name,
        "system": _system(saved.system),
        "weights": nested(saved.controller.weight_names, weights.tolist()),
        "experiment": _beside_system(saved),
        "task": None if saved.task is None else msgspec.to_builtins(saved.task),
        "training": saved.training,
        "software": saved.software,
    }


def _system(system: System) -> JsonObject:
    """A system's document; of limbs elsewhere without release and times, which are not known."""
    document: JsonObject = describe(system)
    if not isinstance(system.body, Interface):
        return document
    return {name: document[name] for name in ("controller", "body", "omega")}


def _beside_system(saved: SavedController) -> JsonObject | None:
    """The experiment without its system, which the file has itself.

    An agent's policy limits its feedback, which the controller of its experiment does not: the
    controller is then kept, too.
    """
    if saved.experiment is None:
        return None
    document: JsonObject = describe(saved.experiment)
    system = document.pop("system")
    if saved.experiment.system != saved.system:
        document["system"] = system
    return document


def load(path: Path | str) -> SavedController:
    """Read a controller file, or a controller of the zoo.

    Args:
        path: the file, or a name of the zoo (`tegotae.systems.zoo.file`).

    Raises:
        TegotaeError: if there is none, or it is truncated, of another version, or not ours; or
            for a name that stands for several.
    """
    if is_zoo_name(str(path)):
        (name, document), *others = zoo_documents(str(path))
        if others:
            raise TegotaeError(f"{path} holds {1 + len(others)} controllers; name one, as {name}")
        return restored(document, name)
    path = Path(path)
    try:
        document = documents.read(path)
    except FileNotFoundError:
        raise TegotaeError(f"no controller file at {path}") from None
    except DamagedDocumentError as error:
        what = f"is damaged: {error}" if begins_as_ours(path) else NOT_OURS
        raise TegotaeError(f"{path} {what}") from None
    return restored(document, str(path))


def restored(document: Json, path: str) -> SavedController:
    """The controller of a document (`described`).

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
        system = entry(document, "system", System)
        experiment = None
        if entries.experiment is not None:
            whole = {"system": document["system"], **entries.experiment}
            experiment = restore(whole, Experiment, "experiment")
        weights = np.asarray(_in_order(system.controller, entries.weights), "float64")
    except UsersPartError as error:
        raise TegotaeError(f"{path} {error}") from None
    except KeyError as error:
        raise TegotaeError(f"{path} is damaged: it has no entry {error}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    _check_weights(system.controller, weights, path)
    return SavedController(
        system,
        weights,
        entries.name,
        experiment,
        entries.task,
        entries.training,
        entries.software,
    )


def is_controller(document: Json) -> TypeGuard[JsonObject]:
    """Whether a JSON value is a controller file's and no other document."""
    return isinstance(document, dict) and document.get("format") == FORMAT


class _ControllerFile(msgspec.Struct):
    """A controller file, but for its parts, whose kinds say what they hold."""

    system: JsonObject
    weights: JsonObject | list[float]
    """By their names, or one list in the controller's order, as the zoo gives them."""
    name: str | None
    experiment: JsonObject | None
    training: JsonObject
    software: dict[str, str]
    task: EnvTask | None = None


def _in_order(controller: Controller, weights: JsonObject | list[float]) -> list[float]:
    """The weights of a file in the controller's order."""
    if isinstance(weights, list):
        return weights
    paths = controller.weight_names
    values = flat(paths, weights)
    numbers: list[float] = []
    for path, value in zip(paths, values, strict=True):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise DamagedDocumentError(
                f"its {spelled(('weights', *path))} is {reprlib.repr(value)}; it must be a number"
            )
        numbers.append(value)
    return numbers


NOT_OURS = "is not a controller file of tegotae"


def begins_as_ours(path: Path) -> bool:
    """Whether a file that is no whole document begins as a controller's."""
    with path.open("rb") as stream:
        first = stream.read(200)
    return first.lstrip().startswith(b"{") and FORMAT.encode() in first


def _check_weights(controller: Controller, weights: np.ndarray, path: str) -> None:
    if weights.shape != (controller.n_weights,):
        raise TegotaeError(
            f"{path}: the controller has {controller.n_weights} weights, not shape {weights.shape}"
        )
    if not np.isfinite(weights).all():
        raise TegotaeError(f"{path}: {int((~np.isfinite(weights)).sum())} weights are not finite")
