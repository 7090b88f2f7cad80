"""Hopper legs under one rigid bar: the plainest body whose limbs feel each other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Number, PerLane
from tegotae.parts.bodies.frame import Turn, hips_at, require_level
from tegotae.parts.bodies.upright import Upright, UprightState
from tegotae.parts.parameters import positive, traceable

_WANTED = "two to four places from back to front, such as (-0.5, 0.5)"


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

    hips_m: tuple[float, ...] = (-0.5, 0.5)
    """Where along the bar the hips are, from its centre of mass, back to front [m]; mean 0."""
    inertia_ratio: float = positive(1.0)
    """j = J / (n m a²)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "hips_m", hips_at("hips_m", self.hips_m, _WANTED))
        if not (2 <= self.limbs <= 4 and all(a < b for a, b in pairwise(self.hips_m))):
            raise TegotaeError(f"hips_m is {self.hips_m}; name {_WANTED}")
        require_level("hips_m", self.hips_m, "bar")
        self._require_present()

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
        """State at release: heave, pitch and their rates."""
        return self._released((height_m, pitch_rad), (velocity_m_per_s, pitch_rate_rad_per_s))
