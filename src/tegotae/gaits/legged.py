"""Legged systems: body, controller and release under a name, for every command about gaits."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from tegotae.bodies import Body
from tegotae.controller import Controller
from tegotae.errors import TegotaeError, require_count, require_finite
from tegotae.gaits.places import leg_names
from tegotae.gaits.summary import CoordinationSummary
from tegotae.limits import MOST_RAD_PER_S
from tegotae.rollout import Engine, Scenario, Summary, Timing, check_posture, check_senses


@dataclass(frozen=True, kw_only=True)
class Legged:
    """A body on several legs, what drives it, and how it is released.

    Args:
        about: what it is, in a line.
        body: the body.
        controller: its structure, of as many units.
        weights: of the controller; (σ,) of a vanilla one.
        omega: prescribed frequency ω [rad/s]; None without an oscillator.
        height_m: height of the release [m].
        posture: what else the release takes, pairs of name and number.
        timing: of a rollout that is long enough to settle.
        legs: the legs' names, in the body's order; those of their places if None.
        reference: the leg that lags are measured from.
        dimensionless: whether length, mass and gravity are 1, so that "m" is the leg's length l0
            and "s" is √(l0 / g).

    Raises:
        TegotaeError: for a body of one leg, a controller that does not go with it, weights or names
            of the wrong number, or an oscillator without a frequency.

    Example:
        >>> from tegotae.bodies import Bar
        >>> from tegotae import build
        >>> legs = dataclasses.replace(build("V-sector-w8"), limbs=2)
        >>> bar = Legged(about="a bar", body=Bar(), controller=legs, weights=(1.0,), omega=8.0)
        >>> bar.names
        ('H', 'F')
    """

    about: str
    body: Body
    controller: Controller
    weights: tuple[float, ...]
    omega: float | None = None
    height_m: float = 1.2
    posture: tuple[tuple[str, float], ...] = ()
    timing: Timing = field(default_factory=lambda: Timing(duration_s=60.0))
    legs: tuple[str, ...] | None = None
    reference: int = 0
    dimensionless: bool = False

    def __post_init__(self) -> None:
        if self.body.limbs < 2:
            raise TegotaeError(
                f"a gait command on a one-legged body: a {type(self.body).__name__} has one leg; "
                "name a body of two legs at least"
            )
        check_senses(self.controller, self.body)
        weights = tuple(float(weight) for weight in np.ravel(self.weights))
        object.__setattr__(self, "weights", weights)
        if len(weights) != self.controller.n_weights:
            raise TegotaeError(
                f"{len(weights)} weights are given; this controller has {self.controller.n_weights}"
            )
        if (self.controller.oscillator is None) != (self.omega is None):
            has = "no oscillator" if self.omega is not None else "an oscillator"
            says = "must be None" if self.omega is not None else "must be a frequency, such as 8"
            raise TegotaeError(f"the controller has {has}; its omega {says}")
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        require_count("reference", self.reference, least=0, most=self.body.limbs - 1)
        if len(self.names) != self.body.limbs or len(set(self.names)) != self.body.limbs:
            raise TegotaeError(f"legs is {self.legs}; give each of {self.body.limbs} legs a name")
        check_posture(self.body, self.scenario(0.0))

    @property
    def names(self) -> tuple[str, ...]:
        """The legs' names, in the body's order."""
        return leg_names(self.body) if self.legs is None else self.legs

    @property
    def units(self) -> tuple[str, str]:
        """How length and time are written."""
        return ("l0", "√(l0/g)") if self.dimensionless else ("m", "s")

    def with_numbers(self, omega: float | None = None, sigma: float | None = None) -> Legged:
        """The same at another frequency ω or gain σ; None leaves it as it is.

        Raises:
            TegotaeError: for a gain of a controller that has more weights than that, or a frequency
                of one without an oscillator.
        """
        changed: dict[str, Any] = {}
        if omega is not None:
            if self.omega is None:
                raise TegotaeError("the controller has no oscillator, and so no omega")
            changed["omega"] = omega
        if sigma is not None:
            require_finite("sigma", sigma)
            if len(self.weights) != 1:
                raise TegotaeError(
                    f"sigma is the one weight of a vanilla controller; this one has "
                    f"{len(self.weights)} weights"
                )
            changed["weights"] = (sigma,)
        return dataclasses.replace(self, **changed)

    def height_on(self, body: Body) -> float:
        """Height that releases another body as high over where its legs touch the ground [m]."""
        return self.height_m + float(body.touching_height_m) - float(self.body.touching_height_m)

    def with_body(self, body: Body) -> Legged:
        """The same with another body, released as high over where its legs touch the ground.

        Raises:
            TegotaeError: for a body that does not go with the rest, or cannot hop from there.

        Example:
            >>> from tegotae.gaits import system
            >>> found = system("quadruped-c")
            >>> higher = found.with_body(dataclasses.replace(found.body, com_z_m=0.2))
            >>> higher.height_m > found.height_m
            True
        """
        height_m = self.height_on(body)
        body.check_release(height_m)
        return dataclasses.replace(self, body=body, height_m=height_m)

    def scenario(self, phase_rad: Any, **more: Any) -> Scenario:
        """A release.

        Args:
            phase_rad: phases of the oscillators [rad], a number, [lanes] or [limbs, lanes].
            more: other entries of the scenario.
        """
        entries = {"height_m": self.height_m, "posture": dict(self.posture), **more}
        return Scenario.of(self.omega, phase_rad=phase_rad, **entries)

    def summary(self, **more: Any) -> CoordinationSummary:
        """What tells the coordination of its legs; `more` are arguments of the summary."""
        given = {"reference": self.reference, **more}
        return CoordinationSummary.on(self.controller, self.body, **given)

    def engine(self, summary: Summary, timing: Timing | None = None) -> Engine:
        """What advances it, by its own timing if none is given."""
        return Engine(controller=self.controller, timing=timing or self.timing, summary=summary)

    def run(self, summary: Summary, scenario: Scenario, timing: Timing | None = None) -> Any:
        """Roll out every lane of a scenario; what the summary makes of them, lanes last.

        Raises:
            TegotaeError: for what the engine refuses.
        """
        return self.engine(summary, timing).run(self.weights, scenario, self.body)


def random_phases(limbs: int, starts: int, seed: int = 0) -> np.ndarray:
    """Phases drawn evenly from the circle, each leg's by itself [rad], [limbs, starts].

    Drawn start by start: more starts begin with the same ones.

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


def lanes_of(found: Any) -> Any:
    """A summary's arrays in double precision, of NumPy."""
    return jax.tree.map(
        lambda x: np.asarray(x, float) if np.asarray(x).dtype.kind == "f" else np.asarray(x), found
    )
