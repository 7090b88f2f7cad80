"""Laws that are compared: their numbers, their weights, and the merit of an episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from research.load_map.cells import Cell
from tegotae.measures.gaits.summary import CoordinationSummary
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.couplings import LearnedCoupling
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    BalancedFoot,
    ConstantGain,
    FreeSector,
    Signals,
    VanillaAction,
    VanillaReaction,
)
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Rollout

Range = tuple[float, float, bool]
"""First mean and deviation of a number; True if the deviation is that of its logarithm."""
STEPS: dict[str, Range] = {
    "omega": (2.5, 0.5, True), "stride": (0.2, 0.4, True), "lift": (0.08, 0.4, True),
    "press": (0.02, 0.4, True), "shift": (0.5, 0.4, False), "lag": (0.5, 0.25, False),
}  # fmt: skip
PUSHES: dict[str, Range] = {
    "omega": (8.0, 0.3, True), "start": (5.5, 1.0, False), "width": (0.6, 0.5, True),
    "lag": (0.0, 0.25, False), "side_lag": (0.0, 0.25, False), "lead": (0.0, 0.25, False),
}  # fmt: skip
LOAD: dict[str, Range] = {"sigma": (1.25, 0.7, True)}
TILT = {name: (0.0, size, False) for name, size in
        {"roll": 0.1, "roll_rate": 0.1, "pitch": 0.1, "yaw": 0.3}.items()}  # fmt: skip
CORNER = {"corner": (0.0, 2.0, False), "corner_rate": (0.0, 0.3, False)}
LAWS = {"neither": (False, False, False), "load": (True, False, False),
        "clock": (False, True, False), "both": (True, True, False),
        "coupled": (False, True, True)}  # fmt: skip
"""Laws, and if they have load, balance, and a coupling of the clocks."""
SPEED = {True: 0.3, False: 0.2}
"""Speed of walkers [√(g l0)], and mean rate of climb in flight of legs that hop [m/s], in the
task."""


@dataclass(frozen=True)
class BalancedSector(FreeSector):
    """A `FreeSector`, beside which a leg pushes where its corner of the frame is low or sinks:

        F_a = α in the sector,  else  -k d_i - k' ḋ_i,    d_i = Σ x_i q over the turns q.

    Args:
        arms_m: of each leg for pitch, and for roll if there is any.
    """

    arms_m: tuple[tuple[float, ...], ...] = ()
    WEIGHTS = (*FreeSector.WEIGHTS, "corner", "corner_rate")

    @property
    def reads(self) -> tuple[str, ...]:
        """Angles and rates of the turns."""
        turns = ("pitch", "roll")[: len(self.arms_m)]
        return (*turns, *(f"{turn}_rate" for turn in turns))

    def __call__(self, weights: Any, signals: Signals) -> jax.Array:
        """Return the force beside the sector."""
        force = jnp.zeros_like(signals["feedback"])
        for turn, arms in zip(("pitch", "roll"), self.arms_m, strict=False):
            turning = weights[2] * signals[turn] + weights[3] * signals[f"{turn}_rate"]
            force = force - jnp.stack([x * turning[i] for i, x in enumerate(arms)])
        return force


def ranges(cell: Cell, law: str) -> dict[str, Range]:
    """Return the free numbers of a law in a cell."""
    load, balance, coupled = LAWS[law]
    free = dict(STEPS if cell.walks else PUSHES)
    free |= (TILT if cell.walks else CORNER) if balance and cell.mechanics.limbs > 1 else {}
    return free | (LOAD if load else {}) | ({"kappa": (1.0, 0.7, True)} if coupled else {})


def numbers(cell: Cell, law: str, x: np.ndarray) -> dict[str, np.ndarray]:
    """Return the numbers of vectors [lanes, size] by name, those that the law lacks as zeros."""
    values = dict.fromkeys([*STEPS, *PUSHES, *LOAD, *TILT, *CORNER, "kappa"], np.zeros(len(x)))
    values["side_lag"] = np.full(len(x), 0.5)
    for i, (name, (mean, deviation, ratio)) in enumerate(ranges(cell, law).items()):
        step = deviation * np.clip(x[:, i], -6.0, 6.0)
        values[name] = mean * np.exp(step) if ratio else mean + step
    return values


def controller(cell: Cell, law: str) -> Controller:
    """Return the controller of a law; all laws but a coupled one have the same."""
    body, actuation = cell.mechanics, BalancedFoot()
    if not cell.walks:
        turns = getattr(body, "turns", ())
        actuation = BalancedSector(arms_m=tuple(turn.arms_m for turn in turns))
        actuation = actuation if turns else FreeSector()
    feedback = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    coupling = LearnedCoupling() if LAWS[law][2] else None
    return Controller(actuation, PhaseOscillator(), feedback, body.limbs, coupling)


def weights(cell: Cell, law: str, values: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the weights of controllers of these numbers, [lanes, n_weights]."""
    steps = ("stride", "lift", "press", "shift", *TILT) if cell.walks else ("start", "width")
    corners = CORNER if cell.mechanics.limbs > 1 and not cell.walks else ()
    rows = [values[name] for name in ("sigma", *steps, *corners)]
    if LAWS[law][2]:
        row, side = cell.places()[..., None]
        behind = 2.0 * np.pi * (row * values["lag"] + side * values["side_lag"])
        strength = values["kappa"] / (len(behind) - 1)
        for to in range(len(behind)):
            for source in (leg for leg in range(len(behind)) if leg != to):
                gap = behind[to] - behind[source]
                rows += [strength * np.cos(gap), -strength * np.sin(gap)]
    return np.stack(rows, axis=1)


@needing("x_m", "y_m", "work_absolute_j", "failed", "time_s")
def _walked(path: Any, scenario: Any, body: Any, timing: Any) -> tuple[jax.Array, ...]:
    half = path.time_s.shape[0] // 2 - 1
    distance = jnp.hypot(path.x_m[-1] - path.x_m[half], path.y_m[-1] - path.y_m[half])
    return _totals(path, distance, half)


@needing("climb_flight_m", "work_absolute_j", "failed", "time_s")
def _hopped(path: Any, scenario: Any, body: Any, timing: Any) -> tuple[jax.Array, ...]:
    half = path.time_s.shape[0] // 2 - 1
    return _totals(path, path.climb_flight_m[-1] - path.climb_flight_m[half], half)


def _totals(path: Any, distance: jax.Array, half: int) -> tuple[jax.Array, ...]:
    """Return distance, work, time of the second half, and the share of time before a fall."""
    work = path.work_absolute_j[-1] - path.work_absolute_j[half]
    return distance, work, path.time_s[-1] - path.time_s[half], 1.0 - path.failed.mean(axis=0)


def episodes(cell: Cell, law: str, x: np.ndarray, seeds: np.ndarray) -> dict[str, np.ndarray]:
    """Return merit, fall, speed and CoT of controllers, one a lane.

    The merit of an episode is 0 if it falls, and otherwise

        max(0, 1 - |v / v* - 1|) / (1 + CoT)

    over its second half; `fitness` has, of one that falls, the missing share of the episode times
    -0.3.

    Args:
        cell: the cell.
        law: of `LAWS`.
        x: vectors, [lanes, size].
        seeds: of the starts, [lanes].
    """
    values, body = numbers(cell, law, x), cell.mechanics
    rollout = Rollout(controller=controller(cell, law), timing=cell.timing,
                      summary=_walked if cell.walks else _hopped)  # fmt: skip
    results = rollout.run(
        weights(cell, law, values), cell.scenario(values, seeds), cell.complete_body
    )
    distance, work, time, up = (np.nan_to_num(np.asarray(a, float)) for a in results)
    weight = getattr(body, "total_mass_kg", body.mass_kg) * body.gravity_m_per_s2
    speed, cost = distance / np.maximum(time, 1e-9), work / np.maximum(weight * distance, 1e-9)
    track = np.maximum(1.0 - np.abs(speed / SPEED[cell.walks] - 1.0), 0.0)
    fell = (up < 1.0) | ~np.isfinite(speed * cost)
    merit = np.where(fell, 0.0, track / (1.0 + np.minimum(cost, 1e6)))
    fitness = np.where(fell, -0.3 * (1.0 - np.minimum(up, 1.0)), merit)
    return {"merit": merit, "fitness": fitness, "fell": fell, "speed": speed, "cost": cost}


def locks(cell: Cell, law: str, x: np.ndarray, seeds: np.ndarray) -> np.ndarray:
    """Return the time from the start, or from an event, until lags stay within 0.05 cycles [s].

    It is NaN of an episode that falls or does not lock before its last quarter.
    """
    values, steps = numbers(cell, law, x), controller(cell, law)
    summary = CoordinationSummary.on(steps, cell.complete_body)
    rollout = Rollout(controller=steps, timing=cell.timing, summary=summary)
    results = rollout.run(
        weights(cell, law, values), cell.scenario(values, seeds), cell.complete_body
    )
    time = np.asarray(results.lock_time_s, float)
    begun = 0.5 * cell.timing.duration_s if cell.event else 0.0
    return np.maximum(time - begun, 0.0)
