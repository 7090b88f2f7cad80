"""The files of an export, and its manifest."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np

from tegotae import __version__
from tegotae._support.documents import JsonObject
from tegotae._support.files import output_file, output_folder, write_atomically
from tegotae.export.c.golden import TOLERANCE, Golden, check_program, golden, outputs_of
from tegotae.export.c.header import constants, header, limbs
from tegotae.export.c.layouts import LAYOUTS, ExportLayout
from tegotae.export.c.names import WHAT, plain
from tegotae.export.c.plan import Export, member, unit_of
from tegotae.export.c.readme import cmake, readme
from tegotae.export.c.source import source
from tegotae.parts.weight_names import nested
from tegotae.systems.descriptions import describe


def manifest(export: Export, golden: Golden, layout: ExportLayout, files: list[str]) -> str:
    """The text of PREFIX.json.

    Args:
        export: what is exported.
        golden: its vectors.
        layout: where its files lie.
        files: the paths of all of them.
    """
    saved, prefix = export.saved, export.prefix
    force = export.commands == ("force",)
    document: JsonObject = {
        "format": "tegotae export",
        "version": 1,
        "software": __version__,
        "prefix": prefix,
        "model": saved.name,
        "files": files,
        "tick_s": export.tick_s,
        "trained_tick_s": export.trained_tick_s,
        "held": "the controller is evaluated at the start of a tick, and holds for that tick"
        + ("; a force is its mean over the tick" if export.averages else ""),
        "limbs": export.limbs,
        "omega_rad_per_s": saved.omega,
        "inputs": [
            {
                "name": member(name),
                "unit": unit_of(name)[1],
                "what": WHAT.get(name, plain(name)),
                "scale": export.scales.get(name),
            }
            for name in export.senses
        ],
        "outputs": [
            {"name": name, "range": [0.0, float(np.asarray(export.max_force_n))]}
            if name == "force_n"
            else {"name": name}
            for name in outputs_of(export)
        ],
        "state": list(export.tracer.state_names),
        "constants": {
            name.lower(): float(np.asarray(value)) for name, (value, _) in constants(export).items()
        },
        "clipping": (
            "force_n is clipped to [0, alpha], whatever the inputs are"
            if force
            else "commands are not clipped; one that is no finite number becomes 0"
        ),
        "flight": _flight(export),
        "no_numbers": (
            "an input that is no finite number counts as 0; an oscillator whose next state would "
            "be none stays as it is; either sets out.fault and counts in state.faults"
        ),
        "golden": {
            "file": layout.place("golden.csv"),
            "vectors": len(golden.rows),
            "columns": ["t_s", *golden.columns],
            "tolerance": TOLERANCE,
        },
        "wired": [msgspec.to_builtins(limb) for limb in limbs(export)],
        "controller": describe(saved.controller),
        "body": describe(export.body),
        "weights": nested(saved.controller.weight_names, np.asarray(saved.weights, float).tolist()),
    }
    return json.dumps(document, indent=1) + "\n"


def _flight(export: Export) -> str:
    """What commands are worth while a foot is in the air."""
    if limbs(export):
        return "as on the environment of the training"
    if export.commands == ("force",):
        return (
            "in the simulator an actuator acts on nothing while its foot is in the air; force_n is "
            "given all the same, and the robot should send 0 then"
        )
    return "feet are commanded in swing and stance alike"


def texts(export: Export, layout: ExportLayout = LAYOUTS["flat"]) -> dict[str, str]:
    """All files of an export by their paths in its folder.

    Raises:
        TegotaeError: for a controller with an operation that has no C, by its name.
    """
    prefix = export.prefix
    code = {f"{prefix}.c": source(export), f"{prefix}.h": header(export)}
    vectors = golden(export)
    made = {
        **code,
        f"test_{prefix}.c": check_program(export, vectors),
        f"{prefix}.json": "",  # lists all files, itself too
        "golden.csv": vectors.csv(),
        "README.md": readme(export, layout),
    }
    if not layout.library:
        made["CMakeLists.txt"] = cmake(export)
    placed = {layout.place(name): text for name, text in made.items()} | layout.own_files(export)
    own = layout.place(f"{prefix}.json")
    return {**placed, own: manifest(export, vectors, layout, list(placed))}


def write(export: Export, folder: Path, layout: ExportLayout = LAYOUTS["flat"]) -> list[Path]:
    """Write an export; the paths of its files.

    Args:
        export: what.
        folder: where; made if it is missing.
        layout: which folders of it the files lie in.

    Raises:
        TegotaeError: for what cannot be exported, or a folder that cannot be written to.
    """
    source(export)  # refuses what has no C, and is quick
    output_folder(folder)
    made = texts(export, layout)
    for name, text in made.items():
        write_atomically(output_file(folder / name), text)
    return [folder / name for name in made]
