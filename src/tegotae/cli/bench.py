"""`tegotae bench`: how fast rollouts are, beside what people would write themselves."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.limits import require_memory
from tegotae.simulation.rollout import Timing
from tegotae.systems.grammar import BUDGET


@dataclass(frozen=True)
class Bench:
    """Time a 96-parameter ART model beside a Python loop and the textbook JAX form."""

    lanes: int = 1024
    """Rollouts at a time."""
    skip_memory: bool = False
    """Leave out the memory of 100,000 lanes, which takes a minute to weigh."""
    legs: bool = False
    """Time bodies with several legs too, and MuJoCo with a twin of the one that walks."""
    mujoco: bool = False
    """Time training on a MuJoCo model beside a plain loop of Stable-Baselines3 on it."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Measure, and print."""
        from tegotae._support.devices import (
            environment,
            jaxlib_version,
            lane_devices,
            xla_options,
        )
        from tegotae.studies.benchmarks import engine, loop

        require_count("lanes", self.lanes)
        require_memory(4.0 * 8 * self.lanes * BUDGET, f"{self.lanes} lanes")
        tick_s = Timing().tick_s
        ours = engine.speed(self.lanes)
        rate, compile_s = ours.ticks_per_s, ours.compile_s
        lanes = str(self.lanes)
        printed = _program("tegotae.studies.benchmarks.engine", lanes, env=environment())
        small_kernels = engine.Speed(*json.loads(printed))
        plain = environment(plain=True)
        textbook = float(_program("tegotae.studies.benchmarks.textbook", lanes, env=plain))
        single = loop.ticks_per_second()
        figures = {
            "devices": [str(device) for device in lane_devices()],
            "lanes": self.lanes,
            "parameters": engine.controller().n_weights,
            "tick_s": tick_s,
            "ticks_per_s": rate,
            "simulated_s_per_s": rate * tick_s,
            "compile_s": compile_s,
            "jaxlib": jaxlib_version(),
            "xla_options": list(xla_options()),
            "ticks_per_core_s": ours.ticks_per_core_s,
            "without_whole_loops_ticks_per_s": small_kernels.ticks_per_s,
            "without_whole_loops_ticks_per_core_s": small_kernels.ticks_per_core_s,
            "textbook_ticks_per_s": textbook,
            "loop_ticks_per_s": single,
            "times_without_whole_loops": ours.ticks_per_core_s / small_kernels.ticks_per_core_s,
            "times_textbook": rate / textbook,
            "times_loop": rate / single,
            "memory_100k_lanes_gib": (
                float(_program("tegotae.studies.benchmarks.engine"))
                if not self.skip_memory
                else None
            ),
        }
        if self.legs:
            from tegotae.studies.benchmarks import legs

            figures["legs"] = [row._asdict() for row in legs.measured(self.lanes)]
        if self.mujoco:
            from tegotae.studies.benchmarks import mujoco_training

            figures["mujoco"] = [row._asdict() for row in mujoco_training.measured()]
        if self.json:
            print(json.dumps(figures))
            return
        table = Table("way", "ticks/s", "ticks/core-s", "simulated s/s", "this / that")
        rows = (
            ("tegotae", rate, ours.ticks_per_core_s),
            ("loops not as kernels", small_kernels.ticks_per_s, small_kernels.ticks_per_core_s),
            ("textbook vmap(scan)", textbook, None),
            ("Python loop", single, None),
        )
        for name, ticks, per_core in rows:
            shown = "" if per_core is None else f"{per_core:.3g}"
            table.add_row(
                name, f"{ticks:.3g}", shown, f"{ticks * tick_s:.3g}", f"{rate / ticks:.3g}"
            )
        console = Console()
        console.print(table)
        console.print(
            f"{figures['parameters']} parameters, {self.lanes} lanes, control period "
            f"{tick_s * 1e3:g} ms, {len(figures['devices'])} devices, compiled in {compile_s:.1f} s"
        )
        console.print(
            f"jaxlib {jaxlib_version()}, XLA options: {', '.join(xla_options()) or 'none'}"
        )
        if self.legs:
            console.print(_table_of_legs(figures["legs"]))
        if self.mujoco:
            console.print(_table_of_mujoco(figures["mujoco"]))
        if not self.skip_memory:
            console.print(
                f"peak memory of 100,000 lanes: {figures['memory_100k_lanes_gib']:.2f} GiB"
            )


def _table_of_legs(rows: list[Document]) -> Table:
    """What a leg costs, body by body; rates of the walkers are in units of √(l0/g)."""
    table = Table("body", "legs", "ticks/s", "ticks/core-s", "legs x ticks/core-s", "time/core-s")
    for row in rows:
        per_core = row["ticks_per_core_s"]
        table.add_row(
            row["name"],
            str(row["legs"]),
            f"{row['ticks_per_s']:.3g}",
            f"{per_core:.3g}",
            f"{per_core * row['legs']:.3g}",
            f"{per_core * row['tick_s']:.3g}",
        )
    return table


def _table_of_mujoco(rows: list[Document]) -> Table:
    """How fast trainings on a MuJoCo model go; the last one is the plain loop."""
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


def _program(module: str, *arguments: str, env: dict[str, str] | None = None) -> str:
    """What a module of this package prints when run as a program of its own."""
    done = subprocess.run(
        [sys.executable, "-m", module, *arguments], env=env, capture_output=True, text=True
    )
    if done.returncode:
        raise TegotaeError(f"{module} failed: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
    return done.stdout.strip().splitlines()[-1]
