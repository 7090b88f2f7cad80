"""`tegotae export native`: a compiled controller as one file for `LiveController`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae._support.files import output_file
from tegotae.cli.options import UNSET
from tegotae.export.live.file import write_native
from tegotae.export.live.tick import compiled
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of


@dataclass(frozen=True, kw_only=True)
class ExportNative:
    """Write a controller as native code for this kind of processor; it runs without JAX.

    The file is machine code, which `LiveController.load` runs: load only files from people that
    you trust.
    """

    controller: Annotated[str, tyro.conf.Positional]
    """A controller file, or another name with weights, such as quadruped-c."""
    out: Path
    """File of the code, such as leg.native."""
    max_force: Annotated[float | None, UNSET] = None
    """The largest force [N], if the controller's file does not contain it."""

    def run(self) -> None:
        """Compile, write, and say how to use it."""
        output_file(self.out)
        native = compiled(controller_of(resolve(self.controller)), self.max_force)
        write_native(native, self.out)
        print(self.out)
        print(f"reads {', '.join(native.senses)}; commands {', '.join(native.commands)}")
        print(f'use it: LiveController.load("{self.out}")')
