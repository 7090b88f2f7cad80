"""The fitness of an episode, computed on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp

from tegotae.bodies import Body
from tegotae.errors import TegotaeError, require_finite
from tegotae.metrics.efficiency import WORK, cot_inverse, work_total
from tegotae.metrics.hopping import hop_height_m
from tegotae.metrics.spectrum import REST_RANGE_M, delta_omega, peak, rest_delta_omega, spectrum
from tegotae.rollout import Scenario, Timing, Trajectory

FAILED = -1e6
"""Fitness of a rollout that failed: below any that did not."""

EPISODE = Timing(duration_s=24.0, tick_s=0.002)
"""An episode of training. At 2 ms regular apexes stay within 0.6 mm of an adaptive solver
(see the convergence study), at half the price of the 1 ms of everything else."""

SETTLE_S = 12.0
"""Time of an episode that is left to settle [s]: transients last 10 s and more."""

_TIE_BREAK = 1e-3


@dataclass(frozen=True, kw_only=True)
class Fitness:
    """`fitness = CoT⁻¹ + ΔΩ` over the settled part of an episode (paper equations 11-13).

    In training the settled part is what follows `settle_s`. Among controllers of equal fitness,
    such as those of early generations that do nothing at all, the one that climbs more in the
    whole episode is better, by less than 1e-3: without this nothing could be learned from them.

    Args:
        settle_s: time left to settle [s].
        energy: definition of work, one of "absolute", "positive", "net".
        follow_omega: whether ΔΩ counts; it does not without an oscillator, nor in the paper's
            comparison of algorithms (Fig. 3).

    Raises:
        TegotaeError: for an unknown definition or a negative settling time.
    """

    settle_s: float = SETTLE_S
    energy: str = "absolute"
    follow_omega: bool = True

    def __post_init__(self) -> None:
        require_finite("settle_s", self.settle_s, least=0.0)
        if self.energy not in WORK:
            raise TegotaeError(f"energy is {self.energy!r}; it must be one of {', '.join(WORK)}")

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves too little after settling to be judged."""
        if timing.duration_s - self.settle_s < 1.0:
            raise TegotaeError(
                f"an episode of {timing.duration_s:g} s leaves less than 1 s after settling for "
                f"{self.settle_s:g} s; make it at least {self.settle_s + 1.0:g} s"
            )

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> dict[str, Any]:
        """Fitness and its parts, each of shape [lanes]."""
        first = round(self.settle_s / timing.frame_s)
        height = trajectory.height_m[first:]
        climb = trajectory.climb_flight_m[-1] - trajectory.climb_flight_m[first]
        work = work_total(trajectory, self.energy)
        cot = cot_inverse(climb, work[-1] - work[first])
        rests = height.max(axis=0) - height.min(axis=0) < REST_RANGE_M
        # A gait that has died out by the last quarter is none, as in `metrics.gait`.
        late = height.shape[0] - height.shape[0] // 4
        least = hop_height_m(body.rest_length_m, trajectory.ground_m[first:])
        hops = (height >= least)[late:].any(axis=0)
        cot = jnp.where(hops, cot, 0.0)
        fitness = cot
        gap = jnp.zeros_like(cot)
        if self.follow_omega:
            w_peak, a_peak = peak(spectrum(height, timing.frame_s))
            gap = jnp.where(
                rests,
                rest_delta_omega(scenario.omega),
                delta_omega(scenario.omega, w_peak, a_peak),
            )
            fitness = fitness + gap
        fitness = fitness + _TIE_BREAK * jnp.tanh(trajectory.climb_m[-1])
        failed = trajectory.failed[-1]
        survived = jnp.mean(jnp.where(trajectory.failed, 0.0, 1.0), axis=0)
        return {
            "fitness": jnp.where(failed, FAILED + survived, fitness),
            "cot_inverse": jnp.where(failed, 0.0, cot),
            "delta_omega": gap,
            "failed": failed,
        }
