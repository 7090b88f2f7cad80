"""Actuation: from the oscillator and its feedback to what the leg's actuator does."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, Weights
from tegotae.parts.channels import FORCE
from tegotae.parts.maths import TWO_PI
from tegotae.parts.parameters import finite, not_negative, positive
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.terms.network import Network


class Actuation(Term):
    """A term whose value is a force [N], before it is clipped to [0, α].

    Or it is a place of the foot, and `COMMANDS` says so; its value then has an axis of the commands
    before that of the limbs (`tegotae.parts.terms.foot`).

    Most actuations are smooth functions of the signals, and are sampled at the control ticks. One
    that switches full force on over a sector of the phase says so through `full_force`, so that
    the sector's edges take effect inside a tick.

    Source: paper III-A, "actuator signals"; the limits are those of III-B, 0 <= F_a <= α.
    """

    COMMANDS: tuple[str, ...] = FORCE
    """The quantities of the command; a body takes one kind of command (`Body.COMMANDS`)."""
    NEEDS_PHASE = False
    """True if the value is undefined without an oscillator's phase."""

    @property
    def commands_force(self) -> bool:
        """True if the command is a force."""
        return self.COMMANDS == FORCE

    @property
    def needs_phase(self) -> bool:
        """True if an oscillator's phase is required; so it is with `full_force`."""
        return self.NEEDS_PHASE or type(self).full_force is not Actuation.full_force

    def check(self, limbs: int, sets: int) -> None:
        """Raise `TegotaeError` if it does not fit this number of limbs, or of sets of weights."""

    def full_force(
        self, weights: Weights, phase_start: jax.Array, phase_end: jax.Array, omega: jax.Array
    ) -> tuple[jax.Array, jax.Array] | None:
        """Share of a phase path [rad] at full force, and that share's centre (0 ... 1); or None."""
        return None

    def paced(self, weights: Weights, command: jax.Array, omega: jax.Array) -> jax.Array:
        """Return the command at a frequency; unchanged where nothing depends on the frequency.

        Args:
            weights: its own, [(limbs,) lanes] each.
            command: its value, a force [N] or places [m], [(commands,) (limbs,) lanes].
            omega: ω [rad/s], [(limbs,) lanes].
        """
        return command

    @abstractmethod
    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the smooth part of the force [N], or another command of `COMMANDS`."""


@dataclass(frozen=True)
class Sector(Actuation):
    """Full force while the phase is in a sector (paper equation 6, with φ for the printed t):

        F_a = α  while  φ mod 2π ∈ [start, start + width),  else 0.

    Args:
        start_rad: where the sector starts [rad].
        width_rad: its width [rad].
        duration_s: a further width of `ω · duration_s` [s]: a sector that lasts a fixed time at
            the prescribed frequency.

    Raises:
        TegotaeError: for a non-finite value or a negative width.
    """

    start_rad: float = finite(1.75 * math.pi)
    width_rad: float = not_negative(0.1 * math.pi)
    duration_s: float = not_negative(0.0)

    def full_force(
        self, weights: Weights, phase_start: jax.Array, phase_end: jax.Array, omega: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Share of the path inside the sector and its centre; exact for paths below one turn."""
        width = self.width_rad + self.duration_s * omega
        return _within_sector(self.start_rad, width, phase_start, phase_end)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return no smooth part."""
        return jnp.zeros_like(signals["feedback"])


def _within_sector(
    start: Number, width: Number, phase_start: jax.Array, phase_end: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Share of a phase path inside a sector, and that share's centre."""
    low, high = jnp.minimum(phase_start, phase_end), jnp.maximum(phase_start, phase_end)
    # Phase past the sector's start, in its own turn; the path may reach into the next turn.
    first = low - start
    first = first - TWO_PI * jnp.floor(first * (1.0 / TWO_PI))
    path = high - low
    moves = path > 0.0
    inside = jnp.maximum(jnp.minimum(first + path, width) - first, 0.0)
    again = jnp.maximum(jnp.minimum(first + path - TWO_PI, width), 0.0)
    length = jnp.where(moves, path, 1.0)
    share = jnp.where(moves, (inside + again) / length, jnp.where(first < width, 1.0, 0.0))
    moment = inside * 0.5 * inside + again * (TWO_PI - first + 0.5 * again)
    centre = moment / (jnp.where(inside + again > 0.0, inside + again, 1.0) * length)
    centre = jnp.where(phase_end < phase_start, 1.0 - centre, centre)
    return share, jnp.where(moves & (share > 0.0), centre, 0.5)


@dataclass(frozen=True)
class FreeSector(Actuation):
    """Full force while the phase is in a sector whose place and width are trained:

        F_a = α  while  φ mod 2π ∈ [start, start + width),  else 0.

    A width is taken as 0 below 0, and as a whole turn above 2π.

    Source: of this library: the paper's sector (equation 6) with its two numbers free.

    Example:
        >>> FreeSector().weight_names
        (('start_rad',), ('width_rad',))
    """

    WEIGHTS = ("start_rad", "width_rad")

    def initial(self, key: jax.Array) -> jax.Array:
        """A start anywhere, and a quarter of a turn."""
        start = jax.random.uniform(key, (1,), maxval=TWO_PI)
        return jnp.concatenate([start, jnp.full((1,), 0.25 * TWO_PI)])

    def full_force(
        self, weights: Weights, phase_start: jax.Array, phase_end: jax.Array, omega: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Share of the path inside the sector and its centre; exact for paths below one turn."""
        width = jnp.clip(weights[1], 0.0, TWO_PI)
        return _within_sector(weights[0], width, phase_start, phase_end)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return no smooth part."""
        return jnp.zeros_like(signals["feedback"])


@dataclass(frozen=True)
class FreeSectorAndReflex(FreeSector):
    """The sum of a trained sector and a reflex of trained scale s [N], clipped like either:

        F_a = (α  while φ is in the sector,  else 0) - s min(0, f).

    Source: of this library: paper equations 6 and 7 with their three numbers free.

    Example:
        >>> FreeSectorAndReflex().n_weights
        3
    """

    READS = ("feedback",)
    WEIGHTS = (*FreeSector.WEIGHTS, "newtons_per_feedback")

    def initial(self, key: jax.Array) -> jax.Array:
        """Return the sector's initial weights, and a unit scale."""
        return jnp.concatenate([super().initial(key), jnp.ones((1,))])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the reflex part."""
        return -weights[2] * jnp.minimum(signals["feedback"], 0.0)


@dataclass(frozen=True)
class Reflex(Actuation):
    """Reaction to falling Tegotae, `F_a = -s min(0, f)` [N] (paper equation 7).

    The paper takes the feedback f [rad/s] as newtons, one for one; the scale s makes that a choice.

    Args:
        newtons_per_feedback: the scale s [N s/rad].

    Raises:
        TegotaeError: for a scale that is not positive.

    Example:
        >>> Reflex()((), Signals({"feedback": jnp.array([-2.0, 3.0])})).tolist()
        [2.0, -0.0]
    """

    READS = ("feedback",)

    newtons_per_feedback: float = positive(1.0)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-s min(0, f)."""
        return _reflex(signals["feedback"], self.newtons_per_feedback)


def _reflex(feedback: jax.Array, newtons: float) -> jax.Array:
    force = -jnp.minimum(feedback, 0.0)
    return force if newtons == 1.0 else newtons * force  # one for one is no operation


@dataclass(frozen=True)
class SectorAndReflex(Sector):
    """The sum of sector and reflex [N], clipped like either:

        F_a = (α  while φ is in the sector,  else 0) - s min(0, f).

    Source: paper equations 6 and 7, for the observation [φ, f] of IV-B. How the two go together,
    the paper leaves open.

    Args:
        start_rad: as of `Sector`.
        width_rad: as of `Sector`.
        duration_s: as of `Sector`.
        newtons_per_feedback: as of `Reflex`.
    """

    READS = ("feedback",)

    newtons_per_feedback: float = positive(1.0)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the reflex part."""
        return _reflex(signals["feedback"], self.newtons_per_feedback)


def with_vanilla_settings(
    actuation: Actuation,
    *,
    start_rad: float | None = None,
    duration_s: float | None = None,
    newtons_per_feedback: float | None = None,
) -> Actuation:
    """Return an actuation with other numbers of its sector and reflex; a learned one has none.

    Args:
        actuation: as it is.
        start_rad: where the sector starts [rad]; as it is by default.
        duration_s: how long the sector lasts at the prescribed frequency [s], in place of its width
            in phase; as it is by default.
        newtons_per_feedback: the reflex's scale [N s/rad]; as it is by default.

    Raises:
        TegotaeError: for a number that the actuation does not allow.

    Example:
        >>> with_vanilla_settings(Sector(), duration_s=0.06).width_rad
        0.0
        >>> with_vanilla_settings(Reflex(), duration_s=0.06) == Reflex()
        True
    """
    if isinstance(actuation, Sector) and start_rad is not None:
        actuation = replace(actuation, start_rad=start_rad)
    if isinstance(actuation, Sector) and duration_s is not None:
        actuation = replace(actuation, width_rad=0.0, duration_s=duration_s)
    if isinstance(actuation, Reflex | SectorAndReflex) and newtons_per_feedback is not None:
        actuation = replace(actuation, newtons_per_feedback=newtons_per_feedback)
    return actuation


@dataclass(frozen=True)
class LearnedActuation(Network, Actuation):
    """A learned actuation T: a network whose output is the force [N].

    Its inputs are {phase}, {feedback} or {phase, feedback}; in the single network without
    oscillator they are what is sensed.

    Source: paper III-A, the network T of Fig. 1; the single network is that of IV-A.

    Example:
        >>> LearnedActuation(("phase", "feedback"), hidden=4).n_weights
        20
    """


@dataclass(frozen=True)
class CommandedForce(Actuation):
    """A force `F_a = w` [N] that is commanded from outside: the weights are the commands.

    Source: of this library; it is the action of agents and of policies in the benchmark.

    Example:
        >>> CommandedForce().n_weights
        1
    """

    @property
    def n_weights(self) -> int:
        """Number of weights: one per command."""
        return len(self.COMMANDS)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the command unchanged."""
        return weights[0] if self.n_weights == 1 else jnp.stack(list(weights))
