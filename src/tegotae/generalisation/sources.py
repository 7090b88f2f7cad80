"""Where controllers to be tried come from: the records of a study."""

from __future__ import annotations

from pathlib import Path

from tegotae.collection import Runs
from tegotae.errors import TegotaeError
from tegotae.study.folder import Folder


def of_study(place: Path) -> list[Runs]:
    """The controllers of a study's records, a set a model; weights are in the records.

    Raises:
        TegotaeError: if there is no study, or it has no whole record.
    """
    records, others = Folder(place).all()
    if not records:
        raise TegotaeError(f"{place} has no record that is whole: {'; '.join(others) or 'none'}")
    found = []
    for record in records:
        experiment = record.experiment
        labels = tuple(str(seed) for seed in record.configuration["seeds"])
        weights = record.weights.astype(float)
        found.append(
            Runs(
                experiment.name,
                experiment.controller,
                weights,
                experiment.omega,
                experiment.body,
                labels,
                {name: x for name, x in record.configuration.items() if name != "seeds"},
            )
        )
    return found
