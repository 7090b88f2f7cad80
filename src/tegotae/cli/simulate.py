"""`tegotae simulate`: one rollout, as numbers, a plot or an animation."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.cli.console import check_outputs
from tegotae.cli.extras import require_environments
from tegotae.cli.gait.options import OF_LEGS, LegsOptions, legs_of
from tegotae.cli.options import (
    UNSET,
    ControllerOptions,
    FromPreset,
    refuse_given,
    refuse_on_environment,
    require_ours,
)
from tegotae.parts.bodies import Hopper
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import SavedController
from tegotae.systems.resolve import Resolved, resolve
from tegotae.systems.simulation import Simulation

DURATION_S = 20.0
"""Simulated time of one leg by default [s]."""
OF_ONE_LEG = (
    *("drop", "drop_time", "height", "velocity", "phase", "tick", "hold", "float64"),
    *("measure_from", "work", "actuation", "oscillator", "preset"),
)
ON_ENVIRONMENTS = ("place", "duration", "json", "csv", "plot", "animate")
OF_SEVERAL = (*OF_LEGS, "phases", "out")


@dataclass(frozen=True, kw_only=True)
class Simulate(LegsOptions, ControllerOptions):
    """Simulate a controller. One leg: apexes and efficiency; several legs: footfalls, lags and the
    name of the gait.

    Without PLACE, the options define a vanilla controller. With PLACE, settings such as release,
    integrator and definition of work are those of its system and experiment; options replace them.
    """

    place: Annotated[str | None, tyro.conf.Positional, UNSET] = None
    """A controller file, or another name with weights, such as V-sector-w4, quadruped-c or
    FILE.py:OBJECT."""
    duration: Annotated[float | None, UNSET] = None
    """Simulated time [s]; by default 20 s for one leg, and the system's for several."""
    drop: float = 0.0
    """Height by which the ground drops [m], for one leg; a negative one raises it."""
    drop_time: float = 10.0
    """Time of the drop [s]."""
    height: FromPreset = None
    """Release height [m]."""
    velocity: Annotated[float | None, UNSET] = None
    """Release velocity [m/s]; by default the system's, or 0."""
    phase: Annotated[float | None, UNSET] = None
    """Phase at release [rad]; by default the system's, or 0."""
    phases: Annotated[tuple[float, ...], UNSET] = ()
    """Phases of several legs at release [cycles], in the body's order; random ones by default."""
    tick: Annotated[float | None, UNSET] = None
    """Control period of one leg [s]; by default 1 ms, or the system's for a held controller."""
    hold: bool = False
    """Hold the controller over each tick, as a robot does."""
    float64: bool = False
    """Compute in double precision."""
    work: Annotated[str | None, UNSET] = None
    """Definition of the actuator's work: absolute, positive or net; by default the experiment's, or
    absolute."""
    measure_from: Annotated[float | None, UNSET] = None
    """Measure CoT⁻¹ over whole hops from this time on [s]; by default half of the duration."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Write the time series (.csv). One leg: height, velocity, phase, forces, feedback, running
    totals of work and climbs; several legs: lags, phases and loads."""
    plot: Annotated[Path | None, UNSET] = None
    """Write a plot over time (.png, .pdf, .svg); for several legs a footfall diagram."""
    animate: Annotated[Path | None, UNSET] = None
    """Write an animation (.gif; for one leg also .mp4, which needs ffmpeg). MuJoCo renders its own
    models."""
    out: Annotated[Path | None, UNSET] = None
    """Folder for all pictures (.png), the table (.csv) and the document (.json), for several
    legs."""

    def run(self) -> None:
        """Simulate and show."""
        found = None if self.place is None else resolve(self.place)
        if found is not None and found.is_on_environment:
            self._on_environment(found)
            return
        if found is not None:
            require_ours(found)
        if found is not None and found.body.limbs > 1:
            refuse_given(self, OF_ONE_LEG, found.name, several=True)
            self._of_several(found)
        else:
            called = "a vanilla controller" if found is None else found.name
            refuse_given(self, OF_SEVERAL, called, several=False)
            self._of_one_leg(found)

    def _on_environment(self, found: Resolved) -> None:
        require_environments(saved.task for _, saved in found.controllers)
        from tegotae.cli.wired import simulate

        refuse_on_environment(self, ON_ENVIRONMENTS, found.name)
        simulate(
            found.controller(),
            name=found.name,
            duration_s=self.duration,
            csv=self.csv,
            plot=self.plot,
            animate=self.animate,
            as_json=self.json,
        )

    def _of_several(self, found: Resolved) -> None:
        from tegotae.cli.walking import simulate_legs

        simulate_legs(
            legs_of(self, found.name),
            self.phases,
            out=self.out,
            csv=self.csv,
            plot=self.plot,
            animate=self.animate,
            as_json=self.json,
        )

    def _of_one_leg(self, found: Resolved | None) -> None:
        from tegotae.cli import hopping as one_leg

        saved = self.vanilla() if found is None else self.adapted(found)
        simulation = self._simulation(saved)
        files = (self.csv, self.plot, self.animate)
        check_outputs(*files)
        result = simulation.run()
        name = None if found is None else found.name
        used = one_leg.parameters(simulation, name, self.preset)
        summary = {**result.summary(), "parameters": used}
        if self.json:
            print(json.dumps(summary), flush=True)
        else:
            one_leg.print_summary(summary)
        one_leg.write(result, *files)

    def _simulation(self, saved: SavedController) -> Simulation:
        from tegotae.cli.hopping import frame_s

        assert isinstance(saved.body, Hopper)  # `adapted` refuses others
        system = saved.system
        duration = DURATION_S if self.duration is None else self.duration
        tick = system.period_s(Timing.tick_s) if self.tick is None else self.tick
        require_finite("tick", tick, above=0.0)
        saved.body.check_tick(tick)
        require_finite("drop", self.drop)
        require_finite("drop_time", self.drop_time, least=0.0)
        if self.drop and self.drop_time >= duration:
            raise TegotaeError(
                f"the ground is to drop at {self.drop_time:g} s, but the rollout ends at "
                f"{duration:g} s; set --drop-time or --duration"
            )
        released = {
            "height_m": self.height,
            "velocity_m_per_s": self.velocity,
            "phase_rad": self.phase,
        }
        scenario = system.scenario(
            **{name: value for name, value in released.items() if value is not None},
            drop_m=self.drop,
            drop_time_s=self.drop_time if self.drop else math.inf,
        )
        work = "absolute" if saved.experiment is None else saved.experiment.protocol.work
        return Simulation(
            saved.controller,
            saved.weights,
            scenario,
            saved.body,
            Timing(duration_s=duration, tick_s=tick, frame_s=frame_s(tick)),
            work if self.work is None else self.work,
            self.measure_from,
            "float64" if self.float64 else "float32",
            Hold() if self.hold else system.integrator,
        )
