"""Phase response of the tuned laws: what strides leave of a slip of one leg's phase."""

from __future__ import annotations

import numpy as np
import pandas as pd

from research.load_map import laws
from research.load_map.cells import CELLS, SLIP_S
from tegotae.simulation.rollout import Rollout
from tegotae.simulation.summaries import KeptChannels

CELL = "quadruped, phase slips"
SLIPS = np.linspace(-0.48, 0.48, 25)
"""Slips of a leg's phase, less than half a cycle either way [cycles]."""
STRIDES = (0, 1, 2, 4)
"""Strides after the slip."""
STARTS = 8


def response(rows: pd.DataFrame) -> list[dict[str, object]]:
    """Return the slip that is left after strides, median over searches and starts, law by law.

    It is the deviation of the leg's phase from that of the same episode without a slip, less the
    mean deviation of the other legs.

    Args:
        rows: of judged controllers of one budget.
    """
    cell = next(cell for cell in CELLS if cell.name == CELL)
    table: list[dict[str, object]] = []
    for law in ("load", "clock", "coupled"):
        tuned = rows[(rows.cell == CELL) & (rows.law == law)]
        x = np.array([[*map(float, text.split())] for text in tuned.x.dropna()])
        lanes = np.repeat(x, STARTS, axis=0)
        rollout = Rollout(controller=laws.controller(cell, law), timing=cell.timing,
                          summary=KeptChannels(("phase_rad",)))  # fmt: skip
        paths = []
        for slip in (0.0, *SLIPS):
            values = laws.numbers(cell, law, lanes) | {"slip": np.full(len(lanes), slip)}
            scenario = cell.scenario(values, np.tile(np.arange(STARTS), len(x)))
            weights = laws.weights(cell, law, values)
            paths.append(np.asarray(rollout.run(weights, scenario, cell.complete_body).phase_rad))
        table += _remaining(law, np.exp(1j * np.array(paths)), cell.timing.frame_s)
    return table


def _remaining(law: str, phase: np.ndarray, frame_s: float) -> list[dict[str, object]]:
    """Return rows of phases as complex numbers, [1 + slips, frames, limbs, lanes]."""
    begins = phase.shape[1] // 2 + round(SLIP_S / frame_s)
    turned = np.angle(phase[0, begins + 1 :, 0] / phase[0, begins:-1, 0]).mean(axis=0)
    stride = 2.0 * np.pi / np.maximum(turned, 0.05)
    rows: list[dict[str, object]] = []
    for strides in STRIDES:
        frame = np.minimum(begins + strides * stride, phase.shape[1] - 1).astype(int)
        phases = np.take_along_axis(phase, frame[None, None, None], axis=1)[:, 0]
        off = phases[1:] / phases[:1]
        if not strides:
            first = np.abs(np.angle(off / off.mean(axis=1, keepdims=True))).argmax(axis=1)
        leg = np.take_along_axis(off, first[:, None], axis=1)[:, 0]
        remaining = np.angle(leg / (off.sum(axis=1) - leg)) / (2.0 * np.pi)
        rows += [{"law": law, "strides": strides, "slip": slip, "remaining": np.median(values)}
                 for slip, values in zip(SLIPS, remaining, strict=True)]  # fmt: skip
    return rows
