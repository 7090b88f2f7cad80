"""Cost of a leg: bodies with one leg and with several, and MuJoCo with one that walks."""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from research.benchmarks import engine, mujoco_walker
from tegotae._support.errors import MissingExtraError
from tegotae.parts.bodies import (
    Bar,
    Body,
    Hopper,
    Plate,
    Walker,
)
from tegotae.parts.terms import EllipticFoot
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe

WALKER_TICK_S = 0.01
"""Tick of the walker [√(l0/g)], at which lags, speed and cost of transport hold within 1 %
(`docs/studies/legs_validation.md`)."""
FOOT = EllipticFoot(shift_rad=0.4)
OMEGA = 2.1


class BodySpeed(NamedTuple):
    """Speed of a body."""

    name: str
    legs: int
    tick_s: float
    """Control tick, or time step [s]; of a walker [√(l0/g)]."""
    ticks_per_s: float
    """Ticks per second of time that passes, over all lanes."""
    ticks_per_core_s: float
    """Ticks per second that a core is at work."""
    compile_core_s: float = 0.0
    """Core-seconds to trace, lower and compile the program."""


@dataclass(frozen=True)
class LastFrame:
    """The summary of a rollout: work, and whether it failed."""

    needs = ("work_absolute_j", "failed")

    def __call__(self, trajectory, scenario, body, timing):
        """Summarise the last frame."""
        return trajectory.work_absolute_j[-1], trajectory.failed[-1]


def measure_body(name: str, body: Body, lanes: int, tick_s: float = WALKER_TICK_S) -> BodySpeed:
    """Measure a body under vanilla Tegotae, each lane from its own phases; `tick_s` is that of a
    walker.
    """
    walks = isinstance(body, Walker)
    controller = dataclasses.replace(recipe("V-sector-w8").controller(), limbs=body.limbs)
    timing = Timing(duration_s=10.0)
    scenario = Scenario(omega=8.0)
    if walks:
        controller = dataclasses.replace(controller, actuation=FOOT)
        timing = Timing(duration_s=20.0, tick_s=tick_s, frame_s=10 * tick_s)
        scenario = Scenario(omega=OMEGA, height_m=body.touching_height_m)
    shape = (body.limbs, lanes) if body.limbs > 1 else (lanes,)
    phases = np.random.default_rng(0).uniform(0.0, 2 * np.pi, shape)
    run = Rollout(controller=controller, timing=timing, summary=LastFrame())
    gains = np.full((lanes, 1), 1.25 if walks else 1.0)
    speed = engine.timed(run, gains, scenario._replace(phase_rad=phases), body)
    return BodySpeed(name, body.limbs, timing.tick_s, *speed)


BODIES: dict[str, type[Body]] = {"hopper": Hopper, "bar": Bar, "plate": Plate, "walker": Walker}
"""Those that are timed."""


def measure_bodies(lanes: int = 1024, bodies: Sequence[str] = tuple(BODIES)) -> list[BodySpeed]:
    """Measure bodies under their oscillators."""
    return [measure_body(name, BODIES[name](), lanes) for name in bodies]


def mujoco(lanes: int = 256) -> list[BodySpeed]:
    """Measure the walker's bare twin in MuJoCo, or return None if MuJoCo is not installed.

    MuJoCo steps its model under a command made beforehand, with nothing to feel and nothing
    recorded; the walker's row is the whole closed loop.
    """
    try:
        rates = mujoco_walker.mujoco_ticks_per_second(Walker(), FOOT, omega=OMEGA, lanes=lanes)
    except MissingExtraError:
        return []
    return [
        BodySpeed("MuJoCo, no controller", Walker().limbs, mujoco_walker.Settings().tick, *rates)
    ]


if __name__ == "__main__":
    print(json.dumps(measure_bodies(int(sys.argv[1]), sys.argv[2:])))
