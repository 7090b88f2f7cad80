"""One leg: simulate, evaluate, basin."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tegotae._support import tables
from tegotae._support.limits import MOST_M
from tegotae._support.progress import Console, reporting
from tegotae.cli.console import print_rows, print_text
from tegotae.measures.evaluation import Evaluation, evaluate, require_evaluable
from tegotae.measures.hopping.metric import TABLE, Metric
from tegotae.measures.hopping.registry import metrics
from tegotae.measures.hopping.signals import work_total
from tegotae.measures.hopping.statistics import Interval
from tegotae.simulation.integrators import Hold
from tegotae.simulation.timing import MOST_TICKS
from tegotae.systems.controller_file import SavedController
from tegotae.systems.controller_set import ControllerSet
from tegotae.systems.simulation import Result, Simulation

if TYPE_CHECKING:
    from tegotae.analysis.maps import HopperBasin


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


def shown(asked: tuple[Metric, ...] | None) -> tuple[Metric, ...]:
    """The metrics of a table on the screen: those asked for, or the usual ones."""
    return metrics(TABLE) if asked is None else asked


def evaluate_all(
    sets: list[ControllerSet],
    protocol: Mapping[str, Any],
    omega: float | None = None,
    asked: tuple[Metric, ...] | None = None,
) -> list[tuple[ControllerSet, Evaluation]]:
    """Evaluate sets of runs, showing how far it is.

    Each is released, integrated and evaluated as its own system and protocol say.

    Args:
        sets: the runs.
        protocol: fields of the protocol in place of each set's own.
        omega: frequency around which all are evaluated [rad/s]; each one's own by default.
        asked: the metrics that are asked for; all by default.
    """
    protocols = [dataclasses.replace(runs.protocol, **protocol) for runs in sets]
    for runs, own in zip(sets, protocols, strict=True):
        require_evaluable(runs.controller, runs.body, own)
    found = []
    with reporting("evaluate", len(sets)) as reporter:
        for runs, own in zip(sets, protocols, strict=True):
            # A frequency asked for does not give one to a controller without an oscillator.
            omega_t = runs.omega_t if omega is None or runs.omega_t is None else omega
            there = runs.replaced(omega=omega_t)
            result = evaluate(
                runs.controller,
                runs.weights,
                omega_t,
                runs.body,
                own,
                metrics=asked,
                start=runs.system.scenario(),
                integrator=runs.system.integrator,
            )
            found.append((there, result))
            reporter.update(len(found), runs.name)
    return found


def print_table(found: list[tuple[ControllerSet, Evaluation]], shown: tuple[Metric, ...]) -> None:
    """One row per set of runs: mean and 95 % interval of each metric over the runs."""
    summaries = [evaluation.summary() for _, evaluation in found]
    print_rows(
        ("controller", "runs", *(metric.heading for metric in shown)),
        (
            (runs.name, str(evaluation.n_runs), *(show(summary[m.name]) for m in shown))
            for (runs, evaluation), summary in zip(found, summaries, strict=True)
        ),
        turned=True,
    )
    print_text(
        "Mean over runs [95 % interval]. A body at rest has CoT⁻¹ 0; hopping without a "
        "limit cycle has neither CoT⁻¹ nor transients, and counts in the share of limit cycles. "
        "– is undefined, * means that some runs are."
    )


def show(value: Interval) -> str:
    """An interval in a table."""
    if math.isnan(value.mean):
        return "–"
    mark = "*" if value.undefined else ""
    if math.isnan(value.low):
        return f"{value.mean:.3g}{mark}"
    return f"{value.mean:.3g}{mark} [{value.low:.3g}, {value.high:.3g}]"


def columns(found: list[tuple[ControllerSet, Evaluation]]) -> dict[str, list[str]]:
    """One row per run: where it is from, and every metric that was asked for."""
    columns: dict[str, list[str]] = {}
    for runs, evaluation in found:
        omega = "" if runs.omega_t is None else f"{runs.omega_t:g}"
        own = {
            "controller": [runs.name] * len(runs.labels),
            "run": list(runs.labels),
            "omega_t_rad_per_s": [omega] * len(runs.labels),
            **{name: [*map(_cell, values)] for name, values in evaluation.runs().items()},
        }
        for name, cells in own.items():
            columns.setdefault(name, []).extend(cells)
    return columns


def _cell(value: np.floating) -> str:
    return "" if np.isnan(value) else f"{value:.6g}"


DURATION_S = 40.0
"""Simulated time by default [s]."""


def find_basin(
    saved: SavedController,
    height: tuple[float, float],
    velocity: tuple[float, float],
    resolution: int,
    duration_s: float | None,
) -> HopperBasin:
    """Release a hopper from all heights of a range, at all phases or velocities, and print where
    it ends.

    Raises:
        TegotaeError: for a range or a resolution that is none.
    """
    from tegotae.analysis.maps import axis, map_basin
    from tegotae.figures.maps import describe

    heights = axis("height", *height, resolution, above=0.0, most=MOST_M)
    across = (
        axis("velocity", *velocity, resolution, most=MOST_M)
        if saved.controller.oscillator is None
        else axis("phase", 0.0, 2.0 * math.pi, resolution)
    )
    timing = saved.system.timing_over(DURATION_S if duration_s is None else duration_s)
    found = map_basin(saved, heights, across, timing=timing)
    for attractor in found.attractors:
        print(f"{describe(attractor)}, CoT⁻¹ {attractor.cot_inverse:.3f} m/J")
    without = 1.0 - sum(attractor.share for attractor in found.attractors)
    print(f"no limit cycle: {without:.1%} of the releases")
    return found
