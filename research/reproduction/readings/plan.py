"""The multiverse's work: some models under every reading, all in one folder."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from functools import partial

from research.reproduction.plan import SMOKE
from research.reproduction.readings.designs import design_named
from research.reproduction.readings.experiment import experiment_under
from research.reproduction.readings.readings import (
    PLATEAU,
    Reading,
)
from research.reproduction.unit import FORMAT, Unit
from tegotae._support.documents import Document
from tegotae._support.errors import require_count, unknown
from tegotae._support.limits import MOST_SEEDS
from tegotae.measures.evaluation import Protocol
from tegotae.measures.objectives.fitness import EPISODE, SETTLE_S
from tegotae.simulation.rollout import Timing
from tegotae.systems.descriptions import describe
from tegotae.systems.recipe import Recipe, recipe
from tegotae.training.algorithms import Algorithm, algorithm_document
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import configuration, tuned

_KIND = "multiverse-"

BRIEF = 80 * 16
"""The budget that needs settings of its own [episodes]."""

UNITS_PER_BUNDLE = 6
"""Units that a worker does before it reports: a kill costs no more than these."""

_FEEDBACK = ("V", "VG-gF", "AR-rF", "ARG-rF-gF", "AR-rFv", "ARG-rFv-gFv")
_LEARNED_ACTUATION = ("VT", "ART-rF", "ARGT-rF-gF", "ART-rFv", "ARGT-rFv-gFv")


def _brief() -> Algorithm:
    settings = configuration("pgpe-80x16").settings
    assert isinstance(settings, Algorithm)
    return settings


@dataclass(frozen=True, kw_only=True)
class Multiverse:
    """The study of some models under many readings of the paper.

    Raises:
        TegotaeError: for an unknown model, or a count below one.
    """

    scale: str
    """The name of the scale that it was made from."""
    readings: int
    """Number of readings, the standard one among them."""
    models: tuple[str, ...]
    """Names of the models that are trained under each."""
    seeds: int
    """Runs per model and reading."""
    cap: int
    """Episodes of training per run at most, also where it is to go on to its plateau."""
    algorithm: Algorithm = field(default_factory=partial(tuned, "pgpe"))
    """Learning algorithm."""
    brief: Algorithm = field(default_factory=_brief)
    """The same where the budget is that of 80 generations of 16: what is tuned for that."""
    design: str = "open"
    """Set of readings: all that the paper leaves open, or those "calibrated" on V."""
    stopping: Stopping = field(default_factory=Stopping)
    """Rule of the plateau; the cap is the multiverse's own."""
    timing: Timing = EPISODE
    settle_s: float = SETTLE_S
    protocol: Protocol = field(default_factory=Protocol)

    def __post_init__(self) -> None:
        for name in ("readings", "seeds", "cap"):
            require_count(name, getattr(self, name), most=MOST_SEEDS)
        design_named(self.design).readings(self.readings)
        for name in self.models:
            recipe(name)

    @property
    def by_reading(self) -> list[tuple[Reading, dict[str, Unit]]]:
        """Every reading with its units, by the name of the model."""
        return [
            (reading, {name: self._unit(recipe(name), reading) for name in self.models})
            for reading in design_named(self.design).readings(self.readings)
        ]

    @property
    def units(self) -> list[Unit]:
        """All of the work; units that share a compiled program are adjacent."""
        units = [unit for _, by_model in self.by_reading for unit in by_model.values()]
        first: dict[object, int] = {}
        for i, unit in enumerate(units):
            first.setdefault(unit.run.learner.program(unit.run.experiment), i)
        return sorted(units, key=lambda unit: first[unit.run.learner.program(unit.run.experiment)])

    def _unit(self, model: Recipe, reading: Reading) -> Unit:
        algorithm, stopping = self._training(reading.episodes)
        experiment = experiment_under(
            reading, model, timing=self.timing, settle_s=self.settle_s, protocol=self.protocol
        )
        run = Run(
            experiment=experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(algorithm=algorithm, stopping=stopping),
        )
        return Unit(run)

    def _training(self, episodes: float) -> tuple[Algorithm, Stopping]:
        """Return the settings and the stopping rule that spend a budget of training."""
        algorithm = self.brief if episodes <= BRIEF else self.algorithm
        generations = max(1, round(min(episodes, self.cap) / algorithm.population))
        if episodes == PLATEAU:
            return algorithm, dataclasses.replace(self.stopping, generations=generations)
        return algorithm, Stopping.after(generations)

    @property
    def document(self) -> Document:
        """The settings as JSON values, without the number of readings: more of them can follow."""
        document = describe(self)
        del document["readings"]
        for name in ("algorithm", "brief"):
            document[name] = algorithm_document(getattr(self, name))
        document["scale"] = f"{_KIND}{self.scale}"  # which no study has
        document["format"] = FORMAT
        design = design_named(document.pop("design"))
        document["choices"] = {c.name: [str(v) for v in c.values] for c in design.choices}
        return json.loads(json.dumps(document))


def multiverse(scale: str, readings: int | None = None) -> Multiverse:
    """Return the multiverse of a scale.

    - `smoke`: three readings of two small models, for seconds, to see that everything works;
    - `full`: 32 readings of 24 models, one design of every architecture, 4 runs each;
    - `calibrated`: 24 readings under which V does what the paper says of it
      (`research.reproduction.calibration`), the same models, 8 runs each to the plateau.

    Args:
        scale: its name, also as a folder's description has it.
        readings: how many; the scale's number by default.

    Raises:
        TegotaeError: for an unknown scale, or a number of readings below one.
    """
    name = scale.removeprefix(_KIND)
    if name not in _SCALES:
        raise unknown("scale", scale, _SCALES)
    full = _SCALES[name]()
    return full if readings is None else dataclasses.replace(full, readings=readings)


def _smoke() -> Multiverse:
    return Multiverse(
        scale="smoke",
        readings=3,
        models=("V-reflex-w8", "VG-gF-reflex-w8"),
        seeds=2,
        cap=16,
        algorithm=SMOKE,
        brief=SMOKE,
        timing=Timing(duration_s=4.0, tick_s=0.002),
        settle_s=2.0,
        protocol=Protocol(undisturbed_s=8.0, disturbed_s=8.0, offsets=(-1.0, 1.0), tick_s=0.002),
    )


def _full() -> Multiverse:
    """Return one design of the actuation, which all architectures share: on φ and f."""
    models = [f"{name}-both" for name in _FEEDBACK] + [f"{n}-tphif" for n in _LEARNED_ACTUATION]
    return Multiverse(
        scale="full",
        readings=32,
        models=(*(f"{name}-w{omega}" for name in models for omega in (4, 8)), "T-F", "T-Fv"),
        seeds=4,
        cap=12_800,
        protocol=Protocol(undisturbed_s=30.0, disturbed_s=20.0, tick_s=0.002),
    )


def _calibrated() -> Multiverse:
    """Return the learned claims over the readings that V chose, which the calibration leaves
    out.
    """
    return dataclasses.replace(
        _full(), scale="calibrated", readings=24, seeds=8, design="calibrated"
    )


_SCALES = {"smoke": _smoke, "full": _full, "calibrated": _calibrated}
SCALES = tuple(_SCALES)
"""The names of the scales."""
