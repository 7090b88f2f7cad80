"""Contract of a controller's term: an elementwise function of weights and signals. Vanilla terms:
action A, reaction R and gain G (paper equations 2 to 5)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import Number, PerCommand, PerLimb, Weights
from tegotae.parts.maths import sin_cos
from tegotae.parts.parameters import positive
from tegotae.parts.weight_names import Weighted


@dataclass(frozen=True)
class Signals:
    """All that a term may read at one instant; every array has the shape of the lanes.

    `values` holds SI quantities by name: what the body senses (such as `spring_force` [N] and
    `velocity` [m/s]), `sin_phase` and `cos_phase` where there is an oscillator, and, for the
    actuation, the Tegotae `feedback` [rad/s]. `scales` makes them dimensionless.

    Args:
        values: arrays [(limbs,) lanes] by the names of the signals.
        scales: by the same names, in the signal's units; 1 for those that are not there.

    Example:
        >>> Signals({"spring_force": jnp.array([3.0])}, {"spring_force": 1.5}).dimensionless(
        ...     "spring_force"
        ... ).tolist()
        [2.0]
    """

    values: dict[str, PerLimb]
    scales: Mapping[str, Number] = field(default_factory=dict[str, Number])

    def __getitem__(self, name: str) -> PerLimb:
        return self.values[name]

    def dimensionless(self, name: str) -> PerLimb:
        """Return the quantity over its scale, the input of a network."""
        value, scale = self.values[name], self.scales.get(name, 1.0)
        # A scale may be one a lane.
        return value / (jnp.broadcast_to(scale, value.shape) if jnp.ndim(scale) else scale)

    def adding(self, scale: Number | None = None, **values: PerLimb) -> Signals:
        """Return the same signals and some more; `scale` belongs to each of the added ones."""
        scales = self.scales if scale is None else {**self.scales, **dict.fromkeys(values, scale)}
        return Signals({**self.values, **values}, scales)


class Term(Weighted, ABC):
    """One of A′, R, G or T: a frozen dataclass, called with its weights and the signals.

    A new term is a subclass with `reads`, `n_weights`, `initial` and `__call__`, and with
    `weight_names` if its weights are to have names in files and in C; nothing else needs to know of
    it. `tegotae.check` names what is missing.

    Source: paper equation 4, `f = G A′ R`, and Fig. 1 for T.
    """

    READS: tuple[str, ...] = ()
    """Result of `reads`, where it is constant."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the signals that the term reads."""
        return self.READS

    @abstractmethod
    def __call__(self, weights: Weights, signals: Signals) -> PerCommand:
        """Return the term's value, elementwise.

        Args:
            weights: n_weights arrays, each like the lanes.
            signals: what it `reads`, arrays [(limbs,) lanes].

        Returns:
            The value, [(limbs,) lanes]; of an actuation of several commands [commands, limbs,
            lanes].
        """


@dataclass(frozen=True)
class VanillaAction(Term):
    """`A′(φ) = C′(φ) = -cos φ`, from the belief C(φ) = -sin φ that stance has sin φ < 0.

    Source: paper equation 2; the belief is in IV-A.

    Example:
        >>> from tegotae.parts.terms import Signals
        >>> VanillaAction()((), Signals({"cos_phase": jnp.array([1.0, -1.0])})).tolist()
        [-1.0, 1.0]
    """

    READS = ("cos_phase",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-cos φ."""
        return -signals["cos_phase"]


@dataclass(frozen=True)
class OffsetAction(Term):
    """`A′(φ) = -(cos φ + o)` with a trained offset o, the action of the ORC oscillators.

    With the load as reaction and a constant gain it is the law φ̇ = ω - c N (cos φ + o).

    Source: the oscillators of MIT's Biomimetic Robotics Lab's ORCAgym, whose `osc_offset` it is.

    Example:
        >>> OffsetAction().weight_names
        (('offset',),)
    """

    READS = ("cos_phase",)
    WEIGHTS = ("offset",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-(cos φ + o)."""
        return -(signals["cos_phase"] + weights[0])


@dataclass(frozen=True)
class ShiftedAction(Term):
    """`A′(φ) = -(cos(φ - p) + o)` with a trained place p [rad] and offset o.

    It is `OffsetAction` where the actuation is tied to a phase, so that the place is no choice of
    where the phase is zero.

    Source: of this library; it is the action that ten trainings on four legs agree on.

    Example:
        >>> ShiftedAction().weight_names
        (('place_rad',), ('offset',))
    """

    READS = ("sin_phase", "cos_phase")
    WEIGHTS = ("place_rad", "offset")

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-(cos(φ - p) + o)."""
        sine, cosine = sin_cos(weights[0])
        return -(signals["cos_phase"] * cosine + signals["sin_phase"] * sine + weights[1])


@dataclass(frozen=True)
class TwoHarmonicsAction(Term):
    """`A′(φ) = -(cos φ + o + a cos 2φ + b sin 2φ)`: `OffsetAction` with a second harmonic.

    Source: of this library; much of what one harmonic leaves of learned actions is of the second.

    Example:
        >>> TwoHarmonicsAction().weight_names
        (('offset',), ('cos_2',), ('sin_2',))
    """

    READS = ("sin_phase", "cos_phase")
    WEIGHTS = ("offset", "cos_2", "sin_2")

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """-(cos φ + o + a cos 2φ + b sin 2φ)."""
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        twice = weights[1] * (2.0 * cosine * cosine - 1.0) + weights[2] * (2.0 * sine * cosine)
        return -(cosine + weights[0] + twice)


@dataclass(frozen=True)
class UnitAction(Term):
    """`A′ = 1`: what is sensed reaches the oscillator as it is, `f = G · R(s)` [rad/s].

    Source: of this library; with it a sensed load is a plain input, as of a Matsuoka neuron.
    """

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """1."""
        return jnp.ones_like(next(iter(signals.values.values())))


@dataclass(frozen=True)
class VanillaReaction(Term):
    """`R(s) = S(s) = F_k`, the spring force [N] (paper equation 2 and [24], [30])."""

    READS = ("spring_force",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """F_k [N]."""
        return signals["spring_force"]


@dataclass(frozen=True)
class ReversingReaction(Term):
    """`R(N) = 1 - k N`, a reaction that changes sign at the load N = 1/k, in weights of the body.

    In flight it lets the feedback act with one sign, and in deep stance with the other: an
    oscillator that it slows down can park in flight until touchdown.

    Source: of this library: the one number that vanilla feedback lacks.

    Example:
        >>> ReversingReaction()((jnp.array(2.0),), Signals({"spring_force": jnp.array(1.0)})).item()
        -1.0
    """

    READS = ("spring_force",)
    WEIGHTS = ("per_load",)

    def initial(self, key: jax.Array) -> jax.Array:
        """k = 1: a change of sign at the body's weight."""
        return jnp.ones((1,))

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """1 - k N."""
        return 1.0 - weights[0] * signals.dimensionless("spring_force")


@dataclass(frozen=True)
class DecayingReaction(Term):
    """`R(N) = e^(-k N)`, a reaction that falls with the load N, in weights of the body.

    A negative k is taken as 0.

    Source: of this library.

    Example:
        >>> zero = Signals({"spring_force": jnp.array(0.0)})
        >>> DecayingReaction()((jnp.array(2.0),), zero).item()
        1.0
    """

    READS = ("spring_force",)
    WEIGHTS = ("per_load",)

    def initial(self, key: jax.Array) -> jax.Array:
        """k = 1."""
        return jnp.ones((1,))

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """e^(-k N)."""
        return jnp.exp(-jnp.maximum(weights[0], 0.0) * signals.dimensionless("spring_force"))


@dataclass(frozen=True)
class SaturatingReaction(Term):
    """`R(N) = 1 - k N / (1 + s N)`, which changes with the load N, in weights of the body, and
    levels off; with s = 0 it is `ReversingReaction`. A negative s is taken as 0.

    Source: of this library.

    Example:
        >>> one = Signals({"spring_force": jnp.array(1.0)})
        >>> SaturatingReaction()((jnp.array(3.0), jnp.array(1.0)), one).item()
        -0.5
    """

    READS = ("spring_force",)
    WEIGHTS = ("per_load", "saturation")

    def initial(self, key: jax.Array) -> jax.Array:
        """k = s = 1."""
        return jnp.ones((2,))

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """1 - k N / (1 + s N)."""
        load = signals.dimensionless("spring_force")
        return 1.0 - weights[0] * load / (1.0 + jnp.maximum(weights[1], 0.0) * load)


@dataclass(frozen=True)
class TiltReaction(Term):
    """`R = (ρ² + θ² + ρ̇² + θ̇²) / ρ₁²`, how far the torso tilts and how fast, at least 0.

    Args:
        tilt_rad: ρ₁, the tilt at which R = 1 [rad]; the rates are in the controller's time.

    Raises:
        TegotaeError: for a tilt that is not above zero.

    Source: of this library.

    Example:
        >>> level = dict.fromkeys(TiltReaction.READS, jnp.array(0.0))
        >>> tilted = Signals({**level, "pitch": jnp.array(-0.1)})
        >>> round(TiltReaction()((), tilted).item(), 4)
        1.0
    """

    READS = ("roll", "pitch", "roll_rate", "pitch_rate")

    tilt_rad: float = positive(0.1)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """R."""
        roll, pitch, roll_rate, pitch_rate = (signals[name] for name in self.READS)
        squares = roll * roll + pitch * pitch + roll_rate * roll_rate + pitch_rate * pitch_rate
        return squares * (1.0 / self.tilt_rad**2)


@dataclass(frozen=True)
class SpeedReaction(Term):
    """`R = v*`, the commanded speed [m/s]: with a `UnitAction` legs step the faster, the faster
    they are to go, φ̇ = ω + σ v*.

    Source: of this library; animals and Raibert's machines step faster at higher speeds.
    """

    READS = ("commanded_speed",)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """v* [m/s]."""
        return signals["commanded_speed"]


@dataclass(frozen=True)
class ConstantGain(Term):
    """`G = σ`, one trained number (paper equation 2).

    With the vanilla terms σ is in rad/(s N).

    Args:
        start: the σ that training starts from.
    """

    WEIGHTS = ("sigma",)

    start: float = 1.0

    def initial(self, key: jax.Array) -> jax.Array:
        """σ = `start`."""
        return jnp.full((1,), self.start)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """σ."""
        return weights[0]
