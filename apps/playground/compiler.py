"""C to WebAssembly, by a compiler that comes as a Python package."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from tegotae._support.errors import MissingExtraError, TegotaeError, how_to_install

FLAGS = (
    *("-target", "wasm32-freestanding", "-std=c99", "-O2", "-fno-builtin"),
    *("-ffp-contract=off", "-nostdlib", "-fno-sanitize=all", "-fno-stack-protector"),
    *("-Wl,--no-entry", "-Wl,--export-memory", "-Wl,--export=__heap_base", "-Wl,--strip-all"),
    *("-Wl,-z,stack-size=65536", "-w"),
)
"""Flags of the compiler: no library, no contracted products, which would round otherwise."""
_PATIENCE_S = 300.0


def has_compiler() -> bool:
    """Return whether the compiler is installed."""
    return find_spec("ziglang") is not None


def compile_webassembly(text: str) -> bytes:
    """Compile a program in C to WebAssembly.

    Raises:
        MissingExtraError: if the compiler is not installed.
        TegotaeError: if it refuses the program.
    """
    if not has_compiler():
        raise MissingExtraError(
            "no engine comes with the package for this controller, and the compiler that would "
            f"make one is not installed; {how_to_install('playground')}"
        )
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "lane.c").write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "ziglang", "cc", *FLAGS, "-o", "lane.wasm", "lane.c"]
        completed = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=_PATIENCE_S, check=False
        )
        if completed.returncode:
            errors = [line for line in completed.stderr.splitlines() if "error" in line] or [
                "no reason"
            ]
            raise TegotaeError(f"ziglang could not compile the engine: {errors[0]}")
        return (folder / "lane.wasm").read_bytes()
