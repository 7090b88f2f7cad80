"""Legged systems: body, controller and release under a name, for every command about gaits."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeVar

import jax
import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.measures.gaits.places import leg_names, reference_leg
from tegotae.measures.gaits.summary import CoordinationSummary
from tegotae.parts._shapes import AnyArray, ArrayTree, LaneNumbers
from tegotae.parts.bodies import Body, Interface, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.fields import unwrapped
from tegotae.simulation.rollout import (
    Engine,
    Scenario,
    Summary,
    Timing,
)
from tegotae.systems.system import System

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Legged:
    """A system on several legs with its weights, as questions about gaits take it.

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
        >>> from tegotae import System, build
        >>> from tegotae.parts.bodies import Bar
        >>> legs = dataclasses.replace(build("V-sector-w8"), limbs=2)
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
    def controller(self) -> Controller:
        """The structure of the controller."""
        return self.system.controller

    @property
    def body(self) -> Body:
        """The body."""
        return self.system.mechanics

    @property
    def omega(self) -> float | None:
        """The prescribed frequency ω [rad/s]; None without an oscillator."""
        return self.system.omega

    @property
    def timing(self) -> Timing:
        """Of a rollout that is long enough to settle."""
        return self.system.timing

    @property
    def names(self) -> tuple[str, ...]:
        """The legs' names, in the body's order."""
        return leg_names(self.body) if self.legs is None else self.legs

    @property
    def dimensionless(self) -> bool:
        """Whether length, mass and gravity are 1, so that "m" is l0 and "s" is √(l0 / g)."""
        own = unwrapped(self.body)
        return isinstance(own, Walker) and (
            own.rest_length_m == own.gravity_m_per_s2 == own.mass_kg == 1.0
        )

    @property
    def units(self) -> tuple[str, str]:
        """How length and time are written."""
        return ("l0", "√(l0/g)") if self.dimensionless else ("m", "s")

    def with_system(self, **changes: object) -> Legged:
        """The same with other fields of the system or its release (`System.replaced`)."""
        return dataclasses.replace(self, system=self.system.replaced(changes))

    def with_numbers(self, omega: float | None = None, sigma: float | None = None) -> Legged:
        """The same at another frequency ω or gain σ; None leaves it as it is.

        Raises:
            TegotaeError: for a gain of a controller that has more weights than that, or a frequency
                of one without an oscillator.
        """
        changed = self
        if omega is not None:
            if self.omega is None:
                raise TegotaeError("the controller has no oscillator, and so no omega")
            changed = changed.with_system(omega=omega)
        if sigma is not None:
            require_finite("sigma", sigma)
            if len(self.weights) != 1:
                raise TegotaeError(
                    f"sigma is the one weight of a vanilla controller; this one has "
                    f"{len(self.weights)} weights"
                )
            changed = dataclasses.replace(changed, weights=(sigma,))
        return changed

    def with_body(self, body: Body) -> Legged:
        """The same with another body, released as high over where its legs touch the ground.

        Raises:
            TegotaeError: for a body that does not go with the rest, or cannot hop from there.

        Example:
            >>> from tegotae.analysis.gaits import system
            >>> found = system("quadruped-c")
            >>> higher = found.with_body(dataclasses.replace(found.body, com_z_m=-0.3))
            >>> higher.system.release.height_m > found.system.release.height_m
            True
        """
        return dataclasses.replace(self, system=self.system.on(body))

    def scenario(self, phase_rad: LaneNumbers, **more: LaneNumbers) -> Scenario:
        """A release.

        Args:
            phase_rad: phases of the oscillators [rad], a number, [lanes] or [limbs, lanes].
            more: other entries of the scenario.
        """
        return self.system.scenario(phase_rad=phase_rad, **more)

    def summary(self, **more: Any) -> CoordinationSummary:
        """The summary of how its legs are coordinated; `more` are arguments of the summary."""
        given = {"reference": self.reference, **more}
        return CoordinationSummary.on(self.controller, self.body, **given)

    def engine(self, summary: Summary, timing: Timing | None = None) -> Engine:
        """What advances it, by its own timing if none is given."""
        return self.system.engine(summary, timing)

    def run(self, summary: Summary, scenario: Scenario, timing: Timing | None = None) -> ArrayTree:
        """Roll out every lane of a scenario; what the summary makes of them, lanes last.

        Raises:
            TegotaeError: for what the engine refuses.
        """
        return self.engine(summary, timing).run(self.weights, scenario, self.body)


def require_legs(body: Body | Interface) -> None:
    """Raise `TegotaeError` for a body of one leg, which has no gait."""
    if body.limbs < 2:
        raise TegotaeError(
            f"a gait command on a one-legged body: a {type(body).__name__} has one leg; "
            "name a body of two legs at least"
        )


def random_phases(limbs: int, starts: int, seed: int = 0) -> np.ndarray:
    """Phases drawn evenly from the circle, each leg's by itself [rad], [limbs, starts].

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


def lanes_of(found: T) -> T:
    """A summary's arrays in double precision, of NumPy."""

    def lanes(x: AnyArray) -> np.ndarray:
        array = np.asarray(x)
        return np.asarray(array, float) if array.dtype.kind == "f" else array

    return jax.tree.map(lanes, found)
