"""Controllers in a study's folder: the weights of every seed, in the records of its units."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tegotae._support import documents
from tegotae._support.errors import TegotaeError
from tegotae.study import CellResult, DamagedRecordError
from tegotae.systems.controller_file import SavedController
from tegotae.systems.experiment import Experiment

_DESCRIPTION = "study.json"
"""File in a study's folder that describes the study."""
_RECORDS = "records"
"""The folder in it that has the records."""
SUFFIX = ".record.npz"
"""Suffix of a record's file."""
NOT_OF_THE_TRAINING = frozenset({"format", "experiment", "seeds", "budgets", "metrics"})
"""Entries of a record's configuration that say nothing of how was trained."""


def is_study(folder: Path) -> bool:
    """Return whether a folder is a study's."""
    return (folder / _DESCRIPTION).exists()


def controllers_of_study(folder: Path) -> tuple[tuple[Path, SavedController], ...]:
    """The controllers of a study's whole records, seed by seed.

    Raises:
        TegotaeError: if it has no whole record, a description that is damaged, or a part that is
            not registered.
    """
    described = documents.read(folder / _DESCRIPTION)
    experiments = described.get("experiments") if isinstance(described, dict) else None
    controllers: list[tuple[Path, SavedController]] = []
    damaged: list[str] = []
    for path in sorted((folder / _RECORDS).glob(f"*{SUFFIX}")):
        try:
            result = CellResult.read(path)
        except DamagedRecordError as error:
            damaged.append(str(error))
            continue
        configuration = result.document
        document = configuration["experiment"]
        if isinstance(experiments, dict) and document["name"] not in experiments:
            continue  # of another study that was here
        experiment = Experiment.from_document(document)
        training = {n: x for n, x in configuration.items() if n not in NOT_OF_THE_TRAINING}
        controllers += [
            (
                path,
                SavedController(
                    experiment.system,
                    np.asarray(weights, float),
                    experiment.name,
                    experiment,
                    training={**training, "seed": seed},
                    software=result.software,
                ),
            )
            for seed, weights in zip(configuration["seeds"], result.arrays["weights"], strict=True)
        ]
    if not controllers:
        raise TegotaeError(f"{folder} has no record that is whole: {'; '.join(damaged) or 'none'}")
    return tuple(controllers)
