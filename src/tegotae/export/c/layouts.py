"""Folders for Arduino, a library, or plain C."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Literal

from tegotae import __version__
from tegotae.export.c.header import limbs
from tegotae.export.c.names import plain
from tegotae.export.c.plan import Export, member


def sketch(export: Export) -> str:
    """The text of control_loop.ino: setup and loop, and two functions for a robot's author."""
    prefix = export.prefix
    one = export.limbs == 1
    at = "" if one else "[leg]"
    legs = f"for (int leg = 0; leg < {prefix.upper()}_LIMBS; ++leg) "
    measured = " ".join(f"in.{member(name)}{at} = 0.0f;" for name in export.senses)
    sent = " ".join(f"(void)out.{member(name)}{at};" for name in export.commands)
    if not one:
        measured, sent = (f"{legs}{{ {line} }}" for line in (measured, sent))
    phases = ""
    start = f"{prefix}_init(&state);"
    if export.tracer.state_names:
        start = f"{prefix}_init(&state, {'0.0f' if one else 'phases'});"
        if not one:
            phases = f"  static const float phases[{prefix.upper()}_LIMBS] = {{0.0f}};\n"
    air = ""
    if export.commands == ("force",) and not limbs(export):
        air = " Send 0 while the foot is in the air."
    return f"""\
// control_loop.ino: a step of {prefix}.h every {export.tick_s:g} s.
// measure() and command() are yours: they know your sensors and actuators.
#include <Arduino.h>
#include <{prefix}.h>

static const uint32_t PERIOD_US = {round(1e6 * export.tick_s)};
static {prefix}_state state;
static {prefix}_inputs in;
static {prefix}_outputs out;
static uint32_t due_us;

// Put what the robot measures now into `in`, in the units of {prefix}.h.
static void measure() {{
  {measured}
}}

// Send `out` to the actuators.{air}
static void command() {{
  {sent}
}}

void setup() {{
{phases}  {start}
  due_us = micros();
}}

void loop() {{
  if ((int32_t)(micros() - due_us) < 0) {{
    return;
  }}
  due_us += PERIOD_US;
  measure();
  {prefix}_step(&state, &in, &out);
  command();
}}
"""


LayoutName = Literal["flat", "platformio", "arduino"]


@dataclass(frozen=True)
class ExportLayout:
    """Folders of an export, by the kind of a file; `""` is the export's own folder.

    Args:
        name: of the layout.
        headers: folder of the header.
        sources: folder of the source.
        checks: folder of the program that checks the source, and of its vectors.
    """

    name: LayoutName
    headers: str = ""
    sources: str = ""
    checks: str = ""
    library: bool = field(default=True)
    """Whether the folder is a library, with a sketch as its example, and no CMakeLists.txt."""

    def place(self, file: str) -> str:
        """The path of a file in the export's folder.

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
        """The command that checks the C, from the export's folder."""
        test = self.place(f"test_{prefix}.c")
        include = f"-I{self.headers} " if self.headers else ""
        return (
            f"cc -std=c99 -O2 {include}{self.place(f'{prefix}.c')} {test} -lm "
            f"-o test_{prefix} && ./test_{prefix}"
        )

    def own_files(self, export: Export) -> dict[str, str]:
        """The files of this layout alone, by their paths."""
        if not self.library:
            return {}
        example = {"examples/control_loop/control_loop.ino": sketch(export)}
        if self.name == "platformio":
            return {"library.json": library_json(export), **example}
        return {"library.properties": library_properties(export), **example}


LAYOUTS: dict[LayoutName, ExportLayout] = {
    "flat": ExportLayout("flat", library=False),
    "platformio": ExportLayout("platformio", "include", "src", "test"),
    "arduino": ExportLayout("arduino", "src", "src", "extras"),
}
"""Every layout by its name."""


def library_json(export: Export) -> str:
    """The description of a library for PlatformIO."""
    document = {
        "name": export.prefix,
        "version": __version__,
        "description": _title(export),
        "keywords": ["control", "robotics"],
        "headers": f"{export.prefix}.h",
        "frameworks": "*",
        "platforms": "*",
        # Checks for what is no finite number need them.
        "build": {"flags": ["-fno-fast-math"]},
        "examples": [
            {
                "name": "control_loop",
                "base": "examples/control_loop",
                "files": ["control_loop.ino"],
            }
        ],
    }
    return json.dumps(document, indent=2) + "\n"


def library_properties(export: Export) -> str:
    """The description of a library for the Arduino IDE."""
    entries = {
        "name": export.prefix,
        "version": __version__,
        "author": "tegotae",
        "maintainer": "tegotae",
        "sentence": _title(export),
        "paragraph": f"Call {export.prefix}_step every {export.tick_s:g} s.",
        "category": "Device Control",
        "url": "",
        "architectures": "*",
        "includes": f"{export.prefix}.h",
    }
    return "".join(f"{name}={value}\n" for name, value in entries.items())


def _title(export: Export) -> str:
    return plain(f"{export.saved.name or 'A Tegotae controller'} for a robot with legs")
