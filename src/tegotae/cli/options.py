"""Options that several commands share: which controller, on which hopper."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from tegotae import controller_file
from tegotae.bodies import Hopper
from tegotae.controller_file import SavedController
from tegotae.errors import TegotaeError, require_finite
from tegotae.presets import preset

FromPreset = Annotated[float | None, tyro.conf.arg(help_behavior_hint="(default: the preset's)")]
"""A number that a preset, or a controller file, has too."""
Vanilla = Annotated[str | None, tyro.conf.arg(help_behavior_hint="(default: the preset's)")]
"""The name of a vanilla actuation."""
UNSET = tyro.conf.arg(help_behavior_hint="")
"""For an option whose help says what leaving it out means."""


@dataclass(frozen=True)
class HopperOptions:
    """The hopper's parameters; those not given come from a preset or a controller file."""

    preset: str = "paper"
    """Where numbers not given come from: paper, or pyTegotaeCPG."""
    mass: FromPreset = None
    """Mass [kg]."""
    stiffness: FromPreset = None
    """Spring stiffness [N/m]."""
    damping: FromPreset = None
    """Damping in stance [N s/m]."""
    flight_damping: FromPreset = None
    """Damping in flight [N s/m]."""
    rest_length: FromPreset = None
    """Rest length of the leg [m]."""
    gravity: FromPreset = None
    """Gravity [m/s²]."""
    max_force: FromPreset = None
    """Largest actuator force [N]."""

    def hopper(self, base: Hopper | None = None) -> Hopper:
        """`base`, the preset's hopper by default, with the parameters that were given."""
        given = {
            "mass_kg": self.mass,
            "stiffness_n_per_m": self.stiffness,
            "damping_ns_per_m": self.damping,
            "flight_damping_ns_per_m": self.flight_damping,
            "rest_length_m": self.rest_length,
            "gravity_m_per_s2": self.gravity,
            "max_force_n": self.max_force,
        }
        base = preset(self.preset).hopper if base is None else base
        return dataclasses.replace(base, **{k: v for k, v in given.items() if v is not None})


@dataclass(frozen=True)
class ControllerOptions(HopperOptions):
    """A controller file, or else a vanilla controller made of options, and its hopper."""

    actuation: Vanilla = None
    """Vanilla actuation: sector, reflex or both."""
    omega: FromPreset = None
    """Frequency ω [rad/s]."""
    sigma: FromPreset = None
    """Gain σ of the vanilla feedback [rad/(s N)]."""

    def chosen(self, file: Path | None) -> SavedController:
        """The controller, its weights, frequency and hopper.

        Raises:
            TegotaeError: for a file that is none, an unknown name, a number that is not finite, or
                options of a vanilla controller beside a file.
        """
        if self.omega is not None:
            require_finite("omega", self.omega)
        if file is None:
            source = preset(self.preset)
            sigma = source.sigma if self.sigma is None else self.sigma
            require_finite("sigma", sigma)
            return SavedController(
                source.controller(self.actuation or source.actuation),
                np.array([sigma]),
                source.omega_rad_per_s if self.omega is None else self.omega,
                self.hopper(),
            )
        for name in ("actuation", "sigma"):
            if getattr(self, name) is not None:
                raise TegotaeError(f"--{name} belongs to vanilla controllers, not to a file")
        saved = controller_file.load(file)
        if not isinstance(saved.body, Hopper):
            raise TegotaeError(f"{file} is for a body that is not a hopper")
        return dataclasses.replace(
            saved,
            omega=saved.omega if self.omega is None or saved.omega is None else self.omega,
            body=self.hopper(saved.body),
        )
