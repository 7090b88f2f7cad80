"""The numbers that make a walker: legs, torso, ground; and which of them no body can have."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies.base import require_present
from tegotae.parts.parameters import Part, a_part, finite, not_negative, numbers, positive
from tegotae.parts.terrains import A_TERRAIN, Flat, Terrain

LOWEST_SHARE = 0.3
"""Share of its height on legs of full length below which a centre of mass has fallen."""


@dataclass(frozen=True, kw_only=True)
class WalkerNumbers(Part):
    """Geometry, inertia, leg impedance and ground of a walker.

    Defaults are the dimensionless quadruped C (l0 = m = g = 1).
    """

    LARGEST_TURN_RAD: ClassVar[float] = 0.5
    """Rate of the stiffest motion times the tick [rad] that is accepted. Up to here lags, speed and
    cost of transport hold within one per cent; where the stiffest motion is a damped one they would
    for longer ticks, too (docs/studies/legs_validation.md)."""

    hips_x_m: tuple[float, ...] = numbers((0.85, 0.85, -0.85, -0.85))
    """Positions of the hips forward of the middle of the torso [m]."""
    hips_y_m: tuple[float, ...] = numbers((0.44, -0.44, 0.44, -0.44))
    """Positions of the hips to the left of the middle of the torso [m]."""
    present: tuple[float, ...] = numbers(())
    """1 of a leg that is there, 0 of one that is lost; all are there if nothing is said."""
    com_x_m: float = finite(0.0)
    """Position of the centre of mass forward of the middle of the torso [m]."""
    com_y_m: float = finite(0.0)
    """Position of the centre of mass to the left of the middle [m]."""
    com_z_m: float = finite(-0.39)
    """Height of the centre of mass above the hips [m]; negative below them."""
    mass_kg: float = positive(1.0)
    """Mass m [kg]."""
    inertia_x_kg_m2: float = positive(0.10)
    """Moment of inertia in roll [kg m²]."""
    inertia_y_kg_m2: float = positive(0.24)
    """Moment of inertia in pitch [kg m²]."""
    inertia_z_kg_m2: float = positive(0.29)
    """Moment of inertia in yaw [kg m²]."""
    stiffness_x_n_per_m: float = positive(10.0)
    """Stiffness of a leg fore and aft K_x [N/m]."""
    stiffness_y_n_per_m: float = positive(3.7)
    """Sideways K_y [N/m]."""
    stiffness_z_n_per_m: float = positive(14.0)
    """Up and down K_z [N/m]."""
    damping_xy_ns_per_m: float = positive(1.3)
    """Damping of a leg along the ground D_x = D_y [N s/m]."""
    damping_z_ns_per_m: float = not_negative(0.9)
    """Up and down D_z [N s/m]."""
    leg_mass_x_kg: float = not_negative(0.0)
    """Apparent mass of a foot moved fore and aft [kg]: a cost, no force on the torso."""
    leg_mass_z_kg: float = not_negative(0.0)
    """Up and down [kg]."""
    joint_damping_x_ns_per_m: float = not_negative(0.0)
    """Damping of a foot moved fore and aft [N s/m]: a cost, no force on the torso."""
    joint_damping_z_ns_per_m: float = not_negative(0.0)
    """Up and down [N s/m]."""
    friction: float = not_negative(0.8)
    """Coefficient of friction μ."""
    rest_length_m: float = positive(1.0)
    """Length of a leg at rest l0 [m]."""
    gravity_m_per_s2: float = positive(1.0)
    """Gravity g [m/s²]."""
    push_x_n: float = finite(0.0)
    """External force on the centre of mass, in the world's x [N]."""
    push_y_n: float = finite(0.0)
    """Push on the torso in y [N]."""
    push_z_n: float = finite(0.0)
    """Upwards [N]."""
    terrain: Terrain = a_part(Terrain, A_TERRAIN, Flat)
    """The ground."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_places()
        self._check_legs()
        self._check_inertia()
        standing = sum(self.present)
        sag = self.weight_n / (standing * self.stiffness_z_n_per_m)
        height = self.rest_length_m + self.com_z_m
        if sag >= (1.0 - LOWEST_SHARE) * height:
            raise TegotaeError(
                f"stiffness_z_n_per_m is {self.stiffness_z_n_per_m:g}: {standing:g} legs give way "
                f"by {sag:.3g} m under this weight, and the centre of mass is {height:.3g} m high; "
                f"it must be more than {sag / (1.0 - LOWEST_SHARE) / height:.2g} times that"
            )

    def _check_places(self) -> None:
        if any(leaf is self.terrain for leaf in jax.tree.leaves(self.terrain)):
            raise TegotaeError(
                f"{type(self.terrain).__name__} is no pytree; put "
                "@tegotae.parts.parameters.traceable above its @dataclass"
            )
        if self.com_z_m <= -self.rest_length_m:
            raise TegotaeError(
                f"com_z_m is {self.com_z_m:g}, which is on the ground under hips of "
                f"{self.rest_length_m:g} m; it must be higher than {-self.rest_length_m:g}"
            )

    def _check_legs(self) -> None:
        if len(self.hips_x_m) < 2 or len(self.hips_x_m) != len(self.hips_y_m):
            raise TegotaeError(
                f"hips_x_m places {len(self.hips_x_m)} legs and hips_y_m {len(self.hips_y_m)}; "
                "each leg needs both, and there must be two legs or more"
            )
        if not self.present:
            object.__setattr__(self, "present", (1.0,) * self.limbs)
        require_present(self.present, self.limbs)

    def _check_inertia(self) -> None:
        inertia = self.inertia_x_kg_m2, self.inertia_y_kg_m2, self.inertia_z_kg_m2
        if 2.0 * max(inertia) > sum(inertia) * (1.0 + 1e-6):
            raise TegotaeError(
                f"the moments of inertia are {inertia} kg m², which no body has: none of them can "
                "be larger than the two others together"
            )

    @property
    def limbs(self) -> int:
        """Number of legs, lost ones included."""
        return len(self.hips_x_m)

    @property
    def weight_n(self) -> float:
        """Weight m g [N]."""
        return self.mass_kg * self.gravity_m_per_s2

    @property
    def max_force_n(self) -> float:
        """The weight, by which forces of this body are scaled: its actuators have no limit [N]."""
        return self.weight_n

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l0) [rad/s]."""
        return jnp.sqrt(self.gravity_m_per_s2 / self.rest_length_m)

    @property
    def touching_height_m(self) -> float:
        """Height of the centre of mass over legs at rest, l0 + com_z [m]."""
        return self.rest_length_m + self.com_z_m

    @property
    def standing_height_m(self) -> float:
        """Height at which it stands with no command: l0 + com_z - m g / (n K_z) [m]."""
        sag = self.weight_n / (sum(self.present) * self.stiffness_z_n_per_m)
        return self.rest_length_m + self.com_z_m - sag

    @property
    def fastest_rad_per_s(self) -> float:
        """A bound of the rates of stance: all legs on the ground, each mode by itself."""
        reach_x = max(abs(x - self.com_x_m) for x in self.hips_x_m)
        reach_y = max(abs(y - self.com_y_m) for y in self.hips_y_m)
        height = self.rest_length_m + self.com_z_m

        def fastest(x: float, y: float, z: float) -> float:
            rates = (
                x / self.mass_kg,
                y / self.mass_kg,
                z / self.mass_kg,
                (z * reach_y**2 + y * height**2) / self.inertia_x_kg_m2,
                (z * reach_x**2 + x * height**2) / self.inertia_y_kg_m2,
                (x * reach_y**2 + y * reach_x**2) / self.inertia_z_kg_m2,
            )
            return self.limbs * max(rates)

        along, down = self.damping_xy_ns_per_m, self.damping_z_ns_per_m
        springs = self.stiffness_x_n_per_m, self.stiffness_y_n_per_m, self.stiffness_z_n_per_m
        return max(math.sqrt(fastest(*springs)), fastest(along, along, down))
