"""One unit of the study's work: all seeds of one model, trained and evaluated."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tegotae.devices import described_devices
from tegotae.evaluation import Protocol, evaluate
from tegotae.study.record import Record
from tegotae.training.evolve import Curves, evolve, start
from tegotae.training.run import Run, software
from tegotae.training.search import best_gain

FORMAT = 2
"""Changed whenever the same configuration would give other numbers."""
DEVICES = 1
"""CPU devices that a unit is computed on: on another number its numbers are others."""


@dataclass(frozen=True)
class Unit:
    """What is trained, and how it is then evaluated."""

    run: Run
    protocol: Protocol = field(default_factory=Protocol)

    @property
    def configuration(self) -> dict[str, Any]:
        """All that decides the record's content, as JSON values."""
        document = {
            "format": FORMAT,
            **self.run.configuration,
            "generations": self.run.generations,
            "protocol": dataclasses.asdict(self.protocol),
        }
        return json.loads(json.dumps(document))

    @property
    def key(self) -> str:
        """The record's name: the model's, and a hash of the configuration."""
        return key_of(self.configuration)


def key_of(configuration: dict[str, Any]) -> str:
    """The name of a record with this configuration: the model's, and a hash of it all."""
    canonical = json.dumps(configuration, sort_keys=True)
    return f"{configuration['model']}-{hashlib.sha256(canonical.encode()).hexdigest()[:12]}"


def work(unit: Unit) -> Record:
    """Train a unit from random weights and evaluate what came out. Deterministic."""
    run = unit.run
    training = run.training
    if run.model.is_trained:
        progress = start(training, run.seeds)
        curves: list[Curves] = []
        omega = run.model.omega_t or 0.0
        steps = evolve(training, progress, run.seeds, omega, run.generations, run.hopper)
        for step in steps:
            progress, generation = step
            curves.append(generation)
        weights, fitness = np.asarray(progress.best_weights), np.asarray(progress.best_fitness)
    else:
        # The search has no randomness: it is one run, whatever the seeds.
        gain, best = best_gain(
            training.controller,
            run.model.omega_t or 0.0,
            run.hopper,
            fitness=run.fitness,
            timing=run.timing,
        )
        weights, fitness, curves = np.array([[gain]]), np.array([best]), []
    found = evaluate(training.controller, weights, run.model.omega_t, run.hopper, unit.protocol)
    return Record(
        configuration=unit.configuration,
        software={**software(), "devices": described_devices()},
        weights=weights.astype("float32"),
        best_fitness=fitness.astype("float32"),
        curves={
            name: np.stack([getattr(c, name) for c in curves]).astype("float32")
            for name in Curves._fields
            if curves
        },
        omega=found.omega,
        episodes={name: values.astype("float32") for name, values in found.episodes.items()},
    )
