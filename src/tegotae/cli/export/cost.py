"""`tegotae export cost`: what controllers cost on microcontrollers."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from tegotae._support import tables
from tegotae._support.files import output_file
from tegotae._support.progress import reporting
from tegotae.cli.console import print_rows
from tegotae.cli.options import UNSET
from tegotae.export.c.cost import (
    CLOCK_HZ,
    CORES,
    Cost,
    costs,
    require_tools,
    systems,
)


@dataclass(frozen=True, kw_only=True)
class ExportCost:
    """Measure size and instructions per tick of exported controllers on emulated Cortex-M cores.

    This needs the Arm compiler and QEMU: apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi
    qemu-system-arm.
    """

    model: tuple[str, ...] = ("V-sector-w8", "AR", "ART", "ARGT", "T")
    """Models, with random weights; the weights hardly affect the cost."""
    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, UNSET] = None
    """Write a row per model and core to this file."""

    def run(self) -> None:
        """Compile, run, and print."""
        require_tools()
        if self.csv is not None:
            output_file(self.csv)
        exports = systems(self.model)
        found: list[Cost] = []
        with reporting("cost", len(exports) * len(CORES)) as reporter:
            for export in exports:
                for cost in costs(export):
                    found.append(cost)
                    reporter.update(len(found), f"{cost.model} on {cost.core}")
        rows = [{**asdict(cost), "share_at_1_khz": cost.share(CLOCK_HZ)} for cost in found]
        if self.csv is not None:
            columns = {name: [str(row[name]) for row in rows] for name in rows[0]}
            tables.write_csv(self.csv, columns)
        if self.json:
            print(json.dumps({"clock_hz": CLOCK_HZ, "costs": rows}))
            return
        print_rows(
            ("model", "weights", "core", "flash B", "RAM B", "stack B", "instructions", "at 1 kHz"),
            (
                (
                    cost.model,
                    str(cost.weights),
                    cost.core,
                    str(cost.flash_bytes),
                    str(cost.ram_bytes),
                    str(cost.stack_bytes),
                    f"{cost.instructions:.0f}",
                    f"{100.0 * cost.share(CLOCK_HZ):.1f} %",
                )
                for cost in found
            ),
        )
        print(
            "Instructions executed per tick, counted by an emulator: neither cycles nor a worst "
            "case. The last column is their share of "
            f"{CLOCK_HZ / 1e6:g} MHz at 1 kHz, if each took one cycle. Flash is what the "
            "controller adds to a program, with the parts of the C library that it calls; RAM is "
            "its state, inputs and outputs."
        )
