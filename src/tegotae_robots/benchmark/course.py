"""Episodes of a robot on legs, in lanes under one condition, each at its own time.

A fall is a trunk below half of its height at the start, or tilted by more than 1 rad.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from tegotae.envs.command import CommandSchedule
from tegotae.envs.mujoco.env import ModelEnv, ModelLanes
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import started
from tegotae_robots.benchmark.conditions import RobotCondition, model_of

LOW, TILTED = 0.5, math.cos(1.0)
"""Share of the height at the start, and cosine of the tilt, below which a robot fell."""
_PUSH_S = 0.1
TRUNK = tuple(f"trunk_{name}_{axis}" for name in ("velocity", "turn", "down") for axis in "xyz")
"""Entries of a trunk's true velocity [m/s], its turning [rad/s] and the direction down, in its
axes."""


class Course:
    """Lanes of a robot under one condition.

    Args:
        settings: of the robot.
        condition: of all lanes.
        layouts: of blocks or rough ground, if there are any, [lanes].
        seconds: the longest episode [s].
        schedule: commands of the lanes, if the controller takes some.
        trunk: whether the entries `TRUNK` are observed, too.
    """

    def __init__(
        self,
        settings: ModelSettings,
        condition: RobotCondition,
        layouts: Sequence[int],
        seconds: float,
        schedule: CommandSchedule | None = None,
        trunk: bool = False,
    ) -> None:
        lanes, drawn = len(layouts), condition.blocks_m or condition.rough_m
        different = dict.fromkeys(layouts if drawn else [0])
        settings = dataclasses.replace(settings, command=() if schedule is None else (0, 0, 0))
        variants = {layout: model_of(condition, settings, layout) for layout in different}
        settings, self.model = next(iter(variants.values()))
        settings = dataclasses.replace(settings, duration_s=seconds)
        self.env, self._condition = ModelEnv(settings), condition
        models = [variants[layout][1] if drawn else self.model for layout in layouts]
        self._lanes = ModelLanes(settings, lanes, models=models, schedule=schedule)
        self.sensing, self.step_s = self._lanes.sensing, self.env.dt
        self.names = [*self._lanes.names, *(TRUNK if trunk else ())]
        self.mass_kg = float(self.model.body_mass.sum())
        self.weight_n = self.mass_kg * float(np.linalg.norm(self.model.opt.gravity))
        self._draws: list[np.random.Generator] = [np.random.default_rng()] * lanes
        self._trunk, self._nq = trunk, int(self.model.nq)
        self.phases = np.zeros((len(settings.feet), lanes))
        """Where oscillators begin that begin anywhere [rad], [legs, lanes]."""
        self.seen = np.zeros((lanes, len(self.names)))
        """The observations as they are, [lanes, entries]."""
        late = round(condition.delay_s / self.step_s)
        self._past, self._taken = np.zeros((late + 1, *self.seen.shape)), np.zeros(lanes, int)
        self._scale, self._height = np.zeros(len(self.names)), self.names.index("root_height")
        self._upright = self.names.index("root_upright")
        self._low_m = LOW * float(started(self.model).xpos[1, 2])

    def reset(self, starts: np.ndarray, where: np.ndarray) -> None:
        """Begin new episodes of some lanes; starts and where are [lanes]."""
        self.seen = self._with_trunk(self._lanes.reset(starts, where))
        self._past[:, where], self._taken[where] = self.seen[where], 0
        for lane in np.flatnonzero(where):
            self._draws[lane] = np.random.default_rng([37, int(starts[lane])])
            if self._condition.random_phases:
                self.phases[:, lane] = self._draws[lane].uniform(0.0, 2.0 * np.pi, len(self.phases))

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
        leftward, right = ((time_s >= x) & (time_s < x + _PUSH_S - 1e-9) for x in (5.0, 15.0))
        push = self.mass_kg * self._condition.push_m_per_s / _PUSH_S
        push_n[:, 1] = (leftward * 1.0 - right) * push
        self.seen = self._with_trunk(self._lanes.step(actions, alive, push_n)[0])
        self._past = np.concatenate([self._past[1:], self.seen[None]])
        self._taken += 1
        return (self.seen[:, self._height] > self._low_m) & (self.seen[:, self._upright] > TILTED)

    def _with_trunk(self, observed: np.ndarray) -> np.ndarray:
        """Return the observations with those of the trunk, where they are asked for."""
        if not self._trunk:
            return observed
        states = self.states[:, 1:]
        w, x, y, z = states[:, 3:7].T
        down = -np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
        leftward = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)])
        ahead = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)])
        world, turn = states[:, self._nq : self._nq + 3], states[:, self._nq + 3 : self._nq + 6]
        velocity = ahead * world[:, 0] + leftward * world[:, 1] - down * world[:, 2]
        return np.concatenate([observed, velocity.T, turn, down.T], axis=1)

    @property
    def states(self) -> np.ndarray:
        """MuJoCo's states of the lanes, to be drawn, [lanes, numbers]."""
        return self._lanes.batch.states

    def close(self) -> None:
        """End the threads."""
        self.env.close()
        self._lanes.close()
