"""Episodes of robots on legs under commands, in lanes: each with its law, command and start."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from research.public_robots import plan
from tegotae._support.files import output_folder
from tegotae.envs.command import CommandSchedule
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.env import ModelEnv, ModelLanes
from tegotae.envs.robot_file import load_robot
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import Wiring
from tegotae.envs.wrapper import Pilot
from tegotae.parts.units import Units
from tegotae.systems.recipe import recipe
from tegotae_robots.api.suggesting_wirings import suggest_wiring

ROOT = plan.FOLDER.parents[1]
RUNS = ROOT / "runs" / "public_robots"


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as `tegotae wiring suggest` has it, under the law.

    Args:
        spec: the model with its settings.
        wiring: of the law, without weights.
    """

    spec: EnvSpec
    wiring: Wiring

    @property
    def units(self) -> Units:
        """l0, √(l0 / g) and the weight."""
        assert self.wiring.units is not None
        return self.wiring.units

    @property
    def scale(self) -> np.ndarray:
        """Unit of a command: forward, left [m/s] and yaw rate [rad/s]."""
        units = self.units
        speed = units.length_m / units.time_s
        return np.array([speed, speed, 1.0 / units.time_s])


@lru_cache
def robot_named(name: str) -> Robot:
    """Return a robot of the plan; its file is written if it is not there."""
    file = output_folder(RUNS) / f"{name}.toml"
    if not file.exists():
        model = plan.MODELS[name]
        suggest_wiring(model if ":" in model else str(ROOT / model)).save(file)
    spec, wiring = load_robot(file)
    law = recipe("raibert@quadruped-c").controller()
    return Robot(spec, wiring.reading(law))


class Lanes(Protocol):
    """Lanes of a physics engine, as `ModelLanes` are."""

    names: tuple[str, ...]

    def reset(self, seed: np.ndarray, where: np.ndarray) -> np.ndarray:
        """Begin episodes; return the observations, [lanes, entries]."""
        ...

    def step(
        self, actions: np.ndarray, alive: np.ndarray, push_n: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Advance by a control period; the first result is the observations."""
        ...

    def close(self) -> None:
        """End."""
        ...


@dataclass(frozen=True)
class Walks:
    """Results of episodes, [lanes].

    Args:
        lasted: share of the time until a fall, 1 without one.
        followed: displacement along the commanded path over what was asked; NaN after a fall.
        heading_error_rad: heading at the end less what was asked; likewise.
        cost_of_transport: ∫|τ q̇| over weight and that displacement; likewise.
    """

    lasted: np.ndarray
    followed: np.ndarray
    heading_error_rad: np.ndarray
    cost_of_transport: np.ndarray

    @property
    def fell(self) -> np.ndarray:
        """True of a robot that fell."""
        return self.lasted < 1.0


def walks(
    robot: Robot,
    numbers: np.ndarray,
    commands: np.ndarray,
    starts: np.ndarray,
    seconds: float,
    *,
    pushes: np.ndarray | None = None,
    lanes_of: type[ModelLanes] = ModelLanes,
) -> Walks:
    """Simulate lanes of laws, each at its command.

    Args:
        robot: of all.
        numbers: frequency and weights of the law at l0 = m = g = 1, [lanes, 14].
        commands: forward, left and yaw rate in units of the robot, [lanes, 3].
        starts: seeds, [lanes].
        seconds: how long [s].
        pushes: velocity to the left that a push adds [√(g l0)], [lanes]; none by default.
        lanes_of: lanes of the physics engine.
    """
    n, units = len(numbers), robot.units
    command = commands * robot.scale
    schedule = CommandSchedule(np.zeros(1), command[None])
    settings = replace(robot.spec.model_settings, duration_s=seconds)
    wires, problems = look_up(env := ModelEnv(settings), robot.wiring)
    assert wires is not None, problems
    env.close()
    lanes: Lanes = lanes_of(settings, n, schedule=schedule)
    omega = numbers[:, 0] / units.time_s
    law = Pilot(wires, replace(robot.wiring, omega=float(omega[0])), numbers[:, 1:].T)
    law.restart(np.ones(n, bool), omega)
    alive, lasted, steps = np.ones(n, bool), np.zeros(n), round(seconds / wires.step_s)
    entries = ("forward", "left", "height", "upright", "yaw_rate")
    columns = [lanes.names.index(f"root_{name}") for name in entries]
    work_column = lanes.names.index("work")
    observed = lanes.reset(starts, alive)
    path, work = np.zeros((steps + 1, len(columns), n)), np.zeros(n)
    path[0] = observed[:, columns].T
    rest_m = robot.wiring.rest_length_m
    assert rest_m is not None
    first = plan.PUSHED_AT * units.time_s
    last = first + plan.PUSH_LONG * units.time_s
    mass = units.force_n * units.time_s**2 / units.length_m
    for k in range(steps):
        push_n = np.zeros((n, 3))
        if pushes is not None and first <= k * wires.step_s < last:
            push_n[:, 1] = mass * pushes * robot.scale[0] / (last - first)
        observed, _, _ = lanes.step(law.act(observed), alive, push_n)
        path[k + 1] = observed[:, columns].T
        _, _, height, upright, _ = path[k + 1]
        alive = alive & (height > plan.LOW * rest_m) & (upright > math.cos(plan.TILTED_RAD))
        work = np.where(alive, observed[:, work_column], work)
        lasted += alive
        if not alive.any():
            break
    lanes.close()
    only = np.where(alive, 1.0, np.nan)
    time_s = wires.step_s * np.arange(1, steps + 1)
    direction = time_s[:, None] * command[:, 2] + np.arctan2(command[:, 1], command[:, 0])
    forward, aside = np.diff(path[:, :2], axis=0).transpose(1, 0, 2)
    along = (forward * np.cos(direction) + aside * np.sin(direction)).sum(axis=0)
    distance = np.linalg.norm(command[:, :2], axis=1) * seconds
    heading = wires.step_s * path[1:, 4].sum(axis=0)
    return Walks(
        lasted=lasted / steps,
        followed=only * along / distance,
        heading_error_rad=only * (heading - command[:, 2] * seconds),
        cost_of_transport=only * work / (units.force_n * np.maximum(along, 1e-3)),
    )
