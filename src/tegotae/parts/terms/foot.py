"""Commanded foot positions of a walking leg: along an ellipse, by networks, or by their sum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import AnyArray, Weights
from tegotae.parts.channels import FOOT, FOOT_ASIDE
from tegotae.parts.parameters import a_part, finite, not_negative, positive
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals
from tegotae.parts.terms.network import Network
from tegotae.parts.weight_names import WeightName, inside

_SOON = 4.0
"""An alarm of the inverse of this lifts feet as high as they go."""


@dataclass(frozen=True)
class EllipticFoot(Actuation):
    """The foot goes round two half ellipses, backwards while it presses down (Owaki et al. 2013):

        x = -B cos(φ + δ),    z = A sin φ  if  sin φ > 0,  else  A′ sin φ.

    Args:
        stride_m: half of the stride B [m].
        lift_m: how high the foot is lifted A [m].
        press_m: how deep it presses A′ [m].
        shift_rad: by how much the fore and aft motion leads δ [rad].

    Raises:
        TegotaeError: for a number that is not finite, or a length below zero.

    Reference: D. Owaki, T. Kano, K. Nagasawa, A. Tero, A. Ishiguro, Simple robot suggests physical
    interlimb communication is essential for quadruped walking, J. R. Soc. Interface 10 (2013).
    """

    COMMANDS = FOOT
    NEEDS_PHASE = True
    READS = ("sin_phase", "cos_phase")

    stride_m: float = not_negative(0.2)
    lift_m: float = not_negative(0.12)
    press_m: float = not_negative(0.03)
    shift_rad: float = finite(0.0)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        return self.place(signals["sin_phase"], signals["cos_phase"])

    def place(self, sine: AnyArray, cosine: AnyArray) -> jax.Array:
        """Forward and up [m], [2, ...], where the phase has this sine and cosine, [...] each."""
        ahead = math.cos(self.shift_rad) * cosine - math.sin(self.shift_rad) * sine
        height = jnp.where(sine > 0.0, self.lift_m, self.press_m)
        return jnp.stack([-self.stride_m * ahead, height * sine])


@dataclass(frozen=True)
class TunedFoot(Actuation):
    """An `EllipticFoot` whose four numbers are weights: stride B, lift A, press A′, shift δ.

    A lane, or a training, can have an ellipse of its own.

    Args:
        start: the ellipse to start from.

    Raises:
        TegotaeError: for what is no ellipse.

    Source: of this library; the ellipse is that of `EllipticFoot`.

    Example:
        >>> TunedFoot().weight_names
        (('stride_m',), ('lift_m',), ('press_m',), ('shift_rad',))
    """

    COMMANDS = FOOT
    NEEDS_PHASE = True
    READS = EllipticFoot.READS
    WEIGHTS = ("stride_m", "lift_m", "press_m", "shift_rad")

    start: EllipticFoot = a_part(EllipticFoot, "an EllipticFoot", EllipticFoot)

    def initial(self, key: jax.Array) -> jax.Array:
        """Return the numbers of the ellipse to start from, and zeros for all others, for any
        key.
        """
        return jnp.array([getattr(self.start, name, 0.0) for name in self.WEIGHTS])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        stride, lift, press, shift = (weights[i] for i in range(4))
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        ahead = jnp.cos(shift) * cosine - jnp.sin(shift) * sine
        return jnp.stack([-stride * ahead, jnp.where(sine > 0.0, lift, press) * sine])


@dataclass(frozen=True)
class BalancedFoot(TunedFoot):
    """A `TunedFoot` that a leg moves by how far its own corner of the torso is up or turned:

        x = (1 + k_ψ ψ) x_ellipse,    z = z_ellipse + k_ρ ρ + k_ρ' ρ̇ + k_θ θ.

    ρ is the torso's roll and ψ its heading as the leg's side has them, up and to that side; θ its
    pitch as the leg's end has it, up. With gains above zero a leg is shorter where it is too high,
    and steps further where the torso turns to it.

    Args:
        start: the ellipse to start from; the gains start at zero.

    Raises:
        TegotaeError: for what is no ellipse.

    Source: of this library; a clock with a roll reflex is the least law that a robot's stable trot
    needs.

    Example:
        >>> BalancedFoot().n_weights
        8
    """

    READS = (*TunedFoot.READS, "side_roll", "side_roll_rate", "end_pitch", "side_yaw")
    WEIGHTS = (*TunedFoot.WEIGHTS, "roll_m", "roll_rate_ms", "pitch_m", "yaw")

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        ahead, up = super().__call__(weights, signals)
        roll, roll_rate, pitch, yaw = (weights[i] for i in range(4, 8))
        level = roll * signals["side_roll"] + roll_rate * signals["side_roll_rate"]
        up = up + level + pitch * signals["end_pitch"]
        return jnp.stack([ahead * (1.0 + yaw * signals["side_yaw"]), up])


@dataclass(frozen=True)
class SteppingFoot(BalancedFoot):
    """A `BalancedFoot` that also steps to the side where the torso falls, to the left

        y = -k_y ρ - k_y' ρ̇.

    ρ is the torso's roll, its left side up. With gains above zero a swinging foot lands there, and
    a standing one pushes the torso back.

    Args:
        start: the ellipse to start from; the gains start at zero.

    Raises:
        TegotaeError: for what is no ellipse.

    Source: of this library; foot placement as in M. H. Raibert, Legged Robots That Balance (1986),
    from an IMU's roll in place of the speed to the side.

    Example:
        >>> SteppingFoot().n_weights, SteppingFoot().COMMANDS
        (10, ('foot_x', 'foot_z', 'foot_y'))
    """

    COMMANDS = FOOT_ASIDE
    READS = (*BalancedFoot.READS, "roll", "roll_rate")
    WEIGHTS = (*BalancedFoot.WEIGHTS, "aside_m", "aside_rate_ms")

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward, up and to the left [m], [3, limbs, lanes]."""
        aside = weights[8] * signals["roll"] + weights[9] * signals["roll_rate"]
        return jnp.concatenate([super().__call__(weights, signals), -aside[None]])


@dataclass(frozen=True)
class PacedFoot(BalancedFoot):
    """A `BalancedFoot` whose stride grows with the frequency, and is none at ω₀:

        B(ω) = B (1 - ω₀ / ω),    0 for ω ≤ ω₀.

    So it steps on the spot up to ω₀. Above, 2 B (ω - ω₀) / π, its mean speed while it bears, is a
    line.

    Args:
        start: the ellipse to start from; the gains and ω₀ start at zero.

    Raises:
        TegotaeError: for what is no ellipse.

    Source: of this library; animals change stride length and frequency together: R. McN.
    Alexander, Principles of Animal Locomotion (2003).

    Example:
        >>> PacedFoot().weight_names[-1]
        ('still_rad_per_s',)
    """

    WEIGHTS = (*BalancedFoot.WEIGHTS, "still_rad_per_s")

    def paced(self, weights: Weights, command: jax.Array, omega: jax.Array) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes], at a frequency [rad/s]."""
        still = weights[8]
        share = jnp.where(omega > jnp.maximum(still, 0.0), 1.0 - still / omega, 0.0)
        return jnp.stack([command[0] * share, command[1]])


@dataclass(frozen=True)
class WaryFoot(PacedFoot):
    """A `PacedFoot` that makes shorter and higher steps while its oscillator is alarmed:

        stride B(ω) / (1 + a),    lift A (1 + r min(4 a, 1)).

    Its frequency stays as commanded. The alarm a is that of a `WaryOscillator`, in the controller's
    time.

    Args:
        start: the ellipse to start from; the gains, ω₀ and r start at zero.

    Raises:
        TegotaeError: for what is no ellipse.

    Source: of this library.

    Example:
        >>> WaryFoot().n_weights, WaryFoot().reads[-1]
        (10, 'alarm')
    """

    READS = (*PacedFoot.READS, "alarm")
    WEIGHTS = (*PacedFoot.WEIGHTS, "higher")

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        alarm = jnp.maximum(signals["alarm"], 0.0)
        stride, lift, *remaining = weights
        lift = lift * (1.0 + remaining[-1] * jnp.minimum(_SOON * alarm, 1.0))
        ahead, up = super().__call__([stride, lift, *remaining], signals)
        return jnp.stack([ahead / (1.0 + alarm), up])


@dataclass(frozen=True)
class PlacedFoot(Actuation):
    """A foot that its oscillator places, and that levels the torso:

        x = x_f + x₀,    y = y_f,    z = A max(sin φ, 0) + A′ min(sin φ, 0) + h
            + k_ρ ρ + k_ρ' ρ̇ + k_θ θ + k_θ' θ̇.

    A standing foot presses down by A′, since its servos yield to the load: else it would be on the
    ground before its swing is over. ρ is the torso's roll as the leg's side has it, up, and θ its
    pitch as the leg's end has it, up: with gains above zero a leg is shorter where it is too high.

    Args:
        lift_m: how high a foot is lifted A to start from [m]; all others start at zero.

    Raises:
        TegotaeError: for a lift that is negative.

    Reference: M. H. Raibert, Legged Robots That Balance (1986); x_f and y_f are those of a
    `FootholdOscillator`.

    Example:
        >>> PlacedFoot().n_weights, PlacedFoot().COMMANDS
        (8, ('foot_x', 'foot_z', 'foot_y'))
    """

    COMMANDS = FOOT_ASIDE
    NEEDS_PHASE = True
    TILT = ("side_roll", "side_roll_rate", "end_pitch", "end_pitch_rate")
    READS = ("sin_phase", "foothold_x", "foothold_y", *TILT)
    WEIGHTS = (
        *("lift_m", "ahead_m", "raise_m", "roll_m", "roll_rate_ms", "pitch_m", "pitch_rate_ms"),
        "press_m",
    )

    lift_m: float = not_negative(0.2)

    def initial(self, key: jax.Array) -> jax.Array:
        """Return the lift, and zeros for all others, for any key."""
        return jnp.array([self.lift_m, *[0.0] * (self.n_weights - 1)])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward, up and to the left [m], [3, limbs, lanes]."""
        lift, ahead, up, *gains, press = (weights[i] for i in range(self.n_weights))
        for gain, name in zip(gains, self.TILT, strict=True):
            up = up + gain * signals[name]
        sine = signals["sin_phase"]
        up = up + jnp.where(sine > 0.0, lift, press) * sine
        return jnp.stack([signals["foothold_x"] + ahead, up, signals["foothold_y"]])


@dataclass(frozen=True)
class LearnedFoot(Actuation):
    """A learned place of the foot: a network for each of its two coordinates.

    Their outputs are in `reach_m`, a length that stands for the size of the ellipse.

    Args:
        inputs: names of signals, as of any network.
        hidden: neurons of each of the two networks.
        reach_m: by what the outputs are multiplied [m].

    Raises:
        TegotaeError: for what a network refuses, or a reach that is not positive.

    Source: of this library; the learned actuation T of the paper (III-A), for a foot's place.

    Example:
        >>> LearnedFoot(("phase", "feedback"), hidden=4).n_weights
        40
    """

    COMMANDS = FOOT

    inputs: tuple[str, ...]
    hidden: int
    reach_m: float = positive(0.1)

    def __post_init__(self) -> None:
        super().__post_init__()
        Network(self.inputs, self.hidden)

    @property
    def _network(self) -> Network:
        return Network(self.inputs, self.hidden)

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals that the networks read."""
        return self._network.reads

    @property
    def n_weights(self) -> int:
        """Number of weights of two networks."""
        return 2 * self._network.n_weights

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of the weights of each command's network."""
        names = self._network.weight_names
        return tuple(path for name in FOOT for path in inside((name,), names))

    def initial(self, key: jax.Array) -> jax.Array:
        """Return random weights to start training from, shape [n_weights]."""
        return jnp.concatenate([self._network.initial(subkey) for subkey in jax.random.split(key)])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        n = self._network.n_weights
        places = [self._network(part, signals) for part in (weights[:n], weights[n:])]
        return self.reach_m * jnp.stack(places)


class AddedToEllipse(Actuation):
    """Sum of an ellipse, `around`, and a learned displacement of the foot.

    Its random weights to start from add nothing: training begins with the ellipse.
    """

    NEEDS_PHASE = True

    around: EllipticFoot

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals that the ellipse and the networks read."""
        return tuple(dict.fromkeys((*self.around.reads, *super().reads)))

    def initial(self, key: jax.Array) -> jax.Array:
        """Return the weights of the networks, zero for their outputs, shape [n_weights]."""
        outputs = jnp.array(["output" in path for path in self.weight_names])
        return jnp.where(outputs, 0.0, super().initial(key))


@dataclass(frozen=True)
class CorrectedFoot(AddedToEllipse, LearnedFoot):
    """An ellipse, and what two networks add to it.

    Its random weights to start from add nothing: training begins with the ellipse.

    Args:
        around: the ellipse.

    Raises:
        TegotaeError: for what a `LearnedFoot` refuses, or what is no ellipse.

    Source: of this library; the ellipse is that of `EllipticFoot`.

    Example:
        >>> CorrectedFoot(("phase",), hidden=4, around=EllipticFoot(stride_m=0.3)).n_weights
        32
    """

    around: EllipticFoot = a_part(EllipticFoot, "an EllipticFoot", EllipticFoot)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        return self.around(weights, signals) + super().__call__(weights, signals)
