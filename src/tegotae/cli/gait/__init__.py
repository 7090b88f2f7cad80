"""`tegotae gait`: how the legs of a body go together, one file a command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae.cli.gait.basin import Basin
from tegotae.cli.gait.judge import Judge
from tegotae.cli.gait.lesion import Lesion
from tegotae.cli.gait.map import Map
from tegotae.cli.gait.simulate import Simulate
from tegotae.cli.gait.stability import Stability
from tegotae.cli.gait.sweep import Sweep

subcommand = tyro.conf.subcommand


@dataclass(frozen=True)
class Gait:
    """Study the gaits of a body with several legs."""

    which: Annotated[
        Annotated[Simulate, subcommand("simulate")]
        | Annotated[Basin, subcommand("basin")]
        | Annotated[Sweep, subcommand("sweep")]
        | Annotated[Map, subcommand("map")]
        | Annotated[Stability, subcommand("stability")]
        | Annotated[Lesion, subcommand("lesion")]
        | Annotated[Judge, subcommand("judge")],
        tyro.conf.arg(name=""),
    ]

    def run(self) -> None:
        """Study them."""
        self.which.run()
