"""Records of a study, made up."""

from collections.abc import Iterable, Iterator

import numpy as np

from research.reproduction.record import Record
from research.reproduction.unit import Unit
from tegotae._support.engines import selected
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.study import CellResult


def made_up(unit: Unit, runs: int = 2) -> Record:
    """A record of the right form with numbers that depend on the unit alone."""
    random = np.random.default_rng(int(unit.key[-8:], 16))

    def metric(name: str, *shape: int) -> np.ndarray:
        smallest, largest = HOPPING.range_of(name)
        return np.clip(random.normal(size=shape), smallest, largest).astype("float32")

    n_weights = unit.run.experiment.controller.n_weights
    return Record(
        unit.configuration,
        {"tegotae": "0", "engine": selected()},
        random.normal(size=(runs, n_weights)).astype("float32"),
        random.uniform(size=(runs, n_weights)).astype("float32"),
        random.normal(size=runs).astype("float32"),
        random.integers(1, 4, runs),
        np.array(["cap"] * runs),
        {"centre_fitness": random.normal(size=(3, runs)).astype("float32")},
        np.array([7.0, 9.0]),
        {name: metric(name, runs, 2) for name in HOPPING.names()},
        {name: metric(name, 1, runs, 2) for name in HOPPING.names()},
        {name: metric(name, runs, 2) for name in HOPPING.names()},
    )


def instant(bundles: Iterable[Iterable[Unit]]) -> Iterator[tuple[Unit, CellResult]]:
    """Stands in for workers."""
    for bundle in bundles:
        for unit in bundle:
            yield unit, made_up(unit).result
