"""Growth of cost with lanes, limbs, weights and cores; each point in a process of its own."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from research.benchmarks import engine, legs
from tegotae._support.compiled import VARIABLE as KEPT
from tegotae._support.engines import available_cores
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import Console
from tegotae._support.workers import CORES
from tegotae.figures.style import new_figure, save_figure
from tegotae.parts.bodies import Walker
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe

LANES = 1024
AXES: dict[str, tuple[int, ...]] = {
    "lanes": (1_000, 10_000, 100_000, 1_000_000),
    "weights": (32, 96, 320, 1_000, 3_200, 10_000),
    "limbs": (2, 4, 6, 8),
    "cores": (1, 2, 4, 8, 16),
}
"""Varied sizes, while the rest is 1024 lanes of ART with 96 weights on the hopper, on all cores.
With limbs it is vanilla Tegotae on a walker; of cores there are as many as the machine has."""


def measure_point(axis: str, size: int) -> dict[str, float]:
    """Measure rates, compiling and memory of one point, in this process."""
    lanes = size if axis == "lanes" else LANES
    if axis == "limbs":
        side = np.linspace(0.85, -0.85, size // 2) if size > 2 else np.zeros(1)
        body = Walker(
            hips_x_m=tuple(np.repeat(side, 2).tolist()),
            hips_y_m=(0.44, -0.44) * (size // 2),
            mass_kg=size / 4,
        )
        speed: Any = legs.measure_body("walker", body, lanes, legs.WALKER_TICK_S / 2)
    else:
        controller = recipe("ART").controller(
            size if axis == "weights" else engine.benchmark_controller().n_weights
        )
        run = Rollout(controller=controller, timing=Timing(duration_s=1.0), summary=engine.totals)
        weights = np.random.default_rng(0).normal(size=(lanes, controller.n_weights)) * 0.5
        speed = engine.timed(run, weights.astype("float32"), Scenario(omega=5.0))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "ticks_per_s": speed.ticks_per_s,
        "ticks_per_core_s": speed.ticks_per_core_s,
        "compile_core_s": speed.compile_core_s,
        "peak_gib": peak / (2**30 if sys.platform == "darwin" else 2**20),
    }


def measure_scaling() -> pd.DataFrame:
    """Return one row per point: axis, size, and the result of `measure_point`."""
    rows = []
    for axis, sizes in AXES.items():
        for size in sizes:
            if axis == "cores" and size > available_cores():
                continue
            Console().print(f"{axis} {size}")
            variables = {CORES: str(size)} if axis == "cores" else {}
            completed = subprocess.run(
                [sys.executable, "-m", "research.benchmarks.scale", axis, str(size)],
                env=os.environ | {KEPT: "off"} | variables,
                capture_output=True,
                text=True,
            )
            if completed.returncode:
                reason = (completed.stderr.strip().splitlines() or ["?"])[-1]
                raise TegotaeError(f"{axis} {size} failed: {reason}")
            rates = json.loads(completed.stdout.strip().splitlines()[-1])
            rows.append({"axis": axis, "size": size, **rates})
    return pd.DataFrame(rows)


def draw_scaling(table: pd.DataFrame, file: Path) -> Path:
    """Draw rates over each axis, with the memory and the core-seconds of compiling."""
    labels = {
        "ticks_per_core_s": "ticks per core-second",
        "compile_core_s": "compiling [core-s]",
        "peak_gib": "peak memory [GiB]",
    }
    figure = new_figure(7.0, 5.0)
    axes = figure.subplots(len(labels), len(AXES), sharex="col", sharey="row", squeeze=False)
    for column, (axis, rows) in zip(axes.T, table.groupby("axis", sort=False), strict=False):
        for panel, (name, label) in zip(column, labels.items(), strict=True):
            panel.plot(rows["size"], rows[name], "o-", color="black", markersize=3)
            if name == "ticks_per_core_s":
                panel.set_yscale("log")
            else:
                panel.set_ylim(0.0, 1.1 * table[name].max())
            if axis in ("lanes", "weights"):
                panel.set_xscale("log")
            else:
                panel.set_xticks(rows["size"])
            if panel in axes[:, 0]:
                panel.set_ylabel(label)
        column[-1].set_xlabel(axis)
    return save_figure(figure, file)


if __name__ == "__main__":
    print(json.dumps(measure_point(sys.argv[1], int(sys.argv[2]))))
