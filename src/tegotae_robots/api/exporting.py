"""Controllers for robots: as C, as native code, and what they cost on a microcontroller."""

from __future__ import annotations

import io
import json
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any, cast

import pandas as pd

from tegotae._support.files import write_atomically
from tegotae._support.progress import reporting
from tegotae.api.controller import LoadedController
from tegotae.api.parameters import Values, check_types, with_own_values
from tegotae.api.results import Files, Table
from tegotae.systems.controller_file import SavedController
from tegotae.systems.resolve import Named, resolve
from tegotae.training.collection import controller_of
from tegotae_robots.c import LAYOUTS, Export, package_texts
from tegotae_robots.c.cost import CLOCK_HZ, CORES, Cost, costs, require_tools, systems
from tegotae_robots.c.package import LayoutName
from tegotae_robots.c.plan import facts, usual_tick_s
from tegotae_robots.live.controller import LiveController, write_native
from tegotae_robots.robot import compiled

Exportable = str | PathLike[str] | Named | LoadedController
"""Controller by name, loaded, or an object with weights."""


def _saved(controller: Exportable) -> SavedController:
    """Return the controller with its weights."""
    if isinstance(controller, LoadedController):
        return controller.saved
    return controller_of(resolve(cast(Any, controller)))


def _tick(controller: Any = "", **_: Any) -> Values:
    """Return the default tick: a millisecond, or the control period of the training on an
    environment.
    """
    return {"tick_s": usual_tick_s(_saved(controller)) if controller else 0.001}


@with_own_values(_tick)
def export_c(
    law: Exportable,
    *,
    tick_s: float | None = None,
    prefix: str = "tegotae",
    layout: LayoutName = "flat",
    max_force_n: float | None = None,
) -> Files:
    """Write a controller as C99: a header, a source, golden vectors and their test.

    Its table has the golden vectors: ticks of the simulator's own run, which the C must repeat; its
    document is the manifest.

    Args:
        law: controller, loaded or by name: a controller file, a trained controller such as zoo:ART,
            a vanilla one such as V-sector-w4, a legged system such as quadruped-c or FILE.toml, or
            FILE.py:OBJECT.
        tick_s: control period of the robot [s]; a millisecond by default, or the control period of
            the training on an environment.
        prefix: prefix of all names in C and of the files.
        layout: all files in one folder (flat), or a library with a sketch (platformio, arduino).
        max_force_n: largest force [N], if the controller's file does not contain it.

    Raises:
        TegotaeError: for a name that means nothing, or values that cannot be.

    Example:
        >>> export_c("V-reflex-w8", prefix="leg").files["leg.h"].splitlines()[2]
        '#ifndef LEG_H'
    """
    saved = _saved(law)
    tick_s = usual_tick_s(saved) if tick_s is None else tick_s
    export = Export(saved, tick_s, prefix, max_force_n=max_force_n)
    form, facts_of_export = LAYOUTS[layout], facts(export)
    files = package_texts(export, form)
    rows = [
        (direction, x["member"], x["unit"], x["what"])
        for direction, name in (("in", "senses"), ("out", "commands"))
        for x in facts_of_export[name]
    ]
    title = f"{saved.name or 'a controller'} as C, for a loop of {export.tick_s:g} s"

    def write(folder: Path) -> list[Path]:
        for name, text in files.items():
            write_atomically(folder / name, text)
        return [folder / name for name in files]

    return Files(
        raw=export,
        files=files,
        write=write,
        title=f"{title}; check it in its folder:\n{form.check(export.prefix)}",
        notes=[f"warning: {warning}" for warning in export.warnings()],
        rows=lambda: pd.read_csv(io.StringIO(files[form.place("golden.csv")])),
        views=[pd.DataFrame(rows, columns=["", "name", "unit", "what"]).set_index("")],
        data=json.loads(files[f"{export.prefix}.json"]),
    )


@dataclass(frozen=True, repr=False, kw_only=True)
class NativeCode(Files):
    """Controller as native code, in memory until it is saved; `raw` is the code."""

    ENDINGS = (".native",)
    REPLACES = True

    def live(self) -> LiveController:
        """Return the controller, to be stepped in this process."""
        return LiveController(self.raw)


@check_types
def export_native(law: Exportable, *, max_force_n: float | None = None) -> NativeCode:
    """Write a controller as native code for this kind of processor; it runs without JAX.

    The file is machine code, which `LiveController.load` runs: load only files from people that you
    trust.

    Args:
        law: controller, loaded or by name: a controller file, a trained controller such as zoo:ART,
            a vanilla one such as V-sector-w4, a legged system such as quadruped-c or FILE.toml, or
            FILE.py:OBJECT.
        max_force_n: largest force [N], if the controller's file does not contain it.

    Raises:
        TegotaeError: for a name that means nothing, or a processor without native code.
    """
    native = compiled(_saved(law), max_force_n)
    header = asdict(native)
    senses = ", ".join(native.senses) or "nothing"

    return NativeCode(
        raw=native,
        write=lambda path: write_native(native, path),
        title=f"reads {senses}; commands {', '.join(native.commands)}",
        notes=['use it: tegotae_robots.live.LiveController.load("FILE")'],
        data={name: header[name] for name in header if name not in ("code", "start")},
    )


@check_types
def export_cost(*models: str) -> Table:
    """Measure size and instructions per tick of exported controllers on emulated Cortex-M cores.

    A tick of a law on a robot's legs ends with its joints. Weights of a model of the paper, which
    hardly affect the cost, are drawn. This needs the Arm compiler and QEMU:
    apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm.

    Args:
        models: models of the paper, or controllers by name; a few of the paper's by default.

    Raises:
        TegotaeError: without the compiler or the emulator, or for a name that means nothing.
    """
    models = models or ("V-sector-w8", "AR", "ART", "ARGT", "T")
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
    columns = table.assign(instructions=counts).rename(columns=names)
    columns = columns.assign(**{"at 1 kHz": share.map("{:.1%}".format)}).set_index("model")
    table = table.assign(share_at_1_khz=share)
    return Table(
        raw=counted,
        rows=table,
        views=[columns],
        notes=[
            "Instructions executed per tick, counted by an emulator: neither cycles nor a worst "
            f"case. The last column is their share of {CLOCK_HZ / 1e6:g} MHz at 1 kHz, if each "
            "took one cycle. Flash is what the controller adds to a program, with the parts of the "
            "C library that it calls; RAM is its state, inputs and outputs."
        ],
        data={"clock_hz": CLOCK_HZ, "costs": table.to_dict("records")},
    )
