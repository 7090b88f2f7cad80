"""Baseline: one controller in a Python loop, as a Gymnasium user writes it."""

from __future__ import annotations

import math
import time

import numpy as np

from tegotae.parts.bodies import Hopper
from tegotae.parts.terms import Network
from tegotae.systems.recipe import recipe


class LoopHopper:
    """The hopper with an ART controller, one plain first-order step at a time."""

    def __init__(self, weights: np.ndarray, tick_s: float, omega: float) -> None:
        self.hopper, self.tick_s, self.omega = Hopper(), tick_s, omega
        self.networks, self.gain, start = {}, 1.0, 0
        for role, term in recipe("ART").controller().terms.items():
            parameters = weights[start : start + term.n_weights]
            start += term.n_weights
            if isinstance(term, Network):
                self.networks[role] = parameters.reshape(term.hidden, -1)
            else:
                self.gain = parameters[0]
        self.y, self.v, self.phase = 1.2, 0.0, 0.0

    def network(self, name: str, *x: float) -> float:
        """Compute one tanh layer."""
        w = self.networks[name]
        return float(np.tanh(w[:, :-2] @ np.array(x) + w[:, -2]) @ w[:, -1])

    def step(self) -> tuple[float, float]:
        """Advance one control tick."""
        p = self.hopper
        stance = self.y < p.rest_length_m
        spring = p.stiffness_n_per_m * (p.rest_length_m - self.y) if stance else 0.0
        angle = (math.sin(self.phase), math.cos(self.phase))
        match = self.network("action", *angle) * self.network("reaction", spring / p.weight_n)
        feedback = self.gain * match
        force = self.network("actuation", *angle, feedback)
        force = min(max(force, 0.0), p.max_force_n)
        push = spring - p.damping_ns_per_m * self.v + force if stance else 0.0
        self.v += self.tick_s * (push / p.mass_kg - p.gravity_m_per_s2)
        self.y += self.tick_s * self.v
        self.phase += self.tick_s * (self.omega + feedback)
        return self.y, self.v


def loop_ticks_per_second(ticks: int = 20_000, tick_s: float = 0.001) -> float:
    """Return the control ticks per second of the loop."""
    env = LoopHopper(np.random.default_rng(0).normal(size=96) * 0.5, tick_s, 5.0)
    begun = time.perf_counter()
    for _ in range(ticks):
        env.step()
    return ticks / (time.perf_counter() - begun)
