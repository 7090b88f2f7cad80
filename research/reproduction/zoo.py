"""Files of trained controllers, which names of the zoo are read from: of a study, or of some."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from research.reproduction.record import Record
from research.reproduction.table import means, registry_order
from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_arrays
from tegotae.systems import controller_file
from tegotae.systems.controller_file import NOT_OF_THE_TRAINING, SavedController
from tegotae.systems.recipe import study_recipes
from tegotae.systems.zoo import FORMAT, VERSION, Zoo


@dataclass(frozen=True)
class ZooEntry:
    """All runs of one model.

    Args:
        document: its controller file as JSON values, without weights; the same for all runs.
        weights: shape [runs, n_weights].
        seed: of each run, [runs].
        fitness: best fitness of the training, [runs].
        generations: how many there were, [runs].
        ended: why training ended, such as "plateau" or "cap", [runs].
        metrics: means over the episodes of the evaluation by name, [runs] each; NaN if undefined.
    """

    document: JsonObject
    weights: np.ndarray
    seed: np.ndarray
    fitness: np.ndarray
    generations: np.ndarray
    ended: np.ndarray
    metrics: Mapping[str, np.ndarray]

    @property
    def model(self) -> str:
        """The model's name."""
        return str(self.document["name"])


def zoo_entries(records: Iterable[Record]) -> Iterator[ZooEntry]:
    """Yield the runs of every record, in the order of the registry of models."""
    for record in registry_order(records):
        yield ZooEntry(
            document=_document(record),
            weights=record.weights,
            seed=np.array(record.configuration["seeds"]),
            fitness=record.best_fitness,
            generations=record.generations,
            ended=record.ended,
            metrics=means(record, record.episodes),
        )


ACTUATIONS = ("sector", "reflex", "tphif")


def core(archive: Zoo) -> Iterator[ZooEntry]:
    """Select the part of the paper's study that an installed package has: single networks, and
    models that sense F_k alone, with a reflex, an actuation learned from φ and f, or, where A and R
    are learned, a sector."""
    for name, model in study_recipes().items():
        plain = "Fv" not in (model.learned_terms.reaction, model.learned_terms.gain)
        is_common = model.actuation in ("reflex", "tphif") or {"A", "R"} <= {*model.terms.learned}
        is_core = model.omega_t is None or (plain and is_common and model.actuation in ACTUATIONS)
        if is_core and name in archive.models:
            runs = archive.runs(name)
            summary = {
                field: runs.pop(field) for field in ("seed", "fitness", "generations", "ended")
            }
            yield ZooEntry(archive.common(name), archive.weights(name), **summary, metrics=runs)


def _document(record: Record) -> JsonObject:
    """Return the common part of the controller files of all its runs."""
    experiment = record.experiment
    training = {n: x for n, x in record.configuration.items() if n not in NOT_OF_THE_TRAINING}
    saved = SavedController(
        experiment.system,
        record.weights[0],
        experiment.name,
        experiment,
        training=training,
        software=record.software,
    )
    document = controller_file.described(saved, record.model)
    return {name: value for name, value in document.items() if name != "weights"}


def write_archive(path: Path, study: str, entries: Iterable[ZooEntry]) -> None:
    """Write a file of trained controllers.

    Args:
        path: the file.
        study: the study's name.
        entries: its models.

    Raises:
        TegotaeError: for two models of one name, or if the file cannot be written.
    """
    entries = list(entries)
    models = {entry.model: len(entry.weights) for entry in entries}
    if len(models) < len(entries):
        raise TegotaeError(f"of {len(entries)} models of {study} only {len(models)} names differ")
    metrics = list(dict.fromkeys(name for entry in entries for name in entry.metrics))
    weights = {entry.model: np.asarray(entry.weights, "float32") for entry in entries}
    header = {
        "format": FORMAT,
        "version": VERSION,
        "study": study,
        "software": _software(entries),
        "models": models,
        "metrics": metrics,
    }
    index = {
        "documents": np.array([json.dumps(entry.document).encode() for entry in entries]),
        "seed": np.concatenate([entry.seed for entry in entries]).astype("int64"),
        "fitness": np.concatenate([entry.fitness for entry in entries]).astype("float32"),
        "generations": np.concatenate([entry.generations for entry in entries]).astype("int32"),
        "ended": np.concatenate([entry.ended for entry in entries]).astype("U"),
        "metrics": np.concatenate([_columns(entry, metrics) for entry in entries]),
    }
    of_models = {f"weights/{model}": values for model, values in weights.items()}
    write_arrays(path, {"header": np.array(json.dumps(header)), **index, **of_models})


def _software(entries: Iterable[ZooEntry]) -> dict[str, str]:
    """Return the versions of the programs that made them, all where there are several."""
    versions_by_name: dict[str, dict[str, None]] = {}
    for entry in entries:
        for name, version in cast(dict[str, str], entry.document["software"]).items():
            versions_by_name.setdefault(name, {})[version] = None
    return {name: ", ".join(versions) for name, versions in versions_by_name.items()}


def _columns(entry: ZooEntry, metrics: Iterable[str]) -> np.ndarray:
    lacking = np.full(len(entry.weights), np.nan)
    columns = [entry.metrics.get(name, lacking) for name in metrics]
    return np.array(columns, "float32").reshape(-1, len(entry.weights)).T
