"""Sets of controllers that belong together: the runs of one model, read from files."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

import msgspec
import numpy as np

from tegotae._support.documents import Json, JsonObject, differing
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import note
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.descriptions import describe
from tegotae.systems.resolve import Resolved, Untrained, resolve
from tegotae.training.scoring import best_gain

_OF_A_RUN = frozenset(
    {
        *("seed", "seeds", "run", "generations", "ended", "best_fitness", "best_generation"),
        *("episodes", "simulated_s", "best_episode", "evaluation"),
    }
)
"""Entries of a file that belong to its run alone. The other entries describe the training, which
runs of other seeds share."""
_MOST_SHOWN = 3
"""Differences that a name shows; of more it shows their number."""


def read_runs(place: str | Path) -> list[ControllerSet]:
    """Read the controllers of a name (`tegotae.systems.resolve`), such as a file or a folder of
    files.

    Files of the same training (controller, frequency, body, fitness, algorithm and all else that
    decides the result) are runs of one set, and no two of the same seed; a folder is searched with
    its subfolders, and JSON files of other kinds are passed over. What has a gain σ alone to learn,
    such as a pure V model, needs no file: its σ is found by search.

    Raises:
        TegotaeError: for a name that means nothing, or has no weights; a file that is not a
            controller's; or one of a folder that may be a controller's and cannot be read: empty,
            cut short, without permission.
    """
    return sets_of(resolve(place))


def named_sets(sets: list[tuple[str, ControllerSet]]) -> list[tuple[str, ControllerSet]]:
    """Check that no two names hold the same runs, and return the sets.

    Raises:
        TegotaeError: for runs that two names hold.
    """
    for (place, runs), (other_place, later) in combinations(sets, 2):
        if _is_within(runs, later) or _is_within(later, runs):
            raise TegotaeError(
                f"{place} and {other_place} hold the same runs of {runs.name}, with equal weights; "
                "name them once"
            )
    return sets


def sets_of(resolved: Resolved) -> list[ControllerSet]:
    """Return the controllers that a name resolved to, one set per training.

    Raises:
        TegotaeError: if it has no weights.
    """
    searched = _searched(resolved)
    return group(resolved.weighted()) if searched is None else [searched]


def controller_of(resolved: Resolved) -> SavedController:
    """Return the one controller that a name resolved to; an unknown σ is found by search.

    Raises:
        TegotaeError: if it has no weights, or several controllers.
    """
    runs = _searched(resolved)
    if runs is None:
        return resolved.controller()
    return SavedController(runs.system, runs.weights[0], runs.name, runs.experiment)


def _searched(resolved: Resolved) -> ControllerSet | None:
    """Return a system whose only parameter is σ with its best σ; None for all others."""
    if not isinstance(resolved, Untrained) or len(resolved.experiments) > 1:
        return None
    experiment = resolved.experiment()
    if not experiment.is_searched:
        return None
    gain, _ = best_gain(experiment)
    return ControllerSet(
        experiment.name, experiment.system, np.array([[gain]]), ("search",), experiment=experiment
    )


def group(files: Sequence[tuple[Path, SavedController]]) -> list[ControllerSet]:
    """Return the sets of runs of one training each, in the order in which their first members come.

    Sets of one model are named by what differs in how they were trained. Runs of equal weights,
    such as a file and its copy, count once, which a line says.
    """
    trainings: dict[tuple, list[tuple[Path, SavedController]]] = {}
    for path, saved in files:
        key = json.dumps(_document(saved), sort_keys=True)
        trainings.setdefault((saved.name, key), []).append((path, saved))
    sets = [
        _once(members_of_set)
        for members in trainings.values()
        for members_of_set in _by_folder(members)
    ]
    names = [members[0][1].name or members[0][0].stem for members in sets]
    labels = [""] * len(sets)
    for name, count in Counter(names).items():
        if count > 1:
            indices = [i for i, members_of_set in enumerate(names) if members_of_set == name]
            for i, label in zip(indices, _differences([sets[i] for i in indices]), strict=True):
                labels[i] = f" ({label})"
    return [
        ControllerSet(
            name + label,
            members[0][1].system,
            np.stack([saved.weights for _, saved in members]),
            _labels(members),
            _document(members[0][1]),
            members[0][1].experiment,
            members[0][1].task,
        )
        for name, label, members in zip(names, labels, sets, strict=True)
    ]


def _labels(members: list[tuple[Path, SavedController]]) -> tuple[str, ...]:
    """Return seeds as labels, or the files' names where a seed is missing or repeated."""
    seeds = tuple(str(saved.training.get("seed", path.stem)) for path, saved in members)
    return seeds if len(set(seeds)) == len(seeds) else tuple(path.stem for path, _ in members)


def _once(members: list[tuple[Path, SavedController]]) -> list[tuple[Path, SavedController]]:
    """Return the runs of a set without those that repeat another's weights."""
    first: dict[bytes, tuple[Path, SavedController]] = {}
    copies: list[Path] = []
    for path, saved in members:
        weights = np.asarray(saved.weights, float).tobytes()
        if weights in first:
            copies.append(path)
        else:
            first[weights] = (path, saved)
    if copies:
        note(
            f"tegotae: {len(copies)} of {len(members)} runs have the weights of another, such as "
            f"{copies[0]}; equal ones count once"
        )
    return list(first.values())


def _is_within(runs: ControllerSet, candidate: ControllerSet) -> bool:
    """Return whether another set contains all runs of a set: equal weights, trained alike."""
    ours, theirs = (
        {np.asarray(row, float).tobytes() for row in controllers.weights}
        for controllers in (runs, candidate)
    )
    same_training = all(
        getattr(runs, x) == getattr(candidate, x) for x in ("system", "training", "experiment")
    )
    return ours <= theirs and same_training


def _by_folder(
    members: list[tuple[Path, SavedController]],
) -> list[list[tuple[Path, SavedController]]]:
    """Split the sets by folder if a seed occurs twice, as after other lengths of training."""
    seeds = Counter(saved.training.get("seed") for _, saved in members)
    if not any(count > 1 for seed, count in seeds.items() if seed is not None):
        return [members]
    by_folder: dict[Path, list[tuple[Path, SavedController]]] = {}
    for path, saved in members:
        by_folder.setdefault(path.parent, []).append((path, saved))
    return list(by_folder.values())


def _differences(sets: list[list[tuple[Path, SavedController]]]) -> list[str]:
    """Return the differences between sets of runs of one model, a text each, no two alike."""
    documents = [_document(members[0][1]) for members in sets]
    differing_names = (name for other in documents[1:] for name in differing(documents[0], other))
    names = list(dict.fromkeys(differing_names))
    if "algorithm.name" in names:  # whose settings differ, too
        names = ["algorithm.name", *(n for n in names if not n.startswith("algorithm."))]
    if "parameters" in names:
        names.remove("controller")
    hidden = len(names) - _MOST_SHOWN
    end = [f"{hidden} more differ"] if hidden > 0 else []
    labels = [
        ", ".join([*(_formatted(document, name) for name in names[:_MOST_SHOWN]), *end])
        for document in documents
    ]
    if len(set(labels)) < len(labels):  # of another length, or of what a word cannot express
        folders = [f"in {members[0][0].parent}" for members in sets]
        labels = [", ".join(filter(None, parts)) for parts in zip(labels, folders, strict=True)]
    counts = Counter(labels)
    return [
        f"{label}, no. {i}" if counts[label] > 1 else label for i, label in enumerate(labels, 1)
    ]


def _document(saved: SavedController) -> JsonObject:
    """Return all settings that determine a controller except its seed, as JSON values."""
    training = {name: value for name, value in saved.training.items() if name not in _OF_A_RUN}
    description = {} if saved.experiment is None else describe(saved.experiment)
    description.pop("system", None)
    description.pop("name", None)
    document = {
        "parameters": saved.controller.n_weights,
        **describe(saved.system),
        **training,
        **description,
        **({} if saved.task is None else msgspec.to_builtins(saved.task)),
    }
    return json.loads(json.dumps(document))


def _formatted(document: Mapping[str, Json], name: str) -> str:
    """Return an entry of a document in a few words, such as "fitness.work net"."""
    if name.startswith("code of "):
        return name
    value: Json = document
    for key in name.split("."):
        if not isinstance(value, Mapping) or key not in value:
            return f"usual {name}" if name.partition(".")[0] not in document else name
        value = value[key]
    if isinstance(value, Mapping):
        value = value.get("kind", "")
    if isinstance(value, list):
        return name if value else f"no {name}"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{name.removesuffix('.name')} {text}".strip()
