"""An exported controller compiled as a shared library, and called from Python."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tegotae_robots.c import Export
from tegotae_robots.c.package import header
from tegotae_robots.c.source import source

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror")
SANITIZERS = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


class Compiled:
    """A compiled controller; every array is of float32, limb after limb."""

    def __init__(self, export: Export, folder: Path) -> None:
        self.export = export
        prefix = export.prefix
        (folder / f"{prefix}.c").write_text(source(export))
        (folder / f"{prefix}.h").write_text(header(export))
        library = folder / f"{prefix}.so"
        command = ["gcc", *FLAGS, "-O1", "-shared", "-fPIC", f"{prefix}.c", "-lm", "-o", library]
        subprocess.run(command, check=True, cwd=folder)
        loaded = ctypes.CDLL(str(library))
        self._library = loaded
        self._init, self._step = loaded[f"{prefix}_init"], loaded[f"{prefix}_step"]
        limbs = export.limbs
        self.leaves = len(export.state_names)
        # A frequency, if there is an oscillator, and the count of faults follow the oscillators.
        self.state = np.zeros(self.leaves * limbs + (self.leaves > 0) + 1, np.float32)
        self.inputs = np.zeros(max(1, len(export.senses) * limbs), np.float32)
        self.outputs = np.zeros(len(export.outputs) * limbs + 1, np.float32)

    def init(self, phase_rad) -> None:
        """Begin at a phase, or at the limbs' phases."""
        if not self.leaves:
            self._init(_at(self.state))
        elif self.export.limbs == 1:
            self._init(_at(self.state), ctypes.c_float(phase_rad))
        else:
            self._init(_at(self.state), _at(np.asarray(phase_rad, np.float32)))

    def step(self, inputs) -> np.ndarray:
        """One tick: the outputs [names, limbs], for inputs [senses, limbs]."""
        self.inputs[:] = np.ravel(inputs)
        self._step(_at(self.state), _at(self.inputs), _at(self.outputs))
        return self.outputs[:-1].reshape(-1, self.export.limbs).copy()

    @property
    def oscillators(self) -> np.ndarray:
        """Their state, [limbs, leaves]: a view."""
        count = self.leaves * self.export.limbs
        return self.state[:count].reshape(self.export.limbs, self.leaves)

    @property
    def fault(self) -> bool:
        """True if the last step met a number that is not finite."""
        return bool(self.outputs[-1:].view(np.uint8)[0])

    @property
    def faults(self) -> int:
        """Number of steps that met one."""
        return int(self.state[-1:].view(np.uint32)[0])

    def number(self, function: str, *values: float) -> float:
        """Call another function of the header for some numbers."""
        call = self._library[f"{self.export.prefix}_{function}"]
        call.restype = ctypes.c_float
        return call(*map(ctypes.c_float, values))


def _at(array: np.ndarray):
    return array.ctypes.data_as(ctypes.c_void_p)
