"""What a study consists of: models, runs, settings, at three scales."""

from __future__ import annotations

import dataclasses
import fnmatch
import json
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tegotae.bodies import Hopper
from tegotae.errors import require_count, unknown
from tegotae.evaluation import Protocol
from tegotae.models import BUDGET, Model, all_models
from tegotae.rollout import Timing
from tegotae.study.unit import FORMAT, Unit
from tegotae.training.algorithms import PGPE, Algorithm
from tegotae.training.fitness import EPISODE, SETTLE_S
from tegotae.training.run import Run
from tegotae.training.settings import configuration, tuned
from tegotae.training.stopping import Stopping

BUDGETS = (1280, 2560, 5120)
"""Training budgets [episodes] on the way to the plateau at which runs are evaluated, too. The first
is 80 generations of 16 episodes."""

_PLAIN = ("reflex", "sector", "tphif")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A study: the same settings for every model.

    Raises:
        TegotaeError: for a scale or a pattern that is not known, or a count below one.
    """

    scale: str
    """The name of the scale that it was made from."""
    models: tuple[str, ...]
    """Names of the models."""
    seeds: int
    """Runs per model."""
    stopping: Stopping = field(default_factory=Stopping)
    """When a run ends."""
    budgets: tuple[int, ...] = BUDGETS
    """After how many episodes of training runs are evaluated, too."""
    algorithm: Algorithm = field(default_factory=partial(tuned, "pgpe"))
    timing: Timing = EPISODE
    settle_s: float = SETTLE_S
    energy: str = "absolute"
    follow_omega: bool = True
    budget: int = BUDGET
    hopper: Hopper = field(default_factory=Hopper)
    release_m: float = 1.2
    protocol: Protocol = field(default_factory=Protocol)

    def __post_init__(self) -> None:
        require_count("seeds", self.seeds)

    @property
    def units(self) -> list[Unit]:
        """The study's work, one unit a model; those that share a compiled program in a row."""
        known = all_models()
        units = [self._unit(known[name]) for name in self.models]
        shapes = {unit.run.model: repr(unit.run.training.controller) for unit in units}
        first = {shape: i for i, shape in reversed(list(enumerate(shapes.values())))}
        return sorted(units, key=lambda unit: first[shapes[unit.run.model]])

    def _unit(self, model: Model) -> Unit:
        run = Run(
            model=model,
            seeds=tuple(range(self.seeds)),
            stopping=self.stopping,
            algorithm=self.algorithm,
            timing=self.timing,
            settle_s=self.settle_s,
            energy=self.energy,
            follow_omega=self.follow_omega,
            budget=self.budget,
            hopper=self.hopper,
            release_m=self.release_m,
        )
        return Unit(run, self.protocol, self.budgets)

    @property
    def document(self) -> dict[str, Any]:
        """The settings as JSON values, without the list of models."""
        values = {
            f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.name != "models"
        }
        document = {
            name: dataclasses.asdict(v) if dataclasses.is_dataclass(v) else v  # type: ignore[arg-type]
            for name, v in values.items()
        }
        document["algorithm"]["name"] = type(self.algorithm).__name__
        document["format"] = FORMAT
        return json.loads(json.dumps(document))


def is_of(document: dict[str, Any], configuration: dict[str, Any]) -> bool:
    """Whether a unit of this configuration is one of the study of this `Plan.document`.

    All but the model must be equal.
    """
    ours = {name: value for name, value in document.items() if name != "scale"}
    ours["seeds"] = list(range(document["seeds"]))
    ours["algorithm"] = {**document["algorithm"], "name": document["algorithm"]["name"].lower()}
    return ours == {name: value for name, value in configuration.items() if name != "model"}


def plan(scale: str, pattern: str = "*") -> Plan:
    """The plan of a scale, restricted to the models that match a pattern.

    - `smoke`: three small models for seconds, to see that everything works;
    - `quick`: every architecture, on [F_k] and [F_k, ẏ], with its plain actuation, 5 runs each;
    - `paper`: all 218 models, 15 runs each, trained to the plateau;
    - `paper-80x16`: the same with the budget that the paper names, 80 generations of 16 episodes.

    Raises:
        TegotaeError: for an unknown scale, or a pattern that matches none of the scale's models.
    """
    if scale not in _SCALES:
        raise unknown("scale", scale, _SCALES)
    whole = _SCALES[scale]()
    chosen = tuple(name for name in whole.models if fnmatch.fnmatchcase(name, pattern))
    if not chosen:
        raise unknown("model of this scale", pattern, whole.models)
    return dataclasses.replace(whole, models=chosen)


def _smoke() -> Plan:
    return Plan(
        scale="smoke",
        models=("V-sector-w8", "ART-rF-tphif-w8", "T-Fv"),
        seeds=2,
        stopping=Stopping.after(3),
        budgets=(16,),
        algorithm=PGPE(population=8),
        timing=Timing(duration_s=4.0, tick_s=0.002),
        settle_s=2.0,
        protocol=Protocol(undisturbed_s=8.0, disturbed_s=8.0, offsets=(-1.0, 1.0)),
    )


def _quick() -> Plan:
    def plain(model: Model) -> bool:
        if model.is_single_network:
            return True
        sensed = {x for x in (model.reaction, model.gain) if x}
        half_learned = model.learned_action != (model.reaction is not None)
        return model.actuation_name in _PLAIN and len(sensed) < 2 and not half_learned

    models = tuple(name for name, model in all_models().items() if plain(model))
    return Plan(scale="quick", models=models, seeds=5)


def _paper() -> Plan:
    return Plan(scale="paper", models=tuple(all_models()), seeds=15)


def _paper_80x16() -> Plan:
    return dataclasses.replace(
        _paper(),
        scale="paper-80x16",
        algorithm=configuration("pgpe-80x16").settings,
        stopping=Stopping.after(80),
        budgets=(),
    )


_SCALES = {"smoke": _smoke, "quick": _quick, "paper": _paper, "paper-80x16": _paper_80x16}
SCALES = tuple(_SCALES)
"""The names of the scales."""
