"""Loss that the search for gaits of least cost minimises."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from research.legs_limit.gaits import OverStrides, Space
from tegotae.parts.bodies import Walker
from tegotae.simulation.rollout import Timing

GAITS = Path(__file__).resolve().parents[2] / "research" / "legs_limit" / "gaits.json"
"""The kept gaits, one for each kind of feet and speed."""
TIMING = Timing(duration_s=32.0, tick_s=0.0125, frame_s=0.1)
"""Timing of a candidate's rollout."""
SETTLE_S = 10.0
"""Settling time of the rollout."""
POPULATION = 16
"""Candidates of a generation."""
TRACKING = 4.0
"""Loss for a speed error of 100 %, in units of log CoT."""


def losses(
    space: Space, x: np.ndarray, speed: np.ndarray, timing: Timing = TIMING
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return log CoT + 4 |v / v* - 1| of vectors [lanes, size] for speeds v* [lanes], with speeds
    and costs.

    Of two windows the one with the larger loss counts.
    """
    weights, scenario = space.decoded(x, speed)
    settle = SETTLE_S / TIMING.duration_s * timing.duration_s
    walked = space.rollout(OverStrides(settle), timing).run(weights, scenario, Walker())
    v, power, turn, fall = (np.asarray(a, float) for a in walked)
    cost = np.where(v > 0.0, power / np.maximum(v, 1e-3), 1e6)
    loss = np.log(np.clip(cost, 1e-6, 1e6)) + TRACKING * np.abs(v / speed - 1.0)
    loss = loss + 2.0 * np.maximum(turn - 0.05, 0.0)
    worse = np.argmax(loss, axis=0), np.arange(len(x))
    loss = np.where(np.isfinite(fall), 100.0 - np.nan_to_num(fall, posinf=0.0), loss[worse])
    return np.where(np.isfinite(loss), loss, 200.0), v[worse], cost[worse]


def kept_gaits(feet: str) -> list[tuple[Space, np.ndarray, np.ndarray]]:
    """Return speeds [gaits] and vectors [gaits, size] of the kept gaits of such feet, space by
    space.
    """
    entries = [gait for gait in json.loads(GAITS.read_text()) if gait["feet"] == feet]
    spaces = [Space(feet, gait["harmonics"]) for gait in entries]
    groups = []
    for space in dict.fromkeys(spaces):
        mine = [gait for gait, candidate in zip(entries, spaces, strict=True) if candidate == space]
        groups.append((space, *(np.array([gait[n] for gait in mine]) for n in ("speed", "x"))))
    return groups
