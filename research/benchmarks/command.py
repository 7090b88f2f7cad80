"""`python -m research.benchmarks`: the speed of rollouts, beside hand-written programs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from tegotae._support.engines import NATIVE, VARIABLE, XLA, available_cores, why_not_native
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.files import output_folder
from tegotae._support.limits import require_memory
from tegotae._support.progress import Console
from tegotae.simulation.rollout import Timing
from tegotae.systems.term_sets import BUDGET


@dataclass(frozen=True)
class Bench:
    """Time both engines on a 96-parameter ART model and a walker, beside a kernel written by hand,
    and two simple programs."""

    lanes: int = 1024
    """Number of parallel rollouts."""
    most_lanes: int = 100_000
    """Measure time and memory of up to this many rollouts of 1 s; 1000000 take half a minute."""
    legs: bool = False
    """Time all bodies with several legs, and MuJoCo with a twin of the walker."""
    mujoco: bool = False
    """Time training on a MuJoCo model beside a plain loop of Stable-Baselines3 on it."""
    scale: Path | None = None
    """Write the curves over lanes, weights, limbs and cores to this folder, and nothing else."""
    race: Path | None = None
    """Train a law with this package, textbook JAX and other libraries to the same fitness, and
    write the core-seconds of each to this folder, and nothing else; half an hour."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Measure, and print."""
        from research.benchmarks import engine, kernel, legs, loop
        from tegotae._support.engines import selected

        if self.scale is not None:
            from research.benchmarks import scale

            folder = output_folder(self.scale)
            table = scale.measure_scaling()
            table.to_csv(folder / "scale.csv", index=False, float_format="%.4g")
            print(scale.draw_scaling(table, folder / "scale.png"))
            return
        if self.race is not None:
            from research.benchmarks.race import race

            print(race(output_folder(self.race)))
            return
        for name in ("lanes", "most_lanes"):
            lanes = getattr(self, name)
            require_count(name, lanes)
            require_memory(4.0 * 8 * lanes * BUDGET, f"{lanes} lanes")
        current, names = selected(), tuple(legs.BODIES) if self.legs else ("walker",)
        speeds = {current: engine.engine_speed(self.lanes)}
        bodies = {current: legs.measure_bodies(self.lanes, names)}
        for alternative in _alternatives(current):
            run = f"{_BENCHMARKS}.engine", "speed", str(self.lanes)
            speeds[alternative] = engine.Speed(*json.loads(_program(*run, engine=alternative)))
            run = f"{_BENCHMARKS}.legs", str(self.lanes), *names
            rows = json.loads(_program(*run, engine=alternative))
            bodies[alternative] = [legs.BodySpeed(*row) for row in rows]
        textbook = float(_program(f"{_BENCHMARKS}.textbook", str(self.lanes)))
        sizes = [10**n for n in range(3, 10) if 10**n <= self.most_lanes]
        costs = [
            engine.LaneCost(*json.loads(_program(f"{_BENCHMARKS}.engine", "cost", str(size))))
            for size in sizes
        ]
        figures: dict[str, Any] = {
            "lanes": self.lanes,
            "cores": available_cores(),
            "parameters": engine.benchmark_controller().n_weights,
            "tick_s": Timing().tick_s,
            "engine": current,
            "engines": {name: result._asdict() for name, result in speeds.items()},
            "textbook_ticks_per_s": textbook,
            "loop_ticks_per_s": loop.loop_ticks_per_second(),
            "kernel": None
            if (by_hand := kernel.kernel_speed(self.lanes)) is None
            else by_hand._asdict(),
            "bodies": {name: [row._asdict() for row in rows] for name, rows in bodies.items()},
            "costs": [result._asdict() for result in costs],
        }
        if self.legs:
            figures["mujoco_walker"] = [row._asdict() for row in legs.mujoco()]
        if self.mujoco:
            from research.benchmarks import mujoco_training

            figures["mujoco"] = [row._asdict() for row in mujoco_training.measure_environments()]
        if self.json:
            print(json.dumps(figures))
            return
        console = Console()
        console.print(_table_of_ways(figures))
        console.print(
            f"{figures['parameters']} parameters, {self.lanes} lanes, control period "
            f"{figures['tick_s'] * 1e3:g} ms, {figures['cores']} cores; this is {current}"
        )
        console.print(_table_of_bodies(figures))
        console.print(_table_of_costs(figures["costs"]))
        if self.mujoco:
            console.print(_table_of_mujoco(figures["mujoco"]))


_BENCHMARKS = "research.benchmarks"


def _alternatives(current: str) -> tuple[str, ...]:
    """Return the other engine, if it is available here."""
    if current == NATIVE:
        return (XLA,)
    return () if why_not_native() else (NATIVE,)


def _table_of_ways(figures: dict[str, Any]) -> Table:
    """Return a table of both engines, and of common alternatives."""
    table = Table("way", "ticks/s", "ticks/core-s", "compiled in core-s", "this engine / that")
    reference = figures["engines"][figures["engine"]]["ticks_per_s"]
    for name, speed in figures["engines"].items():
        table.add_row(
            f"tegotae, {name}",
            f"{speed['ticks_per_s']:.3g}",
            f"{speed['ticks_per_core_s']:.3g}",
            f"{speed['compile_core_s']:.2g}",
            f"{reference / speed['ticks_per_s']:.3g}",
        )
    if limit := figures["kernel"]:
        table.add_row(
            "kernel written by hand",
            f"{limit['ticks_per_s']:.3g}",
            f"{limit['ticks_per_core_s']:.3g}",
            "",
            f"{limit['engine_share']:.2f} of it",
        )
    plain = {"textbook vmap(scan)": "textbook", "Python loop": "loop"}
    for name, key in plain.items():
        ticks = figures[f"{key}_ticks_per_s"]
        table.add_row(name, f"{ticks:.3g}", "", "", f"{reference / ticks:.3g}")
    return table


def _table_of_bodies(figures: dict[str, Any]) -> Table:
    """Return the cost of a leg, body by body; rates of the walkers are in units of √(l0/g)."""
    table = Table(
        "body", "legs", "engine", "ticks/core-s", "legs x ticks/core-s", "time/core-s", "compiled"
    )
    bodies = {**figures["bodies"], "": figures.get("mujoco_walker", [])}
    for name, rows in bodies.items():
        for row in rows:
            per_core, compiled = row["ticks_per_core_s"], row["compile_core_s"]
            table.add_row(
                row["name"],
                str(row["legs"]),
                name,
                f"{per_core:.3g}",
                f"{per_core * row['legs']:.3g}",
                f"{per_core * row['tick_s']:.3g}",
                f"{compiled:.2g}" if compiled else "",
            )
    return table


def _table_of_costs(rows: list[dict[str, Any]]) -> Table:
    """Return the cost of many lanes of a second, each row a process of its own."""
    table = Table("lanes", "ticks/core-s, with compiling", "peak memory [GiB]")
    for row in rows:
        numbers = f"{row['ticks_per_core_s']:.3g}", f"{row['peak_gib']:.2f}"
        table.add_row(str(row["lanes"]), *numbers)
    return table


def _table_of_mujoco(rows: list[dict[str, Any]]) -> Table:
    """Return the speeds of trainings on a MuJoCo model; the last one is the plain loop."""
    table = Table("on the MuJoCo hopper", "lanes", "steps/s", "steps/core-s", "this / plain loop")
    for row in rows:
        per_core = row["steps_per_core_s"]
        table.add_row(
            row["name"],
            str(row["lanes"]),
            f"{row['steps_per_s']:.3g}",
            f"{per_core:.3g}",
            f"{per_core / rows[-1]['steps_per_core_s']:.3g}",
        )
    return table


def _program(module: str, *arguments: str, engine: str | None = None) -> str:
    """Return the output of a module of this package run as a program."""
    completed = subprocess.run(
        [sys.executable, "-m", module, *arguments],
        env=os.environ | ({VARIABLE: engine} if engine else {}),
        capture_output=True,
        text=True,
    )
    if completed.returncode:
        raise TegotaeError(
            f"{module} failed: {(completed.stderr.strip().splitlines() or ['?'])[-1]}"
        )
    return completed.stdout.strip().splitlines()[-1]
