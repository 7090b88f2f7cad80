"""Walking: a body with several legs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.gaits.releases import coordination_columns, release_all, simulate
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.parts.bodies import Body, Sensors
from tegotae.parts.fields import unwrapped, with_fields
from tegotae.questions.answer import Answer, RecordedRun, columns
from tegotae.questions.task import Task
from tegotae.systems.legged import Legged, felt, terrain_of


@dataclass(frozen=True, kw_only=True)
class WalkingOptions:
    """What of a body with several legs can be otherwise."""

    duration_s: float
    """Simulated time [s]."""
    terrain: tuple[str, ...] = ()
    """Ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by its
    parameters, such as rough rms_m=0.05."""
    delay_s: float = 0.0
    """Delay of the senses of the legs [s]."""
    noise: float = 0.0
    """Noise of the senses of the legs, relative to their scales."""
    tolerance: float = TOLERANCE
    """Tolerance around the lags of a named gait [cycles]."""
    body: Body


@dataclass(frozen=True, kw_only=True)
class DrivenOptions(WalkingOptions):
    """The same of one controller."""

    omega: float | None
    """Frequency ω [rad/s]."""
    sigma: float | None
    """Gain σ of the vanilla feedback [rad/(s N)]."""


@dataclass(frozen=True, kw_only=True)
class WalkingSimulation(DrivenOptions):
    """Simulate a body with several legs: footfalls, lags and the name of its gait."""

    phases: tuple[float, ...] = ()
    """Phases of the legs at release [cycles], in the body's order; random ones by default."""
    seed: int = 0
    """Seed of the random phases at release."""


@dataclass(frozen=True, kw_only=True)
class WalkingEvaluation(WalkingOptions):
    """Evaluate how several legs walk from random phases: falls, speed, cost, gait."""

    omega: tuple[float, ...]
    """Frequencies [rad/s]."""
    starts: int = 32
    """Number of releases of each controller."""
    seed: int = 1
    """Seed of the random phases at release."""


@dataclass(frozen=True)
class WalkingTask(Task):
    """Controllers on a body with several legs."""

    what = "walks on several legs"

    legged: Legged
    """Their system, timed so that it settles."""

    def on(self, body: Body) -> WalkingTask:
        return dataclasses.replace(self, legged=self.legged.with_body(body))

    def system(self, options: WalkingOptions) -> Legged:
        """The system with what was given.

        Raises:
            TegotaeError: for what cannot be, before anything is computed.
        """
        require_finite("tolerance", options.tolerance, above=0.0, most=0.5)
        body, legged = options.body, self.legged
        if getattr(body, "present", None) != getattr(unwrapped(legged.body), "present", None):
            raise TegotaeError(
                "--present would remove legs that are then measured; tegotae gait lesion --lose "
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

    def _own(self) -> dict[str, Any]:
        body, senses = self.legged.body, {}
        if isinstance(body, Sensors):
            body, senses = body.body, {"delay_s": body.delay_s, "noise": body.noise}
        return {"body": body, "duration_s": self.legged.timing.duration_s, **senses}

    def driven_options(self) -> dict[str, Any]:
        """The values of `DrivenOptions`."""
        return {**self._own(), "omega": self.legged.omega, "sigma": self.sigma}

    def driven(self, options: DrivenOptions) -> Legged:
        """The system of the one controller with what was given."""
        legged = self.system(options).replaced(omega=options.omega)
        return dataclasses.replace(legged, weights=tuple(self.weights_at(options.sigma)))

    def simulate_options(self) -> WalkingSimulation:
        """The options of a simulation."""
        return WalkingSimulation(**self.driven_options())

    def simulate(self, options: WalkingSimulation) -> RecordedRun:
        """One release: footfalls, lags and the gait."""
        legged = self.driven(options)
        if options.phases and options.seed:
            raise TegotaeError("--seed is of random phases, and --phases says what they are")
        phases = [2.0 * math.pi * phase for phase in options.phases] or None
        run = simulate(legged, phases, seed=options.seed, tolerance=options.tolerance)
        (length, time), last = legged.units, run.found
        numbers = {k: x[0].item() for k, x in coordination_columns(last, legged.names).items()}
        stances = {
            name: [list(stance) for stance in leg]
            for name, leg in zip(legged.names, run.stances, strict=True)
        }
        more = {"gait": run.gait, "release_phase_rad": run.phase_rad, "stances": stances}
        of_legs = {
            "leg": legged.names,
            "lag [cycles]": last.lag[:, 0] % 1.0,
            "footfall lag": last.touchdown_lag[:, 0] % 1.0,
            "duty factor": last.duty_factor[:, 0],
            f"steps [1/{time}]": last.step_frequency_hz[:, 0],
        }
        return RecordedRun(
            name=self.name,
            outcome=run.gait,
            raw=run,
            numbers={**numbers, **more},
            columns=columns(
                ("lock_time_s", "locked after", time),
                ("order_parameter", "order parameter"),
                ("speed_m_per_s", "speed", f"{length}/{time}"),
                ("cost_of_transport", "cost of transport"),
                ("froude", "Froude number"),
                ("fall_time_s", "fell at", time),
            ),
            table=lambda: run.series,
            settings=options,
            limbs=pd.DataFrame(of_legs),
        )

    def evaluate_options(self) -> WalkingEvaluation:
        """The options of an evaluation."""
        omega = self.legged.omega
        return WalkingEvaluation(**self._own(), omega=() if omega is None else (omega,))

    def alike(self, options: WalkingEvaluation) -> Mapping[str, Any]:
        return {name: getattr(options, name) for name in ("starts", "seed", "omega")}

    def evaluate(self, options: WalkingEvaluation) -> Answer:
        """How every run walks at every frequency."""
        legged, weights = self.system(options), self.runs.weights
        released = release_all(
            legged,
            weights,
            options.omega,
            options.starts,
            seed=options.seed,
            tolerance=options.tolerance,
        )
        rows = dict(released.summary)
        rows["run"] = np.array(self.runs.labels)[rows["run"]]
        (length, time), share, positive = legged.units, (0.0, 1.0), (0.0, math.inf)
        return self.answer(
            rows,
            columns(
                ("upright", "upright", "", share, True),
                ("locked", "locked", "", share, True),
                ("lock_time_s", "locks in", time, positive, False),
                ("speed_m_per_s", "speed", f"{length}/{time}"),
                ("cost_of_transport", "CoT", "", positive, False),
                ("froude", "Froude number", "", positive, None, False),
                ("slip", "slip", "", positive, False),
                ("gait", "gait"),
                ("gait_share", "share of it", "", share, None, False),
            ),
            options,
            groups=("controller", "omega"),
        )
