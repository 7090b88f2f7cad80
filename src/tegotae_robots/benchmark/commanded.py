"""Controllers that take commands of velocity, and what becomes of their episodes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from tegotae._support.errors import TegotaeError, other_code
from tegotae.envs.command import CommandSchedule, heading_rate
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.policies import Answers, network
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import read_by
from tegotae.envs.wrapper import Pilot
from tegotae.systems.controller_file import SavedController
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.benchmark.conditions import FIELD_M, RobotCondition
from tegotae_robots.benchmark.course import TRUNK, Course

COMMANDS: dict[str, tuple[float, float, float]] = {
    **{f"forward {v:g}": (v, 0.0, 0.0) for v in (0.3, 0.6, 1.2, 1.8, 2.5)},
    "back 0.6": (-0.6, 0.0, 0.0),
    "left 0.4": (0.0, 0.4, 0.0),
    "turn 1": (0.0, 0.0, 1.0),
    "curve 0.6, 0.8": (0.6, 0.0, 0.8),
    "aslant 0.4, 0.3": (0.4, 0.3, 0.0),
}
"""Commands by name: forward, left [m/s] and yaw rate [rad/s]."""
AWAY_RAD, SLOW = np.pi / 2.0, 0.5
"""A robot turned away if its heading ends further off; it lags below this share of its path."""
_DEFAULT_RAD = {"hip": 0.1, "thigh": 0.9, "calf": -1.8}
_ACTION_RAD = 0.5
"""Range of an action of a joystick policy."""
_ENTRIES = 48


class LanePolicy(Protocol):
    """Controller of all lanes."""

    @property
    def read(self) -> list[int]:
        """Return the entries of the observation that it reads."""
        ...

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions [lanes, actions] for observations [lanes, entries]."""
        ...


@dataclass(frozen=True)
class Commanded:
    """A controller that takes commands of velocity, and the robot that it is made for.

    Args:
        settings: of its robot: model, servos, period.
        driver: makes what drives the lanes of a course at commands [lanes, 3].
        trunk: whether it reads the trunk's true velocity.
    """

    settings: ModelSettings
    driver: Callable[[Course, np.ndarray], LanePolicy]
    trunk: bool = False


class LawDriver(Pilot):
    """A law on the limbs of a robot."""

    @property
    def read(self) -> list[int]:
        """Return the entries of the observation that it reads."""
        return sorted({int(k) for entries, _ in self._wires.sensed.values() for k in entries})


def law(
    saved: SavedController, weights: np.ndarray | None = None, omega: np.ndarray | None = None
) -> Commanded:
    """Return a saved law that takes commands.

    Args:
        saved: the law.
        weights: those of the lanes, [lanes, n_weights]; its own by default.
        omega: frequencies of the lanes [rad/s], [lanes]; its own by default.

    Raises:
        TegotaeError: for a law without commands.
    """
    if saved.task is None or "commanded_speed" not in read_by(saved.system.controller):
        raise TegotaeError(f"{saved.name} takes no command; give a law that does, such as raibert")
    experiment = EnvExperiment.from_controller(saved)
    table = np.ravel(saved.weights)[None] if weights is None else weights

    def driver(course: Course, commands: np.ndarray) -> LanePolicy:
        wires, problems = look_up(course.env, experiment.wiring)
        if wires is None:
            raise TegotaeError(f"{saved.name} does not fit the robot: {'; '.join(problems)}")
        rows = np.broadcast_to(table, (len(commands), table.shape[1]))
        pilot = LawDriver(wires, experiment.wiring, np.asarray(rows, np.float32).T)
        if omega is not None:
            pilot.restart(np.ones(len(commands), bool), omega)
        return pilot

    return Commanded(experiment.spec.model_settings, driver)


def joystick(path: Path, settings: ModelSettings, holds_heading: bool = True) -> Commanded:
    """Return a joystick policy in the form of MuJoCo Playground, a network in ONNX.

    It observes 48 numbers: the trunk's velocity, its gyroscope and the direction down, in its axes;
    joints less their defaults, their rates, its last output, and the command. Its output, times 0.5
    rad, is added to the defaults of the joints, which are 0.1, 0.9 and -1.8 rad of hip, thigh and
    calf. Joints come leg by leg: FR, FL, RR, RL. The yaw rate of its command is that which holds
    the heading by the gyroscope, as a law's is.

    Args:
        path: of the network.
        settings: of the robot, with the policy's own servos and period.
        holds_heading: whether it is told to hold its heading; else it gets the plain command.

    Raises:
        TegotaeError: for a network of other numbers, or a robot with other joints.
    """
    answer, entries = network(path)
    if entries not in (None, _ENTRIES):
        raise TegotaeError(f"{path} observes {entries} numbers; a joystick policy has {_ENTRIES}")
    legless = dataclasses.replace(settings, legs=False, command=())

    def driver(course: Course, commands: np.ndarray) -> LanePolicy:
        return _Joystick(answer, course, commands, holds_heading)

    return Commanded(legless, driver, trunk=True)


class _Joystick:
    """A joystick policy on the lanes of a course."""

    def __init__(
        self, answer: Answers, course: Course, commands: np.ndarray, holds_heading: bool
    ) -> None:
        legs = ("FR", "FL", "RR", "RL")
        joints = [f"{leg}_{part}_joint" for leg in legs for part in _DEFAULT_RAD]
        if lacking := [name for name in joints if name not in course.names]:
            raise TegotaeError(f"the robot has no joint {lacking[0]}; the policy is for Go1")
        model, sensed = course.model, course.sensing
        driven = [model.joint(int(model.actuator_trnid[i, 0])).name for i in sensed.driven]
        self._order = [joints.index(name) for name in driven]
        angles, rates = (
            [course.names.index(name + x) for name in joints] for x in ("", "_velocity")
        )
        self.read = [*(course.names.index(name) for name in TRUNK), *angles, *rates]
        sides = np.repeat([1.0, -1.0, 1.0, -1.0], 3) * np.tile([1.0, 0.0, 0.0], 4)
        default = np.tile([*_DEFAULT_RAD.values()], 4)
        self._default = np.where(sides != 0.0, sides * default, default)
        self._answer, self._commands, self._holds = answer, commands, holds_heading
        self._behind_rad, self._step_s = np.zeros(len(commands)), course.step_s
        self._last = np.zeros((len(commands), len(joints)))

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the angles of the joints [rad], [lanes, actions]."""
        felt = observed[:, self.read]
        felt[:, 9:21] -= self._default
        # By how much the heading is behind the commanded one, by the gyroscope.
        self._behind_rad += self._step_s * (self._commands[:, 2] - felt[:, 5])
        command = self._commands.copy()
        command[:, 2] += self._holds * heading_rate(self._behind_rad)
        columns = [felt, self._last, command]
        with other_code("the policy failed"):
            self._last = np.asarray(self._answer(np.concatenate(columns, axis=1)), float)
        return (self._default + _ACTION_RAD * self._last)[:, self._order]


@dataclass(frozen=True)
class CommandedEpisodes:
    """Results of episodes under commands, [lanes]."""

    fell: np.ndarray
    """True of a robot that fell."""
    lasted: np.ndarray
    """Share of the time until a fall, 1 without one."""
    followed: np.ndarray
    """Displacement along the commanded path over what was asked; NaN without, or after a fall."""
    astray_m: np.ndarray
    """Displacement of a robot that is to stay on its place."""
    heading_error_rad: np.ndarray
    """Heading at the end less what was asked."""
    turned: np.ndarray
    """Turned over what was asked."""
    inside: np.ndarray
    """Share of the time on the field, where the condition has one."""
    cost_of_transport: np.ndarray
    """Work ∫|τ q̇| of the actuators over weight and displacement along the commanded path."""

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """The columns of a table, with `turned_away` and `lags`."""
        away = np.abs(self.heading_error_rad) > AWAY_RAD
        return dataclasses.asdict(self) | {"turned_away": away, "lags": self.followed < SLOW}


def judge(
    entry: Commanded,
    commands: np.ndarray,
    starts: Sequence[int],
    condition: RobotCondition,
    seconds: float = 20.0,
) -> CommandedEpisodes:
    """Simulate lanes of a controller, each at its command from its start.

    Args:
        entry: the controller.
        commands: forward, left [m/s] and yaw rate [rad/s], [lanes, 3].
        starts: seeds of the starts, and of blocks and rough ground, [lanes].
        condition: of all lanes.
        seconds: duration of an episode [s].
    """
    n = len(commands)
    schedule = CommandSchedule(np.zeros(1), commands[None]) if entry.settings.legs else None
    course = Course(entry.settings, condition, starts, seconds, schedule, entry.trunk)
    course.reset(np.asarray(starts), np.ones(n, bool))
    driver, steps = entry.driver(course, commands), round(seconds / course.step_s)
    place, quaternion = np.zeros((steps, n, 2)), np.zeros((steps, n, 4))
    alive, lasted = np.ones(n, bool), np.zeros(n)
    for k in range(steps):
        alive &= course.step(driver.act(course.felt(driver.read)), alive)
        place[k], quaternion[k] = course.states[:, 1:3], course.states[:, 4:8]
        lasted += alive
        if not alive.any():
            break
    course.close()
    work_j = course.seen[:, course.names.index("work")]
    (x0, y0), (x1, y1) = FIELD_M
    x, y = np.moveaxis(place, -1, 0)
    inside = ((x > x0) & (x < x1) & (y > y0) & (y < y1)).mean(axis=0)
    w, i, j, k = np.moveaxis(quaternion, -1, 0)
    heading = np.unwrap(np.arctan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)), axis=0)
    speed = np.linalg.norm(commands[:, :2], axis=1)
    time_s = course.step_s * (np.arange(steps) + 1.0)
    direction = time_s[1:, None] * commands[:, 2] + np.arctan2(commands[:, 1], commands[:, 0])
    moved = np.diff(place, axis=0)
    along = (moved[..., 0] * np.cos(direction) + moved[..., 1] * np.sin(direction)).sum(axis=0)
    turned, stands = heading[-1] - heading[0], np.where(alive, 1.0, np.nan)

    def over(value: np.ndarray, denominator: np.ndarray) -> np.ndarray:
        return stands * np.where(
            denominator != 0.0, value / np.where(denominator != 0.0, denominator, 1.0), np.nan
        )

    weight_n = np.where(speed > 0.0, course.weight_n * np.maximum(along, 1e-2), 0.0)
    away_m = np.where(speed > 0.0, np.nan, np.hypot(*(place[-1] - place[0]).T))
    return CommandedEpisodes(
        fell=~alive,
        lasted=lasted / steps,
        followed=over(along, speed * seconds),
        astray_m=stands * away_m,
        heading_error_rad=stands * (turned - commands[:, 2] * seconds),
        turned=over(turned, commands[:, 2] * seconds),
        inside=stands * np.where(condition.has_field, inside, np.nan),
        cost_of_transport=over(work_j, weight_n),
    )


def with_servos(settings: ModelSettings, servos: Sequence[float], period_s: float) -> ModelSettings:
    """Return a robot's settings with servos [N m/rad, N m s/rad] and a period [s] of another
    controller.
    """
    changes: dict[str, Any] = {"control_s": period_s}
    changes |= dict(zip(("servo_nm_per_rad", "servo_damping_nms_per_rad"), servos, strict=True))
    return dataclasses.replace(settings, **changes)
