"""The multiverse's work: some models under every reading, all in one folder."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from functools import partial

from research.reproduction.calibration.prior import PRIOR
from research.reproduction.plan import SMOKE
from research.reproduction.readings.designs import calibrated_readings
from research.reproduction.readings.experiment import experiment_under
from research.reproduction.readings.readings import Reading
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
from tegotae.training.settings import tuned

_KIND = "multiverse-"

UNITS_PER_BUNDLE = 6
"""Units that a worker does before it reports: a kill costs no more than these."""

_FEEDBACK = ("V", "VG-gF", "AR-rF", "ARG-rF-gF", "AR-rFv", "ARG-rFv-gFv")
_LEARNED_ACTUATION = ("VT", "ART-rF", "ARGT-rF-gF", "ART-rFv", "ARGT-rFv-gFv")


@dataclass(frozen=True, kw_only=True)
class Multiverse:
    """The study of some models under many readings of the paper.

    Raises:
        TegotaeError: for an unknown model, or a count below one.
    """

    scale: str
    """The name of the scale that it was made from."""
    readings: int
    """Number of readings: the first so many of those that were calibrated on V."""
    models: tuple[str, ...]
    """Names of the models that are trained under each."""
    seeds: int
    """Runs per model and reading."""
    cap: int
    """Episodes of training per run at most, if it has not come to its plateau."""
    algorithm: Algorithm = field(default_factory=partial(tuned, "pgpe"))
    """Learning algorithm."""
    stopping: Stopping = field(default_factory=Stopping)
    """Rule of the plateau; the cap is the multiverse's own."""
    timing: Timing = EPISODE
    settle_s: float = SETTLE_S
    protocol: Protocol = field(default_factory=Protocol)

    def __post_init__(self) -> None:
        for name in ("readings", "seeds", "cap"):
            require_count(name, getattr(self, name), most=MOST_SEEDS)
        calibrated_readings(self.readings)
        for name in self.models:
            recipe(name)

    @property
    def by_reading(self) -> list[tuple[Reading, dict[str, Unit]]]:
        """Every reading with its units, by the name of the model."""
        return [
            (reading, {name: self._unit(recipe(name), reading) for name in self.models})
            for reading in calibrated_readings(self.readings)
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
        generations = max(1, round(self.cap / self.algorithm.population))
        stopping = dataclasses.replace(self.stopping, generations=generations)
        experiment = experiment_under(
            reading, model, timing=self.timing, settle_s=self.settle_s, protocol=self.protocol
        )
        run = Run(
            experiment=experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(algorithm=self.algorithm, stopping=stopping),
        )
        return Unit(run)

    @property
    def document(self) -> Document:
        """The settings as JSON values, without the number of readings: more of them can follow."""
        document = describe(self)
        del document["readings"]
        document["algorithm"] = algorithm_document(self.algorithm)
        document["scale"] = f"{_KIND}{self.scale}"  # which no study has
        document["format"] = FORMAT
        document["choices"] = {c.name: [str(v) for v in c.values] for c in PRIOR}
        return json.loads(json.dumps(document))


def multiverse(scale: str, readings: int | None = None) -> Multiverse:
    """Return the multiverse of a scale.

    - `smoke`: three readings of two small models, for seconds, to see that everything works;
    - `calibrated`: 24 readings under which V does what the paper says of it
      (`research.reproduction.calibration`), 24 models, one design of every architecture, 8 runs
      each to the plateau.

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
        timing=Timing(duration_s=4.0, tick_s=0.002),
        settle_s=2.0,
        protocol=Protocol(undisturbed_s=8.0, disturbed_s=8.0, offsets=(-1.0, 1.0), tick_s=0.002),
    )


def _calibrated() -> Multiverse:
    """Return one design of the actuation, which all architectures share: on φ and f."""
    models = [f"{name}-both" for name in _FEEDBACK] + [f"{n}-tphif" for n in _LEARNED_ACTUATION]
    return Multiverse(
        scale="calibrated",
        readings=24,
        models=(*(f"{name}-w{omega}" for name in models for omega in (4, 8)), "T-F", "T-Fv"),
        seeds=8,
        cap=12_800,
        protocol=Protocol(undisturbed_s=30.0, disturbed_s=20.0, tick_s=0.002),
    )


_SCALES = {"smoke": _smoke, "calibrated": _calibrated}
SCALES = tuple(_SCALES)
"""The names of the scales."""
