"""Steps of an agent per second: the batch beside the same environment in a `DummyVecEnv`.

Run as a program, `python -m research.benchmarks.vec_env`; needs the extra `sb3`.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.errors import require
from tegotae.envs import make_sb3
from tegotae.envs._types import AnyEnv

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv

NAME = "tegotae/TegotaeHopper-v0"
LANES = (64, 1024, 4096)
DUMMY_LANES = 64
"""A `DummyVecEnv` is a loop: its steps per second do not grow with its lanes."""


def steps_per_second(env: VecEnv, steps: int, repeats: int = 10) -> float:
    """Return the steps of an agent per second over all lanes, after compilation; the best of
    some runs.
    """
    rng = np.random.default_rng(0)
    actions = rng.uniform(-0.3, 0.3, (env.num_envs, 1)).astype(np.float32)
    env.reset()
    env.step(actions)
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        for _ in range(steps):
            env.step(actions)
        times.append(time.perf_counter() - begun)
    return env.num_envs * steps / min(times)


def throughput(decimation: int) -> dict[str, float]:
    """Return the steps per second of a `DummyVecEnv` (key "DummyVecEnv") and of batches, by
    their size.
    """
    dummy = require("stable_baselines3.common.vec_env", "sb3").DummyVecEnv
    monitor = require("stable_baselines3.common.monitor", "sb3").Monitor
    make = require("gymnasium", "gym").make

    def single() -> AnyEnv:
        return monitor(make(NAME, decimation=decimation))

    rates = {"DummyVecEnv": steps_per_second(dummy([single] * DUMMY_LANES), steps=10)}
    for lanes in LANES:
        rates[f"batch of {lanes}"] = steps_per_second(
            make_sb3(NAME, lanes, decimation=decimation), steps=50
        )
    return rates


def main() -> None:
    """Print a table for an agent that acts at every tick, and one that acts at every tenth."""
    for decimation in (1, 10):
        rates = throughput(decimation)
        print(f"{NAME}, {decimation} ticks a step")
        for name, rate in rates.items():
            print(f"  {name:>14}  {rate:9.3g} steps/s  {rate / rates['DummyVecEnv']:6.1f} x")


if __name__ == "__main__":
    main()
