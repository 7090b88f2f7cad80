"""Hopping: a body with one leg."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_GAIN, require_within
from tegotae.measures.evaluation import Protocol, evaluate, require_evaluable
from tegotae.measures.hopping.metric import TABLE, Metric
from tegotae.measures.hopping.registry import chosen, register
from tegotae.measures.hopping.signals import work_total
from tegotae.parts.bodies import Body
from tegotae.questions.answer import Answer, RecordedRun, columns
from tegotae.questions.task import Task, Work
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing
from tegotae.simulation.timing import MOST_TICKS
from tegotae.systems.controller_file import SavedController
from tegotae.systems.simulation import Result, simulate
from tegotae.systems.system import Release
from tegotae.systems.user_objects import is_reference, named


@dataclass(frozen=True, kw_only=True)
class HoppingOptions:
    """What of a controller on a body with one leg can be otherwise."""

    omega: float | None
    """Frequency ω [rad/s]."""
    sigma: float | None
    """Gain σ of the vanilla feedback [rad/(s N)]."""
    release: Release
    body: Body

    @classmethod
    def options_of(cls, task: HoppingTask, **more: Any) -> Self:
        """The controller's own."""
        system, body = task.runs.system, task.runs.body
        own = {"omega": system.omega, "release": system.release, "body": body}
        return cls(sigma=task.sigma, **own, **more)


@dataclass(frozen=True, kw_only=True)
class HoppingSimulation(HoppingOptions):
    """Simulate a body with one leg: apexes and efficiency."""

    duration_s: float = 20.0
    """Simulated time [s]."""
    drop_m: float = 0.0
    """Height by which the ground drops [m]; a negative one raises it."""
    drop_time_s: float = 10.0
    """Time of the drop [s]."""
    work: Work
    """Definition of the actuator's work."""
    measure_from_s: float | None = None
    """Measure CoT⁻¹ over whole hops from this time on [s]; by default half of the duration."""
    tick_s: float
    """Control period [s]."""
    hold: bool
    """Hold the controller over each tick, as a robot does."""
    float64: bool = False
    """Compute in double precision."""


@dataclass(frozen=True, kw_only=True)
class HoppingEvaluation:
    """Evaluate hopping as in the paper: at several frequencies, with a drop of the ground."""

    omega: float | None
    """Frequency around which it is evaluated [rad/s]."""
    metric: tuple[str, ...] = ()
    """Compute only these metrics: names, your own as FILE.py:OBJECT, or all. By default all are
    computed and the usual ones shown."""
    protocol: Protocol
    body: Body


SERIES = (
    *("time_s", "height_m", "velocity_m_per_s", "phase_rad", "spring_force_n"),
    *("feedback_rad_per_s", "actuator_force_n", "ground_m", "climb_flight_m", "climb_m"),
)
"""The columns of the time series, and beside it the running total of the work."""
OF_HOPS = columns(
    ("hops", "whole hops"),
    ("cot_inverse_flight", "CoT⁻¹ (flight)", "m/J"),
    ("cot_inverse_total", "CoT⁻¹ (all)", "m/J"),
    ("work_j", "work", "J"),
)


class HoppingTask(Task):
    """Controllers on a body with one leg."""

    what = "hops on one leg"

    def controller(self, options: HoppingOptions) -> SavedController:
        """The one controller with what was given.

        Raises:
            TegotaeError: for several controllers, or what does not fit together.
        """
        if options.sigma is not None:
            require_within("sigma", options.sigma, MOST_GAIN)
        changed = {"omega": options.omega, "body": options.body, "release": options.release}
        system = self.runs.system.replaced(changed)
        return SavedController(system, self.weights_at(options.sigma), self.name)

    def simulate_options(self) -> HoppingSimulation:
        """The options of a simulation."""
        system, trained = self.runs.system, self.runs.experiment
        return HoppingSimulation.options_of(
            self,
            work="absolute" if trained is None else trained.protocol.work,  # type: ignore[arg-type]
            tick_s=system.period_s(Timing.tick_s),
            hold=isinstance(system.integrator, Hold),
        )

    def simulate(self, options: HoppingSimulation) -> RecordedRun:
        """One rollout: apexes and efficiency."""
        result = self._rolled_out(options)
        summary, trajectory = result.summary(), result.trajectory
        heights = ", ".join(f"{height:.4f}" for height in result.apexes[1][-4:])
        remarks = [f"no CoT⁻¹: {summary['reason']}"] if summary["reason"] else []
        if summary["hops"]:
            start_s, end_s = summary["window_s"]  # type: ignore[misc]
            remarks.append(f"The whole hops are from {start_s:.2f} to {end_s:.2f} s.")
        if summary["failed"]:
            remarks.append(
                f"failed at {summary['failed_time_s']:.2f} s: the leg has no length left, or the "
                "numbers exceed their range"
            )
        return RecordedRun(
            name=self.name,
            outcome=f"{len(result.apexes[0])} apexes"
            + (f"; the last at {heights} m" if heights else ""),
            raw=result,
            numbers=summary,
            columns=OF_HOPS if summary["hops"] else (),
            table=lambda: {
                **{name: getattr(trajectory, name) for name in SERIES},
                "work_j": work_total(trajectory, options.work),
            },
            settings=options,
            remarks=remarks,
        )

    def _rolled_out(self, options: HoppingSimulation) -> Result:
        tick_s, drops = options.tick_s, options.drop_m != 0.0
        require_finite("tick", tick_s, above=0.0)
        require_finite("drop_time", options.drop_time_s, least=0.0)
        if drops and options.drop_time_s >= options.duration_s:
            raise TegotaeError(
                f"the ground is to drop at {options.drop_time_s:g} s, but the rollout ends at "
                f"{options.duration_s:g} s; set --drop-time or --duration"
            )
        saved = self.controller(options)
        held = {"integrator": Hold()} if options.hold else {}
        frame_s = tick_s * max(1, round(min(0.01 / tick_s, MOST_TICKS)))  # whole ticks, near 10 ms
        return simulate(
            saved.system.replaced(held),
            saved.weights,
            Timing(duration_s=options.duration_s, tick_s=tick_s, frame_s=frame_s),
            drop_m=options.drop_m,
            drop_time_s=options.drop_time_s if drops else math.inf,
            work=options.work,
            measure_from_s=options.measure_from_s,
            dtype="float64" if options.float64 else "float32",
        )

    def evaluate_options(self) -> HoppingEvaluation:
        """The options of an evaluation."""
        runs = self.runs
        return HoppingEvaluation(body=runs.body, protocol=runs.protocol, omega=runs.omega)

    def check(self, options: HoppingEvaluation) -> None:
        _ = _metrics(options.metric)
        require_evaluable(self.runs.controller, options.body, options.protocol)

    def alike(self, options: HoppingEvaluation) -> Mapping[str, Any]:
        """All of the protocol but what belongs to the system: release and control period."""
        protocol = dataclasses.asdict(options.protocol)
        return {name: protocol[name] for name in protocol if name not in ("release_m", "tick_s")}

    def evaluate(self, options: HoppingEvaluation) -> Answer:
        """The metrics of every run and frequency."""
        runs, metrics = self.runs.replaced(body=options.body), _metrics(options.metric)
        result = evaluate(
            runs.controller,
            runs.weights,
            options.omega,
            runs.body,
            options.protocol,
            metrics=metrics,
            start=runs.system.scenario()._replace(height_m=options.protocol.release_m),
            integrator=runs.system.integrator,
        )
        shown = metrics if options.metric else [m for m in metrics if TABLE in m.shown]
        labels, omegas = runs.labels, result.omega
        rows = {"run": np.repeat(labels, len(omegas)), "omega": np.tile(omegas, len(labels))}
        return self.answer(
            rows | {name: values.ravel() for name, values in result.episodes.items()},
            columns(
                *((m.name, m.label, m.unit, m.range, m.more_is_better, m in shown) for m in metrics)
            ),
            options,
            remarks=(
                "Mean over runs [95 % interval]. A body at rest has CoT⁻¹ 0; hopping without a "
                "limit cycle has neither CoT⁻¹ nor transients, and counts in the share of limit "
                "cycles. – is undefined, * means that some runs are.",
            ),
        )


def _metrics(asked: tuple[str, ...]) -> tuple[Metric, ...]:
    """The metrics of names; a user's own is registered."""
    own = {name: named(name, Metric, "metric") for name in asked if is_reference(name)}
    names = [register(own[name]).name if name in own else name for name in asked]
    return chosen(names or None)
