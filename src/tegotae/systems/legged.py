"""Systems with several legs, with their weights."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, TypeVar

import jax
import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.measures.gaits.names import leg_names, reference_leg
from tegotae.measures.gaits.summary import CoordinationSummary
from tegotae.parts._shapes import AnyArray, ArrayTree, LaneNumbers
from tegotae.parts.bodies import Body, Interface, Sensors, Walker
from tegotae.parts.fields import replace, unwrapped
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.simulation.summaries import Summary
from tegotae.systems.system import WALKING, OnSystem, System

S = TypeVar("S", bound=CoordinationSummary)
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Legged(OnSystem):
    """A system on several legs with its weights, as the functions of gaits take it.

    Args:
        about: its meaning, in a line.
        system: body, controller and release; its timing is long enough to settle.
        weights: of the controller; (σ,) of a vanilla one.
        legs: the legs' names, in the body's order; those of their places if None.
        reference: the number of the leg that lags are measured from; -1 takes the left hind leg,
            or the first one where there is none.

    Raises:
        TegotaeError: for a body of one leg, or weights or names of the wrong number.

    Example:
        >>> import dataclasses
        >>> from tegotae import System
        >>> from tegotae.systems.recipe import recipe
        >>> from tegotae.parts.bodies import Bar
        >>> legs = dataclasses.replace(recipe("V-sector-w8").controller(), limbs=2)
        >>> under_bar = System(controller=legs, body=Bar(), omega=8.0)
        >>> Legged(about="a bar", system=under_bar, weights=(1.0,)).names
        ('H', 'F')
    """

    about: str
    system: System
    weights: tuple[float, ...]
    legs: tuple[str, ...] | None = None
    reference: int = -1

    def __post_init__(self) -> None:
        require_legs(self.body)
        weights = tuple(float(weight) for weight in np.ravel(self.weights))
        object.__setattr__(self, "weights", weights)
        if len(weights) != self.controller.n_weights:
            raise TegotaeError(
                f"{len(weights)} weights are given; this controller has {self.controller.n_weights}"
            )
        if len(self.names) != self.body.limbs or len(set(self.names)) != self.body.limbs:
            raise TegotaeError(f"legs is {self.legs}; give each of {self.body.limbs} legs a name")
        if self.reference == -1:
            object.__setattr__(self, "reference", reference_leg(self.names))
        require_count("reference", self.reference, least=0, most=self.body.limbs - 1)

    @property
    def names(self) -> tuple[str, ...]:
        """The legs' names, in the body's order."""
        return leg_names(self.body) if self.legs is None else self.legs

    @property
    def dimensionless(self) -> bool:
        """True if length, mass and gravity are 1, so that "m" is l0 and "s" is √(l0 / g)."""
        body = unwrapped(self.body)
        return isinstance(body, Walker) and (
            body.rest_length_m == body.gravity_m_per_s2 == body.mass_kg == 1.0
        )

    @property
    def units(self) -> tuple[str, str]:
        """Units of length and time as text."""
        return ("l0", "√(l0/g)") if self.dimensionless else ("m", "s")

    def with_numbers(self, omega: float | None = None, sigma: float | None = None) -> Legged:
        """Return the system at another frequency ω or gain σ; None leaves it unchanged.

        Raises:
            TegotaeError: for a gain of a controller that has more weights than that, or a frequency
                of one without an oscillator.
        """
        changed = self
        if omega is not None:
            if self.omega is None:
                raise TegotaeError("the controller has no oscillator, and so no omega")
            changed = replace(changed, {"omega": omega})
        if sigma is not None:
            require_finite("sigma", sigma)
            if len(self.weights) != 1:
                raise TegotaeError(
                    f"sigma is the one weight of a vanilla controller; this one has "
                    f"{len(self.weights)} weights"
                )
            changed = dataclasses.replace(changed, weights=(sigma,))
        return changed

    def scenario(self, phase_rad: LaneNumbers, **entries: LaneNumbers) -> Scenario:
        """Return the scenario of a release.

        Args:
            phase_rad: phases of the oscillators [rad], a number, [lanes] or [limbs, lanes].
            more: other entries of the scenario.
        """
        return self.system.scenario(phase_rad=phase_rad, **entries)

    def summary(self, kind: type[S] = CoordinationSummary, **settings: Any) -> S:
        """Return the summary of the legs' coordination; `more` are arguments of its class."""
        return kind.on(self.controller, self.body, **{"reference": self.reference, **settings})

    def rollout(self, summary: Summary, timing: Timing | None = None) -> Rollout:
        """Return the engine that advances the system, by its own timing by default."""
        return self.system.rollout(summary, timing)

    def run(self, summary: Summary, scenario: Scenario, timing: Timing | None = None) -> ArrayTree:
        """Roll out every lane of a scenario; return the summary's results, lanes last.

        Raises:
            TegotaeError: for what the engine refuses.
        """
        return self.rollout(summary, timing).run(self.weights, scenario, self.body)


def require_legs(body: Body | Interface) -> None:
    """Raise `TegotaeError` for a body of one leg, which has no gait."""
    if body.limbs < 2:
        raise TegotaeError(
            f"a gait command on a one-legged body: a {type(body).__name__} has one leg; "
            "name a body of two legs at least"
        )


def random_phases(limbs: int, starts: int, seed: int = 0) -> np.ndarray:
    """Draw phases evenly from the circle, each leg's independently [rad], [limbs, starts].

    Drawn start by start: more starts begin with the same ones.

    Args:
        limbs: how many legs.
        starts: how many releases.
        seed: of the draw.

    Example:
        >>> random_phases(2, 3).shape
        (2, 3)
        >>> bool((random_phases(2, 3) == random_phases(2, 5)[:, :3]).all())
        True
    """
    require_count("limbs", limbs)
    require_count("starts", starts)
    require_count("seed", seed, least=0)
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (starts, limbs)).T


def lanes_of(result: T) -> T:
    """Return a summary's arrays as NumPy arrays in double precision."""

    def lanes(x: AnyArray) -> np.ndarray:
        array = np.asarray(x)
        return np.asarray(array, float) if array.dtype.kind == "f" else array

    return jax.tree.map(lanes, result)


HOPPING_S = 60.0
"""Time in which legs that hop under a bar or a plate settle [s]."""


def settling(system: System, weights: LaneNumbers, description: str = "") -> Legged:
    """Return a system with its weights and a duration in which it settles from any release.

    Gaits lock in some 20 to 60 √(l0 / g), which is more than an episode of training.

    Args:
        system: the system.
        weights: shape [n_weights].
        description: the system in one line; the kind of its body by default.

    Raises:
        TegotaeError: for a body of one leg, or weights of the wrong number.
    """
    timing = dataclasses.replace(system.timing, duration_s=settling_s(system.mechanics))
    return Legged(
        about=description or type(system.body).__name__,
        system=dataclasses.replace(system, timing=timing),
        weights=tuple(map(float, weights)),
    )


def settling_s(body: Body) -> float:
    """Return the time in which the legs of a body settle into a gait from any release [s]."""
    base = unwrapped(body)
    if not isinstance(base, Walker):
        return HOPPING_S
    return WALKING * math.sqrt(base.rest_length_m / base.gravity_m_per_s2)


_MOST_LATE = 1000
"""The longest delay of the senses [control ticks]: all of it is kept."""


def felt(legged: Legged, delay_s: float, noise: float) -> Body:
    """Return the body of a system with delayed and noisy senses.

    Args:
        legged: the system.
        delay_s: of its senses [s].
        noise: of its senses, relative to their scales.

    Raises:
        TegotaeError: for a delay or noise below zero, or a delay of too many ticks.
    """
    require_finite("delay", delay_s, least=0.0)
    require_finite("noise", noise, least=0.0)
    ticks = max(1, math.ceil(delay_s / legged.timing.tick_s - 1e-6))
    if ticks > _MOST_LATE:
        raise TegotaeError(
            f"delay is {delay_s:g}, which is {ticks} control ticks; it must be at most "
            f"{_MOST_LATE * legged.timing.tick_s:g}"
        )
    return Sensors(body=legged.body, delay_s=delay_s, noise=noise, most_ticks=ticks)
