"""`tegotae export c`: a controller as C99 for a microcontroller."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae.cli.options import UNSET
from tegotae.export.c import Export, write
from tegotae.export.c.layouts import LAYOUTS, LayoutName
from tegotae.export.c.plan import usual_tick_s
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of


@dataclass(frozen=True, kw_only=True)
class ExportC:
    """Write a controller as C99: a header, a source, golden vectors and their test."""

    controller: Annotated[str, tyro.conf.Positional]
    """A controller file, or another name with weights, such as quadruped-c."""
    out: Path
    """Folder for the files."""
    tick: Annotated[float | None, UNSET] = None
    """Control period of the robot [s]; by default 0.001, or that of the training on an
    environment."""
    prefix: str = "tegotae"
    """Prefix of all names in C and of the files."""
    layout: LayoutName = "flat"
    """All files in one folder (flat), or a library with a sketch (platformio, arduino)."""

    def run(self) -> None:
        """Export, and say how to check it."""
        saved = controller_of(resolve(self.controller))
        tick_s = usual_tick_s(saved) if self.tick is None else self.tick
        export = Export(saved, tick_s, self.prefix)
        layout = LAYOUTS[self.layout]
        paths = write(export, self.out, layout)
        for warning in export.warnings():
            print(f"warning: {warning}", file=sys.stderr)
        for path in paths:
            print(path)
        print(f"check it: cd {self.out} && {layout.check(self.prefix)}")
