"""Walking: a body with several legs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypedDict, Unpack

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.gaits.releases import GaitRun, release_all, simulate_gaits
from tegotae.api.controller import Changes, LoadedController, MetricOptions, Subject
from tegotae.api.evaluations import EvaluationTable
from tegotae.api.parameters import Values, check_types, filled
from tegotae.api.results import Animation, MatplotlibFigure, Recording, Table
from tegotae.measures.gaits.metrics import GAIT, WALKING
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.measures.metric import Metric
from tegotae.parts.bodies import Body, Sensors
from tegotae.parts.fields import replace, unwrapped
from tegotae.systems.legged import Legged, felt
from tegotae.systems.parts_by_name import terrain_of

_GAIT = Metric(name=GAIT, label=GAIT, about="name of the gait", more_is_better=None)


class GroundOptions(TypedDict, total=False):
    """Options of a body with several legs and of its ground."""

    terrain: Annotated[
        Sequence[str],
        "ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by its "
        "parameters, such as rough rms_m=0.05",
        (),
    ]
    delay_s: Annotated[float | None, "delay of the senses of the legs [s]"]
    noise: Annotated[float | None, "noise of the senses of the legs, relative to their scales"]
    tolerance: Annotated[float, "tolerance around the lags of a named gait [cycles]", TOLERANCE]
    body: Annotated[Body | Changes | None, "another body, or changes of the system's own"]


class RhythmOptions(TypedDict, total=False):
    """Options of one release of a body with several legs."""

    duration_s: Annotated[float | None, "simulated time [s]"]
    omega: Annotated[float | None, "frequency ω [rad/s]"]
    sigma: Annotated[float | None, "gain σ of the vanilla feedback [rad/(s N)]"]
    seed: Annotated[int, "seed of the random phases at release", 0]


class WalkerOptions(RhythmOptions, GroundOptions, total=False):
    """Options of a controller of a body with several legs."""


class ReleaseOptions(MetricOptions, total=False):
    """Options of many releases of several controllers."""

    omega: Annotated[Sequence[float] | None, "frequencies [rad/s]"]
    starts: Annotated[int, "number of releases of each controller", 32]
    seed: Annotated[int, "seed of the random phases at release", 1]
    duration_s: Annotated[float | None, "simulated time [s]"]


class WalkerEvaluation(ReleaseOptions, GroundOptions, total=False):
    """Options of an evaluation of bodies with several legs."""


@dataclass(frozen=True, repr=False)
class WalkerController(LoadedController):
    """Controllers of a body with several legs."""

    description = "walks on several legs"
    catalogue = WALKING

    legged: Legged
    """Their system, timed so that it settles."""

    def on(self, body: Body) -> WalkerController:
        return dataclasses.replace(self, legged=self.legged.on(body))

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
            body = replace(body, {"terrain": terrain_of(options.terrain)})
        if body is not legged.body:
            legged = legged.on(body)
        timing = dataclasses.replace(legged.timing, duration_s=options.duration_s)
        legged = replace(legged, {"timing": timing})
        if options.delay_s or options.noise:
            legged = legged.on(felt(legged, options.delay_s, options.noise))
        return legged

    def driven(self, options: Any) -> Legged:
        """Return the system of the one controller with other values.

        Args:
            options: those of `system`, omega and sigma.
        """
        legged = replace(self.system(options), {"omega": options.omega})
        return dataclasses.replace(legged, weights=tuple(self.weights_at(options.sigma)))

    @check_types
    def simulate(
        self, *, phases: Sequence[float] = (), **options: Unpack[WalkerOptions]
    ) -> Recording:
        """Simulate a body with several legs: footfalls, lags and the name of its gait.

        Args:
            phases: phases of the legs at release [cycles], in the body's order; random ones by
                default.

        Raises:
            TegotaeError: for values that cannot be, before anything is computed.
        """
        values = filled(locals(), self.defaults())
        legged = self.driven(values)
        if values.phases and values.seed:
            raise TegotaeError("seed is of random phases, and phases gives them; leave one out")
        release = [2.0 * math.pi * phase for phase in values.phases] or None
        run = simulate_gaits(legged, release, seed=values.seed, tolerance=values.tolerance)
        length, time = legged.units
        return Recording(
            name=self.name,
            title=run.gait,
            raw=run,
            numbers=run.numbers,
            headings={
                "lock_time_s": f"locked after [{time}]",
                "order_parameter": "order parameter",
                "speed_m_per_s": f"speed [{length}/{time}]",
                "cost_of_transport": "cost of transport",
                "froude": "Froude number",
                "fall_time_s": f"fell at [{time}]",
            },
            rows=lambda: run.series,
            settings=vars(values),
            draw=lambda: _figures(run, f"{self.name}: {run.gait}"),
            film=lambda: _animation(run),
            limbs=run.limbs,
        )

    @check_types
    def evaluate(
        self, *others: Subject | LoadedController, **options: Unpack[WalkerEvaluation]
    ) -> Table:
        """Evaluate how several legs walk from random phases: falls, speed, cost, gait.

        Args:
            others: further controllers.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._evaluated(others, options)

    @check_types
    def compare(
        self, *others: Subject | LoadedController, **options: Unpack[WalkerEvaluation]
    ) -> Table:
        """Compare how several legs walk from random phases, and how it differs from the first.

        Args:
            others: controllers that are compared with this one.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._compared(others, options)

    def _shared(self, options: Any) -> Mapping[str, Any]:
        return {"starts": options.starts, "seed": options.seed, "omega": _frequencies(options)}

    def _measured(self, options: Any) -> EvaluationTable:
        options.omega = _frequencies(options)
        metrics = self._metrics(options.metric)
        released = release_all(
            self.system(options),
            self.runs.weights,
            options.omega,
            options.starts,
            seed=options.seed,
            tolerance=options.tolerance,
            metrics=metrics if options.metric else None,
        )
        rows = dict(released.summary)
        rows["run"] = np.array(self.runs.labels)[rows["run"]]
        length, time = self.legged.units
        units = {"s": time, "m": length, "m/s": f"{length}/{time}"}
        measured = [dataclasses.replace(x, unit=units.get(x.unit, x.unit)) for x in metrics]
        return self._measurements(
            rows,
            (*measured, _GAIT),
            options,
            shows_all=bool(options.metric),
            groups=("controller", "omega"),
        )


def _figures(run: GaitRun, title: str) -> dict[str, MatplotlibFigure]:
    from tegotae.figures.gaits.lags import footfall_figure, lags_figure
    from tegotae.figures.style import literal_text

    title = literal_text(title)
    return {"footfall": footfall_figure(run, title), "lags": lags_figure(run, title)}


def _animation(run: GaitRun) -> Animation:
    from tegotae.figures.gaits.animation import gait_animation

    return gait_animation(run)


def _frequencies(options: Any) -> tuple[float, ...]:
    """Return the frequencies of an evaluation [rad/s]; the system's own by default."""
    omega = options.omega
    return tuple(omega) if isinstance(omega, Sequence) else () if omega is None else (omega,)
