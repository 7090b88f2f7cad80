"""`tegotae simulate`: one rollout, as numbers, a plot or an animation."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from tegotae.bodies import Hopper
from tegotae.cli.options import ControllerOptions
from tegotae.errors import require_finite
from tegotae.files import output_file
from tegotae.presets import preset
from tegotae.rollout import Scenario, Timing
from tegotae.simulation import Result, Simulation


@dataclass(frozen=True)
class Simulate(ControllerOptions):
    """Simulate a controller file, or a vanilla controller made of options."""

    controller: Path | None = None
    """A controller file of `tegotae train`."""
    duration: float = 20.0
    """Simulated time [s]."""
    drop: float = 0.0
    """How far the ground drops [m]."""
    drop_time: float = 10.0
    """When it drops [s]."""
    height: float | None = None
    """Release height [m]."""
    velocity: float = 0.0
    """Release velocity [m/s]."""
    phase: float = 0.0
    """Phase at release [rad]."""
    tick: float = Timing.tick_s
    """Control period [s]."""
    float64: bool = False
    """Compute in double precision."""
    energy: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    measure_from: float | None = None
    """Count work and climbs from here on [s]; from half of the duration by default."""
    json: bool = False
    """Print one JSON object."""
    plot: Path | None = None
    """Write a plot over time (.png, .pdf, .svg)."""
    animate: Path | None = None
    """Write an animation (.gif, or .mp4 where ffmpeg is installed)."""

    def run(self) -> None:
        """Simulate and show."""
        outputs = [output_file(path) for path in (self.plot, self.animate) if path is not None]
        simulation = self._simulation()
        result = simulation.run()
        summary = {**result.summary(), "parameters": self._parameters(simulation)}
        if outputs:
            self._draw(result)
        if self.json:
            print(json.dumps(summary))
        else:
            _print(summary)

    def _draw(self, result: Result) -> None:
        from tegotae.figures.animation import write_animation
        from tegotae.figures.rollout import rollout_figure
        from tegotae.figures.style import save_figure

        if self.plot is not None:
            save_figure(rollout_figure(result), self.plot)
        if self.animate is not None:
            write_animation(result, self.animate)

    def _simulation(self) -> Simulation:
        saved = self.chosen(self.controller)
        assert isinstance(saved.body, Hopper)  # `chosen` refuses others
        scenario = Scenario(
            omega=saved.omega,
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
            self.energy,
            self.measure_from,
            "float64" if self.float64 else "float32",
        )

    def _parameters(self, simulation: Simulation) -> dict:
        scenario: dict[str, float | None] = {
            k: float(v) for k, v in simulation.scenario._asdict().items()
        }
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
        }


def _frame(tick_s: float) -> float:
    """A recording period of whole ticks, near 10 ms: fine enough for a plot."""
    require_finite("tick", tick_s, above=0.0)
    return tick_s * max(1, round(0.01 / tick_s))


def _print(summary: dict) -> None:
    console = Console(highlight=False)
    if summary["failed"]:
        console.print(f"failed at {summary['failed_time_s']:.2f} s: the leg has no length left")
    heights = summary["apex_height_m"]
    console.print(
        f"{len(heights)} apexes; the last at " + ", ".join(f"{h:.4f}" for h in heights[-4:]) + " m"
    )
    start, end = summary["window_s"]
    console.print(f"from {start:g} to {end:g} s:")
    if not summary["failed"]:
        console.print(f"  CoT⁻¹ (flight)   {summary['cot_inverse_flight']:.4f} m/J")
        console.print(f"  CoT⁻¹ (all)      {summary['cot_inverse_total']:.4f} m/J")
    console.print(f"  work ({summary['energy']})  {summary['work_j']:.4f} J")
