"""`tegotae simulate`: one rollout, as numbers, a plot or an animation."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from tegotae import controller_file
from tegotae.bodies import Hopper
from tegotae.errors import TegotaeError, require_finite
from tegotae.files import output_file
from tegotae.presets import preset
from tegotae.rollout import Scenario, Timing
from tegotae.simulation import Result, Simulation


@dataclass(frozen=True)
class Simulate:
    """Simulate a controller file, or a vanilla controller made of options."""

    controller: Path | None = None
    """A controller file of `tegotae train`."""
    preset: str = "paper"
    """Where numbers not given come from: paper, or pyTegotaeCPG."""
    actuation: str | None = None
    """Vanilla actuation: sector, reflex or both."""
    omega: float | None = None
    """Frequency ω [rad/s]."""
    sigma: float | None = None
    """Gain σ of the vanilla feedback [rad/(s N)]."""
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
    mass: float | None = None
    """Mass [kg]."""
    stiffness: float | None = None
    """Spring stiffness [N/m]."""
    damping: float | None = None
    """Damping in stance [N s/m]."""
    flight_damping: float | None = None
    """Damping in flight [N s/m]."""
    rest_length: float | None = None
    """Rest length of the leg [m]."""
    gravity: float | None = None
    """Gravity [m/s²]."""
    max_force: float | None = None
    """Largest actuator force [N]."""
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
        chosen = preset(self.preset)
        if self.controller is None:
            controller = chosen.controller(self.actuation or chosen.actuation)
            sigma = chosen.sigma if self.sigma is None else self.sigma
            require_finite("sigma", sigma)
            weights, omega, hopper = np.array([sigma]), chosen.omega_rad_per_s, chosen.hopper
        else:
            for name in ("actuation", "sigma"):
                if getattr(self, name) is not None:
                    raise TegotaeError(f"--{name} belongs to vanilla controllers, not to a file")
            saved = controller_file.load(self.controller)
            controller, weights, omega = saved.controller, saved.weights, saved.omega
            if not isinstance(saved.body, Hopper):
                raise TegotaeError(f"{self.controller} is for a body that is not a hopper")
            hopper = saved.body
        scenario = Scenario(
            omega=omega if self.omega is None else self.omega,
            height_m=chosen.height_m if self.height is None else self.height,
            velocity_m_per_s=self.velocity,
            phase_rad=self.phase,
            drop_m=self.drop,
            drop_time_s=self.drop_time if self.drop else math.inf,
        )
        return Simulation(
            controller,
            weights,
            scenario,
            self._hopper(hopper),
            Timing(duration_s=self.duration, tick_s=self.tick, frame_s=_frame(self.tick)),
            self.energy,
            self.measure_from,
            "float64" if self.float64 else "float32",
        )

    def _hopper(self, hopper: Hopper) -> Hopper:
        given = {
            "mass_kg": self.mass,
            "stiffness_n_per_m": self.stiffness,
            "damping_ns_per_m": self.damping,
            "flight_damping_ns_per_m": self.flight_damping,
            "rest_length_m": self.rest_length,
            "gravity_m_per_s2": self.gravity,
            "max_force_n": self.max_force,
        }
        return dataclasses.replace(hopper, **{k: v for k, v in given.items() if v is not None})

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
