"""Hopper legs under a rigid bar, or under a plate that heaves, pitches and rolls, and may twist."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Number, PerLane
from tegotae.parts.bodies.base import require_present
from tegotae.parts.bodies.frame import Turn
from tegotae.parts.bodies.upright import Upright, UprightState
from tegotae.parts.parameters import not_negative, numbers, positive, traceable


@traceable
@dataclass(frozen=True, kw_only=True)
class Bar(Upright):
    """Two to four of the paper's hopper legs, upright under a rigid bar (heave and pitch).

    The hip of leg i is at x_i along the bar, at height `y_i = y + x_i θ`. In stance, y_i < l0 + h,

        F_i = k (l0 + h - y_i) - c ẏ_i + F_a,i,    0 <= F_a,i <= α,

    in flight F_i = 0; and with m the mass per leg, of n legs,

        n m ÿ = Σ F_i - n m g,    J θ̈ = Σ x_i F_i,    J = j n m a²,

    a being half the distance of the outermost hips. The inertia ratio j is the number that counts:
    two legs at j = 1 do not feel each other, and each moves as the hopper does. Released level,
    with all legs alike, the bar is the hopper at any j.

    Raises:
        TegotaeError: for a number out of its range, or hips that are not two to four places around
            the middle.

    Source: of this library; each leg is that of paper equations 8-10.

    Example:
        >>> bar = Bar(inertia_ratio=0.6)
        >>> bar.limbs, round(bar.inertia_kg_m2, 3)
        (2, 0.03)
    """

    SENSES = ("spring_force", "velocity", "height", "pitch", "pitch_rate")

    hips_m: tuple[float, ...] = numbers((-0.5, 0.5))
    """Positions of the hips along the bar, from its centre of mass, back to front [m]; mean 0."""
    inertia_ratio: float = positive(1.0)
    """j = J / (n m a²)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (2 <= self.limbs <= 4 and all(a < b for a, b in pairwise(self.hips_m))):
            raise TegotaeError(
                f"hips_m is {self.hips_m}; name two to four places from back to front"
            )
        _require_level("hips_m", self.hips_m, "bar")
        require_present(self.present, self.limbs)

    @property
    def turns(self) -> tuple[Turn]:
        """Pitch θ."""
        return (Turn("pitch", self.hips_m, self.half_span_m, self.inertia_ratio),)

    @property
    def half_span_m(self) -> float:
        """Half the distance of the outermost hips a [m]."""
        return 0.5 * (self.hips_m[-1] - self.hips_m[0])

    @property
    def inertia_kg_m2(self) -> float:
        """Moment of inertia about the centre of mass J = j n m a² [kg m²]."""
        return self.inertia_ratio * self.total_mass_kg * self.half_span_m**2

    def release(
        self,
        height_m: PerLane,
        velocity_m_per_s: PerLane,
        pitch_rad: Number = 0.0,
        pitch_rate_rad_per_s: Number = 0.0,
    ) -> UprightState:
        """Return the state at release: heave, pitch and their rates."""
        return self._released((height_m, pitch_rad), (velocity_m_per_s, pitch_rate_rad_per_s))


@traceable
@dataclass(frozen=True, kw_only=True)
class Plate(Upright):
    """Three to eight of the paper's hopper legs, upright under a rigid plate.

    The hip of leg i is at (x_i, z_i), forward and to the left of the plate's centre of mass, at
    height `y_i = y + x_i θ + z_i ρ`. In stance, y_i < l0 + h,

        F_i = k (l0 + h - y_i) - c ẏ_i + F_a,i,    0 <= F_a,i <= α,

    in flight F_i = 0; and with m the mass per leg, of n legs,

        n m ÿ = Σ F_i - n m g,
        J_p θ̈ = Σ x_i F_i,    J_p = j_p m Σ x_i²,
        J_r ρ̈ = Σ z_i F_i,    J_r = j_r m Σ z_i².

    With a torsional spine the plate also twists by τ: with a² = Σ x_i² / n, hips at x = a roll by
    ρ + τ, those at -a by ρ - τ,

        y_i = y + x_i θ + z_i ρ + w_i τ,    w_i = x_i z_i / a,
        J_t τ̈ = Σ w_i F_i - K τ,    J_t = j_t m Σ w_i².

    An inertia ratio of 1 is that of point masses m at the hips; with four legs at (±a, ±b),
    J_p = j_p n m a². Any positive ratios are those of a body: masses far out along an axis make one
    as large, and near the middle as small as one likes. With as many modes as legs, all ratios 1
    and K 0, the legs do not feel each other: four legs at (±a, ±b) with the twist, or three with
    Σ x_i z_i = 0 without it. Four legs without the twist feel each other at any ratios, for the
    rigid plate passes on what would twist it.

    Raises:
        TegotaeError: for a number out of its range; for hips that are not three to eight places
            around the middle, or all in one line.

    Reference: M. Hildebrand, Science 150 (1965) 701-708, for what such gaits are called.

    Example:
        >>> plate = Plate(pitch_inertia_ratio=0.6, roll_inertia_ratio=1.6)
        >>> plate.limbs, [turn.name for turn in plate.turns]
        (4, ['pitch', 'roll'])
        >>> [turn.name for turn in Plate(twist_inertia_ratio=0.8).turns]
        ['pitch', 'roll', 'twist']
    """

    SENSES = ("spring_force", "velocity", "height", "pitch", "pitch_rate", "roll", "roll_rate")

    hips_x_m: tuple[float, ...] = numbers((0.5, 0.5, -0.5, -0.5))
    """Positions of the hips forward of the centre of mass [m]; mean 0."""
    hips_z_m: tuple[float, ...] = numbers((0.3, -0.3, 0.3, -0.3))
    """Positions of the hips to the left of the centre of mass [m]; mean 0."""
    pitch_inertia_ratio: float = positive(1.0)
    """j_p = J_p / (m Σ x_i²)."""
    roll_inertia_ratio: float = positive(1.0)
    """j_r = J_r / (m Σ z_i²)."""
    twist_inertia_ratio: float | None = positive(None)
    """j_t = J_t / (m Σ w_i²); None for a plate that does not twist."""
    twist_stiffness_nm_per_rad: float = not_negative(0.0)
    """Stiffness K of the spine against the twist τ [N m/rad]; 0 if it is limp."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.twist_inertia_ratio is None and self.twist_stiffness_nm_per_rad > 0.0:
            raise TegotaeError(
                f"twist_stiffness_nm_per_rad is {self.twist_stiffness_nm_per_rad:g}, and this "
                "plate does not twist; give it a twist_inertia_ratio"
            )
        require_present(self.present, self.limbs)
        x, z = self.hips_x_m, self.hips_z_m
        if len(x) != len(z):
            raise TegotaeError(
                f"hips_x_m names {len(x)} hips and hips_z_m {len(z)}; every leg needs a place"
            )
        if not 3 <= len(x) <= 8:
            raise TegotaeError(f"hips_x_m is {x}; name three to eight places")
        _require_level("hips_x_m", x, "plate")
        _require_level("hips_z_m", z, "plate")
        xx, zz, xz = (
            sum(p * q for p, q in zip(*pair, strict=True)) for pair in ((x, x), (z, z), (x, z))
        )
        if xx * zz - xz**2 <= 1e-9 * xx * zz:
            raise TegotaeError(
                f"the hips at x = {x}, z = {z} are in one line, about which nothing holds the "
                "plate; use a Bar, or move one of them"
            )
        if self.twist_inertia_ratio is not None and abs(xz) > 1e-6 * (xx * zz) ** 0.5:
            raise TegotaeError(
                f"the hips at x = {x}, z = {z} have a mean x z of {xz / len(x):g}; it must be 0, "
                "for a spine to rest untwisted"
            )

    @property
    def turns(self) -> tuple[Turn, ...]:
        """Pitch θ, roll ρ and, with a spine, twist τ."""
        x, z = self.hips_x_m, self.hips_z_m
        turns = (
            Turn("pitch", x, _typical(x), self.pitch_inertia_ratio),
            Turn("roll", z, _typical(z), self.roll_inertia_ratio),
        )
        if self.twist_inertia_ratio is None:
            return turns
        w = tuple(along * across / _typical(x) for along, across in zip(x, z, strict=True))
        stiffness = self.twist_stiffness_nm_per_rad
        return (*turns, Turn("twist", w, _typical(w), self.twist_inertia_ratio, stiffness))

    def release(
        self,
        height_m: PerLane,
        velocity_m_per_s: PerLane,
        pitch_rad: Number = 0.0,
        pitch_rate_rad_per_s: Number = 0.0,
        roll_rad: Number = 0.0,
        roll_rate_rad_per_s: Number = 0.0,
        twist_rad: Number | None = None,
        twist_rate_rad_per_s: Number | None = None,
    ) -> UprightState:
        """Return the state at release: heave, pitch, roll, with a spine the twist, and their rates.

        Raises:
            TegotaeError: for a twist of a plate that does not twist.
        """
        place = (height_m, pitch_rad, roll_rad)
        rate = (velocity_m_per_s, pitch_rate_rad_per_s, roll_rate_rad_per_s)
        if self.twist_inertia_ratio is None:
            if twist_rad is not None or twist_rate_rad_per_s is not None:
                raise TegotaeError(
                    "the release is twisted, and this plate does not twist; give it a "
                    "twist_inertia_ratio"
                )
            return self._released(place, rate)
        twist = (0.0 if x is None else x for x in (twist_rad, twist_rate_rad_per_s))
        return self._released(*((*axis, x) for axis, x in zip((place, rate), twist, strict=True)))


def _typical(arms: tuple[float, ...]) -> float:
    """Return the root mean square of the lengths [m]; for hips at ±a it is a."""
    return (sum(arm**2 for arm in arms) / len(arms)) ** 0.5


def _require_level(name: str, hips: tuple[float, ...], body: str) -> None:
    """Raise `TegotaeError` unless the hips' mean is zero, so that the body rests level.

    Example:
        >>> _require_level("hips_m", (-0.5, 0.7), "bar")
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: hips_m is (-0.5, 0.7), whose mean is 0.1; it must be 0, for \
the bar to rest level
    """
    if abs(sum(hips)) > 1e-6 * max(map(abs, hips)):
        raise TegotaeError(
            f"{name} is {hips}, whose mean is {sum(hips) / len(hips):g}; it must be 0, for the "
            f"{body} to rest level"
        )
