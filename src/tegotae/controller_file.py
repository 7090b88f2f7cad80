"""Controllers on disk: a readable JSON file, self-describing, without pickle."""

from __future__ import annotations

import json
import math
import reprlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from tegotae import documents
from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller
from tegotae.descriptions import EditedPartError, describe, entry
from tegotae.documents import DamagedDocumentError
from tegotae.errors import TegotaeError
from tegotae.files import write_atomically
from tegotae.rollout import check_senses
from tegotae.weight_names import flat, nested, spelled

FORMAT = "tegotae controller"
VERSION = 3


@dataclass(frozen=True)
class SavedController:
    """A controller with its weights, and what it was trained for.

    Args:
        controller: the structure.
        weights: shape [n_weights].
        omega: the frequency it was trained at, ω_t [rad/s]; None without an oscillator.
        body: the body it was trained on.
        model: the model's name, if it is one of the registry's.
        training: how it was trained and how well that went; numbers, strings and lists only.
        software: versions of the programs that made it.
    """

    controller: Controller
    weights: np.ndarray
    omega: float | None
    body: Body = field(default_factory=Hopper)
    model: str | None = None
    training: dict[str, Any] = field(default_factory=dict)
    software: dict[str, str] = field(default_factory=dict)


def save(saved: SavedController, path: Path | str) -> None:
    """Write a controller file.

    Raises:
        TegotaeError: if it cannot be written, or its weights are not finite or of the wrong number.
    """
    weights = np.asarray(saved.weights, "float64")
    _check_weights(saved.controller, weights, str(path))
    _check_frequency(saved, f"{path} cannot be written")
    document = {
        "format": FORMAT,
        "version": VERSION,
        "model": saved.model,
        "omega_rad_per_s": None if saved.omega is None else float(saved.omega),
        "controller": describe(saved.controller),
        "weights": nested(saved.controller.weight_names, weights.tolist()),
        "body": describe(saved.body),
        "training": saved.training,
        "software": saved.software,
    }
    write_atomically(Path(path), json.dumps(document, indent=1) + "\n")


def load(path: Path | str) -> SavedController:
    """Read a controller file.

    Raises:
        TegotaeError: if there is none, or it is truncated, of another version, or not ours.
    """
    path = Path(path)
    try:
        document = documents.read(path)
    except FileNotFoundError:
        raise TegotaeError(f"no controller file at {path}") from None
    except DamagedDocumentError as error:
        what = f"is damaged: {error}" if _begins_as_ours(path) else _NOT_OURS
        raise TegotaeError(f"{path} {what}") from None
    if not is_controller(document):
        raise TegotaeError(f"{path} {_NOT_OURS}")
    if document.get("version") not in range(1, VERSION + 1):
        raise TegotaeError(
            f"{path} is of version {reprlib.repr(document.get('version'))}; "
            f"this program reads versions 1 to {VERSION}"
        )
    try:
        entries = documents.fitted(document, _Document)
        if document["version"] == 1:
            document = _of_version_1(document)
        omega = entry(document, "omega_rad_per_s", float | None)
        controller = entry(document, "controller", Controller)
        saved = SavedController(
            controller,
            np.asarray(_in_order(controller, entries.weights), "float64"),
            None if omega is None else float(omega),
            entry(document, "body", Body),
            entries.model,
            entries.training,
            entries.software,
        )
        check_senses(saved.controller, saved.body)
    except EditedPartError as error:
        raise TegotaeError(f"{path} {error}") from None
    except KeyError as error:
        raise TegotaeError(f"{path} is damaged: it has no entry {error}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    _check_weights(saved.controller, saved.weights, str(path))
    if saved.omega is not None and not math.isfinite(saved.omega):
        raise TegotaeError(f"{path} is damaged: its frequency is {saved.omega}")
    _check_frequency(saved, f"{path} is damaged")
    return saved


def _check_frequency(saved: SavedController, where: str) -> None:
    if saved.omega is None and saved.controller.oscillator is not None:
        raise TegotaeError(f"{where}: it has an oscillator but no frequency")
    if saved.omega is not None and saved.controller.oscillator is None:
        raise TegotaeError(f"{where}: it has a frequency but no oscillator")


def is_controller(document: Any) -> bool:
    """Whether a JSON value is a controller file's and no other document."""
    return isinstance(document, dict) and document.get("format") == FORMAT


class _Document(msgspec.Struct):
    """A controller file, but for its parts, whose kinds say what they hold."""

    controller: dict[str, Any]
    weights: dict[str, Any] | list[float]
    """By their names; up to version 2 one list in the controller's order."""
    omega_rad_per_s: float | None
    body: dict[str, Any]
    model: str | None
    training: dict[str, Any]
    software: dict[str, str]


def _in_order(controller: Controller, weights: dict[str, Any] | list[float]) -> list[float]:
    """The weights of a file in the controller's order."""
    if isinstance(weights, list):
        return weights
    paths = controller.weight_names
    values = flat(paths, weights)
    for path, value in zip(paths, values, strict=True):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise DamagedDocumentError(
                f"its {spelled(('weights', *path))} is {reprlib.repr(value)}; it must be a number"
            )
    return values


_NOT_OURS = "is not a controller file of tegotae"


def _begins_as_ours(path: Path) -> bool:
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


def _of_version_1(document: dict[str, Any]) -> dict[str, Any]:
    """A document of version 1 as one of this version.

    There the terms of the feedback lay beside the actuation, and a controller without an oscillator
    had the frequency 0.
    """
    parts = dict(entry(document, "controller", dict))
    if "action" in parts:
        own = [name for name in ("limit_rad_per_s",) if name in parts]
        names = ["action", "reaction", "gain", *own]
        parts["tegotae"] = {name: parts.pop(name) for name in names}
    omega = float(entry(document, "omega_rad_per_s", float))
    return {
        **document,
        "controller": parts,
        "omega_rad_per_s": omega if "oscillator" in parts else None,
    }
