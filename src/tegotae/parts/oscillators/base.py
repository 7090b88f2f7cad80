"""Contract of an oscillator that Tegotae feedback can entrain, and the paper's oscillator."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, StateTree, Weights
from tegotae.parts.channels import Channel, Latest, RecordedFrame, State, Tick
from tegotae.parts.weight_names import Weighted

_MOST_DECAY_PER_TICK = 0.3
"""Decay of an oscillator's state over a tick up to which the integrators follow it well."""


class Oscillator(Weighted, ABC):
    """A rhythm generator: a frozen dataclass without state of its own.

    Its state is a pytree of arrays (a NamedTuple, say), passed in and out; every method is
    elementwise. A phase is the usual thing to have, and not a must: an oscillator without one
    leaves `phase` alone, and names and gives its own `signals`.

    Source: paper equation 5, whose φ̇ is the `rate` of the usual one, `PhaseOscillator`.
    """

    SIGNALS: tuple[str, ...] = ("sin_phase", "cos_phase")
    """Names of what `signals` returns: what terms and couplings may read of it."""
    READS: tuple[str, ...] = ()
    """Names of the senses that its rate reads; `rate` takes signals where there are any."""
    STATE: tuple[str, ...] = ()
    """Entries of the state beside the phase, and of its rate, which `start` takes and `channels`
    records, each by its own name and, at an apex, as `apex_` and its name. An oscillator that names
    all of its state here can be started anywhere on its limit cycle."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of the state beside the phase, at the frames and at the apexes."""
        names = self.STATE
        return (
            *(State(n, f"State of the oscillator: {n}.", partial(_state_entry, n)) for n in names),
            *(
                Latest(
                    f"apex_{n}",
                    f"{n} of the oscillator at an apex.",
                    _is_apex,
                    partial(_entry_at_apex, n),
                )
                for n in names
            ),
        )

    @abstractmethod
    def start(self, phase_rad: PerLimb) -> StateTree:
        """Return the state at phase `phase_rad` [rad]; without a phase, any state that it leads to.

        What `STATE` names are further arguments; without them it is at or near the limit cycle.
        """

    @abstractmethod
    def rate(
        self,
        state: StateTree,
        omega: PerLimb,
        feedback: PerLimb,
        weights: Weights = (),
    ) -> StateTree:
        """Time derivative of the state.

        Args:
            state: a pytree of arrays [(limbs,) lanes].
            omega: prescribed frequency ω [rad/s], like the lanes.
            feedback: Tegotae feedback and the coupling's input f [rad/s], like the lanes.
            weights: of an oscillator that has some, n_weights arrays, each like the lanes.
        """

    def phase(self, state: StateTree) -> PerLimb:
        """Return the phase φ [rad]; it may be unwrapped within one control tick."""
        raise TegotaeError(f"{type(self).__name__} has no phase")

    def sin_cos(self, state: StateTree) -> tuple[PerLimb, PerLimb]:
        """Return the sine and cosine of the phase."""
        return maths.sin_cos(self.phase(state))

    def signals(self, state: StateTree) -> dict[str, PerLimb]:
        """Return the signals that terms and couplings may read, by the names of `SIGNALS`."""
        sine, cosine = self.sin_cos(state)
        return {"sin_phase": sine, "cos_phase": cosine}

    def settle(self, state: StateTree) -> StateTree:
        """Return the same state in the form kept between ticks (such as a phase wrapped to [0,
        2π)).
        """
        return state

    @property
    def has_phase(self) -> bool:
        """True if the oscillator has a phase."""
        return type(self).phase is not Oscillator.phase

    @property
    def is_open(self) -> bool:
        """True if all of the state can be set from outside, so that an orbit can be entered by
        it."""
        leaves = jax.tree.leaves(self.start(jnp.zeros(1)))
        return self.has_phase and len(leaves) == 1 + len(self.STATE)

    def in_units(self, time_s: float) -> Oscillator:
        """Return the same oscillator with a time unit of `time_s` [s].

        Raises:
            TegotaeError: for one with rates of its own; a subclass that knows how scales them.
        """
        raise TegotaeError(
            f"a {type(self).__name__} has rates of its own, which units do not scale; export "
            "controllers with phase oscillators, or wary ones"
        )

    def decay_per_s(self, omega: float) -> float:
        """Return an upper bound of its fastest decay rate [1/s] at frequency ω [rad/s]."""
        return 0.0

    def check_tick(self, omega: float, tick_s: float) -> None:
        """Raise `TegotaeError` if the control period is too long for it at frequency ω [rad/s]."""
        decay = self.decay_per_s(omega)
        if decay * tick_s > _MOST_DECAY_PER_TICK:
            raise TegotaeError(
                f"{type(self).__name__} at omega {omega:g} is too stiff for ticks of {tick_s:g} s: "
                f"its state decays at {decay:.3g} 1/s; use ticks of at most "
                f"{_MOST_DECAY_PER_TICK / decay:.2g} s, or milder parameters"
            )


class PhaseState(NamedTuple):
    """Phase φ [rad]."""

    phase: jax.Array


@dataclass(frozen=True)
class PhaseOscillator(Oscillator):
    """A single Kuramoto phase oscillator, `φ̇ = ω + f` (paper equation 5; f holds the gain once).

    Args:
        slowest_rad_per_s: optional floor of the phase rate. The paper has none: strong feedback
            may stop or reverse the phase.

    Example:
        >>> import jax.numpy as jnp
        >>> oscillator = PhaseOscillator()
        >>> oscillator.rate(oscillator.start(jnp.zeros(1)), jnp.array([5.0]), jnp.array([-2.0]))
        PhaseState(phase=Array([3.], dtype=float32))
    """

    slowest_rad_per_s: float | None = None

    def start(self, phase_rad: jax.Array) -> PhaseState:
        """Return the state at phase φ [rad]."""
        return PhaseState(maths.wrap_phase(phase_rad))

    def rate(
        self, state: PhaseState, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> PhaseState:
        """φ̇ = ω + f [rad/s]."""
        rate = omega + feedback
        if self.slowest_rad_per_s is not None:
            rate = jnp.maximum(rate, self.slowest_rad_per_s)
        return PhaseState(rate)

    def phase(self, state: PhaseState) -> jax.Array:
        """φ [rad]."""
        return state.phase

    def in_units(self, time_s: float) -> PhaseOscillator:
        """Return the same oscillator with a time unit of `time_s` [s]."""
        slowest = self.slowest_rad_per_s
        return PhaseOscillator(None if slowest is None else slowest / time_s)

    def settle(self, state: PhaseState) -> PhaseState:
        """φ modulo 2π: a growing phase would lose float32 digits."""
        return PhaseState(maths.wrap_phase(state.phase))


def _state_entry(name: str, frame: RecordedFrame) -> jax.Array:
    return getattr(frame.lane.moment.oscillator, name)


def _is_apex(tick: Tick) -> jax.Array:
    return ~jnp.isnan(tick.contact.apex_share)


def _entry_at_apex(name: str, tick: Tick) -> jax.Array:
    """Return an entry at the apex: its value at the tick's end, less its change since."""
    at_end: PerLimb = getattr(tick.end.oscillator, name)
    rate: PerLimb = getattr(tick.end.drive.rate, name)
    since = (1.0 - jnp.broadcast_to(tick.contact.apex_share, at_end.shape)) * tick.tick_s
    return at_end - since * rate
