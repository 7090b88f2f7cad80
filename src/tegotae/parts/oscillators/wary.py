"""A phase oscillator that feedback alarms, and that stays wary for a while."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, Weights
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.parameters import positive


class WaryState(NamedTuple):
    """Phase φ [rad] and alarm a [rad/s]."""

    phase: jax.Array
    alarm_rad_per_s: jax.Array


@dataclass(frozen=True, kw_only=True)
class WaryOscillator(Oscillator):
    """Feedback f does not turn it: it raises an alarm, soon, which fades slowly, and is the higher
    the faster it steps,

        φ̇ = ω,    τ ȧ = b - a,    b = f (ω / ω₁)²,    τ = τ↑ if b > a, else τ↓.

    So a law remembers that it stumbled, and a `WaryFoot` steps shorter and higher until it is over.

    Args:
        fast_rad_per_s: ω₁ [rad/s].
        rise_s: τ↑ [s].
        fall_s: τ↓ [s].

    Raises:
        TegotaeError: for a frequency or a time that is not above zero.

    Source: of this library; the alarm is an envelope with an attack and a release.

    Example:
        >>> import jax.numpy as jnp
        >>> wary = WaryOscillator(rise_s=0.5, fall_s=4.0)
        >>> state = wary.start(jnp.zeros(2))._replace(alarm_rad_per_s=jnp.ones(2))
        >>> wary.rate(state, jnp.full(2, wary.fast_rad_per_s), jnp.array([2.0, 0.0]))[1].tolist()
        [2.0, -0.25]
    """

    SIGNALS = (*Oscillator.SIGNALS, "alarm")
    STATE = ("alarm_rad_per_s",)

    fast_rad_per_s: float = positive(5.0)
    rise_s: float = positive(0.25)
    fall_s: float = positive(18.0)

    def start(self, phase_rad: jax.Array, alarm_rad_per_s: jax.Array | None = None) -> WaryState:
        """Return the state at phase φ [rad] and alarm [rad/s], calm by default, [(limbs,)
        lanes].
        """
        calm = jnp.zeros_like(phase_rad)
        alarm = calm if alarm_rad_per_s is None else alarm_rad_per_s
        return WaryState(maths.wrap_phase(phase_rad), alarm)

    def rate(
        self, state: WaryState, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> WaryState:
        """φ̇ = ω [rad/s], and ȧ [rad/s²]."""
        pace = omega * (1.0 / self.fast_rad_per_s)
        gap = feedback * pace * pace - state.alarm_rad_per_s
        time_s = jnp.where(gap > 0.0, self.rise_s, self.fall_s)
        return WaryState(omega + jnp.zeros_like(gap), gap / time_s)

    def phase(self, state: WaryState) -> jax.Array:
        """φ [rad]."""
        return state.phase

    def signals(self, state: WaryState) -> dict[str, jax.Array]:
        """sin φ, cos φ and a [rad/s]."""
        return {**super().signals(state), "alarm": state.alarm_rad_per_s}

    def settle(self, state: WaryState) -> WaryState:
        """φ modulo 2π."""
        return state._replace(phase=maths.wrap_phase(state.phase))

    def decay_per_s(self, omega: float) -> float:
        """Return the alarm's decay rate where it is faster than the oscillator's [1/s]."""
        return 1.0 / min(self.rise_s, self.fall_s)

    def in_units(self, time_s: float) -> WaryOscillator:
        """Return the same oscillator with a time unit of `time_s` [s]."""
        fast, rise, fall = self.fast_rad_per_s, self.rise_s, self.fall_s
        return WaryOscillator(
            fast_rad_per_s=fast / time_s, rise_s=rise * time_s, fall_s=fall * time_s
        )
