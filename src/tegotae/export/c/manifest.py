"""The manifest: everything about an export that a program, or a colleague, may ask."""

from __future__ import annotations

import json

import msgspec
import numpy as np

from tegotae import __version__
from tegotae._support.documents import JsonObject
from tegotae.export.c.check_program import TOLERANCE
from tegotae.export.c.golden import Golden, outputs_of
from tegotae.export.c.header import constants
from tegotae.export.c.layouts import ExportLayout
from tegotae.export.c.names import WHAT, plain
from tegotae.export.c.plan import Export, member, unit_of
from tegotae.export.c.wired import limbs
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
