"""Oscillators that turn in a plane: their phase is the angle of their state there."""

from __future__ import annotations

from abc import abstractmethod
from collections import namedtuple
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import jax
import jax.numpy as jnp

from tegotae.parts import maths
from tegotae.parts._shapes import PerLimb, StateTree, Weights
from tegotae.parts.channels import Channel, Latest, RecordedFrame, State, Tick
from tegotae.parts.oscillators.base import Oscillator
from tegotae.parts.parameters import finite

Ranges = Mapping[str, tuple[float, float] | None]
"""Parameters by name, each with its bounds, or None for any number."""

NEAR = 0.05
"""Radius below which an input turns the state no faster than it does there."""


@dataclass(frozen=True, kw_only=True)
class Planar(Oscillator):
    """An oscillator in polar coordinates (φ, r) of a plane that is scaled to its limit cycle.

    Polar coordinates are exact, and their phase grows without a jump. Feedback f enters as

        φ̇ = … + turn · f + push · f · (b_y cos φ - b_x sin φ) / r
        ṙ = …             + push · f · (b_x cos φ + b_y sin φ)

    `turn` rotates the state, as in the phase oscillator. `push` is an additive input of the
    oscillator's own equations, b being the direction in which that input moves the state. Below
    r = 0.05 the division is by 0.05.

    A subclass is a frozen dataclass with `free`. Its `State` is made of what `STATE` names: a named
    tuple of the phase, the radius, and the rest.

    Args:
        pace: the free-running frequency as a multiple of ω.
        turn: how far feedback turns the state.
        push: how far feedback enters as an input.

    Raises:
        TegotaeError: for numbers out of their range.
    """

    SIGNALS = ("sin_phase", "cos_phase", "radius")
    STATE = ("radius",)

    RANGES: ClassVar[Ranges] = {"pace": (0.5, 2.0), "turn": None, "push": None}
    """What `Learned` trains."""
    State: ClassVar[Any]
    """Its state, (phase, *STATE)."""

    pace: float = finite(1.0, above=0.0, most=10.0)
    turn: float = finite(1.0)
    push: float = finite(0.0)

    def __init_subclass__(cls) -> None:
        cls.State = namedtuple(f"{cls.__name__}State", ("phase", *cls.STATE))  # type: ignore[misc]
        cls.State.__module__, cls.State.__qualname__ = cls.__module__, f"{cls.__qualname__}.State"

    @property
    def on_cycle(self) -> dict[str, float]:
        """What else than the phase the state has at or near the limit cycle, by name."""
        return {"radius": 1.0}

    def start(self, phase_rad: PerLimb, **rest: PerLimb) -> StateTree:
        """State at phase φ [rad]; at or near the limit cycle but for what is named."""
        near = {name: jnp.full_like(phase_rad, value) for name, value in self.on_cycle.items()}
        return self.State(maths.wrap_phase(phase_rad), **{**near, **rest})

    @abstractmethod
    def free(self, state: StateTree, sine: PerLimb, cosine: PerLimb, omega: PerLimb) -> StateTree:
        """Time derivative of the state without feedback, at frequency `omega` [rad/s]."""

    def input_axis(self) -> tuple[float, float]:
        """Direction b of the input in the plane."""
        return 0.0, 1.0

    def entering(
        self, state: StateTree, sine: jax.Array, cosine: jax.Array, feedback: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """What feedback adds to φ̇ [rad/s] and to ṙ [1/s]."""
        along, across = self.input_axis()
        pushed = self.push * feedback
        turned = pushed * (across * cosine - along * sine) / jnp.maximum(state[1], NEAR)
        return self.turn * feedback + turned, pushed * (along * cosine + across * sine)

    def rate(
        self, state: StateTree, omega: PerLimb, feedback: PerLimb, weights: Weights = ()
    ) -> StateTree:
        """Free motion and feedback together."""
        sine, cosine = maths.sin_cos(state[0])
        own = self.free(state, sine, cosine, self.pace * omega)
        turning, growing = self.entering(state, sine, cosine, feedback)
        return own._replace(phase=own.phase + turning, radius=own.radius + growing)

    def phase(self, state: StateTree) -> jax.Array:
        """φ [rad]."""
        return state[0]

    def sin_cos(self, state: StateTree) -> tuple[jax.Array, jax.Array]:
        """sin φ, cos φ."""
        return maths.sin_cos(state[0])

    def signals(self, state: StateTree) -> dict[str, jax.Array]:
        """sin φ, cos φ and r."""
        return {**super().signals(state), "radius": state[1]}

    def settle(self, state: StateTree) -> StateTree:
        """φ in [0, 2π) and r ≥ 0: a state that went through the origin is on the other side."""
        through = state.radius < 0.0
        phase = jnp.where(through, state.phase + 0.5 * maths.TWO_PI, state.phase)
        radius = jnp.abs(state.radius)
        return state._replace(phase=maths.wrap_phase(phase), radius=radius)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What else than the phase the state has, at the frames and at the apexes."""
        names = self.STATE
        return (
            *(State(n, f"State of the oscillator: {n}.", partial(_now, n)) for n in names),
            *(
                Latest(f"apex_{n}", f"{n} of the oscillator at an apex.", _is_apex, partial(_at, n))
                for n in names
            ),
        )


def _now(name: str, frame: RecordedFrame) -> jax.Array:
    return getattr(frame.lane.moment.oscillator, name)


def _is_apex(tick: Tick) -> jax.Array:
    return ~jnp.isnan(tick.contact.apex_share)


def _at(name: str, tick: Tick) -> jax.Array:
    """What it is at the apex: what it is at the tick's end, less what came since."""
    at_end: PerLimb = getattr(tick.end.oscillator, name)
    rate: PerLimb = getattr(tick.end.drive.rate, name)
    since = (1.0 - jnp.broadcast_to(tick.contact.apex_share, at_end.shape)) * tick.tick_s
    return at_end - since * rate
