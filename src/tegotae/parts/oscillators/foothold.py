"""A clock that places a foot: Raibert's foot placement in swing, the commanded speed in stance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import Numeric, PerLimb, Weights
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.parameters import positive
from tegotae.parts.terms.base import Signals

_FLAT = 1e-3
"""Least 1 + cos φ; there a swing is over."""
_SLOWEST = 0.1
"""Frequency at which stance lasts longest [rad/s]."""


def raibert_placement(
    velocity: Numeric, commanded: Numeric, stance_s: Numeric, gain_s: Numeric
) -> jax.Array:
    """Return where a foot shall touch down from its place under the hip [m]:

        x = v T / 2 + k (v - v*).

    With v = v* the body passes over the foot as far behind it as before it. A foot that is put
    further ahead slows the body down.

    Args:
        velocity: v, of the hip over the ground [m/s].
        commanded: v* [m/s].
        stance_s: T, how long the foot will stand [s].
        gain_s: k [s].

    Reference: M. H. Raibert, Legged Robots That Balance (1986), equation 2.4.

    Example:
        >>> print(f"{raibert_placement(1.0, 0.5, 0.2, 0.1):.3f} m")
        0.150 m
    """
    return jnp.asarray(0.5 * stance_s * velocity + gain_s * (velocity - commanded))


class FootholdState(NamedTuple):
    """Phase φ [rad], the foot's place from that at rest [m], the speed that it is to have over the
    ground [m/s], and how far the leg lags behind that [m], forward and to the left."""

    phase: jax.Array
    foothold_x: jax.Array
    foothold_y: jax.Array
    pace_x: jax.Array
    pace_y: jax.Array
    lag_x: jax.Array
    lag_y: jax.Array


@dataclass(frozen=True, kw_only=True)
class FootholdOscillator(Oscillator):
    """A clock whose leg swings while sin φ > 0, to where `raibert_placement` has it, and otherwise
    stands and moves the body over it at the commanded speed:

        φ̇ = ω + f,    ẋ = min(φ̇ tan(φ/2), 1/τ) (x_f - x)  in swing,  else  -(w + k_i s),
        ẇ = ((1 + c) v* - w) / τ  within ±a,    ṡ = w / (1 + c) - v  while |s| < s_max.

    In swing that is x = x₀ + (x_f - x₀) (1 - cos φ) / 2 if x_f stays. Stance lasts T = π / φ̇. The
    pace w approaches the command v*, raised by c since feet whose servos yield are slower than they
    are commanded, and s is the integral part of a PI control of the speed. Forward and to the left
    alike. v and v* are those of the trunk over the leg, so that a turning trunk has others there.

    Args:
        settle_s: τ [s].
        most_m_per_s2: a [m/s²].
        most_lag_m: s_max [m].
        reach_m: largest |x| [m].

    Raises:
        TegotaeError: for a number that is not above zero.

    Reference: M. H. Raibert, Legged Robots That Balance (1986).

    Example:
        >>> FootholdOscillator().weight_names
        (('forward_s',), ('left_s',), ('lag_per_s',), ('calibration',))
    """

    SIGNALS = (*Oscillator.SIGNALS, "foothold_x", "foothold_y")
    READS = ("odometry_x", "odometry_y", "commanded_x", "commanded_y")
    STATE = FootholdState._fields[1:]
    WEIGHTS = ("forward_s", "left_s", "lag_per_s", "calibration")

    settle_s: float = positive(0.2)
    most_m_per_s2: float = positive(0.3)
    most_lag_m: float = positive(0.5)
    reach_m: float = positive(1.0)

    def start(self, phase_rad: PerLimb, **state: PerLimb) -> FootholdState:
        """Return the state at phase φ [rad], the foot at rest by default, [(limbs,) lanes]."""
        zeros = dict.fromkeys(self.STATE, jnp.zeros_like(phase_rad))
        return FootholdState(maths.wrap_phase(phase_rad), **{**zeros, **state})

    def rate(
        self,
        state: FootholdState,
        omega: PerLimb,
        feedback: PerLimb,
        weights: Weights = (),
        signals: Signals | None = None,
    ) -> FootholdState:
        """Return φ̇ [rad/s], and the rates of places [m/s], speeds [m/s²] and lags [m/s]."""
        assert signals is not None
        rate = omega + feedback
        sine, cosine = self.sin_cos(state)
        stance_s = math.pi / jnp.maximum(rate, _SLOWEST)
        approach = rate * sine / jnp.maximum(1.0 + cosine, _FLAT)
        approach = jnp.clip(approach, 0.0, 1.0 / self.settle_s)
        most, raised = self.most_m_per_s2, 1.0 + weights[3]
        moves, speeds, lags = list[jax.Array](), list[jax.Array](), list[jax.Array]()
        for axis, gain_s, (place, pace, lag) in (
            ("x", weights[0], state[1::2]),
            ("y", weights[1], state[2::2]),
        ):
            velocity, commanded = signals[f"odometry_{axis}"], signals[f"commanded_{axis}"]
            goal = raibert_placement(velocity, pace, stance_s, gain_s)
            goal = jnp.clip(goal, -self.reach_m, self.reach_m)
            standing = -(pace + weights[2] * lag)
            moves.append(jnp.where(sine > 0.0, approach * (goal - place), standing))
            speeds.append(jnp.clip((raised * commanded - pace) / self.settle_s, -most, most))
            lags.append(pace / raised - velocity)
        return FootholdState(rate, *moves, *speeds, *lags)

    def phase(self, state: FootholdState) -> jax.Array:
        """φ [rad]."""
        return state.phase

    def signals(self, state: FootholdState) -> dict[str, jax.Array]:
        """sin φ, cos φ and the foot's place [m]."""
        places = {"foothold_x": state.foothold_x, "foothold_y": state.foothold_y}
        return {**super().signals(state), **places}

    def settle(self, state: FootholdState) -> FootholdState:
        """φ modulo 2π, and places and lags within their bounds."""
        _, x, y, *paces, lag_x, lag_y = state
        places = (jnp.clip(place, -self.reach_m, self.reach_m) for place in (x, y))
        lags = (jnp.clip(lag, -self.most_lag_m, self.most_lag_m) for lag in (lag_x, lag_y))
        return FootholdState(maths.wrap_phase(state.phase), *places, *paces, *lags)

    def decay_per_s(self, omega: float) -> float:
        """Return the fastest approach to a foothold [1/s]."""
        return 1.0 / self.settle_s
