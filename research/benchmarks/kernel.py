"""The limit: the same hopper and controller as a kernel written by hand, `kernel.cpp`."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from research.benchmarks import engine
from tegotae._support.engines import available_cores
from tegotae.simulation.rollout import Rollout, Scenario, Timing

SOURCE = Path(__file__).with_suffix(".cpp")
_OPTIONS = ("-std=c++17", "-O3", "-march=native", "-ffast-math", "-pthread")
_ROUNDS = 5


class KernelSpeed(NamedTuple):
    """Speeds of the kernel and of the engine: the best of rounds that alternate."""

    ticks_per_s: float
    """Control ticks of the kernel per second of time that passes."""
    ticks_per_core_s: float
    """Its ticks per second that a core is at work."""
    engine_share: float
    """The engine's ticks per core-second over the kernel's."""


def compiler() -> str | None:
    """Return a C++ compiler of this machine."""
    return next(filter(None, map(shutil.which, ("g++", "clang++", "c++"))), None)


class CompiledKernel:
    """The compiled kernel; a context manager, whose folder is removed at its end.

    Args:
        compiler: of C++, for this processor.
    """

    def __init__(self, compiler: str) -> None:
        self._folder = TemporaryDirectory()
        self._program = Path(self._folder.name) / "kernel"
        subprocess.run([compiler, *_OPTIONS, str(SOURCE), "-o", str(self._program)], check=True)

    def __enter__(self) -> CompiledKernel:
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def run(self, weights: np.ndarray, ticks: int) -> tuple[np.ndarray, float, float]:
        """Roll out lanes at 5 rad/s, with ticks of a millisecond.

        Args:
            weights: [lanes, 96]; lanes are a multiple of 32.
            ticks: of each lane.

        Returns:
            Height climbed in flight [m], absolute work [J] and failure, [3, lanes]; seconds that
            passed; and core-seconds.
        """
        words = (len(weights), ticks, available_cores())
        completed = subprocess.run(
            [self._program, *map(str, words)],
            input=np.ascontiguousarray(weights.T, "float32").tobytes(),
            capture_output=True,
            check=True,
        )
        passed, worked = map(float, completed.stderr.split())
        return np.frombuffer(completed.stdout, "float32").reshape(3, -1), passed, worked


def kernel_speed(lanes: int = 1024, duration_s: float = 10.0) -> KernelSpeed | None:
    """Measure the kernel's speed beside the engine's, or return None without a C++ compiler."""
    executable = compiler()
    if executable is None:
        return None
    timing = Timing(duration_s=duration_s)
    reference = Rollout(
        controller=engine.benchmark_controller(), timing=timing, summary=engine.totals
    )
    weights = engine.weights(-(-lanes // 32) * 32)
    ticks = len(weights) * timing.n_frames * timing.ticks_per_frame
    reference.run(weights, Scenario(omega=5.0))
    rounds = []
    with CompiledKernel(executable) as kernel:
        for _ in range(_ROUNDS):
            begun = time.process_time()
            reference.run(weights, Scenario(omega=5.0))
            spent = time.process_time() - begun
            rounds.append((spent, *kernel.run(weights, ticks // len(weights))[1:]))
    of_engine, passed, worked = np.min(rounds, axis=0).tolist()
    return KernelSpeed(ticks / passed, ticks / worked, worked / of_engine)
