"""Fitness of hopping: CoT⁻¹ + ΔΩ, on one leg or several."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.hopping import at_frame, dies_out, whole_hops
from tegotae.measures.hopping.signals import (
    REST_RANGE_M,
    WORK,
    check_work,
    cot_inverse,
    delta_omega,
    peak,
    rest_delta_omega,
    spectrum,
    work_total,
)
from tegotae.measures.objectives.objective import Objective, require_settled
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.parts.bodies import Body
from tegotae.parts.parameters import not_negative
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing

EPISODE = Timing(duration_s=24.0, tick_s=0.002)
"""An episode of training. At 2 ms regular apexes of vanilla laws stay within 0.6 mm of an adaptive
solver, those of stiff learned laws within two centimetres (see the convergence study), at half
the price of the 1 ms of everything else."""

SETTLE_S = 12.0
"""Time of an episode that is left to settle [s]: transients last 10 s and more."""

HERTZ = (2.0 * math.pi) ** -2
"""The weight of ΔΩ that takes its frequencies in hertz, 0.025: (ω - w)² in Hz², not in rad²/s²."""

TIE_BREAK = 1e-3
"""Weight of the height climbed, so that something can be learned from controllers of no other merit
[m/J]."""
STRIDE = 2
"""Frames per sample of the spectrum: 40 ms are 30 samples of the quickest hop and more."""


class HopOutcome(NamedTuple):
    """Outcome of an episode of hopping, for every definition of work."""

    cot_inverse: jax.Array
    """CoT⁻¹ over whole hops [m/J] by each definition of `WORK`, shape [definitions, lanes]."""
    delta_omega: jax.Array
    """ΔΩ (equation 13), [lanes]."""
    climb_m: jax.Array
    """Height climbed in the whole episode [m], [lanes]."""


class _SettledHops(Objective):
    """Part of a fitness of hopping: the time after settling, with ΔΩ or without."""

    settle_s: float
    follow_omega: bool

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves less than a second after settling."""
        require_settled(timing, self.settle_s, 1.0)

    def without_frequency(self) -> Self:
        """Return this fitness without ΔΩ."""
        return dataclasses.replace(self, follow_omega=False)  # type: ignore[type-var]


@dataclass(frozen=True, kw_only=True)
class Fitness(_SettledHops):
    """`fitness = CoT⁻¹ + w ΔΩ` over the settled part of an episode (paper equations 11-13).

    The paper adds m/J to a squared frequency without a unit. The weight w is 1 if that is in
    rad²/s², and `HERTZ` if it is in Hz²: the frequency then counts for a 39th, and what is learned
    hops nearer to the body's own rate.

    In training the settled part is what follows `settle_s`; of that, CoT⁻¹ is over the last whole
    hops (`whole_hops`) and ΔΩ over all of it. A gait that has died out by the end has a CoT⁻¹ of
    zero, as in `metrics.gait`.

    Among controllers of equal fitness, such as those of early generations that do nothing at all,
    the one that climbs more in the whole episode is better, by less than 1e-3: without this nothing
    could be learned from them.

    Args:
        settle_s: time at the start of an episode that does not count [s].
        work: definition of work, one of "absolute", "positive", "net".
        follow_omega: subtract ΔΩ, which is nothing without an oscillator, nor in the paper's
            comparison of algorithms (Fig. 3).
        frequency_weight: weight w of ΔΩ [m/J per rad²/s²].

    Raises:
        TegotaeError: for an unknown definition, a negative settling time or a negative weight.
    """

    settle_s: float = not_negative(SETTLE_S)
    work: str = "absolute"
    follow_omega: bool = True
    frequency_weight: float = not_negative(1.0)

    needs = (
        *("time_s", "height_m", "ground_m", "apex_height_m", "climb_flight_m", "climb_m"),
        *("work_absolute_j", "work_positive_j", "work_net_j", "failed"),
    )
    DATA = ("work", "follow_omega", "frequency_weight")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_work(self.work)

    @property
    def data(self) -> dict[str, np.ndarray]:
        """The weight of ΔΩ, and 1 at the definition of work that counts, 0 elsewhere."""
        selected = [float(definition == self.work) for definition in WORK]
        weight = self.frequency_weight if self.follow_omega else 0.0
        return {"definition": np.array(selected, "float32"), "weight": np.array(weight, "float32")}

    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> HopOutcome:
        """Return CoT⁻¹ by every definition of work, ΔΩ and the climb of every lane."""
        first = round(self.settle_s / timing.frame_s)
        hops = whole_hops(
            trajectory.apex_height_m[first:], trajectory.ground_m[first:], body.rest_length_m
        )

        def over_hops(total: AnyArray) -> jax.Array:
            return hops.over(total[first:])

        last_hop_s = jnp.where(
            hops.n_hops >= 0, at_frame(trajectory.time_s[first:], hops.ends), -jnp.inf
        )
        goes_on = ~dies_out(last_hop_s, timing.duration_s)
        climb = jnp.where(goes_on, over_hops(trajectory.climb_flight_m), 0.0)
        work = [over_hops(work_total(trajectory, definition)) for definition in WORK]

        height = trajectory.height_m[first:]
        moves_m = height.max(axis=0) - height.min(axis=0)
        gap = _gap(height[::STRIDE], moves_m, scenario.omega, timing.frame_s)
        return HopOutcome(
            cot_inverse=jnp.stack([cot_inverse(climb, joules) for joules in work]),
            delta_omega=gap,
            climb_m=trajectory.climb_m[-1],
        )

    def score(self, outcome: HopOutcome, data: Mapping[str, Any]) -> dict[str, jax.Array]:
        """Return `fitness`, `cot_inverse` [m/J] and `delta_omega`, [lanes] each."""
        shares = jnp.asarray(data["definition"], outcome.cot_inverse.dtype)
        cot = (shares[:, None] * outcome.cot_inverse).sum(axis=0)
        # A failed lane may hold anything; what is not asked for must not spoil what is.
        weight = data["weight"]
        gap = jnp.where(weight > 0.0, outcome.delta_omega, 0.0)
        fitness = cot + weight * gap + TIE_BREAK * jnp.tanh(outcome.climb_m)
        return {"fitness": fitness, "cot_inverse": cot, "delta_omega": gap}


@dataclass(frozen=True, kw_only=True)
class HoppingLegs(_SettledHops):
    """`fitness = CoT⁻¹ + ΔΩ` of hopper legs under a frame (paper equations 11-13), leg by leg.

    Each hip is a hopper's body. With y_i its height,

        CoT⁻¹ = Σ_i (what hip i climbs while leg i is in flight) / (the actuators' |work|),

    and ΔΩ is the mean over the legs of equation 13, each on the spectrum of its own y_i. Where the
    inertia ratios are 1 no leg feels another, and this is the mean of the hopper's fitness, but for
    climbs that are counted over all of the settled part and not over whole hops. In a bound the
    middle of the body hardly moves; the hips do.

    Of equal fitness the body whose middle climbs more is better, by less than 1e-3.

    Args:
        settle_s: time at the start of an episode that does not count [s].
        follow_omega: subtract ΔΩ, which is nothing without an oscillator.

    Raises:
        TegotaeError: for a negative time.

    Example:
        >>> HoppingLegs().without_frequency().follow_omega
        False
    """

    settle_s: float = not_negative(SETTLE_S)
    follow_omega: bool = True

    needs = ("hip_m", "ground_m", "work_absolute_j", "climb_m", "failed")

    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> HopOutcome:
        """Return CoT⁻¹ of all legs together, [lanes], the mean ΔΩ, and the climb of the middle."""
        t = trajectory
        first = round(self.settle_s / timing.frame_s)
        hips, ground = t.hip_m[first:], t.ground_m[first:, None]
        rest_length = jnp.asarray(body.rest_length_m)
        work = t.work_absolute_j[-1] - t.work_absolute_j[first]
        cot = cot_inverse(climb_in_flight(hips - ground, rest_length), work)
        gap = jnp.zeros_like(cot)
        if self.follow_omega:
            limbs, lanes = hips.shape[1:]
            command = jnp.broadcast_to(scenario.omega, (limbs, lanes)).reshape(-1)
            heights = hips[::STRIDE].reshape(-1, limbs * lanes)
            moves_m = heights.max(axis=0) - heights.min(axis=0)
            of_legs = _gap(heights, moves_m, command, timing.frame_s)
            gap = of_legs.reshape(limbs, lanes).mean(axis=0)
        return HopOutcome(cot, gap, t.climb_m[-1])

    def score(self, outcome: HopOutcome, data: object) -> dict[str, jax.Array]:
        """Return `fitness`, `cot_inverse` [m/J] and `delta_omega`, [lanes] each."""
        cot, gap, climb_m = outcome
        fitness = cot + gap + TIE_BREAK * jnp.tanh(climb_m)
        return {"fitness": fitness, "cot_inverse": cot, "delta_omega": gap}


def climb_in_flight(hips_m: jax.Array, rest_m: Numeric) -> jax.Array:
    """Return the climb of the hips above their legs' rest length, all legs together [m], [lanes].

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


def _gap(height_m: AnyArray, moves_m: AnyArray, omega: Numeric, frame_s: float) -> jax.Array:
    """Return ΔΩ of heights at every `STRIDE`-th frame [m], of which some hardly move, [lanes]."""
    gap = delta_omega(omega, *peak(spectrum(height_m, STRIDE * frame_s)))
    return jnp.where(moves_m < REST_RANGE_M, rest_delta_omega(omega), gap)
