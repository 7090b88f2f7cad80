"""`tegotae simulate`: one rollout, as numbers, a plot or an animation."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rich.console import Console

from tegotae._support import tables
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.files import output_file
from tegotae.cli.options import UNSET, ControllerOptions, FromPreset, WorkOption
from tegotae.measures.hopping.efficiency import work_total
from tegotae.parts.bodies import Hopper
from tegotae.simulation.integrators import Hold, PredictorCorrector
from tegotae.simulation.rollout import MOST_TICKS, Scenario, Timing
from tegotae.systems.presets import preset
from tegotae.systems.simulation import Result, Simulation

SERIES = (
    "time_s",
    "height_m",
    "velocity_m_per_s",
    "phase_rad",
    "spring_force_n",
    "feedback_rad_per_s",
    "actuator_force_n",
    "ground_m",
    "climb_flight_m",
    "climb_m",
)
"""What the time series tells, a column each, and beside it the running total of the work."""


@dataclass(frozen=True, kw_only=True)
class Simulate(WorkOption, ControllerOptions):
    """Simulate a controller file, or a vanilla controller made of options."""

    controller: Annotated[Path | None, UNSET] = None
    """A controller file of `tegotae train`."""
    duration: float = 20.0
    """Simulated time [s]."""
    drop: float = 0.0
    """How far the ground drops [m]; a negative drop raises it."""
    drop_time: float = 10.0
    """When it drops [s]."""
    height: FromPreset = None
    """Release height [m]."""
    velocity: float = 0.0
    """Release velocity [m/s]."""
    phase: float = 0.0
    """Phase at release [rad]."""
    tick: float = Timing.tick_s
    """Control period [s]."""
    hold: bool = False
    """Hold the controller over each tick, as a robot does."""
    float64: bool = False
    """Compute in double precision."""
    measure_from: Annotated[float | None, UNSET] = None
    """Take CoT⁻¹ over whole hops from here on [s]; from half of the duration by default."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Write the time series (.csv): height, velocity, phase, forces and feedback, and the running
    totals of work and climbs."""
    plot: Annotated[Path | None, UNSET] = None
    """Write a plot over time (.png, .pdf, .svg)."""
    animate: Annotated[Path | None, UNSET] = None
    """Write an animation (.gif, or .mp4 where ffmpeg is installed)."""

    def run(self) -> None:
        """Simulate and show."""
        simulation = self._simulation()
        self._check_outputs()
        result = simulation.run()
        summary = {**result.summary(), "parameters": self._parameters(simulation)}
        self._draw(result)
        if self.json:
            print(json.dumps(summary))
        else:
            _print(summary)

    def _check_outputs(self) -> None:
        if self.csv is not None:
            output_file(self.csv)
        if self.plot is not None:
            from tegotae.figures.style import figure_file

            figure_file(self.plot)
        if self.animate is not None:
            from tegotae.figures.animation import animation_file

            animation_file(self.animate)

    def _draw(self, result: Result) -> None:
        if self.csv is not None:
            trajectory = result.trajectory
            columns = {name: getattr(trajectory, name) for name in SERIES}
            columns["work_j"] = work_total(trajectory, self.work)
            tables.write_csv(self.csv, columns, digits=7)
        if self.plot is not None:
            from tegotae.figures.rollout import rollout_figure
            from tegotae.figures.style import save_figure

            save_figure(rollout_figure(result), self.plot)
        if self.animate is not None:
            from tegotae.figures.animation import write_animation

            write_animation(result, self.animate)

    def _simulation(self) -> Simulation:
        saved = self.chosen(self.controller)
        assert isinstance(saved.body, Hopper)  # `chosen` refuses others
        require_finite("tick", self.tick, above=0.0)
        saved.body.check_tick(self.tick)
        require_finite("drop", self.drop)
        require_finite("drop_time", self.drop_time, least=0.0)
        if self.drop and self.drop_time >= self.duration:
            raise TegotaeError(
                f"the ground is to drop at {self.drop_time:g} s, but the rollout ends at "
                f"{self.duration:g} s; set --drop-time or --duration"
            )
        scenario = Scenario.of(
            saved.omega,
            height_m=preset(self.preset).height_m if self.height is None else self.height,
            velocity_m_per_s=self.velocity,
            phase_rad=self.phase,
            drop_m=self.drop,
            drop_time_s=self.drop_time if self.drop else math.inf,
        )
        return Simulation(
            saved.controller,
            saved.weights,
            scenario,
            saved.body,
            Timing(duration_s=self.duration, tick_s=self.tick, frame_s=_frame(self.tick)),
            self.work,
            self.measure_from,
            "float64" if self.float64 else "float32",
            Hold() if self.hold else PredictorCorrector(),
        )

    def _parameters(self, simulation: Simulation) -> dict:
        scenario: dict[str, float | None] = {
            k: float(v)
            for k, v in simulation.scenario._asdict().items()
            if k not in ("initial_pose", "oscillator_state", "changes")
        }
        if simulation.controller.oscillator is None:
            scenario["omega"] = None
        if math.isinf(simulation.scenario.drop_time_s):
            scenario["drop_time_s"] = None
        vanilla = self.controller is None
        return {
            "controller": None if vanilla else str(self.controller),
            "preset": self.preset,
            "actuation": type(simulation.controller.actuation).__name__.lower(),
            "sigma": float(simulation.weights[0]) if vanilla else None,
            **scenario,
            **dataclasses.asdict(simulation.hopper),
            **dataclasses.asdict(simulation.timing),
            "dtype": simulation.dtype,
            "held": self.hold,
        }


def _frame(tick_s: float) -> float:
    """A recording period of whole ticks, near 10 ms: fine enough for a plot."""
    return tick_s * max(1, round(min(0.01 / tick_s, MOST_TICKS)))


def _print(summary: dict) -> None:
    console = Console(highlight=False, soft_wrap=True)
    if summary["failed"]:
        console.print(
            f"failed at {summary['failed_time_s']:.2f} s: the leg has no length left, or the "
            "numbers have left their range"
        )
    heights = summary["apex_height_m"]
    last = ", ".join(f"{height:.4f}" for height in heights[-4:])
    console.print(f"{len(heights)} apexes" + (f"; the last at {last} m" if heights else ""))
    if summary["reason"] is not None:
        console.print(f"no CoT⁻¹: {summary['reason']}")
        return
    start, end = summary["window_s"]
    hops = summary["hops"]
    console.print(f"{hops} whole hop{'s' if hops > 1 else ''}, from {start:.2f} to {end:.2f} s:")
    console.print(f"  CoT⁻¹ (flight)   {_show(summary['cot_inverse_flight'])} m/J")
    console.print(f"  CoT⁻¹ (all)      {_show(summary['cot_inverse_total'])} m/J")
    console.print(f"  work ({summary['work']})  {_show(summary['work_j'])} J")


def _show(value: float | None) -> str:
    return "–" if value is None else f"{value:.4f}"
