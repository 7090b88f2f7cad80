"""Vanilla systems tuned for speed and cost, and the fronts of the tuned."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, lookup, require_finite
from tegotae._support.limits import MOST_WEIGHTS
from tegotae._support.tables import parse_number
from tegotae.measures.fronts import NEAR, front
from tegotae.measures.gaits.names import patterns_for
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace
from tegotae.parts.terms import (
    ConstantGain,
    EllipticFoot,
    OffsetAction,
    TunedFoot,
    VanillaAction,
)
from tegotae.simulation.rollout import Scenario
from tegotae.systems.legged import Legged, random_phases
from tegotae.systems.term_sets import ShortLaw, ellipse_of
from tegotae.systems.vanilla import legged_named

Numbers = Mapping[str, np.ndarray]
"""Numbers of walkers by name, [walkers]."""

NUMBERS = ("omega", "sigma", "offset", "stride", "lift", "press", "shift")
"""All numbers of a walker: frequency, gain, offset of the cosine law, and those of the ellipse."""

FORCED = "forced "
"""Begins the name of a family without feedback, before that of its gait."""


@dataclass(frozen=True)
class Range:
    """Range of values in which a number is tuned.

    Args:
        low: the lowest.
        high: the highest.
        even: whether equal steps count alike; equal ratios do otherwise.
    """

    low: float
    high: float
    even: bool = False

    def quantile(self, share: np.ndarray) -> np.ndarray:
        """Return the values at shares of the range, from 0 to 1.

        Example:
            >>> Range(1.0, 100.0).quantile(np.array([0.5])).round(6).tolist()
            [10.0]
        """
        if self.even:
            return self.low + (self.high - self.low) * share
        return np.exp(math.log(self.low) + math.log(self.high / self.low) * share)


_PLACE = {"omega": Range(0.4, 10.0), "stride": Range(0.03, 0.45), "lift": Range(0.005, 0.25)}
_GAIN = {"sigma": Range(0.03, 6.0)}
_OFFSET = {"offset": Range(-1.5, 1.5, even=True)}
_ELLIPSE = {"press": Range(0.001, 0.1), "shift": Range(-0.6, 1.6, even=True)}


@dataclass(frozen=True)
class FrontFamily:
    """Search space of a front: a law of a walker's legs, and the ranges of its numbers.

    Args:
        name: of `front_families`.
        ranges: of its free numbers; the others are those of the system.
        action: "vanilla" or "cosine".
        lags: the lag of each leg [cycles], of legs that are forced into them; None of others.
    """

    name: str
    ranges: Mapping[str, Range]
    action: str = "vanilla"
    lags: Mapping[str, float] | None = None

    def controller(self, legged: Legged) -> Controller:
        """Return the controller, with weights for all numbers but the frequency."""
        action = OffsetAction() if self.action == "cosine" else VanillaAction()
        law = ShortLaw(name=self.name, action=action, gain=ConstantGain(), step=TunedFoot)
        return law.controller(legged.system, MOST_WEIGHTS)

    def free(self, shares: np.ndarray) -> dict[str, np.ndarray]:
        """Return free numbers at shares of their ranges, from 0 to 1, [walkers, numbers]."""
        return {name: x.quantile(shares[:, i]) for i, (name, x) in enumerate(self.ranges.items())}

    def numbers(self, legged: Legged, free: Numbers) -> dict[str, np.ndarray]:
        """Return all numbers of walkers, the fixed ones those of the system.

        Args:
            legged: the system.
            free: those that are tuned, [walkers].
        """
        ellipse = ellipse_of(legged.system)
        count = len(next(iter(free.values())))
        fixed = {
            "omega": legged.omega,
            "sigma": 0.0 if self.lags is not None else legged.weights[0],
            "offset": 0.0,
            "stride": ellipse.stride_m, "lift": ellipse.lift_m,
            "press": ellipse.press_m, "shift": ellipse.shift_rad,
        }  # fmt: skip
        return {name: np.asarray(free.get(name, np.full(count, fixed[name]))) for name in NUMBERS}

    def weights(self, numbers: Numbers) -> np.ndarray:
        """Return the weights of walkers, [walkers, n_weights]."""
        offset = ("offset",) if self.action == "cosine" else ()
        order = (*offset, "sigma", "stride", "lift", "press", "shift")
        return np.stack([np.asarray(numbers[name], float) for name in order], axis=1)

    def phases(self, legged: Legged, starts: int, seed: int) -> np.ndarray:
        """Return the phases at release [rad], [limbs, starts].

        Independent for each leg; of forced legs those of their gait, begun anywhere.
        """
        drawn = random_phases(legged.body.limbs, starts, seed)
        if self.lags is None:
            return drawn
        lag = np.array([[self.lags[leg]] for leg in legged.names])
        return drawn[:1] - 2.0 * np.pi * lag

    def scenario(self, legged: Legged, numbers: Numbers, phase_rad: np.ndarray) -> Scenario:
        """Return the release of every walker, from its own standing height.

        Args:
            legged: the system.
            numbers: of the walkers, [lanes].
            phase_rad: at release [rad], [limbs, lanes].
        """
        deeper = np.asarray(numbers["press"], float) - ellipse_of(legged.system).press_m
        height = legged.system.release.height_m + deeper
        scenario = legged.scenario(phase_rad, height_m=height)
        return scenario._replace(omega=np.asarray(numbers["omega"], float))

    def walker(self, legged: Legged, numbers: Mapping[str, float]) -> Legged:
        """Return one walker as a system of its own, released at phase 0, or in the phases of its
        gait.

        Args:
            legged: the system.
            numbers: all of the walker's, such as a row of a front.
        """
        lanes = {name: np.array([_number(numbers, name)]) for name in NUMBERS}
        system = dataclasses.replace(legged.system, controller=self.controller(legged))
        release: dict[str, object] = {"omega": float(lanes["omega"][0])}
        deeper = float(lanes["press"][0]) - ellipse_of(legged.system).press_m
        release["height_m"] = legged.system.release.height_m + deeper
        if self.lags is not None:
            release["phase_rad"] = tuple(-2.0 * math.pi * self.lags[leg] for leg in legged.names)
        return dataclasses.replace(
            legged,
            about=f"{legged.about}, {self.name}",
            system=replace(system, release),
            weights=tuple(self.weights(lanes)[0]),
        )


def front_families(legged: Legged) -> dict[str, FrontFamily]:
    """Return the families of a legged system by name.

    "vanilla" and "cosine" have the frequency, gain, stride and lift free; "vanilla ellipse" the
    whole ellipse; "forced trot" and the like turn their legs at ω without feedback.

    Args:
        legged: the system.

    Raises:
        TegotaeError: for a system without units of length, mass and gravity, or without vanilla
            feedback and an ellipse.

    Example:
        >>> from tegotae.systems.vanilla import legged_named
        >>> list(front_families(legged_named("hexapod")))[:4]
        ['vanilla', 'cosine', 'vanilla ellipse', 'forced pronk']
    """
    actuation = legged.controller.actuation
    if not (
        isinstance(actuation, EllipticFoot) and legged.dimensionless and len(legged.weights) == 1
    ):
        raise TegotaeError(
            f"{legged.about} has no front: a front is of a dimensionless walker with vanilla "
            "feedback and feet on an ellipse, such as quadruped-c"
        )
    forced: dict[str, FrontFamily] = {}
    for pattern in patterns_for(legged.names):
        name = FORCED + pattern.name
        forced.setdefault(name, FrontFamily(name, _PLACE, lags=pattern.lags))
    return {
        "vanilla": FrontFamily("vanilla", _PLACE | _GAIN),
        "cosine": FrontFamily("cosine", _PLACE | _GAIN | _OFFSET, "cosine"),
        "vanilla ellipse": FrontFamily("vanilla ellipse", _PLACE | _GAIN | _ELLIPSE),
        **forced,
    }


def front_family(legged: Legged, name: str) -> FrontFamily:
    """Return a family by name.

    Args:
        legged: the system.
        name: of `front_families`.

    Raises:
        TegotaeError: for an unknown one, or a system that has none.
    """
    families_by_name = front_families(legged)
    return lookup("family", name, families_by_name)


def _number(numbers: Mapping[str, float], name: str) -> float:
    value = float(numbers[name])
    return 0.0 if math.isnan(value) else value


PREFIX = "front:"
"""Prefix of the names of a front's walkers."""
USUAL = "vanilla"
"""The family of a name without one."""


def is_front_name(name: str) -> bool:
    """Return whether a name has the form of a front's walker."""
    return name.startswith(PREFIX)


def front_walker(name: str) -> Legged:
    """Return the walker of a kept front nearest to a speed.

    Args:
        name: `front:SYSTEM/FAMILY/SPEED`, or without the family.

    Raises:
        TegotaeError: for a system or family without a front, or a speed that is none, or
            that no walker of the front has.

    Example:
        >>> found = front_walker("front:quadruped-c/0.4")
        >>> found.names, len(found.weights)
        (('LF', 'RF', 'LH', 'RH'), 5)
    """
    parts = name.removeprefix(PREFIX).split("/")
    if len(parts) not in (2, 3):
        raise TegotaeError(f"{name} names no walker; write front:SYSTEM/FAMILY/SPEED")
    body, kind = parts[0], parts[1] if len(parts) == 3 else USUAL
    try:
        speed = parse_number(parts[-1])
    except ValueError:
        raise TegotaeError(f"{name}: {parts[-1]!r} is no speed; write such as 0.4") from None
    require_finite("the speed of a front", speed, above=0.0)
    speed_front = front(body, kind)
    if not speed_front.reaches(speed):
        near = speed_front.nearest(speed)["speed"]
        raise TegotaeError(
            f"{name}: this front has no walker within {NEAR:g} of that speed; the nearest has "
            f"{near:.2f}"
        )
    point = speed_front.nearest(speed)
    legged = legged_named(body)
    return front_family(legged, kind).walker(legged, point)
