"""The paper's fitness, for hopper legs under a bar or a plate: that of each leg, on average."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.hopping.signals import (
    REST_RANGE_M,
    cot_inverse,
    delta_omega,
    peak,
    rest_delta_omega,
    spectrum,
)
from tegotae.measures.objectives.fitness import SETTLE_S, STRIDE, TIE_BREAK
from tegotae.measures.objectives.objective import Objective
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.rollout import Scenario, Timing, Trajectory


class HoppingLegsOutcome(NamedTuple):
    """What of an episode of hopping legs counts, [lanes] each."""

    cot_inverse: jax.Array
    """CoT⁻¹ of all legs together [m/J]."""
    delta_omega: jax.Array
    """ΔΩ (equation 13), the mean over the legs; 0 if it does not count."""
    climb_m: jax.Array
    """What the middle of the body climbs in the whole episode [m]."""


@dataclass(frozen=True, kw_only=True)
class HoppingLegs(Objective):
    """`fitness = CoT⁻¹ + ΔΩ` of hopper legs under a frame (paper equations 11-13), leg by leg.

    Each hip is a hopper's body. With y_i its height,

        CoT⁻¹ = Σ_i (what hip i climbs while leg i is in flight) / (the actuators' |work|),

    and ΔΩ is the mean over the legs of equation 13, each on the spectrum of its own y_i. Where the
    inertia ratios are 1 no leg feels another, and this is the mean of the hopper's fitness, but for
    climbs that are counted over all of the settled part and not over whole hops. In a bound the
    middle of the body hardly moves; the hips do.

    Of equal fitness the body whose middle climbs more is better, by less than 1e-3.

    Args:
        settle_s: time left to settle [s].
        follow_omega: whether ΔΩ counts; it does not without an oscillator.

    Raises:
        TegotaeError: for a negative time.

    Example:
        >>> HoppingLegs().without_frequency().follow_omega
        False
    """

    settle_s: float = SETTLE_S
    follow_omega: bool = True

    needs = ("hip_m", "ground_m", "work_absolute_j", "climb_m", "failed")

    def __post_init__(self) -> None:
        require_finite("settle_s", self.settle_s, least=0.0)

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves too little after settling."""
        if timing.duration_s - self.settle_s < 1.0:
            raise TegotaeError(
                f"an episode of {timing.duration_s:g} s leaves less than 1 s after settling for "
                f"{self.settle_s:g} s; make it at least {self.settle_s + 1.0:g} s"
            )

    def without_frequency(self) -> HoppingLegs:
        """The same without ΔΩ."""
        return HoppingLegs(settle_s=self.settle_s, follow_omega=False)

    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> HoppingLegsOutcome:
        """CoT⁻¹, ΔΩ and the climb of every lane."""
        t = trajectory
        first = round(self.settle_s / timing.frame_s)
        hips, ground = t.hip_m[first:], t.ground_m[first:, None]
        rest = jnp.asarray(body.rest_length_m)
        work = t.work_absolute_j[-1] - t.work_absolute_j[first]
        cot = cot_inverse(climb_in_flight(hips - ground, rest), work)
        gap = jnp.zeros_like(cot)
        if self.follow_omega:
            gap = _gap(hips, scenario.omega, timing.frame_s)
        return HoppingLegsOutcome(cot, gap, t.climb_m[-1])

    def score(self, outcome: HoppingLegsOutcome, data: object) -> dict[str, jax.Array]:
        """`fitness`, `cot_inverse` [m/J] and `delta_omega`, [lanes] each."""
        cot, gap, climb_m = outcome
        fitness = cot + gap + TIE_BREAK * jnp.tanh(climb_m)
        return {"fitness": fitness, "cot_inverse": cot, "delta_omega": gap}


def climb_in_flight(hips_m: jax.Array, rest_m: Numeric) -> jax.Array:
    """What the hips climb over their legs' rest length, all legs together [m], [lanes].

    From frame to frame: of an apex between two frames less than half a millimetre is missed at
    20 ms.

    Args:
        hips_m: heights over the ground [m], [frames, limbs, lanes].
        rest_m: rest length of a leg l0 [m].

    Example:
        >>> climb_in_flight(jnp.array([0.9, 1.25, 1.0, 1.5])[:, None, None], 1.0).tolist()
        [0.75]
    """
    over = jnp.maximum(hips_m, rest_m)
    return jnp.maximum(over[1:] - over[:-1], 0.0).sum(axis=(0, 1))


def _gap(hips: jax.Array, omega: Numeric, frame_s: float) -> jax.Array:
    """ΔΩ, the mean over the legs, [lanes]."""
    limbs, lanes = hips.shape[1:]
    heights = hips[::STRIDE].reshape(-1, limbs * lanes)
    wanted = jnp.broadcast_to(omega, (limbs, lanes)).reshape(-1)
    w_peak, a_peak = peak(spectrum(heights, STRIDE * frame_s))
    rests = heights.max(axis=0) - heights.min(axis=0) < REST_RANGE_M
    each = jnp.where(rests, rest_delta_omega(wanted), delta_omega(wanted, w_peak, a_peak))
    return each.reshape(limbs, lanes).mean(axis=0)
