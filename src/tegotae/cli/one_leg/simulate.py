"""One rollout of a hopper, as numbers, a plot or an animation."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

from tegotae._support import tables
from tegotae._support.progress import Console
from tegotae.measures.hopping.signals import work_total
from tegotae.simulation.integrators import Hold
from tegotae.simulation.timing import MOST_TICKS
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
"""The columns of the time series, and beside it the running total of the work."""


def write(result: Result, csv: Path | None, plot: Path | None, animate: Path | None) -> None:
    """Write the files that were asked for."""
    if csv is not None:
        trajectory = result.trajectory
        columns = {name: getattr(trajectory, name) for name in SERIES}
        columns["work_j"] = work_total(trajectory, result.simulation.work)
        tables.write_csv(csv, columns, digits=7)
    if plot is not None:
        from tegotae.figures.rollout import rollout_figure
        from tegotae.figures.style import save_figure

        save_figure(rollout_figure(result), plot)
    if animate is not None:
        from tegotae.figures.animation import write_animation

        write_animation(result, animate)


def parameters(simulation: Simulation, name: str | None, preset: str) -> dict:
    """All numbers of a simulation, as JSON values.

    Args:
        simulation: what was simulated.
        name: of the controller; None for a vanilla one.
        preset: where the vanilla one's numbers come from.
    """
    scenario: dict[str, float | None] = {
        k: float(v)
        for k, v in simulation.scenario._asdict().items()
        if k not in ("initial_pose", "oscillator_state", "changes")
    }
    if simulation.controller.oscillator is None:
        scenario["omega"] = None
    if math.isinf(simulation.scenario.drop_time_s):
        scenario["drop_time_s"] = None
    return {
        "controller": name,
        "preset": preset,
        "actuation": type(simulation.controller.actuation).__name__.lower(),
        "sigma": float(simulation.weights[0]) if name is None else None,
        **scenario,
        **dataclasses.asdict(simulation.hopper),
        **dataclasses.asdict(simulation.timing),
        "dtype": simulation.dtype,
        "held": isinstance(simulation.integrator, Hold),
    }


def frame_s(tick_s: float) -> float:
    """A recording period of whole ticks, near 10 ms: fine enough for a plot."""
    return tick_s * max(1, round(min(0.01 / tick_s, MOST_TICKS)))


def print_summary(summary: dict) -> None:
    console = Console(highlight=False, soft_wrap=True)
    if summary["failed"]:
        console.print(
            f"failed at {summary['failed_time_s']:.2f} s: the leg has no length left, or the "
            "numbers exceed their range"
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
