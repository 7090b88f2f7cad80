"""Sets of controllers that belong together: the runs of one model, read from files."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import is_earlier
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.controller_set import ControllerSet
from tegotae.systems.descriptions import describe
from tegotae.systems.designs import design, is_design
from tegotae.systems.experiment import differing
from tegotae.systems.models import find
from tegotae.training.search import best_gain

_OF_A_RUN = frozenset(
    {
        *("seed", "seeds", "generations", "ended", "best_fitness", "best_generation"),
        *("episodes", "simulated_s", "best_episode"),
    }
)
"""What a file says of its own run. All else is the training, which runs of other seeds share."""
_MOST_TOLD = 3
"""Differences that a name tells; of more it tells their number."""


def read(place: str | Path) -> list[ControllerSet]:
    """The controllers at a place: a file, a folder of files, or the name of a pure V model.

    Files of the same training (controller, frequency, body, fitness, algorithm and all else that
    decides the result) are runs of one set, and no two of the same seed; a folder is searched with
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


def group(files: Sequence[tuple[Path, SavedController]]) -> list[ControllerSet]:
    """Sets of runs of one training each, in the order in which their first members come.

    Sets of one model are named by what differs in how they were trained.
    """
    trainings: dict[tuple, list[tuple[Path, SavedController]]] = {}
    for path, saved in files:
        what = json.dumps(_document(saved), sort_keys=True)
        trainings.setdefault((saved.name, what), []).append((path, saved))
    sets = [each for members in trainings.values() for each in _without_doubles(members)]
    names = [members[0][1].name or members[0][0].stem for members in sets]
    labels = [""] * len(sets)
    for name, count in Counter(names).items():
        if count > 1:
            own = [i for i, each in enumerate(names) if each == name]
            for i, label in zip(own, _differences([sets[i] for i in own]), strict=True):
                labels[i] = f" ({label})"
    return [
        ControllerSet(
            name + label,
            members[0][1].system,
            np.stack([saved.weights for _, saved in members]),
            _labels(members),
            _document(members[0][1]),
        )
        for name, label, members in zip(names, labels, sets, strict=True)
    ]


def _labels(members: list[tuple[Path, SavedController]]) -> tuple[str, ...]:
    """Seeds, or the files' names where there is none, or one twice."""
    seeds = tuple(str(saved.training.get("seed", path.stem)) for path, saved in members)
    return seeds if len(set(seeds)) == len(seeds) else tuple(path.stem for path, _ in members)


def _without_doubles(
    members: list[tuple[Path, SavedController]],
) -> list[list[tuple[Path, SavedController]]]:
    """The same apart by folder if a seed is there twice, as after other lengths of training."""
    seeds = Counter(saved.training.get("seed") for _, saved in members)
    if not any(count > 1 for seed, count in seeds.items() if seed is not None):
        return [members]
    by_folder: dict[Path, list[tuple[Path, SavedController]]] = {}
    for path, saved in members:
        by_folder.setdefault(path.parent, []).append((path, saved))
    return list(by_folder.values())


def _differences(sets: list[list[tuple[Path, SavedController]]]) -> list[str]:
    """What tells sets of runs of one model apart, a text each, no two alike."""
    documents = [_document(members[0][1]) for members in sets]
    found = (name for other in documents[1:] for name in differing(documents[0], other))
    names = list(dict.fromkeys(found))
    if "algorithm.name" in names:  # whose settings differ, too
        names = ["algorithm.name", *(n for n in names if not n.startswith("algorithm."))]
    if "parameters" in names:
        names.remove("controller")
    more = len(names) - _MOST_TOLD
    end = [f"{more} more differ"] if more > 0 else []
    labels = [
        ", ".join([*(_told(document, name) for name in names[:_MOST_TOLD]), *end])
        for document in documents
    ]
    if len(set(labels)) < len(labels):  # of another length, or of what a word cannot tell
        folders = [f"in {members[0][0].parent}" for members in sets]
        labels = [", ".join(filter(None, each)) for each in zip(labels, folders, strict=True)]
    counts = Counter(labels)
    return [
        f"{label}, no. {i}" if counts[label] > 1 else label for i, label in enumerate(labels, 1)
    ]


def _document(saved: SavedController) -> dict[str, Any]:
    """All that decides what a controller became, but for its seed, as JSON values."""
    training = {name: value for name, value in saved.training.items() if name not in _OF_A_RUN}
    about = {} if saved.experiment is None else describe(saved.experiment)
    about.pop("system", None)
    about.pop("name", None)
    whole = {
        "parameters": saved.controller.n_weights,
        **describe(saved.system),
        **training,
        **about,
        **({} if saved.task is None else msgspec.to_builtins(saved.task)),
    }
    return json.loads(json.dumps(whole))


def _told(document: Mapping[str, Any], name: str) -> str:
    """An entry of a document in a few words, such as "fitness.work net"."""
    if name.startswith("code of "):
        return name
    value: Any = document
    for key in name.split("."):
        if not isinstance(value, Mapping) or key not in value:
            return f"usual {name}" if name.partition(".")[0] not in document else name
        value = value[key]
    if isinstance(value, Mapping):
        value = value.get("kind", "")
    if isinstance(value, list):
        return name
    shown = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{name.removesuffix('.name')} {shown}".strip()


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


def _searched(name: str) -> ControllerSet:
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
    return ControllerSet(
        model.name,
        experiment.system,
        weights,
        ("search",),
    )
