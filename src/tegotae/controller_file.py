"""Controllers on disk: a readable JSON file, self-describing, without pickle."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tegotae import bodies, oscillators, terms
from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller, Tegotae
from tegotae.errors import TegotaeError
from tegotae.files import write_atomically

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
    except json.JSONDecodeError:
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
        controller = _restore_controller(document["controller"])
        weights = np.asarray(document["weights"], "float64")
        saved = SavedController(
            controller,
            weights,
            float(document["omega_rad_per_s"]),
            _restore(document["body"]),
            document["model"],
            document["training"],
            document["software"],
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise TegotaeError(f"{path} is damaged: {_first_line(error)}") from None
    _check_weights(controller, weights, str(path))
    if not math.isfinite(saved.omega):
        raise TegotaeError(f"{path} is damaged: its frequency is {saved.omega}")
    return saved


def _first_line(error: Exception) -> str:
    text = (str(error).splitlines() or [type(error).__name__])[0]
    return f"no entry {text}" if isinstance(error, KeyError) else text


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


def _restore(description: dict[str, Any]) -> Any:
    values = dict(description)
    kind = values.pop("kind")
    if kind not in _kinds():
        raise TypeError(f"unknown kind {kind!r}")
    return _kinds()[kind](**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})


def _describe_controller(controller: Controller) -> dict[str, Any]:
    parts: dict[str, Any] = {role: _describe(term) for role, term in controller.terms.items()}
    if controller.oscillator is not None:
        parts["oscillator"] = _describe(controller.oscillator)
    if controller.tegotae is not None:
        parts["limit_rad_per_s"] = controller.tegotae.limit_rad_per_s
    return parts


def _restore_controller(parts: dict[str, Any]) -> Controller:
    described = {role: part for role, part in parts.items() if role != "limit_rad_per_s"}
    made = {role: _restore(part) for role, part in described.items()}
    tegotae = None
    if "action" in made:
        limit = parts.get("limit_rad_per_s")
        tegotae = Tegotae(made["action"], made["reaction"], made["gain"], limit)
    return Controller(made["actuation"], made.get("oscillator"), tegotae)
