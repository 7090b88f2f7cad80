"""Sets of controllers that belong together: the runs of one model, read from files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import is_earlier
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import design, is_design
from tegotae.systems.models import find
from tegotae.systems.system import System
from tegotae.training.search import best_gain


@dataclass(frozen=True)
class Runs:
    """Several weight vectors of one controller, such as one per seed.

    Args:
        name: the model's name, or the file's.
        system: the closed loop that they share.
        weights: shape [runs, n_weights].
        labels: one per run: its seed, or its file's name.
    """

    name: str
    system: System
    weights: np.ndarray
    labels: tuple[str, ...]

    @property
    def controller(self) -> Controller:
        """The structure that they share."""
        return self.system.controller

    @property
    def omega_t(self) -> float | None:
        """The frequency they were trained at [rad/s]; None without an oscillator."""
        return self.system.omega

    @property
    def body(self) -> Body:
        """The body they were trained on."""
        return self.system.body

    def replaced(self, **changes: Any) -> Runs:
        """The same weights in another system: other fields of the system or its release."""
        return dataclasses.replace(self, system=self.system.replaced(changes))


def read(place: str | Path) -> list[Runs]:
    """The controllers at a place: a file, a folder of files, or the name of a pure V model.

    Files of the same controller, frequency and body are runs of one set; a folder is searched with
    its subfolders, and JSON files of other kinds are passed over. A pure V model has no file: its σ
    is found by search.

    Raises:
        TegotaeError: if there is nothing there, a file is not a controller's, or one of a folder
            may be a controller's and cannot be read: empty, cut short, without permission.
    """
    path = Path(place)
    if path.is_dir():
        files = [file for file in _json_files(path) if _is_controller(file)]
        if not files:
            raise TegotaeError(f"{path} holds no controller files")
        return group([(file, controller_file.load(file)) for file in files])
    if path.exists() or path.suffix or os.sep in str(place):
        return group([(path, controller_file.load(path))])
    return [_searched(str(place))]


def group(files: Sequence[tuple[Path, SavedController]]) -> list[Runs]:
    """Sets of runs, in the order in which their first members come."""
    sets: dict[tuple, list[tuple[Path, SavedController]]] = {}
    for path, saved in files:
        sets.setdefault((saved.name, saved.system), []).append((path, saved))
    return [
        Runs(
            model or members[0][0].stem,
            system,
            np.stack([saved.weights for _, saved in members]),
            tuple(str(saved.training.get("seed", path.stem)) for path, saved in members),
        )
        for (model, system), members in sets.items()
    ]


def _json_files(folder: Path) -> list[Path]:
    """All files in a folder and its subfolders that are named as JSON; none of what was set aside
    for a new beginning."""

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
    """Whether a JSON file is a controller's and no other document.

    Raises:
        TegotaeError: if that cannot be told.
    """
    try:
        return controller_file.is_controller(documents.read(path))
    except FileNotFoundError as error:  # a link to nowhere
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except DamagedDocumentError as error:
        what = f"damaged: {error}" if path.stat().st_size else "empty"
        raise TegotaeError(f"{path} is {what}; remove it from the folder") from None


def _searched(name: str) -> Runs:
    model = None if is_design(name) else find(name)
    if model is None or model.is_trained:
        called = design(name).name if model is None else model.name
        raise TegotaeError(
            f"{called} has weights to train and no file was given; "
            f"first: tegotae train {called} --out FOLDER"
        )
    experiment = model.experiment()
    gain, _ = best_gain(experiment)
    weights = np.array([[gain]])
    return Runs(
        model.name,
        experiment.system,
        weights,
        ("search",),
    )
