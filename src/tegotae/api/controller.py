"""Loaded controllers: one class for a body with one leg, with several, and in another simulator.

Each has the same verbs as methods, with options of its own.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypedDict, TypeVar

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.api.evaluations import EvaluationTable
from tegotae.api.parameters import Values, check_types, filled
from tegotae.api.results import Recording, Table
from tegotae.measures.metric import Catalogue, Metric
from tegotae.parts.bodies import Body
from tegotae.parts.fields import replace
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.legged import Legged
from tegotae.systems.registry import is_reference, load_object, register

if TYPE_CHECKING:
    from tegotae.analysis.generalisation.disturbances import Tested

Work = Literal["absolute", "positive", "net"]
"""Definitions of an actuator's work."""
Subject = str | PathLike[str] | SavedController | Legged | ControllerSet
"""Name of controllers (`tegotae.systems.resolve`), or an object with weights."""
T = TypeVar("T")
Changes = Mapping[str, Any]
"""Values by field that differ from the controller's own, such as {"mass_kg": 0.2}."""


class MetricOptions(TypedDict, total=False):
    """Option that selects metrics."""

    metric: Annotated[
        Sequence[str],
        "names of the metrics to compute, your own as FILE.py:OBJECT, or all. By default all are "
        "computed and the usual ones shown",
        (),
    ]


@dataclasses.dataclass(frozen=True)
class LoadedController:
    """Controllers with their body: one, or all runs of a training."""

    description: ClassVar[str]
    """Predicate of a sentence about them, after their name."""
    catalogue: ClassVar[Catalogue]
    """Metrics of such bodies."""
    runs: ControllerSet
    source: str = dataclasses.field(default="", kw_only=True)
    """Name that they were loaded by."""

    def __repr__(self) -> str:
        size = " of ".join(
            f"{count} {unit}{'s' * (count != 1)}"
            for count, unit in zip(self.runs.weights.shape, ("run", "weight"), strict=True)
        )
        return f"<{type(self).__name__} {self.name}: {size}>"

    def defaults(self) -> Values:
        """Return the controller's own values of the options."""
        return {}

    @check_types
    def simulate(self) -> Recording:
        """Simulate one run of a controller in detail."""
        raise NotImplementedError

    @check_types
    def evaluate(self, *others: Subject | LoadedController) -> Table:
        """Evaluate controllers: means over the runs of a training with their 95 % intervals.

        Args:
            others: further controllers.
        """
        raise NotImplementedError

    @check_types
    def compare(self, *others: Subject | LoadedController) -> Table:
        """Compare controllers: how good each is, and how it differs from the first.

        Args:
            others: controllers that are compared with this one.
        """
        raise NotImplementedError

    @check_types
    def explain(
        self,
        *,
        duration_s: float | None = None,
        releases: int = 15,
        seed: int = 0,
        retune: int = 60,
        retune_seeds: int = 3,
        first_seed: int = 0,
    ) -> Table:
        """Explain a controller on one page.

        The page has its curves over the states of its gait, the phases at which it waits and
        pushes, its score with and without its feedback, and its response to the command ω.

        Args:
            duration_s: simulated time of an episode [s]; that of an evaluation by default.
            releases: number of releases, none of which a training saw.
            seed: seed of their heights and phases.
            retune: generations for which each short form is retuned; 0 tries none.
            retune_seeds: number of runs of each, of which the one of highest fitness in its
                training is taken.
            first_seed: first seed of the retuning; the others follow it.

        Raises:
            TegotaeError: for a controller elsewhere than on a body of this package, or values that
                cannot be.
        """
        options = filled(locals(), self.defaults())
        from tegotae.api.explaining import explain

        return explain(self, options)

    @check_types
    def certify(
        self,
        *,
        least_m_per_s: float = 0.3,
        most_m_per_s: float = 6.5,
        speeds: int = 64,
        phases: int = 160,
        tick_s: float = 0.001,
        load_error: float = 0.0,
        stiffness_error: float = 0.0,
        mass_error: float = 0.0,
        splits: int = 1,
    ) -> Table:
        """Certify that a hopper with this law hops for ever from a set of landings.

        The law is sampled: feedback and force are held over each tick, as in the exported C. A
        landing is the speed and the phase at the first tick in stance. The checker of the study
        `research/certificate` proves the file's claims anew.

        Args:
            least_m_per_s: least landing speed [m/s].
            most_m_per_s: largest landing speed [m/s].
            speeds: number of cells over the speeds.
            phases: number of cells over the phases.
            tick_s: control period [s].
            load_error: largest error of the sensed load [weights of the body].
            stiffness_error: largest relative error of the leg's stiffness.
            mass_error: largest relative error of the mass.
            splits: parts into which the ranges of mass and of stiffness are split, each.

        Raises:
            TegotaeError: for a law or a body without known bounds, or if no set is certified.
        """
        options = filled(locals(), {})
        from tegotae.api.certifying import certify

        return certify(self, options)

    @check_types
    def robustness(
        self,
        *others: Subject | LoadedController,
        conditions: Sequence[str] = (),
        only: str = "*",
        starts: int = 4,
        out: Path | str = Path("robustness"),
        restart: bool = False,
    ) -> Table:
        """Test trained controllers in conditions outside of their training.

        The controllers stay unchanged. Run it again on the same folder to continue.

        Args:
            others: further controllers.
            conditions: names, such as delay noise, or with your own levels, delay=0.01/0.02; all
                by default.
            only: test only controllers whose names match this pattern, with * and ? as in a shell.
            starts: number of releases, for several legs or a MuJoCo model with noise.
            out: folder for records, tables and the picture; the same one again continues.
            restart: start again, and move existing records to a folder beside this one.

        Raises:
            TegotaeError: for a condition that there is not, or a folder of something else.
        """
        options = filled(locals(), {})
        from tegotae.api.controllers import load_all
        from tegotae.api.robustness import robustness

        return robustness(load_all(self, *others), options)

    def _check(self, options: Any) -> None:
        """Raise `TegotaeError` before long work for options that cannot be evaluated."""
        _ = self._metrics(options.metric)

    def _metrics(self, requested: Sequence[str]) -> tuple[Metric, ...]:
        """Return the metrics of names; all without any.

        Args:
            requested: names, or a user's own as FILE.py:OBJECT, which is registered.

        Raises:
            TegotaeError: for one that is not there, or of other bodies.
        """
        names: list[str] = []
        for name in requested:
            if is_reference(name):
                metric = load_object(name, Metric, "metric")
                if metric.CATALOGUE is not self.catalogue:
                    raise TegotaeError(
                        f"{name} is a metric of {metric.CATALOGUE.kind}; here is "
                        f"{self.catalogue.kind}"
                    )
                name = register(metric).name
            names.append(name)
        return self.catalogue.select(names or None)

    def _shared(self, options: Any) -> Mapping[str, Any]:
        """Return the options that two evaluations must share to be compared."""
        return {}

    def _measured(self, options: Any) -> EvaluationTable:
        """Evaluate these controllers alone.

        Args:
            options: all options of `evaluate`, without None.
        """
        raise NotImplementedError

    def tested(self, starts: int) -> Tested:
        """Return the runs, ready to be disturbed (`tegotae.analysis.generalisation.disturbances`).

        Args:
            starts: number of releases.
        """
        from tegotae.analysis.generalisation.on_engine import ControllersUnderTest

        return ControllersUnderTest.from_runs(self.runs, starts)

    def on(self, body: Body) -> Self:
        """Return the same controllers on another body.

        Args:
            body: the other body.
        """
        return dataclasses.replace(self, runs=replace(self.runs, {"body": body}))

    @property
    def name(self) -> str:
        """Name of the controllers."""
        return self.runs.name

    @property
    def weights(self) -> np.ndarray:
        """Weights of the one controller, shape [n_weights].

        Raises:
            TegotaeError: if there are several.
        """
        if len(self.runs.weights) > 1:
            raise TegotaeError(
                f"{self.name} holds {len(self.runs.weights)} controllers; name one of them"
            )
        return self.runs.weights[0]

    @property
    def saved(self) -> SavedController:
        """System and weights of the one controller."""
        runs = self.runs
        return SavedController(
            runs.system, self.weights, self.name, runs.experiment, task=runs.task
        )

    @property
    def sigma(self) -> float | None:
        """Gain of a vanilla controller [rad/(s N)]; None for any other."""
        is_vanilla = self.runs.controller.has_a_gain_alone and len(self.runs.weights) == 1
        return float(self.runs.weights[0, 0]) if is_vanilla else None

    def weights_at(self, sigma: float | None) -> np.ndarray:
        """Return the weights of the one controller, with another gain if it is vanilla.

        Args:
            sigma: gain σ [rad/(s N)]; None for the controller's own.

        Raises:
            TegotaeError: for a gain of any other.
        """
        if sigma is None:
            return self.weights
        if self.sigma is None:
            raise TegotaeError(f"sigma belongs to vanilla controllers; {self.name} is none")
        return np.array([sigma])

    def require(self, kind: type[T], reason: str) -> T:
        """Return the controller as one of a class.

        Args:
            kind: the class.
            reason: reason that others do not fit.

        Raises:
            TegotaeError: if it is another.
        """
        if not isinstance(self, kind):
            raise TegotaeError(f"{self.name} {self.description}, and {reason}")
        return self

    def _evaluated(self, others: Sequence[Any], options: Mapping[str, Any]) -> EvaluationTable:
        """Evaluate the controllers, each with its own values of the options."""
        return _evaluate(self._prepared(others, options))

    def _compared(self, others: Sequence[Any], options: Mapping[str, Any]) -> EvaluationTable:
        """Evaluate the controllers, and return the differences to the first."""
        prepared = self._prepared(others, options)
        if len(prepared) == 1:
            raise TegotaeError("a comparison needs at least two sets of controllers; 1 found")
        (first, values), *further = prepared
        shared = first._shared(values)
        for controller, other_values in further:
            for option, value in controller._shared(other_values).items():
                if value != shared[option]:
                    raise TegotaeError(
                        f"{first.name} and {controller.name} are evaluated with another {option}, "
                        f"{shared[option]} and {value}; an option sets one for all"
                    )
        return _evaluate(prepared).compared_with(first.name)

    def _prepared(
        self, others: Sequence[Any], options: Mapping[str, Any]
    ) -> list[tuple[LoadedController, Any]]:
        """Return the controllers with their values of the options, which can be evaluated."""
        from tegotae.api.controllers import load_all

        controllers: list[LoadedController] = [*load_all(self, *others)]
        first = controllers[0]
        prepared = [
            (controller, filled(options, controller.defaults())) for controller in controllers
        ]
        for controller, values in prepared:
            if type(controller) is not type(first):
                raise TegotaeError(
                    f"{first.name} {first.description}, and {controller.name} "
                    f"{controller.description}: they have no measure in common"
                )
            controller._check(values)
        return prepared

    def _measurements(
        self, rows: Any, metrics: tuple[Metric, ...], options: Any, **fields: Any
    ) -> EvaluationTable:
        """Return the measurements of the runs, with the facts about their training.

        Args:
            rows: columns by name, or a dict a row.
            metrics: measured quantities.
            options: options of the evaluation.
            fields: further fields of the result.
        """
        runs, training = self.runs, self.runs.training
        drawn = (training.get("conditions") or [], training.get("episodes", 1))
        training_facts = (runs.labels, runs.controller, training.get("algorithm"), drawn)
        table = pd.DataFrame(rows)
        table.insert(0, "controller", self.name)
        single = len(runs.labels) == 1 and runs.controller.has_a_gain_alone
        return EvaluationTable(
            rows=table,
            metrics=tuple(metric for metric in metrics if metric.name in table),
            trained={self.name: training_facts if "algorithm" in training else None},
            exact=frozenset([self.name] if single else []),
            settings={self.name: vars(options)},
            **fields,
        )


def _evaluate(prepared: Sequence[tuple[LoadedController, Any]]) -> EvaluationTable:
    """Evaluate controllers with their values of the options."""
    tables: list[EvaluationTable] = []
    with reporting("evaluate", len(prepared)) as reporter:
        for controller, values in prepared:
            tables.append(controller._measured(values))
            reporter.update(len(tables), controller.name)
    return EvaluationTable.joined(tables)
