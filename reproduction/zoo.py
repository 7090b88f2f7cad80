"""A study's trained controllers as one file, which names of the zoo are read from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from reproduction.record import Record
from reproduction.table import means, ordered
from tegotae._support.documents import JsonObject
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.study_records import NOT_OF_THE_TRAINING
from tegotae.systems.zoo.file import ZooEntry


def entries(records: Iterable[Record]) -> Iterator[ZooEntry]:
    """The runs of every record, in the order of the registry of models."""
    for record in ordered(records):
        yield ZooEntry(
            document=_document(record),
            weights=record.weights,
            seed=np.array(record.configuration["seeds"]),
            fitness=record.best_fitness,
            generations=record.generations,
            ended=record.ended,
            metrics=means(record, record.episodes),
        )


def _document(record: Record) -> JsonObject:
    """What the controller files of all its runs have in common."""
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
