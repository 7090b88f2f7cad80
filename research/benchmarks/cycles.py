"""Cycles of the native engine's tick, part by part, as LLVM's model of a processor counts them.

    python -m research.benchmarks.cycles

It needs llvm-mca. A part is the difference between the ticks of two controllers. The model is that
of Ice Lake with AVX-512; it knows neither caches nor mispredicted branches.
"""

from __future__ import annotations

import re
import subprocess
from typing import NamedTuple

import numpy as np

from lanewise import machine
from research.benchmarks import engine
from research.frame import main, markdown_table
from tegotae.parts.controller import Controller
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe

LANES = 32
"""Lanes of a block: two vectors."""
_PORTS = (2, 7)
"""Columns of llvm-mca's table for the two ports of vector arithmetic."""


class Block(NamedTuple):
    """Straight code of a tick, for a block of lanes."""

    cycles: float
    """Cycles of a repetition."""
    floor: float
    """Cycles of the busier of the two ports of vector arithmetic."""


def blocks_of_tick(controller: Controller) -> list[Block]:
    """Return the two longest stretches of a controller's episode: the tick, and its branch for
    touchdown and lift-off, which runs if a lane of the block has either."""
    listings: list[str] = []
    to_object = machine.object_file

    def listed(text: str, target: machine.Target, optimisation: int = 2) -> bytes:
        module, compiler = machine._optimised(text, machine.target_of("avx512"), optimisation)
        listings.append(compiler.emit_assembly(module))
        return to_object(text, target, optimisation)

    machine.object_file = listed
    try:
        run = Rollout(controller=controller, timing=Timing(duration_s=0.02), summary=engine.totals)
        run.run(np.ones((LANES, controller.n_weights)), Scenario(omega=5.0))
    finally:
        machine.object_file = to_object
    episode = listings[-1].partition("\nepisode:")[2].partition("\n.Lfunc_end")[0]
    stretches = sorted(re.split(r"\n\.LBB\S+:", episode), key=len, reverse=True)
    return [_modelled(text) for text in stretches[:2]]


def _modelled(text: str) -> Block:
    """Return the cycles of straight code."""
    lines = [x for x in text.splitlines() if re.match(r"\t[a-z]", x) and not x.startswith("\tj")]
    command = ["llvm-mca", "-mtriple=x86_64", "-mcpu=icelake-server", "-iterations=100"]
    report = subprocess.run(
        command, input="\n".join(lines), capture_output=True, text=True, check=True
    ).stdout
    cycles = re.search(r"Total Cycles:\s+(\d+)", report)
    assert cycles is not None
    pressure = report.partition("Resource pressure per iteration")[2].splitlines()[2].split()
    return Block(float(cycles[1]) / 100.0, max(float(pressure[k]) for k in _PORTS))


def report() -> None:
    """Print the table of docs/native.md."""
    art = recipe("ART")
    (full, touch), (small, _) = (blocks_of_tick(art.controller(n)) for n in (96, 24))
    vanilla, _ = blocks_of_tick(recipe("V-reflex-w8").controller())
    parts = {
        "24 neurons": [24 / 18 * (a - b) for a, b in zip(full, small, strict=True)],
        "body, oscillator, vanilla law, totals": list(vanilla),
    }
    remainder = [a - sum(x) for a, *x in zip(full, *parts.values(), strict=True)]
    parts["divisions and sums of the networks"] = remainder
    rows = [[name, *(f"{x / LANES:.1f}" for x in values)] for name, values in parts.items()]
    rows += [["a tick", *(f"{x / LANES:.1f}" for x in full)]]
    rows += [["touchdown or lift-off in a block", *(f"{x / LANES:.1f}" for x in touch)]]
    print(markdown_table([["part", "cycles a lane", "of which busy in arithmetic"], *rows]))


if __name__ == "__main__":
    main(report)
