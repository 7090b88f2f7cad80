"""What every training leaves in its folder: what it is for, and its controllers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from tegotae import controller_file
from tegotae.bodies import Hopper
from tegotae.controller import Controller
from tegotae.controller_file import SavedController
from tegotae.errors import TegotaeError
from tegotae.files import write_atomically
from tegotae.models import Model


def versions_of(*packages: str) -> dict[str, str]:
    """Versions of the programs that decide the numbers: these packages and what all need."""
    return {name: version(name) for name in ("tegotae", "jax", "jaxlib", *packages, "numpy")}


def claim(out: Path, configuration: Mapping[str, Any], versions: Mapping[str, str]) -> None:
    """Write into `run.json` what the folder is for, or see that what is in it is of this training.

    Raises:
        TegotaeError: if the folder holds another training, or cannot be written.
    """
    path = out / "run.json"
    wanted = json.loads(json.dumps(configuration))
    if any(out.glob("checkpoint*")) or any(out.glob("*-seed*.json")):
        found = _configuration(path)
        if names := differing(found, wanted):
            raise TegotaeError(
                f"{out} holds a training of {found.get('model')} that differs in "
                f"{', '.join(names)}; choose another folder with --out"
            )
    document = {"configuration": wanted, "software": dict(versions)}
    write_atomically(path, json.dumps(document, indent=1) + "\n")


def differing(found: Mapping[str, Any], wanted: Mapping[str, Any]) -> list[str]:
    """Names of what differs between two configurations of JSON values."""
    return [name for name in {**wanted, **found} if found.get(name) != wanted.get(name)]


def _configuration(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text(encoding="utf-8"))["configuration"])
    except FileNotFoundError:
        raise TegotaeError(
            f"{path.parent} holds a training but no {path.name}; choose another folder with --out"
        ) from None
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError):
        raise TegotaeError(f"{path} is damaged; choose another folder with --out") from None


def save_controller(
    out: Path,
    *,
    model: Model,
    hopper: Hopper,
    controller: Controller,
    weights: np.ndarray,
    configuration: Mapping[str, Any],
    outcome: Mapping[str, Any],
    versions: Mapping[str, str],
) -> Path:
    """Write `MODEL-seedN.json`, the controller that the training of one seed ended in.

    Args:
        configuration: how it was trained.
        outcome: how that went; its `seed` is part of the file's name.
    """
    path = out / f"{model.name}-seed{outcome['seed']}.json"
    training = {**configuration, **outcome}
    saved = SavedController(
        controller, weights, model.omega_t or 0.0, hopper, model.name, training, dict(versions)
    )
    controller_file.save(saved, path)
    return path
