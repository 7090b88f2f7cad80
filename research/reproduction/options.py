"""Options that several commands of the study share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tegotae.api.parameters import SEVERAL

Several = Annotated[tuple[tuple[str, ...], ...], SEVERAL]
"""Words of an option that may be given several times, each time with one word or a list."""


@dataclass(frozen=True, kw_only=True)
class HopperParameters:
    """The hopper's parameters, which other bodies may have, too; those not given are left as
    they are."""

    HEADING = "Body"

    mass: float | None = None
    """Mass [kg]."""
    stiffness: float | None = None
    """Spring stiffness [N/m]."""
    damping: float | None = None
    """Damping in stance [N s/m]."""
    flight_damping: float | None = None
    """Damping in flight [N s/m]."""
    rest_length: float | None = None
    """Rest length of the leg [m]."""
    gravity: float | None = None
    """Gravity [m/s²]."""
    max_force: float | None = None
    """Largest actuator force [N]."""

    @property
    def overrides(self) -> dict[str, float]:
        """Parameters set by the user, by field name of the hopper."""
        values = {
            "mass_kg": self.mass,
            "stiffness_n_per_m": self.stiffness,
            "damping_ns_per_m": self.damping,
            "flight_damping_ns_per_m": self.flight_damping,
            "rest_length_m": self.rest_length,
            "gravity_m_per_s2": self.gravity,
            "max_force_n": self.max_force,
        }
        return {name: value for name, value in values.items() if value is not None}
