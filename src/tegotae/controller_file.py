"""Controllers on disk: a readable JSON file, self-describing, without pickle."""

from __future__ import annotations

import dataclasses
import json
import math
import reprlib
from dataclasses import dataclass, field
from pathlib import Path
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from tegotae import bodies, oscillators, terms
from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller, Tegotae
from tegotae.errors import TegotaeError
from tegotae.files import write_atomically
from tegotae.oscillators import Oscillator
from tegotae.rollout import check_senses
from tegotae.terms import Actuation, Term

T = TypeVar("T")

FORMAT = "tegotae controller"
VERSION = 1


@dataclass(frozen=True)
class SavedController:
    """A controller with its weights, and what it was trained for.

    Args:
        controller: the structure.
        weights: shape [n_weights].
        omega: the frequency it was trained at, ω_t [rad/s]; 0 without an oscillator.
        body: the body it was trained on.
        model: the model's name, if it is one of the registry's.
        training: how it was trained and how well that went; numbers, strings and lists only.
        software: versions of the programs that made it.
    """

    controller: Controller
    weights: np.ndarray
    omega: float
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
    document = {
        "format": FORMAT,
        "version": VERSION,
        "model": saved.model,
        "omega_rad_per_s": float(saved.omega),
        "controller": _describe_controller(saved.controller),
        "weights": weights.tolist(),
        "body": _describe(saved.body),
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
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise TegotaeError(f"no controller file at {path}") from None
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise TegotaeError(f"{path} is not a controller file of tegotae") from None
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        ours = FORMAT in text[:200]
        what = "is damaged or truncated" if ours else "is not a controller file of tegotae"
        raise TegotaeError(f"{path} {what}") from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise TegotaeError(f"{path} is not a controller file of tegotae")
    if document.get("version") != VERSION:
        raise TegotaeError(
            f"{path} is of version {document.get('version')!r}; "
            f"this program reads version {VERSION}"
        )
    try:
        saved = SavedController(
            _restore_controller(_entry(document, "controller", dict)),
            np.asarray(_entry(document, "weights", list[float]), "float64"),
            float(_entry(document, "omega_rad_per_s", float)),
            _restore(document, "body", Body),
            _entry(document, "model", str | None),
            _entry(document, "training", dict),
            _entry(document, "software", dict),
        )
        check_senses(saved.controller, saved.body)
    except KeyError as error:
        raise TegotaeError(f"{path} is damaged: it has no entry {error}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None
    _check_weights(saved.controller, saved.weights, str(path))
    if not math.isfinite(saved.omega):
        raise TegotaeError(f"{path} is damaged: its frequency is {saved.omega}")
    return saved


def _check_weights(controller: Controller, weights: np.ndarray, path: str) -> None:
    if weights.shape != (controller.n_weights,):
        raise TegotaeError(
            f"{path}: the controller has {controller.n_weights} weights, not shape {weights.shape}"
        )
    if not np.isfinite(weights).all():
        raise TegotaeError(f"{path}: {int((~np.isfinite(weights)).sum())} weights are not finite")


def _kinds() -> dict[str, type]:
    modules = (bodies, oscillators, terms)
    return {
        name: getattr(module, name)
        for module in modules
        for name in module.__all__
        if dataclasses.is_dataclass(getattr(module, name))
    }


def _describe(part: Any) -> dict[str, Any]:
    """A frozen dataclass of this package as a dictionary with its kind."""
    kind = type(part).__name__
    if _kinds().get(kind) is not type(part):
        raise TegotaeError(
            f"a {kind} cannot be saved: only the bodies, oscillators and terms of tegotae can"
        )
    values = {f.name: getattr(part, f.name) for f in dataclasses.fields(part)}
    return {"kind": kind, **values}


def _restore(parts: dict[str, Any], role: str, base: type[T]) -> T:
    """The part of that role, a `base`, each of its fields of the type that its class says."""
    values = dict(_entry(parts, role, dict))
    name = _entry(values, "kind", str)
    kind = _kinds().get(name)
    if kind is None or not issubclass(kind, base):
        raise TypeError(f"its {role} is a {name!r}, which is no {base.__name__.lower()} known here")
    del values["kind"]
    hints = get_type_hints(kind)
    for field_name in values:
        if field_name not in hints:
            raise TypeError(f"a {name} has no {field_name!r}")
        value = _entry(values, field_name, hints[field_name])
        values[field_name] = tuple(value) if isinstance(value, list) else value
    return kind(**values)


def _entry(parts: dict[str, Any], name: str, hint: Any) -> Any:
    """The entry, if JSON could have made it from a value of type `hint`."""
    if not _fits(parts[name], hint):
        raise TypeError(f"its {name} is {reprlib.repr(parts[name])}")
    return parts[name]


def _fits(value: Any, hint: Any) -> bool:
    if get_origin(hint) in (list, tuple):
        return isinstance(value, list) and all(_fits(entry, get_args(hint)[0]) for entry in value)
    if isinstance(hint, UnionType):
        return any(_fits(value, each) for each in get_args(hint))
    if isinstance(value, bool):
        return hint is bool
    return isinstance(value, (int, float) if hint is float else hint)


def _describe_controller(controller: Controller) -> dict[str, Any]:
    parts: dict[str, Any] = {role: _describe(term) for role, term in controller.terms.items()}
    if controller.oscillator is not None:
        parts["oscillator"] = _describe(controller.oscillator)
    if controller.tegotae is not None:
        parts["limit_rad_per_s"] = controller.tegotae.limit_rad_per_s
    return parts


def _restore_controller(parts: dict[str, Any]) -> Controller:
    tegotae = None
    if "action" in parts:
        tegotae = Tegotae(
            _restore(parts, "action", Term),
            _restore(parts, "reaction", Term),
            _restore(parts, "gain", Term),
            _entry({"limit_rad_per_s": None, **parts}, "limit_rad_per_s", float | None),
        )
    oscillator = _restore(parts, "oscillator", Oscillator) if "oscillator" in parts else None
    return Controller(_restore(parts, "actuation", Actuation), oscillator, tegotae)
