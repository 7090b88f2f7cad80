"""Choices that the paper leaves open: one way to read it, and the ranges of its choices."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.hopping.signals import check_work
from tegotae.parts.bodies import Hopper
from tegotae.parts.terms import Actuation, with_vanilla_settings

_STANDARD = Hopper()
_RATIOS = ("natural_frequency", "damping_ratio", "force_ratio")


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One way to read the paper: a choice for everything that it leaves open.

    Lengths are in leg lengths l0, forces in weights m g, times in √(l0/g). The body follows with
    g = 9.81 m/s², a mass and a leg length. These are choices, too: CoT⁻¹ goes with 1 / m and is
    added to ΔΩ, the reflex takes rad/s as newtons, and ω_t stays at 4 and 8 rad/s, so that its
    ratios to ω_n and to √(g/l0) vary with the body.

    Args:
        natural_frequency: ω_n √(l0/g), of the leg without damping.
        damping_ratio: ζ = c / (2 √(k m)).
        force_ratio: α / (m g), the largest actuator force in weights.
        release: height of the release in leg lengths, at rest.
        drop: how far the ground drops in the evaluation, in leg lengths.
        work: definition of work, "net", "positive" or "absolute".
        mass_kg: mass of the body [kg]; ratios keep their values.
        rest_length_m: rest length of the leg [m]; ratios keep their values.
        frequency_weight: what ΔΩ counts for in the fitness [m/J per rad²/s²]; 1 takes its
            frequencies in rad/s, `tegotae.measures.objectives.fitness.HERTZ` in hertz.
        newtons_per_feedback: force of the reflex per feedback [N s/rad].
        sector_s: duration of the vanilla sector at the prescribed frequency [s]; None for the
            width in phase that the paper's (6) has.
        sector_start: phase at which the vanilla sector starts [rad].
        flight_damping: damping of the body in flight, in shares of the leg's in stance.
        tuned_over: at which frequencies relative to ω_t the gain of a pure V model is searched
            [rad/s].

    Raises:
        TegotaeError: for what the body does not allow: a force that cannot lift it, a leg that its
            own weight or the fall from release and drop would press to nothing; for a number that
            is not positive, or an unknown definition of work.

    Example:
        >>> f"{Reading().hopper.stiffness_n_per_m:.3f} N/m"
        '5.000 N/m'
    """

    natural_frequency: float = _STANDARD.natural_frequency_rad_per_s * math.sqrt(1.0 / 9.81)
    damping_ratio: float = (
        0.5
        * _STANDARD.damping_ns_per_m
        / math.sqrt(_STANDARD.stiffness_n_per_m * _STANDARD.mass_kg)
    )
    force_ratio: float = _STANDARD.max_force_n / _STANDARD.weight_n
    release: float = 1.2
    drop: float = 0.2
    work: str = "absolute"
    mass_kg: float = _STANDARD.mass_kg
    rest_length_m: float = _STANDARD.rest_length_m
    frequency_weight: float = 1.0
    newtons_per_feedback: float = 1.0
    sector_s: float | None = None
    sector_start: float = 1.75 * math.pi
    flight_damping: float = 0.0
    tuned_over: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        positive = ("natural_frequency", "force_ratio", "release")
        for name in (*positive, "mass_kg", "rest_length_m", "newtons_per_feedback"):
            require_finite(name, getattr(self, name), above=0.0)
        require_finite("sector_start", self.sector_start)
        for name in ("damping_ratio", "drop", "frequency_weight", "flight_damping"):
            require_finite(name, getattr(self, name), least=0.0)
        if self.sector_s is not None:
            require_finite("sector_s", self.sector_s, above=0.0)
        check_work(self.work)
        if self.force_ratio <= 1.0:
            raise TegotaeError(
                f"force_ratio is {self.force_ratio:g}; an actuator that is to lift the body needs "
                "more than 1, its weight"
            )
        if self.natural_frequency <= 1.0:
            raise TegotaeError(
                f"natural_frequency is {self.natural_frequency:g}; this leg has no length left "
                "under the weight alone, it needs more than 1"
            )
        if (depth := self.deepest_compression) >= 1.0:
            raise TegotaeError(
                f"natural_frequency is {self.natural_frequency:g}, release {self.release:g}, drop "
                f"{self.drop:g}: the fall presses the leg by {depth:.2f} of its length; it must be "
                "less than 1"
            )

    @property
    def deepest_compression(self) -> float:
        """Compression of an undamped leg by a fall from the release onto the dropped ground
        [l0]."""
        fall = max(self.release - 1.0, 0.0) + self.drop
        rate_squared = self.natural_frequency**2
        return (1.0 + math.sqrt(1.0 + 2.0 * fall * rate_squared)) / rate_squared

    @property
    def hopper(self) -> Hopper:
        """The body of these ratios; equal to the standard body to the last bit at its own
        ratios.
        """
        names = (*_RATIOS, "mass_kg", "rest_length_m", "flight_damping")
        if all(getattr(self, name) == getattr(Reading, name) for name in names):
            return _STANDARD
        mass, length, gravity = (
            self.mass_kg,
            self.rest_length_m,
            _STANDARD.gravity_m_per_s2,
        )
        rate = self.natural_frequency * math.sqrt(gravity / length)
        return dataclasses.replace(
            _STANDARD,
            mass_kg=mass,
            rest_length_m=length,
            stiffness_n_per_m=mass * rate**2,
            damping_ns_per_m=2.0 * self.damping_ratio * mass * rate,
            flight_damping_ns_per_m=self.flight_damping * 2.0 * self.damping_ratio * mass * rate,
            max_force_n=self.force_ratio * mass * gravity,
        )

    def actuation(self, base: Actuation) -> Actuation:
        """Return an actuation under this reading; a learned one is unchanged."""
        return with_vanilla_settings(
            base,
            start_rad=self.sector_start,
            duration_s=self.sector_s,
            newtons_per_feedback=self.newtons_per_feedback,
        )


@dataclass(frozen=True)
class AnalysisChoice:
    """One choice that the paper leaves open, and the range of its variation.

    Args:
        name: the field of `Reading`.
        label: how figures and tables call it.
        values: the ends of a range, or, if `levels`, everything there is to choose from, in order.
        levels: whether there is nothing between the values.
        reason: basis of the range.
    """

    name: str
    label: str
    values: tuple[Any, ...]
    levels: bool
    reason: str

    def value_at(self, share: float) -> Any:
        """Return the value at a share in [0, 1) of the way from first to last."""
        if self.levels:
            return self.values[int(share * len(self.values))]
        low, high = self.values
        return low + share * (high - low)

    def place(self, value: Any) -> float:
        """Return a value's position between the first (0) and the last (1)."""
        if self.levels:
            return self.values.index(value) / (len(self.values) - 1)
        low, high = self.values
        return (value - low) / (high - low)


ALLOWED: Mapping[str, Callable[[Reading], bool]] = {
    "Damper off in flight": lambda reading: reading.flight_damping == 0.0,
    "and sector from 1.75π": lambda reading: (
        reading.flight_damping == 0.0 and reading.sector_start == Reading.sector_start
    ),
}
"""Readings that the paper's text allows: III-B switches the damper off in flight, and (6) prints
where the sector starts. The calibration has other values of both, from the co-author's program."""
