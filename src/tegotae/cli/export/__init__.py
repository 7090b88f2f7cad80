"""`tegotae export`: controllers as C, and what they cost on a microcontroller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from tegotae.cli.export.c import ExportC
from tegotae.cli.export.cost import ExportCost

subcommand = tyro.conf.subcommand


@dataclass(frozen=True)
class Export:
    """Take a controller to a robot."""

    which: Annotated[
        Annotated[ExportC, subcommand("c")] | Annotated[ExportCost, subcommand("cost")],
        tyro.conf.arg(name=""),
    ]

    def run(self) -> None:
        """Export it."""
        self.which.run()
