"""`tegotae figure`: pictures that explain a controller, one file a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae.cli.figure.basin import Basin
from tegotae.cli.figure.gain_map import GainMap
from tegotae.cli.figure.learning_curves import LearningCurves
from tegotae.cli.figure.optimum import Optimum
from tegotae.cli.figure.phase_locking import PhaseLocking
from tegotae.cli.figure.phase_response import PhaseResponse
from tegotae.cli.figure.poincare import Poincare
from tegotae.cli.figure.portrait import Portrait
from tegotae.cli.figure.surface import Surface

subcommand = tyro.conf.subcommand


@dataclass(frozen=True)
class Figure:
    """Draw a picture that explains a controller, with its numbers beside it."""

    which: Annotated[
        Annotated[GainMap, subcommand("gain-map")]
        | Annotated[Surface, subcommand("surface")]
        | Annotated[Portrait, subcommand("portrait")]
        | Annotated[PhaseLocking, subcommand("phase-locking")]
        | Annotated[PhaseResponse, subcommand("phase-response")]
        | Annotated[Basin, subcommand("basin")]
        | Annotated[Poincare, subcommand("poincare")]
        | Annotated[LearningCurves, subcommand("learning-curves")]
        | Annotated[Optimum, subcommand("optimum")],
        tyro.conf.arg(name=""),
    ]

    def run(self) -> None:
        """Draw it."""
        self.which.run()
