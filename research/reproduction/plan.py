"""Plan of a study: experiments, runs, settings, at three scales."""

from __future__ import annotations

import dataclasses
import fnmatch
import json
import pickle
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from research.reproduction.unit import FORMAT, Unit, metrics_document
from tegotae._support.documents import Document, differing
from tegotae._support.errors import TegotaeError, require_count, require_known, unknown
from tegotae.measures.evaluation import Protocol, require_evaluable
from tegotae.measures.hopping.metrics import HOPPING, DerivedMetric
from tegotae.measures.metric import Metric
from tegotae.measures.objectives.fitness import Fitness
from tegotae.simulation.rollout import Timing
from tegotae.systems.descriptions import describe
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import Recipe, recipe, study_recipes
from tegotae.systems.term_sets import LAWS
from tegotae.training.algorithms import PGPE, Algorithm, algorithm_document
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import configuration, tuned

BUDGETS = (1280, 2560, 5120)
"""Training budgets [episodes] on the way to the plateau at which runs are evaluated, too. The first
is 80 generations of 16 episodes."""

OMEGAS = (3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
"""Training frequencies of the question what learning adds [rad/s]."""
MAIN = ("V", "VG-gF", "VT", "AR-rF", "ARG-rF-gF", "ART-rF", "ARGT-rF-gF")
"""The architectures of that question, on [F_k]; each with three actuations."""

_PLAIN = ("reflex", "sector", "tphif")


def _users_metrics() -> tuple[Metric, ...]:
    """Return the user's metrics that are measured in an episode, and not derived from others."""
    return tuple(x for x in HOPPING.registered if not isinstance(x, DerivedMetric))


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A study: experiments that are trained and evaluated in the same way.

    Raises:
        TegotaeError: for a count below one, no experiment, two of the same name, or one that
            could be trained but not evaluated.
    """

    scale: str
    """The name of the scale that it was made from."""
    experiments: tuple[Experiment, ...]
    """Experiments to train and evaluate: the paper's models, and any others beside them."""
    seeds: int
    """Runs per experiment."""
    stopping: Stopping = field(default_factory=Stopping)
    """Stopping rule of a run."""
    budgets: tuple[int, ...] = BUDGETS
    """After how many episodes of training runs are evaluated, too."""
    algorithm: Algorithm = field(default_factory=partial(tuned, "pgpe"))
    """Learning algorithm."""
    metrics: tuple[Metric, ...] = field(default_factory=_users_metrics)
    """A user's metrics, measured beside the package's; all that are registered by default."""

    def __post_init__(self) -> None:
        require_count("seeds", self.seeds)
        for experiment in self.experiments:
            require_evaluable(experiment.controller, experiment.body, experiment.protocol)
        for metric in self.metrics:
            _require_sendable(metric)
        names = Counter(experiment.name for experiment in self.experiments)
        if not names:
            raise TegotaeError("a study of no experiments; name at least one")
        for name, count in names.items():
            if count > 1:
                raise TegotaeError(f"{count} experiments are called {name}; call each its own name")

    @property
    def units(self) -> list[Unit]:
        """The study's work, one unit per experiment; experiments that share a compiled program
        are adjacent.
        """
        units = [self._unit(experiment) for experiment in self.experiments]
        first: dict[str, int] = {}
        for i, unit in enumerate(units):
            first.setdefault(repr(unit.run.experiment.controller), i)
        return sorted(units, key=lambda unit: first[repr(unit.run.experiment.controller)])

    def _unit(self, experiment: Experiment) -> Unit:
        run = Run(
            experiment=experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(algorithm=self.algorithm, stopping=self.stopping),
        )
        return Unit(run, self.budgets, self.metrics)

    @property
    def document(self) -> Document:
        """The study as JSON values, its experiments by name."""
        document = {
            "format": FORMAT,
            "scale": self.scale,
            "seeds": self.seeds,
            "stopping": describe(self.stopping),
            "budgets": self.budgets,
            "algorithm": algorithm_document(self.algorithm),
            **metrics_document(self.metrics),
            "experiments": {
                experiment.name: experiment.document for experiment in self.experiments
            },
        }
        return json.loads(json.dumps(document))


def _require_sendable(metric: Metric) -> None:
    """Raise `TegotaeError` for a metric that worker processes could not be given."""
    try:
        pickle.dumps(metric)
    except (pickle.PicklingError, AttributeError, TypeError):
        raise TegotaeError(
            f"the metric {metric.name} cannot be given to worker processes; let a module have it "
            f"under a name, such as {metric.name} = GaitMetric(...) in a file of its own"
        ) from None


def united(existing: Document, requested: Document) -> Document:
    """Return the document of a study that has the experiments of two documents (`Plan.document`).

    Raises:
        TegotaeError: if they are no parts of one study: anything but the experiments differs, or
            two of the same name do; says what.
    """
    names = differing(_without_experiments(existing), _without_experiments(requested))
    if of_metrics := [name for name in names if name.partition(".")[0] == "metrics"]:
        metrics = ", ".join(sorted(existing.get("metrics", {}))) or "none"
        names = [name for name in names if name not in of_metrics]
        names.append(f"set of your own metrics ({metrics}; see --parts)")
    theirs, ours = existing.get("experiments", {}), requested.get("experiments", {})
    for name in theirs.keys() & ours.keys():
        names += [field for field in differing(theirs[name], ours[name]) if field not in names]
    if names:
        raise TegotaeError(f"another {', '.join(sorted(names))}")
    return {**requested, "experiments": {**theirs, **ours}} if theirs or ours else requested


def _without_experiments(document: Document) -> Document:
    return {name: value for name, value in document.items() if name != "experiments"}


def belongs_to_study(document: Document, configuration: Document) -> bool:
    """Return whether a unit of this configuration is one of the study of this `Plan.document`."""
    experiment = configuration.get("experiment")
    name = experiment.get("name") if isinstance(experiment, dict) else None
    return name in document["experiments"] and configuration == {
        "format": document["format"],
        "experiment": document["experiments"][name],
        "seeds": list(range(document["seeds"])),
        "algorithm": document["algorithm"],
        "stopping": document["stopping"],
        "budgets": document["budgets"],
        **{name: document[name] for name in ("metrics",) if name in document},
    }


def plan(scale: str, models: str | Sequence[str] = "*", extra: Sequence[Experiment] = ()) -> Plan:
    """Return the plan of a scale, restricted to the models that match patterns, with others beside
    them.

    - `smoke`: three small models for seconds, to see that everything works;
    - `quick`: every architecture, on [F_k] and [F_k, ẏ], with its plain actuation, 5 runs each;
    - `paper`: all 218 models, 15 runs each, trained to the plateau;
    - `learning`: seven architectures on [F_k] and the short laws, at seven frequencies, 15 runs
      each, for the question what learning adds (`research.reproduction.learning`);
    - `paper-80x16`: the paper's models with the budget that it names, 80 generations of 16.

    Args:
        scale: its name.
        models: a pattern of their names, with * and ? as in a shell, or several; empty for none.
        extra: experiments that are trained and evaluated beside the models.

    Raises:
        TegotaeError: for an unknown scale, a pattern that matches none of the scale's models, or
            two experiments of the same name.
    """
    require_known("scale", scale, _SCALES)
    full = _SCALES[scale]()
    patterns = [models] if isinstance(models, str) else models
    experiments = matching(full.experiments, patterns, or_none=bool(extra))
    return dataclasses.replace(full, experiments=(*experiments, *extra))


def matching(
    experiments: Sequence[Experiment], patterns: Sequence[str], *, or_none: bool
) -> tuple[Experiment, ...]:
    """Return the experiments whose names match patterns; an empty one may match none.

    Raises:
        TegotaeError: for a pattern that matches none.
    """
    names = [experiment.name for experiment in experiments]
    selected: set[str] = set()
    for pattern in patterns:
        matched = {name for name in names if fnmatch.fnmatchcase(name, pattern)}
        if not matched and (pattern or not or_none):
            raise unknown("model of this scale", pattern, names)
        selected |= matched
    return tuple(entry for entry in experiments if entry.name in selected)


SMOKE = PGPE(population=8, std=0.3, std_lr=0.1, learning_rate=0.2, max_speed=0.4)
"""Settings of the scales `smoke`: large steps, for a few generations."""


def _smoke() -> Plan:
    return Plan(
        scale="smoke",
        experiments=tuple(
            recipe(name).experiment(
                timing=Timing(duration_s=4.0, tick_s=0.002),
                objective=Fitness(settle_s=2.0),
                protocol=Protocol(undisturbed_s=8.0, disturbed_s=8.0, offsets=(-1.0, 1.0)),
            )
            for name in ("V-sector-w8", "ART-rF-tphif-w8", "T-Fv")
        ),
        seeds=2,
        stopping=Stopping.after(3),
        budgets=(16,),
        algorithm=SMOKE,
    )


def _quick() -> Plan:
    def plain(model: Recipe) -> bool:
        if model.omega_t is None:
            return True
        sensed = {x for x in (model.learned_terms.reaction, model.learned_terms.gain) if x}
        half_learned = model.learned_terms.action != (model.learned_terms.reaction is not None)
        return model.actuation in _PLAIN and len(sensed) < 2 and not half_learned

    models = filter(plain, study_recipes().values())
    return Plan(scale="quick", experiments=tuple(entry.experiment() for entry in models), seeds=5)


def _paper() -> Plan:
    experiments = tuple(model.experiment() for model in study_recipes().values())
    return Plan(scale="paper", experiments=experiments, seeds=15)


def _learning() -> Plan:
    drives = ("sector", "reflex", "both"), ("tphi", "tf", "tphif")
    models = [
        recipe(f"{architecture}-{drive}-w{omega:g}").experiment()
        for architecture in MAIN
        for drive in drives["T" in architecture]
        for omega in OMEGAS
    ]
    laws = [recipe(f"{law}-w{omega:g}").experiment() for law in LAWS for omega in OMEGAS]
    return Plan(scale="learning", experiments=(*models, *laws), seeds=15)


def _paper_80x16() -> Plan:
    return dataclasses.replace(
        _paper(),
        scale="paper-80x16",
        algorithm=configuration("pgpe-80x16").settings,
        stopping=Stopping.after(80),
        budgets=(),
    )


_SCALES = {
    "smoke": _smoke,
    "quick": _quick,
    "paper": _paper,
    "learning": _learning,
    "paper-80x16": _paper_80x16,
}
SCALES = tuple(_SCALES)
"""The names of the scales."""
