"""The files of an export: header, source, their check, a manifest and a page for a robot's author;
flat, or as a library for Arduino or PlatformIO."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Literal

import msgspec
import numpy as np

from tegotae import __version__
from tegotae._support.documents import JsonObject
from tegotae.analysis.certificate import weights_hash
from tegotae.parts.weight_names import nested
from tegotae.systems.descriptions import describe
from tegotae_robots.c.golden import TOLERANCE, Golden, check_program, golden
from tegotae_robots.c.legs import leg_facts
from tegotae_robots.c.plan import (
    Export,
    constants,
    facts,
    member,
    wired_limbs,
)
from tegotae_robots.c.source import source
from tegotae_robots.c.text import ascii_text, filled_c, filled_template, template_text

LayoutName = Literal["flat", "platformio", "arduino"]
_SKETCH = "examples/control_loop/control_loop.ino"


@dataclass(frozen=True)
class ExportLayout:
    """Folders of an export, by the kind of a file; `""` is the export's own folder.

    Args:
        program: that takes the folder as a library.
        headers: folder of the header.
        sources: folder of the source.
        checks: folder of the program that checks the source, and of its vectors.
        libraries: folder that the program has for such ones.
        files: templates of this layout alone, by where they go.
    """

    program: str = ""
    headers: str = ""
    sources: str = ""
    checks: str = ""
    libraries: str = ""
    files: dict[str, str] = field(default_factory=dict[str, str])

    def place(self, file: str) -> str:
        """Return the path of a file in the export's folder.

        Example:
            >>> LAYOUTS["platformio"].place("leg.c")
            'src/leg.c'
        """
        if file.startswith("test_") or file == "golden.csv":
            folder = self.checks
        else:
            folder = {".h": self.headers, ".c": self.sources}.get(file[-2:], "")
        return f"{folder}/{file}" if folder else file

    def check(self, prefix: str) -> str:
        """Return the command that checks the C, to be run in the export's folder."""
        test = self.place(f"test_{prefix}.c")
        include = f"-I{self.headers} " if self.headers else ""
        return (
            f"cc -std=c99 -O2 {include}{self.place(f'{prefix}.c')} {test} -lm "
            f"-o test_{prefix} && ./test_{prefix}"
        )


LAYOUTS: dict[LayoutName, ExportLayout] = {
    "flat": ExportLayout(files={"CMakeLists.txt": "CMakeLists.txt"}),
    "platformio": ExportLayout(
        *("PlatformIO", "include", "src", "test", "lib"),
        {"library.json": "library.json", _SKETCH: "control_loop.ino"},
    ),
    "arduino": ExportLayout(
        *("Arduino", "src", "src", "extras", "libraries"),
        {"library.properties": "library.properties", _SKETCH: "control_loop.ino"},
    ),
}
"""Every layout by its name."""


def header(export: Export) -> str:
    """Return the text of PREFIX.h."""
    return filled_c("header.h", facts(export))


def package_texts(export: Export, layout: ExportLayout = LAYOUTS["flat"]) -> dict[str, str]:
    """Return all files of an export by their paths in its folder.

    Raises:
        TegotaeError: for a controller with an operation that has no C, by its name.
    """
    prefix = export.prefix
    code = {f"{prefix}.c": source(export), f"{prefix}.h": header(export)}  # refuses, and is quick
    vectors, values = golden(export), _for_authors(export, layout)
    results = {
        **code,
        f"test_{prefix}.c": check_program(export, vectors),
        f"{prefix}.json": "",  # lists all files, itself too
        "golden.csv": vectors.csv(),
        "README.md": filled_template(template_text("README.md"), values),
    }
    placed = {layout.place(name): text for name, text in results.items()}
    placed |= {
        place: filled_template(template_text(name), values) for place, name in layout.files.items()
    }
    manifest = json.dumps(_manifest(export, vectors, layout, list(placed)), indent=1)
    return {**placed, layout.place(f"{prefix}.json"): f"{manifest}\n"}


def _for_authors(export: Export, layout: ExportLayout) -> dict[str, object]:
    """Return facts for the page, the sketch and the descriptions of a library."""
    single, oscillates = export.limbs == 1, bool(export.state_names)
    leg = "" if single else "[leg]"
    legs = f"for (int leg = 0; leg < {export.prefix.upper()}_LIMBS; ++leg) "
    measured = " ".join(f"in.{member(name)}{leg} = 0.0f;" for name in export.senses)
    sent = " ".join(f"(void)out.{member(name)}{leg};" for name in export.commands)
    if not single:
        measured, sent = (f"{legs}{{ {line} }}" for line in (measured, sent))
    sentence = ascii_text(f"{export.saved.name or 'A Tegotae controller'} for a robot with legs")
    phases = "phase_rad" if single else "phases_rad"
    return {
        **facts(export),
        "version": __version__,
        "sentence": sentence,
        "quoted_sentence": json.dumps(sentence),
        "period_us": round(1e6 * export.tick_s),
        "measured": measured,
        "sent_to": sent,
        "setup_phases": "" if not oscillates else ", 0.0f" if single else ", phases",
        "phases_given": f", {phases}" if oscillates else "",
        "sent": f"{leg} and out.".join(map(member, export.commands)) + leg,
        "library": bool(layout.program),
        "library_of": layout.program,
        "libraries": layout.libraries,
        "check": layout.check(export.prefix),
        "golden": layout.place("golden.csv"),
    }


def _manifest(export: Export, golden: Golden, layout: ExportLayout, files: list[str]) -> JsonObject:
    """Return the content of PREFIX.json."""
    saved = export.saved
    pushes = export.controller.actuation.commands_force
    limit = float(np.asarray(export.alpha_n)) if pushes else None
    return {
        "format": "tegotae export",
        "version": 1,
        "software": __version__,
        "prefix": export.prefix,
        "model": saved.name,
        "weights_sha256": weights_hash(saved.weights),
        "files": files,
        "tick_s": export.tick_s,
        "trained_tick_s": export.trained_tick_s,
        "held": "the controller is evaluated at the start of a tick, and holds for that tick"
        + ("; a force is its mean over the tick" if export.averages else ""),
        "limbs": export.limbs,
        "omega_rad_per_s": saved.omega,
        "inputs": [
            {
                "name": sense["member"],
                "unit": sense["unit"],
                "what": sense["what"],
                "scale": export.scales.get(sense["name"]),
            }
            for sense in facts(export)["senses"]
        ],
        "outputs": [
            {"name": name, "range": [0.0, limit]} if name == "force_n" else {"name": name}
            for name in export.outputs
        ],
        "state": list(export.state_names),
        "constants": {
            name.lower(): float(np.asarray(value)) for name, (value, _) in constants(export).items()
        },
        "clipping": (
            "force_n is clipped to [0, alpha], whatever the inputs are"
            if pushes
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
        "wired": [msgspec.to_builtins(limb) for limb in wired_limbs(export)],
        "legs": [
            {"foot": leg["foot"], "joints": leg["names"].split(", ")}
            for leg in leg_facts(export)["legs"]
        ],
        "controller": describe(saved.controller),
        "body": describe(export.body),
        "weights": nested(saved.controller.weight_names, np.asarray(saved.weights, float).tolist()),
    }


def _flight(export: Export) -> str:
    """Return the sentence on commands while a foot is in the air."""
    if wired_limbs(export):
        return "as on the environment of the training"
    if export.controller.actuation.commands_force:
        return (
            "in the simulator an actuator acts on nothing while its foot is in the air; force_n is "
            "given all the same, and the robot should send 0 then"
        )
    return "feet are commanded in swing and stance alike"
