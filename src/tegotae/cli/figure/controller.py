"""What figures of one controller have in common: the controller, and its release."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from tegotae.cli.figure.output import Output
from tegotae.cli.options import UNSET, ControllerOptions, SystemsOwn
from tegotae.parts.terms import Reflex, Sector, SectorAndReflex
from tegotae.systems.presets import preset

if TYPE_CHECKING:
    from tegotae.analysis.orbit import Orbit
    from tegotae.systems.controller_file import SavedController

_VANILLA = {Sector: "sector", Reflex: "reflex", SectorAndReflex: "sector and reflex"}


@dataclass(frozen=True, kw_only=True)
class ControllerFigure(Output, ControllerOptions):
    """A figure of one controller: of a file, or a vanilla controller made of options."""

    path: Annotated[str | None, tyro.conf.Positional, UNSET] = None
    """A controller file, or another name with weights, such as V-sector-w4. Without it, the options
    define a vanilla controller."""

    def called(self) -> str:
        """The controller's name, or the actuation of a vanilla one."""
        if self.path is not None:
            return self.path
        return preset(self.preset).actuation if self.actuation is None else self.actuation

    def saved(self) -> SavedController:
        """The controller, its weights, frequency and hopper."""
        return self.chosen(self.path)

    def title(self, saved: SavedController) -> str:
        """The controller in a few words, for a figure."""
        from tegotae.figures.style import literal

        at = "" if saved.controller.oscillator is None else f", ω = {saved.omega:g} rad/s"
        if self.path is None:
            actuation = _VANILLA[type(saved.controller.actuation)]
            return f"{actuation}, σ = {saved.weights[0]:g}{at}"
        return f"{literal(saved.name or Path(self.path).stem)}{at}"


@dataclass(frozen=True, kw_only=True)
class SettledSubject(ControllerFigure):
    """A figure of the limit cycle that one controller settles on."""

    height: SystemsOwn = None
    """Release height [m]."""
    phase: SystemsOwn = None
    """Phase at release [rad]."""
    settle: float = 60.0
    """Simulated time before the limit cycle is measured [s]."""

    def saved(self) -> SavedController:
        """The system with its weights, released as the options say, and else as it is by itself."""
        saved = super().saved()
        given = {"height_m": self.height, "phase_rad": self.phase}
        return saved.replaced(**{name: x for name, x in given.items() if x is not None})

    def orbit(self, saved: SavedController) -> Orbit:
        """The limit cycle; raises `NoLimitCycleError` if there is none."""
        from tegotae.analysis.orbit import find_orbit

        return find_orbit(saved, settle_s=self.settle)
