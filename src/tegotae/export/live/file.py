"""A native controller in a file: checked, read."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae.lowering.layout import MemoryLayout
from tegotae.lowering.llvm.compile import NativeStep, load_step

if TYPE_CHECKING:
    from tegotae._support.documents import Document


FORMAT = "tegotae native controller"
VERSION = 2
_ABOUT, _CODE = "controller.json", "step.o"
_NAMED_WITHIN = 64
"""Bytes of a file within which its first entry is named."""
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    KeyError,
    TypeError,
    ValueError,
    EOFError,
    RuntimeError,  # an entry that seems to be encrypted, or compressed in another way
)
"""What reading an archive raises where bytes were lost or altered."""


@dataclass(frozen=True, kw_only=True)
class NativeController:
    """A compiled controller: its code, and what its caller must know.

    Args:
        name: of the controller; None if it has none.
        senses: the signals that a step takes.
        commands: what it commands, limb by limb.
        limbs: how many limbs there are.
        omega_rad_per_s: ω [rad/s]; None without an oscillator.
        phase_entry: the entry of the state that is the phase; None if no single one is.
        start: the state at the release, by entry.
        state, inputs, outputs: how memory is laid out.
        code: an object file with its checksum, of `FunctionKernel.object_file`.
    """

    name: str | None
    senses: tuple[str, ...]
    commands: tuple[str, ...]
    limbs: int
    omega_rad_per_s: float | None
    phase_entry: str | None
    start: dict[str, np.ndarray]
    state: MemoryLayout
    inputs: MemoryLayout
    outputs: MemoryLayout
    code: bytes

    def step(self) -> NativeStep:
        """The code in this process.

        Raises:
            TegotaeError: for code that was altered, or is of another kind of processor.
        """
        return load_step(self.code, self.state, self.inputs, self.outputs)


def write_native(native: NativeController, path: Path) -> None:
    """Write a compiled controller.

    Raises:
        TegotaeError: if it cannot be written.
    """
    about = {
        "format": FORMAT,
        "version": VERSION,
        "name": native.name,
        "senses": native.senses,
        "commands": native.commands,
        "limbs": native.limbs,
        "omega_rad_per_s": native.omega_rad_per_s,
        "phase_entry": native.phase_entry,
        "start": {name: x.tolist() for name, x in native.start.items()},
        "state": native.state.document(),
        "inputs": native.inputs.document(),
        "outputs": native.outputs.document(),
    }
    about["checksum"] = _checksum(about, native.code)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        # Without the time, equal controllers are equal files.
        file.writestr(zipfile.ZipInfo(_ABOUT), json.dumps(about, indent=1) + "\n")
        file.writestr(zipfile.ZipInfo(_CODE), native.code)
    write_atomically(path, stream.getvalue())


def is_native(path: Path) -> bool:
    """Whether a file is a compiled controller, whole or not, by how it begins."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return _ABOUT.encode() in file.read(_NAMED_WITHIN)
    except OSError:
        return False


def read_native(path: Path) -> NativeController:
    """Read a compiled controller.

    Its code runs as it is: load files from whom you trust.

    Raises:
        TegotaeError: for a file that is damaged, of another version, or none of these.
    """
    try:
        with zipfile.ZipFile(path) as file:
            about, code = dict(json.loads(file.read(_ABOUT))), file.read(_CODE)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except _DAMAGED:
        raise TegotaeError(f"{path} is damaged, or no {FORMAT}") from None
    if about.get("format") != FORMAT or about.get("version") != VERSION:
        raise TegotaeError(
            f"{path} is of version {about.get('version')}; this program reads {FORMAT}s of version "
            f"{VERSION}; export it again"
        )
    if about.pop("checksum", None) != _checksum(about, code):
        raise TegotaeError(f"{path} is damaged: it is truncated or altered; export it again")
    try:
        return _of_document(about, code)
    except (KeyError, TypeError, ValueError) as error:
        raise TegotaeError(f"{path} is damaged: {error}") from None


def _checksum(about: Document, code: bytes) -> str:
    """Of all that a file says, and its code."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode() + code).hexdigest()


def _of_document(about: Document, code: bytes) -> NativeController:
    state = MemoryLayout.of_document(about["state"])
    return NativeController(
        name=about["name"],
        senses=tuple(about["senses"]),
        commands=tuple(about["commands"]),
        limbs=int(about["limbs"]),
        omega_rad_per_s=about["omega_rad_per_s"],
        phase_entry=about["phase_entry"],
        start={e.name: np.asarray(about["start"][e.name], e.dtype) for e in state.entries},
        state=state,
        inputs=MemoryLayout.of_document(about["inputs"]),
        outputs=MemoryLayout.of_document(about["outputs"]),
        code=code,
    )
