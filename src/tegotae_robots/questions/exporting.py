"""Controllers for robots: as C, as native code, and what they cost on a microcontroller."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from tegotae._support.files import write_atomically
from tegotae._support.progress import reporting
from tegotae.questions.answer import TableAnswer
from tegotae.questions.question import Names, NoOptions, Tasks, question
from tegotae.systems.controller_file import SavedController
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of
from tegotae_robots.c import LAYOUTS, Export, texts
from tegotae_robots.c.cost import CLOCK_HZ, CORES, Cost, costs, require_tools, systems
from tegotae_robots.c.package import LayoutName
from tegotae_robots.c.plan import facts, usual_tick_s
from tegotae_robots.live.controller import LiveController, write_native
from tegotae_robots.robot import compiled


@dataclass(frozen=True, kw_only=True)
class OneController(Names):
    """A controller by name."""

    NAMED = Tasks.NAMED

    def named(self, *names: Any) -> Sequence[SavedController]:
        """The controllers.

        Raises:
            TegotaeError: for a name that means nothing, or has no weights.
        """
        return [controller_of(resolve(name)) for name in names]


@dataclass(frozen=True, kw_only=True)
class ExportNativeOptions:
    """What the controller's file may lack."""

    max_force_n: float | None = None
    """The largest force [N], if the controller's file does not contain it."""


@dataclass(frozen=True, kw_only=True)
class ExportCOptions(ExportNativeOptions):
    """The robot's loop, and the form of the files."""

    tick_s: float = 0.001
    """Control period of the robot [s]."""
    prefix: str = "tegotae"
    """Prefix of all names in C and of the files."""
    layout: LayoutName = "flat"
    """All files in one folder (flat), or a library with a sketch (platformio, arduino)."""

    @classmethod
    def options_of(cls, saved: SavedController) -> ExportCOptions:
        """A millisecond, or the control period of the training on an environment."""
        return cls(tick_s=usual_tick_s(saved))


@dataclass(frozen=True, repr=False, kw_only=True)
class ExportedC(TableAnswer):
    """A controller as C, in memory until it is saved. Its table has the golden vectors: ticks of
    the simulator's own run, which the C must repeat; its document is the manifest."""

    files: dict[str, str]
    """Texts of the files, by their paths in a folder."""

    def save(self, folder: Path | str, format: str = "png") -> list[Path]:
        """Write the files into a folder."""
        for name, text in self.files.items():
            write_atomically(Path(folder) / name, text)
        return [Path(folder) / name for name in self.files]


@question(subjects=OneController, kinds={"option": ExportCOptions}, written="folder")
def export_c(saved: SavedController, options: ExportCOptions) -> ExportedC:
    """Write a controller as C99: a header, a source, golden vectors and their test.

    Example:
        >>> export_c("V-reflex-w8", prefix="leg").files["leg.h"].splitlines()[2]
        '#ifndef LEG_H'
    """
    export = Export(saved, options.tick_s, options.prefix, max_force_n=options.max_force_n)
    layout, known = LAYOUTS[options.layout], facts(export)
    files = texts(export, layout)
    rows = [
        (way, x["member"], x["unit"], x["what"])
        for way, name in (("in", "senses"), ("out", "commands"))
        for x in known[name]
    ]
    named = f"{saved.name or 'a controller'} as C, for a loop of {export.tick_s:g} s"
    return ExportedC(
        raw=export,
        files=files,
        outcome=f"{named}; check it in its folder:\n{layout.check(export.prefix)}",
        remarks=[f"warning: {warning}" for warning in export.warnings()],
        table=lambda: pd.read_csv(io.StringIO(files[layout.place("golden.csv")])),
        shown=[pd.DataFrame(rows, columns=["", "name", "unit", "what"]).set_index("")],
        data=json.loads(files[f"{export.prefix}.json"]),
    )


@dataclass(frozen=True, repr=False, kw_only=True)
class ExportedNative(TableAnswer):
    """A controller as native code, in memory until it is saved; `raw` is the code."""

    ENDING = ".native"

    def live(self) -> LiveController:
        """The controller, to be stepped in this process."""
        return LiveController(self.raw)

    def save(self, folder: Path | str, format: str = "native") -> list[Path]:
        """Write the file of that name, such as leg.native."""
        write_native(self.raw, Path(folder))
        return [Path(folder)]


@question(subjects=OneController, written="file")
def export_native(saved: SavedController, options: ExportNativeOptions) -> ExportedNative:
    """Write a controller as native code for this kind of processor; it runs without JAX.

    The file is machine code, which `LiveController.load` runs: load only files from people that you
    trust.
    """
    native = compiled(saved, options.max_force_n)
    about = asdict(native)
    senses = ", ".join(native.senses) or "nothing"
    return ExportedNative(
        raw=native,
        outcome=f"reads {senses}; commands {', '.join(native.commands)}",
        remarks=['use it: tegotae_robots.live.LiveController.load("FILE")'],
        data={name: about[name] for name in about if name not in ("code", "start")},
    )


@question(subjects=Names, several=True, usual=("V-sector-w8", "AR", "ART", "ARGT", "T"))
def export_cost(models: Sequence[str], options: Sequence[NoOptions]) -> TableAnswer:
    """Measure size and instructions per tick of exported controllers on emulated Cortex-M cores.

    A tick of a law on a robot's legs ends with its joints. Weights of a model of the paper, which
    hardly affect the cost, are drawn. This needs the Arm compiler and QEMU:
    apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm.
    """
    require_tools()
    exports = systems(models)
    counted: list[Cost] = []
    with reporting("cost", len(exports) * len(CORES)) as reporter:
        for export in exports:
            for cost in costs(export):
                counted.append(cost)
                reporter.update(len(counted), f"{cost.model} on {cost.core}")
    table = pd.DataFrame([asdict(cost) for cost in counted])
    share = pd.Series([cost.share(CLOCK_HZ) for cost in counted])
    names = {name: f"{name.removesuffix('_bytes')} [B]" for name in table if "bytes" in name}
    counts = table["instructions"].map("{:.0f}".format)
    shown = table.assign(instructions=counts).rename(columns=names)
    shown = shown.assign(**{"at 1 kHz": share.map("{:.1%}".format)}).set_index("model")
    table = table.assign(share_at_1_khz=share)
    return TableAnswer(
        raw=counted,
        table=table,
        shown=[shown],
        remarks=[
            "Instructions executed per tick, counted by an emulator: neither cycles nor a worst "
            f"case. The last column is their share of {CLOCK_HZ / 1e6:g} MHz at 1 kHz, if each "
            "took one cycle. Flash is what the controller adds to a program, with the parts of the "
            "C library that it calls; RAM is its state, inputs and outputs."
        ],
        data={"clock_hz": CLOCK_HZ, "costs": table.to_dict("records")},
    )
