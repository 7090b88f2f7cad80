"""Hopping: a body with one leg."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from types import SimpleNamespace
from typing import Annotated, Any, TypedDict, Unpack

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_GAIN, require_within
from tegotae.analysis.simulation import Result, largest_change_m, simulate
from tegotae.api.controller import Changes, LoadedController, MetricOptions, Subject, Work
from tegotae.api.evaluations import EvaluationTable
from tegotae.api.parameters import Values, check_types, filled
from tegotae.api.results import Animation, MatplotlibFigure, Recording, Table
from tegotae.measures.evaluation import (
    ACCURACY,
    CONTINUOUS,
    Evaluation,
    Protocol,
    evaluate,
    require_evaluable,
)
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.hopping.signals import work_total
from tegotae.measures.metric import Metric
from tegotae.parts.bodies import Body
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing
from tegotae.simulation.timing import MOST_TICKS
from tegotae.systems.controller_file import SavedController
from tegotae.systems.system import Release

SERIES = (
    *("time_s", "height_m", "velocity_m_per_s", "phase_rad", "spring_force_n"),
    *("feedback_rad_per_s", "actuator_force_n", "ground_m", "climb_flight_m", "climb_m"),
)
"""The columns of the time series, and beside it the running total of the work."""
MEANS = (
    "Mean over runs [95 % interval]. A body at rest has CoT⁻¹ 0; hopping without a limit cycle "
    "has neither CoT⁻¹ nor transients, and counts in the share of limit cycles. – is undefined, * "
    "means that some runs are."
)
ACCURACY_M = 0.001
"""Largest error of the apexes of a rollout that the control period resolves [m]."""
OF_HOPS = {
    "hops": "whole hops",
    "cot_inverse_flight": "CoT⁻¹ (flight) [m/J]",
    "cot_inverse_total": "CoT⁻¹ (all) [m/J]",
    "work_j": "work [J]",
}
"""Headings of the numbers of a rollout with whole hops."""


class HopperOptions(TypedDict, total=False):
    """Options of a controller of a body with one leg."""

    omega: Annotated[float | None, "frequency ω [rad/s]"]
    sigma: Annotated[float | None, "gain σ of the vanilla feedback [rad/(s N)]"]
    release: Annotated[
        Release | Changes | None, "start of the episode, or changes of the controller's own"
    ]
    body: Annotated[Body | Changes | None, "another body, or changes of the controller's own"]


class HopperEvaluation(MetricOptions, total=False):
    """Options of an evaluation as in the paper."""

    omega: Annotated[float | None, "frequency around which it is evaluated [rad/s]"]
    protocol: Annotated[
        Protocol | Changes | None, "protocol of the evaluation, or changes of the controller's own"
    ]
    body: Annotated[Body | Changes | None, "another body, or changes of the controller's own"]


class HopperController(LoadedController):
    """Controllers of a body with one leg."""

    description = "hops on one leg"
    catalogue = HOPPING

    def defaults(self) -> Values:
        system, trained = self.runs.system, self.runs.experiment
        return {
            "omega": system.omega,
            "sigma": self.sigma,
            "release": system.release,
            "body": self.runs.body,
            "work": "absolute" if trained is None else trained.protocol.work,
            "tick_s": system.period_s(Timing.tick_s),
            "hold": isinstance(system.integrator, Hold),
            "protocol": self.runs.protocol,
            "duration_s": self.runs.protocol.undisturbed_s,
        }

    def changed(self, values: Any) -> SavedController:
        """Return the one controller with other values.

        Args:
            values: those of `HopperOptions`, without None.

        Raises:
            TegotaeError: for several controllers, or values that do not fit together.
        """
        if values.sigma is not None:
            require_within("sigma", values.sigma, MOST_GAIN)
        parts = {"omega": values.omega, "release": values.release, "body": values.body}
        return SavedController(
            replace(self.runs.system, parts), self.weights_at(values.sigma), self.name
        )

    @check_types
    def simulate(
        self,
        *,
        duration_s: float = 20.0,
        drop_m: float = 0.0,
        drop_time_s: float = 10.0,
        work: Work | None = None,
        measure_from_s: float | None = None,
        tick_s: float | None = None,
        hold: bool | None = None,
        float64: bool = False,
        **options: Unpack[HopperOptions],
    ) -> Recording:
        """Simulate a body with one leg: apexes and efficiency.

        A note says if half the control period moves an apex by more than 0.5 mm.

        Args:
            duration_s: simulated time [s].
            drop_m: height by which the ground drops [m]; a negative one raises it.
            drop_time_s: time of the drop [s].
            work: definition of the actuator's work.
            measure_from_s: start of the whole hops over which CoT⁻¹ is measured [s]; half of the
                duration by default.
            tick_s: control period [s].
            hold: hold the controller over each tick, as a robot does.
            float64: compute in double precision.

        Raises:
            TegotaeError: for values that cannot be, before anything is computed.

        Example:
            >>> from tegotae.api.controllers import load
            >>> load("paper").simulate(duration_s=4.0, drop_m=0.1, drop_time_s=2.0).table.columns[1]
            'height_m'
        """
        values = filled(locals(), self.defaults())
        result = self._rolled_out(values)
        summary, trajectory = result.summary(), result.trajectory
        heights = ", ".join(f"{height:.4f}" for height in result.apexes[1][-4:])
        notes = [f"no CoT⁻¹: {summary['reason']}"] if summary["reason"] else []
        if summary["hops"]:
            start_s, end_s = summary["window_s"]  # type: ignore[misc]
            notes.append(f"The whole hops are from {start_s:.2f} to {end_s:.2f} s.")
        if summary["failed"]:
            notes.append(
                f"failed at {summary['failed_time_s']:.2f} s: the leg has no length left, or the "
                "numbers exceed their range"
            )
        notes += self._resolution(values, result)
        return Recording(
            name=self.name,
            title=f"{len(result.apexes[0])} apexes"
            + (f"; the last at {heights} m" if heights else ""),
            raw=result,
            numbers=summary,
            headings=OF_HOPS if summary["hops"] else {},
            rows=lambda: {
                **{name: getattr(trajectory, name) for name in SERIES},
                "work_j": work_total(trajectory, values.work),
            },
            settings=vars(values),
            notes=notes,
            draw=lambda: _figures(result),
            film=lambda: _animation(result),
        )

    def _resolution(self, values: Any, result: Result) -> list[str]:
        """Return a note if half the control period changes a rollout in continuous time."""
        tick_s, change_m = values.tick_s, 0.0
        if result.system.integrator == CONTINUOUS:
            with suppress(TegotaeError):  # half the period may be too short, as for delayed senses
                half = SimpleNamespace(**vars(values) | {"tick_s": 0.5 * tick_s})
                apexes_m = self._rolled_out(half).apexes[1]
                change_m = largest_change_m(result.apexes[1], apexes_m, result.body.rest_length_m)
        if change_m <= 0.5 * ACCURACY_M:
            return []
        change = f"moves an apex by {change_m:.2g} m" if change_m < math.inf else "changes the hops"
        return [f"Not resolved by a tick of {1e3 * tick_s:g} ms: half the tick {change}."]

    def _rolled_out(self, values: Any) -> Result:
        tick_s, drops = values.tick_s, values.drop_m != 0.0
        require_finite("tick_s", tick_s, above=0.0)
        require_finite("drop_time_s", values.drop_time_s, least=0.0)
        if drops and values.drop_time_s >= values.duration_s:
            raise TegotaeError(
                f"the ground is to drop at {values.drop_time_s:g} s, but the rollout ends at "
                f"{values.duration_s:g} s; set drop_time_s or duration_s"
            )
        saved = self.changed(values)
        held = {"integrator": Hold()} if values.hold else {}
        frame_s = tick_s * max(1, round(min(0.01 / tick_s, MOST_TICKS)))  # whole ticks, near 10 ms
        return simulate(
            replace(saved.system, held),
            saved.weights,
            Timing(duration_s=values.duration_s, tick_s=tick_s, frame_s=frame_s),
            drop_m=values.drop_m,
            drop_time_s=values.drop_time_s if drops else math.inf,
            work=values.work,
            measure_from_s=values.measure_from_s,
            dtype="float64" if values.float64 else "float32",
        )

    @check_types
    def evaluate(
        self, *others: Subject | LoadedController, **options: Unpack[HopperEvaluation]
    ) -> Table:
        """Evaluate hopping as in the paper: at several frequencies, with a drop of the ground.

        A note counts the episodes that half the control period changes; the column `resolved` has
        them.

        Args:
            others: further controllers.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._evaluated(others, options)

    @check_types
    def compare(
        self, *others: Subject | LoadedController, **options: Unpack[HopperEvaluation]
    ) -> Table:
        """Compare hopping, evaluated as in the paper, and how it differs from the first controller.

        Args:
            others: controllers that are compared with this one.

        Raises:
            TegotaeError: for values that cannot be, or protocols that differ.
        """
        return self._compared(others, options)

    def _check(self, options: Any) -> None:
        super()._check(options)
        require_evaluable(self.runs.controller, options.body, options.protocol)

    def _shared(self, options: Any) -> Mapping[str, Any]:
        """Return the protocol without the options of the system: release and control period."""
        protocol = dataclasses.asdict(options.protocol)
        return {name: protocol[name] for name in protocol if name not in ("release_m", "tick_s")}

    def _measured(self, options: Any) -> EvaluationTable:
        runs = replace(self.runs, {"body": options.body})
        metrics = self._metrics(options.metric)
        # With the drop, the programs of the whole evaluation serve at half the tick, too.
        criteria = ("cot_inverse",) if options.metric else ("cot_inverse", "recovery_share")

        def evaluated(metrics: Iterable[str | Metric], tick_s: float) -> Evaluation:
            return evaluate(
                runs.controller,
                runs.weights,
                options.omega,
                runs.body,
                dataclasses.replace(options.protocol, tick_s=tick_s),
                metrics=metrics,
                start=runs.system.scenario()._replace(height_m=options.protocol.release_m),
                integrator=runs.system.integrator,
            )

        tick_s = options.protocol.tick_s
        result, notes = evaluated((*metrics, *criteria), tick_s), [MEANS]
        labels, omegas = runs.labels, result.omega
        rows = {"run": np.repeat(labels, len(omegas)), "omega": np.tile(omegas, len(labels))}
        rows |= {metric.name: result.episodes[metric.name].ravel() for metric in metrics}
        if runs.system.integrator == CONTINUOUS:
            with suppress(TegotaeError):  # as above
                rows["resolved"] = result.resolved(evaluated(criteria, 0.5 * tick_s)).ravel()
        if count := np.sum(~rows.get("resolved", np.ones(0, bool))):
            notes.append(
                f"Not resolved by a tick of {1e3 * tick_s:g} ms: {count} of {len(rows['run'])} "
                f"episodes of {self.name}. Half the tick changes their CoT⁻¹ by more than "
                f"{50 * ACCURACY:g} %, or whether they settle or recover."
            )
        return self._measurements(
            rows, metrics, options, shows_all=bool(options.metric), notes=notes
        )


def _figures(result: Result) -> dict[str, MatplotlibFigure]:
    from tegotae.figures.rollout import rollout_figure

    return {"rollout": rollout_figure(result)}


def _animation(result: Result) -> Animation:
    from tegotae.figures.animation import animation

    return animation(result)
