"""Walking: a body with several legs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.gaits.releases import release_all, simulate_gaits
from tegotae.api.controller import Changes, LoadedController, Subject, selected_metrics
from tegotae.api.parameters import Values, check_types, filled
from tegotae.api.results import (
    Column,
    EvaluationTable,
    Recording,
    Table,
    columns,
    metric_columns,
)
from tegotae.measures.gaits.metrics import GAIT, WALKING
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.measures.gaits.summary import coordination_columns
from tegotae.parts.bodies import Body, Sensors
from tegotae.parts.fields import unwrapped, with_fields
from tegotae.systems.legged import Legged, felt, terrain_of


@dataclass(frozen=True)
class WalkerController(LoadedController):
    """Controllers of a body with several legs."""

    what = "walks on several legs"

    legged: Legged
    """Their system, timed so that it settles."""

    def on(self, body: Body) -> WalkerController:
        return dataclasses.replace(self, legged=self.legged.with_body(body))

    def defaults(self) -> Values:
        body = self.legged.body
        senses: Values = {"delay_s": 0.0, "noise": 0.0}
        if isinstance(body, Sensors):
            body, senses = body.body, {"delay_s": body.delay_s, "noise": body.noise}
        return {
            "body": body,
            "duration_s": self.legged.timing.duration_s,
            **senses,
            "omega": self.legged.omega,
            "sigma": self.sigma,
        }

    def system(self, options: Any) -> Legged:
        """Return the system with other values.

        Args:
            options: body, duration_s, terrain, delay_s, noise and tolerance.

        Raises:
            TegotaeError: for values that cannot be, before anything is computed.
        """
        require_finite("tolerance", options.tolerance, above=0.0, most=0.5)
        body, legged = options.body, self.legged
        if getattr(body, "present", None) != getattr(unwrapped(legged.body), "present", None):
            raise TegotaeError(
                "present would remove legs that are then measured; tegotae gait perturb --lose "
                "removes legs"
            )
        if options.terrain:
            body = with_fields(body, {"terrain": terrain_of(options.terrain)})
        if body is not legged.body:
            legged = legged.with_body(body)
        timing = dataclasses.replace(legged.timing, duration_s=options.duration_s)
        legged = legged.replaced(timing=timing)
        if options.delay_s or options.noise:
            legged = legged.with_body(felt(legged, options.delay_s, options.noise))
        return legged

    def driven(self, options: Any) -> Legged:
        """Return the system of the one controller with other values.

        Args:
            options: those of `system`, omega and sigma.
        """
        legged = self.system(options).replaced(omega=options.omega)
        return dataclasses.replace(legged, weights=tuple(self.weights_at(options.sigma)))

    @check_types
    def simulate(
        self,
        *,
        duration_s: float | None = None,
        omega: float | None = None,
        sigma: float | None = None,
        phases: Sequence[float] = (),
        seed: int = 0,
        terrain: Sequence[str] = (),
        delay_s: float | None = None,
        noise: float | None = None,
        tolerance: float = TOLERANCE,
        body: Body | Changes | None = None,
    ) -> Recording:
        """Simulate a body with several legs: footfalls, lags and the name of its gait.

        Args:
            duration_s: simulated time [s].
            omega: frequency ω [rad/s].
            sigma: gain σ of the vanilla feedback [rad/(s N)].
            phases: phases of the legs at release [cycles], in the body's order; random ones by
                default.
            seed: seed of the random phases at release.
            terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT,
                followed by its parameters, such as rough rms_m=0.05.
            delay_s: delay of the senses of the legs [s].
            noise: noise of the senses of the legs, relative to their scales.
            tolerance: tolerance around the lags of a named gait [cycles].
            body: another body, or changes of the system's own.

        Raises:
            TegotaeError: for values that cannot be, before anything is computed.
        """
        options = filled(locals(), self.defaults())
        legged = self.driven(options)
        if options.phases and options.seed:
            raise TegotaeError("seed is of random phases, and phases gives them; leave one out")
        release = [2.0 * math.pi * phase for phase in options.phases] or None
        run = simulate_gaits(legged, release, seed=options.seed, tolerance=options.tolerance)
        (length, time), last = legged.units, run.found
        numbers = {k: x[0].item() for k, x in coordination_columns(last, legged.names).items()}
        stances = {
            name: [list(stance) for stance in leg]
            for name, leg in zip(legged.names, run.stances, strict=True)
        }
        further = {"gait": run.gait, "release_phase_rad": run.phase_rad, "stances": stances}
        of_legs = {
            "leg": legged.names,
            "lag [cycles]": last.lag[:, 0] % 1.0,
            "footfall lag": last.touchdown_lag[:, 0] % 1.0,
            "duty factor": last.duty_factor[:, 0],
            f"steps [1/{time}]": last.step_frequency_hz[:, 0],
        }
        return Recording(
            name=self.name,
            title=run.gait,
            raw=run,
            numbers={**numbers, **further},
            columns=columns(
                ("lock_time_s", "locked after", time),
                ("order_parameter", "order parameter"),
                ("speed_m_per_s", "speed", f"{length}/{time}"),
                ("cost_of_transport", "cost of transport"),
                ("froude", "Froude number"),
                ("fall_time_s", "fell at", time),
            ),
            rows=lambda: run.series,
            settings=vars(options),
            limbs=pd.DataFrame(of_legs),
        )

    @check_types
    def evaluate(
        self,
        *others: Subject | LoadedController,
        omega: Sequence[float] | None = None,
        metric: Sequence[str] = (),
        starts: int = 32,
        seed: int = 1,
        duration_s: float | None = None,
        terrain: Sequence[str] = (),
        delay_s: float | None = None,
        noise: float | None = None,
        tolerance: float = TOLERANCE,
        body: Body | Changes | None = None,
    ) -> Table:
        """Evaluate how several legs walk from random phases: falls, speed, cost, gait.

        Args:
            others: further controllers.
            omega: frequencies [rad/s].
            metric: names of the metrics to compute, your own as FILE.py:OBJECT, or all. By default
                all are computed and the usual ones shown.
            starts: number of releases of each controller.
            seed: seed of the random phases at release.
            duration_s: simulated time [s].
            terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT,
                followed by its parameters, such as rough rms_m=0.05.
            delay_s: delay of the senses of the legs [s].
            noise: noise of the senses of the legs, relative to their scales.
            tolerance: tolerance around the lags of a named gait [cycles].
            body: another body, or changes of the system's own.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._evaluated(others, {**locals()})

    @check_types
    def compare(
        self,
        *others: Subject | LoadedController,
        omega: Sequence[float] | None = None,
        metric: Sequence[str] = (),
        starts: int = 32,
        seed: int = 1,
        duration_s: float | None = None,
        terrain: Sequence[str] = (),
        delay_s: float | None = None,
        noise: float | None = None,
        tolerance: float = TOLERANCE,
        body: Body | Changes | None = None,
    ) -> Table:
        """Compare how several legs walk from random phases, and how it differs from the first.

        Args:
            others: controllers that are compared with this one.
            omega: frequencies [rad/s].
            metric: names of the metrics to compute, your own as FILE.py:OBJECT, or all. By default
                all are computed and the usual ones shown.
            starts: number of releases of each controller.
            seed: seed of the random phases at release.
            duration_s: simulated time [s].
            terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT,
                followed by its parameters, such as rough rms_m=0.05.
            delay_s: delay of the senses of the legs [s].
            noise: noise of the senses of the legs, relative to their scales.
            tolerance: tolerance around the lags of a named gait [cycles].
            body: another body, or changes of the system's own.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._evaluated(others, {**locals()}, compares=True)

    def _check(self, options: Any) -> None:
        _ = selected_metrics(WALKING, options.metric)

    def _alike(self, options: Any) -> Mapping[str, Any]:
        return {
            "starts": options.starts,
            "seed": options.seed,
            "omega": _frequencies(options),
        }

    def _measured(self, options: Any) -> EvaluationTable:
        options.omega = _frequencies(options)
        legged, weights = self.system(options), self.runs.weights
        metrics = selected_metrics(WALKING, options.metric)
        released = release_all(
            legged,
            weights,
            options.omega,
            options.starts,
            seed=options.seed,
            tolerance=options.tolerance,
            metrics=metrics if options.metric else None,
        )
        rows = dict(released.summary)
        rows["run"] = np.array(self.runs.labels)[rows["run"]]
        length, time = legged.units
        units = {"s": time, "m": length, "m/s": f"{length}/{time}"}
        measured = metric_columns(metrics, requested=bool(options.metric), units=units)
        return self._measurements(
            rows, (*measured, Column(GAIT, "gait")), options, groups=("controller", "omega")
        )


def _frequencies(options: Any) -> tuple[float, ...]:
    """Frequencies of an evaluation [rad/s]; the system's own by default."""
    omega = options.omega
    return tuple(omega) if isinstance(omega, Sequence) else () if omega is None else (omega,)
