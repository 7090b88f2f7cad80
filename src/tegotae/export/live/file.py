"""A native controller in a file: checked, read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae.lowering.machine import NativeStep, load_step, sealed, unsealed

_FORMAT, _VERSION = b"tegotae native controller ", b"3\n"


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
        start: the state at the release, by entry, as nested lists of numbers.
        code: of a step, from `FunctionKernel.to_bytes`.
    """

    name: str | None
    senses: tuple[str, ...]
    commands: tuple[str, ...]
    limbs: int
    omega_rad_per_s: float | None
    phase_entry: str | None
    start: dict[str, Any]
    code: bytes

    def step(self) -> NativeStep:
        """The code in this process.

        Raises:
            TegotaeError: for code that was altered, or is of another kind of processor.
        """
        return load_step(self.code)


def write_native(native: NativeController, path: Path) -> None:
    """Write a compiled controller: what it is, and the whole of it with a checksum.

    Raises:
        TegotaeError: if it cannot be written.
    """
    write_atomically(path, _FORMAT + _VERSION + sealed(msgspec.msgpack.encode(native)))


def is_native(path: Path) -> bool:
    """Whether a file is a compiled controller, whole or not, by how it begins."""
    try:
        with path.open("rb") as file:
            return file.read(len(_FORMAT)) == _FORMAT
    except OSError:
        return False


def read_native(path: Path) -> NativeController:
    """Read a compiled controller.

    Its code runs as it is: load files from whom you trust.

    Raises:
        TegotaeError: for a file that is damaged, of another version, or none of these.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    if not content.startswith(_FORMAT + _VERSION):
        raise TegotaeError(f"{path} is damaged, or of another version; export it again")
    try:
        about = unsealed(content.removeprefix(_FORMAT + _VERSION))
    except TegotaeError as error:
        raise TegotaeError(f"{path}: {error}") from None
    return msgspec.msgpack.decode(about, type=NativeController)
