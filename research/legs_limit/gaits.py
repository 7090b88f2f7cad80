"""Gaits in open loop on the quadruped, as vectors of numbers: what a search for the limit varies.

Each foot goes round C's ellipse at a phase that is any Fourier series in time, or round an ellipse
of its own with such a timing and series added to its place. No leg feels anything. A vector is
decoded to the weights of four such legs and a frequency.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.parts.bodies import Body
from tegotae.parts.channels import FOOT
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import EllipticFoot, Signals
from tegotae.parts.terms.actuation import Actuation
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.vanilla import legged_named

REACH_M = 0.4
"""Largest distance of a foot ahead of or behind its hip [l0]."""
HEIGHTS_M = (-0.2, 0.3)
"""Lowest and highest commanded height of a foot, from its place at rest [l0]."""
OMEGAS = (0.3, 24.0)
"""Stride frequencies that are allowed [√(g/l0)]."""


def _waves(signals: Signals, harmonics: int) -> list[jax.Array]:
    """Return cos θ, sin θ, cos 2θ, sin 2θ, ... from the oscillator's signals."""
    c1, s1 = signals["cos_phase"], signals["sin_phase"]
    waves, c, s = [c1, s1], c1, s1
    for _ in range(harmonics - 1):
        c, s = c * c1 - s * s1, s * c1 + c * s1
        waves += [c, s]
    return waves


@dataclass(frozen=True)
class TimedEllipse(Actuation):
    """A foot on C's ellipse, at the phase θ + Σ aₖ cos kθ + bₖ sin kθ: any way round in time."""

    COMMANDS = FOOT
    harmonics: int = 3
    around: EllipticFoot = legged_named("quadruped-c").controller.actuation  # type: ignore[assignment]

    @property
    def needs_phase(self) -> bool:
        """True: the foot needs the phase."""
        return True

    @property
    def reads(self) -> tuple[str, ...]:
        """Sine and cosine of the phase."""
        return self.around.reads

    @property
    def shape(self) -> int:
        """Return the number of weights outside of the series."""
        return 0

    @property
    def n_weights(self) -> int:
        """Two a harmonic."""
        return 2 * self.harmonics

    @property
    def scale(self) -> np.ndarray:
        """Sizes of the weights: that of a wave falls with its number."""
        return np.repeat(0.5 / np.arange(1, self.harmonics + 1), 2)

    def __call__(self, weights, signals):
        """Forward and up [m], [2, limbs, lanes]."""
        return self.around((), self.timed(weights, _waves(signals, self.harmonics)))

    def timed(self, weights, waves: list[jax.Array]) -> Signals:
        """Return the sine and cosine of the phase on the ellipse."""
        phase = Signals({"cos_phase": waves[0], "sin_phase": waves[1]})
        return turned(phase, series(weights, waves))


SHAPE = np.array([0.1, 0.05, 0.03, 0.5, 0.1, 0.05])
"""Sizes of B, A, A′, δ and of the middle of a path."""


@dataclass(frozen=True)
class FreeFoot(TimedEllipse):
    """A foot on an ellipse of its own, timed alike, and series added to both coordinates.

    Within a box around the place below the hip.
    """

    @property
    def shape(self) -> int:
        """Return the number of weights of the ellipse and its middle."""
        return len(SHAPE)

    @property
    def n_weights(self) -> int:
        """Return the number of weights of the ellipse, its timing and the added series."""
        return self.shape + 6 * self.harmonics

    @property
    def scale(self) -> np.ndarray:
        """Sizes of the weights."""
        timing = super().scale
        return np.concatenate([SHAPE, timing, 0.2 * timing, 0.1 * timing])

    def __call__(self, weights, signals):
        """Forward and up [m], [2, limbs, lanes]."""
        offset, n = self.shape, 2 * self.harmonics
        stride, lift, press, shift, ahead, up = weights[:offset]
        ellipse = self.around
        waves = _waves(signals, self.harmonics)
        timed = self.timed(weights[offset : offset + n], waves)
        lead, sine = turned(timed, ellipse.shift_rad + shift), timed["sin_phase"]
        height = jnp.where(sine > 0.0, ellipse.lift_m + lift, ellipse.press_m + press)
        x = ahead - (ellipse.stride_m + stride) * lead["cos_phase"]
        z = up + height * sine
        x = x + series(weights[offset + n : offset + 2 * n], waves)
        z = z + series(weights[offset + 2 * n :], waves)
        return jnp.stack([jnp.clip(x, -REACH_M, REACH_M), jnp.clip(z, *HEIGHTS_M)])


def series(weights, waves: list[jax.Array]) -> jax.Array:
    """Return the sum of weights times waves."""
    return sum(a * wave for a, wave in zip(weights, waves, strict=True))  # type: ignore[return-value]


def turned(signals: Signals, angle) -> Signals:
    """Return the sine and cosine of the phase plus an angle."""
    c, s = jnp.cos(angle), jnp.sin(angle)
    sine, cosine = signals["sin_phase"], signals["cos_phase"]
    return Signals({"sin_phase": sine * c + cosine * s, "cos_phase": cosine * c - sine * s})


@dataclass(frozen=True)
class Space:
    """A set of gaits, as vectors of numbers of about one in size.

    A vector is a logarithm of the frequency, the lag of the hind legs, and the series of a fore and
    a hind leg; the right legs do as the left ones half a stride later.

    Args:
        feet: "free" or "ellipse".
        harmonics: of a stride.
    """

    feet: str = "free"
    harmonics: int = 3

    @property
    def foot(self) -> TimedEllipse:
        """Return the actuation of a foot."""
        return (FreeFoot if self.feet == "free" else TimedEllipse)(self.harmonics)

    @property
    def size(self) -> int:
        """Return the length of a vector."""
        return 2 + 2 * self.foot.n_weights

    def decoded(self, x: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, Scenario]:
        """Return the weights [lanes, 4 n] and release of vectors [lanes, size], for speeds
        [lanes].
        """
        fore, hind = np.split(x[:, 2:], 2, axis=1)
        omega = np.clip(np.pi * speed / 0.6 * np.exp(x[:, 0]), *OMEGAS)
        weights = np.concatenate([leg * self.foot.scale for leg in (fore, fore, hind, hind)], 1)
        lags = [0.0 * x[:, 1], 0.0 * x[:, 1] + 0.5, x[:, 1], x[:, 1] + 0.5]
        return weights, Scenario(
            omega=omega, phase_rad=2.0 * np.pi * np.stack(lags), height_m=RELEASE_M
        )

    def rollout(self, summary, timing: Timing) -> Rollout:
        """Return the engine that simulates its gaits."""
        legs = Controller(self.foot, PhaseOscillator(), limbs=4, sharing=(0, 1, 2, 3))
        return Rollout(controller=legs, timing=timing, summary=summary)

    def random(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random start: any frequency and lag, and an ellipse of any size if it is
        free.
        """
        x = np.zeros(self.size)
        x[:2] = 0.3 * rng.normal(), rng.uniform()
        x[2:].reshape(2, -1)[:, : self.foot.shape] = rng.normal(size=self.foot.shape)
        return x

    def from_space(self, source: Space, x: np.ndarray) -> np.ndarray:
        """Convert a vector of another space, of no freer feet, to this space."""
        fore, hind = (self._leg(leg, source) for leg in np.split(x[2:], 2))
        return np.concatenate([x[:2], fore, hind])

    def _leg(self, leg: np.ndarray, source: Space) -> np.ndarray:
        """Return a leg's numbers with another number of waves."""
        shape = source.foot.shape
        mine = np.zeros(self.foot.n_weights)
        mine[:shape] = leg[:shape]
        waves = (leg * source.foot.scale)[shape:].reshape(-1, 2 * source.foot.harmonics)
        to = mine[self.foot.shape :].reshape(-1, 2 * self.foot.harmonics)
        kept = 2 * min(source.foot.harmonics, self.foot.harmonics)
        to[: len(waves), :kept] = waves[:, :kept]
        mine[self.foot.shape :] /= self.foot.scale[self.foot.shape :]
        return mine


RELEASE_M = 0.62
"""Height of the mass at the release [l0]."""


class Walked(NamedTuple):
    """Results of a gait over its last whole strides, and over as many before, [2, lanes] each."""

    speed: np.ndarray
    power: np.ndarray
    turn: np.ndarray
    fall_s: np.ndarray
    """Time of a fall [s], infinite without one, [lanes]."""


@dataclass(frozen=True)
class OverStrides:
    """An engine's summary: speed and power over whole strides, twice, after a time to settle.

    Twice, since a gait that has not settled may look cheap for a while.
    """

    settle_s: float
    needs = ("time_s", "x_m", "y_m", "yaw_rad", "work_absolute_j", "failed")

    def __call__(self, t: Trajectory, scenario: Scenario, body: Body, timing: Timing) -> Walked:
        """Measure from interpolated totals, so that both windows have whole strides."""
        stride, frames = 2.0 * jnp.pi / scenario.omega, t.time_s.shape[0]
        strides = jnp.maximum(jnp.floor(0.5 * (timing.duration_s - self.settle_s) / stride), 1.0)
        time = strides * stride

        def changes(total: jax.Array) -> jax.Array:
            def ago(times: float) -> jax.Array:
                index = (frames - 1) - times * time / timing.frame_s
                index = jnp.clip(index, 0.0, frames - 1.001)
                low = jnp.floor(index).astype(int)
                near, far = (jnp.take_along_axis(total, (low + k)[None], 0)[0] for k in (0, 1))
                return near + (index - low) * (far - near)

            ends = [total[-1], ago(1.0), ago(2.0)]
            return jnp.stack([ends[0] - ends[1], ends[1] - ends[2]])

        ahead, aside = changes(t.x_m), changes(t.y_m)
        fell = jnp.take_along_axis(t.time_s, jnp.argmax(t.failed, axis=0)[None], 0)[0]
        return Walked(
            speed=jnp.sign(ahead) * jnp.sqrt(ahead**2 + aside**2) / time,
            power=changes(t.work_absolute_j) / time,
            turn=jnp.abs(changes(t.yaw_rad)),
            fall_s=jnp.where(t.failed[-1], fell, jnp.inf),
        )
