"""The manifest of an exported C program, as far as the benchmark relies on it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, fitted
from tegotae._support.errors import TegotaeError, other_code
from tegotae.systems.env_documents import LimbDocument
from tegotae_robots.c.plan import MOST_LIMBS, member
from tegotae_robots.c.text import is_c_name

_Name = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,99}$")]
_Positive = Annotated[float, msgspec.Meta(gt=0.0)]


class Number(msgspec.Struct):
    """An input or output, of every limb."""

    name: _Name
    """Its name in C."""


class Leg(msgspec.Struct):
    """A leg of inverse kinematics."""

    foot: str
    joints: list[str]


class Manifest(msgspec.Struct):
    """Contents of the JSON file beside a program."""

    format: str
    tick_s: _Positive
    """Period of the loop [s]."""
    limbs: Annotated[int, msgspec.Meta(ge=1, le=MOST_LIMBS)]
    wired: list[LimbDocument]
    """The limbs of a wiring; none for a body of the package."""
    legs: list[Leg]
    inputs: Annotated[list[Number], msgspec.Meta(max_length=100)]
    outputs: Annotated[list[Number], msgspec.Meta(max_length=100)]
    state: list[_Name]
    """Names of an oscillator's state; empty without one."""
    constants: dict[str, float]
    prefix: str

    @property
    def commanded(self) -> list[str]:
        """The outputs that are commands, which come first."""
        return [x.name for x in self.outputs if x.name not in ("feedback_rad_per_s", "phase_rad")]

    @property
    def phases_rad(self) -> list[float]:
        """Phases at which oscillators begin: those of the wiring, or spread over the turn."""
        spread = [2.0 * math.pi * i / self.limbs for i in range(self.limbs)]
        return [limb.phase_rad for limb in self.wired] or spread

    def checks(self) -> str:
        """Return C code that compiles only if the program has these limbs, numbers and state."""
        prefix, several = self.prefix, self.limbs > 1
        lines = [_check("limbs", f"{prefix.upper()}_LIMBS == {self.limbs}")]
        for direction, numbers in (("inputs", self.inputs), ("outputs", self.outputs)):
            names = [x.name for x in numbers] or ["unused"]
            for k, name in enumerate(names):
                place = f"offsetof({prefix}_{direction}, {name}) == {4 * self.limbs * k}"
                lines.append(_check(f"{direction}_{k}", place))
            # A flag ends the outputs; without senses there is one number, whatever the limbs.
            size = 4 * self.limbs * len(numbers) or 4
            size += 4 if direction == "outputs" else 0
            lines.append(_check(direction, f"sizeof({prefix}_{direction}) == {size}"))
        lines += [
            _check(f"state_{x}", f"offsetof({prefix}_oscillator, {x}) < 64") for x in self.state
        ]
        phases = "" if not self.state else ", const float *" if several else ", float"
        lines.append(f"void (*const entry_init)({prefix}_state *{phases}) = {prefix}_init;")
        return "#include <stddef.h>\n" + "".join(f"{line}\n" for line in lines)


def _check(name: str, condition: str) -> str:
    """Return C code that fails to compile where a condition does not hold."""
    return f"typedef char entry_{name}[({condition}) ? 1 : -1];"


def read_manifest(path: Path) -> Manifest:
    """Read the manifest beside a C file.

    Args:
        path: of the C.

    Raises:
        TegotaeError: where there is none, or one that does not describe a program.
    """
    place = path.with_suffix(".json")
    try:
        document: Any = documents.read(place)
    except (FileNotFoundError, DamagedDocumentError):
        document = None
    if not isinstance(document, dict) or document.get("format") != "tegotae export":
        raise TegotaeError(f"{path} has no {place.name} of tegotae export c beside it")
    lacking = [x.name for x in msgspec.structs.fields(Manifest) if x.name not in document]
    if lacking:
        raise TegotaeError(f"{place.name} lacks {', '.join(lacking)}; export {path} anew")
    fields = {x.name: document[x.name] for x in msgspec.structs.fields(Manifest)}
    with other_code(f"{place.name} describes no program"):
        manifest = fitted(fields, Manifest)
    if wrong := _wrong(manifest):
        raise TegotaeError(f"{place.name} {wrong}; export {path} anew")
    return manifest


def _wrong(manifest: Manifest) -> str:
    """Return the reason why a manifest describes no program; empty where it does."""
    names = [[x.name for x in numbers] for numbers in (manifest.inputs, manifest.outputs)]
    limbs, commanded = manifest.wired, manifest.commanded
    if not is_c_name(manifest.prefix):
        return f"has the prefix {manifest.prefix!r}, which is no name in C"
    if any(len(set(group)) < len(group) for group in names):
        return "names an input or an output twice"
    if not commanded or names[1][: len(commanded)] != commanded:
        return "has no commands, or others before them"
    if not limbs:
        return "has legs without a wiring" if manifest.legs else ""
    if len(limbs) != manifest.limbs:
        return f"wires {len(limbs)} limbs, and has {manifest.limbs}"
    for i, limb in enumerate(limbs):
        sensed = {member(name) for name in limb.senses}
        if missing := [name for name in names[0] if name not in sensed]:
            return f"does not say what {missing[0]} of limb {i} is"
        if np.size(limb.drives) != len(commanded):
            return f"drives {limb.drives} by {len(commanded)} commands in limb {i}"
        if not manifest.legs and (limb.rest is None or limb.push is None):
            return f"does not say where limb {i} rests and what it pushes to"
    max_force_n = manifest.constants.get("max_force_n", 0.0)
    return "" if manifest.legs or max_force_n > 0.0 else "has no max_force_n above 0"
