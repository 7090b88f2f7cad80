"""Where controllers to be tried come from: the records of a study."""

from __future__ import annotations

from pathlib import Path

from tegotae._support.errors import TegotaeError
from tegotae.studies.paper.folder import Folder
from tegotae.systems.controller_set import ControllerSet


def of_study(place: Path) -> list[ControllerSet]:
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
        whole = {**record.configuration, **record.configuration["experiment"]}
        own = ("seeds", "experiment", "system", "name")
        training = {name: x for name, x in whole.items() if name not in own}
        found.append(ControllerSet(experiment.name, experiment.system, weights, labels, training))
    return found
