"""Many hoppers in one vector environment of Gymnasium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count
from tegotae.envs._types import Info
from tegotae.envs.core import TELEMETRY, EnvStep, Hoppers
from tegotae.envs.settings import HopperSettings, TegotaeHopperSettings, settings_of
from tegotae.envs.spaces import action_space, draw, observation_space, pose
from tegotae.simulation.rollout import Scenario


class LaneScenarios:
    """What every lane's next episode meets.

    Lane i seeded with s draws what a single environment draws that was reset with seed s: a batch
    is so many single environments, to the last random number.
    """

    def __init__(self, settings: HopperSettings, lanes: int) -> None:
        self._settings = settings
        self._random: list[np.random.Generator | None] = [None] * lanes
        self._fixed = None if settings.draws else settings.scenario(None)

    def seed(
        self, seed: int | Sequence[int | None] | None, where: np.ndarray | None = None
    ) -> None:
        """Seed lane i with `seed + i`, or each with its own; None leaves a lane as it is.

        Raises:
            TegotaeError: for a list of seeds that has not one per lane.
        """
        lanes = len(self._random)
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + i for i in range(lanes)]
        else:
            seeds = seed
        if len(seeds) != lanes:
            raise TegotaeError(f"there are {len(seeds)} seeds for {lanes} lanes; give one per lane")
        if self._fixed is not None:
            return
        for lane, own in enumerate(seeds):
            if own is not None and (where is None or where[lane]):
                self._random[lane], _ = seeding.np_random(own)

    def next(
        self, where: np.ndarray | None = None, options: Mapping[str, ArrayLike] | None = None
    ) -> list[Scenario]:
        """One scenario a lane; lanes outside the mask `where` draw nothing.

        Args:
            where: which lanes begin an episode; all by default.
            options: numbers by name, or arrays of shape [lanes], that stand for these episodes.
        """
        lanes = len(self._random)
        if self._fixed is not None and not options:
            return [self._fixed] * lanes
        columns = {
            name: np.broadcast_to(_array(name, value, lanes), (lanes,)).tolist()
            for name, value in (options or {}).items()
        }
        idle = self._fixed or Scenario(omega=0.0)
        return [
            self._settings.scenario(
                self._generator(lane), {name: column[lane] for name, column in columns.items()}
            )
            if where is None or where[lane]
            else idle
            for lane in range(lanes)
        ]

    def _generator(self, lane: int) -> np.random.Generator | None:
        if self._fixed is None and self._random[lane] is None:
            self._random[lane], _ = seeding.np_random()
        return self._random[lane]


def _array(name: str, value: ArrayLike, lanes: int) -> np.ndarray:
    array = np.asarray(value)
    if array.shape not in ((), (lanes,)):
        raise TegotaeError(
            f"option {name} has shape {array.shape}; it must be a number or have shape ({lanes},)"
        )
    return array


class HopperVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Many `tegotae/Hopper-v0` at once: what `gymnasium.make_vec` makes.

    Every lane behaves as a single environment that was seeded with its own seed (seed + i).

    Args:
        num_envs: how many hoppers.
        render_mode: `rgb_array` (a frame per hopper), or None.
        autoreset_mode: what happens to a lane whose episode has ended: it is reset by the next
            step, whose action it ignores ("NextStep"), at once ("SameStep": the last observation
            is `info["final_obs"]`), or by the user with `options={"reset_mask": mask}`
            ("Disabled").
        settings: the fields of `HopperSettings`, by name, the same for all lanes; what is a range
            is drawn by each lane for itself.

    Raises:
        TegotaeError: for a setting or mode that does not exist or cannot be used.

    Example:
        >>> envs = HopperVectorEnv(1000, height_m=(1.1, 1.3))
        >>> observations, infos = envs.reset(seed=0)
        >>> actions = np.zeros((1000, 1), np.float32)
        >>> observations, rewards, terminations, truncations, infos = envs.step(actions)
        >>> observations.shape, rewards.shape
        ((1000, 2), (1000,))
    """

    metadata: Info = {  # noqa: RUF012 - Gymnasium's own type
        "render_modes": ["rgb_array"],
        "render_fps": 50,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    SETTINGS: ClassVar[type[HopperSettings]] = HopperSettings

    def __init__(
        self,
        num_envs: int = 1,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **settings: object,
    ) -> None:
        require_count("num_envs", num_envs)
        if render_mode not in (None, "rgb_array"):
            raise TegotaeError(f"render_mode is {render_mode!r}; a batch knows 'rgb_array' or None")
        try:
            mode = AutoresetMode(autoreset_mode)
        except ValueError:
            names = ", ".join(mode.value for mode in AutoresetMode)
            raise TegotaeError(
                f"autoreset_mode is {autoreset_mode!r}; it must be one of {names}"
            ) from None
        self.settings = settings_of(self.SETTINGS, settings)
        self.num_envs, self.render_mode = num_envs, render_mode
        self.metadata = {**self.metadata, "autoreset_mode": mode}
        self.single_observation_space = observation_space(self.settings)
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._mode = mode
        self._hoppers = Hoppers(self.settings, num_envs)
        self._scenarios = LaneScenarios(self.settings, num_envs)
        self._ended = np.zeros(num_envs, np.bool_)
        self._last: EnvStep | None = None

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: Info | None = None
    ) -> tuple[np.ndarray, Info]:
        """Start episodes in all lanes, or in those of `options["reset_mask"]`.

        Other options are chosen numbers for these episodes, such as `height_m`: a number, or one
        per lane.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        options = {} if options is None else dict(options)
        where = options.pop("reset_mask", None)
        if where is not None:
            where = np.asarray(where)
            if where.shape != (self.num_envs,) or where.dtype != np.bool_:
                raise TegotaeError(
                    f"reset_mask has shape {where.shape} and type {where.dtype}; it must be "
                    f"booleans of shape ({self.num_envs},)"
                )
        if self._last is None:
            where = None
        self._scenarios.seed(seed, where)
        self._last = self._hoppers.reset(self._scenarios.next(where, options), where)
        began = np.ones(self.num_envs, np.bool_) if where is None else where
        self._ended = self._ended & ~began
        return self._last.observation, self._infos(self._last, began)

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Info]:
        """Hold actions, shape [num_envs, 1], for `decimation` control ticks.

        Raises:
            TegotaeError: before `reset`, for bad actions, or, where lanes are not reset
                automatically, if one has ended.
        """
        actions = np.asarray(actions, np.float32)
        if actions.shape != (self.num_envs, 1):
            raise TegotaeError(
                f"the actions have shape {actions.shape}; they must be ({self.num_envs}, 1)"
            )
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise TegotaeError(
                f"the episode of lane {int(self._ended.argmax())} has ended; reset it with "
                "reset(options={'reset_mask': mask})"
            )
        step = self._hoppers.step(actions[:, 0])
        rewards = step.reward.astype(np.float64)
        terminated, truncated = step.terminated, step.truncated
        every = np.ones(self.num_envs, np.bool_)
        infos = self._infos(step, every)
        if self._mode is AutoresetMode.NEXT_STEP and self._ended.any():
            begin = self._ended
            step = self._hoppers.reset(self._scenarios.next(begin), begin)
            rewards[begin] = 0.0
            terminated, truncated = terminated & ~begin, truncated & ~begin
            infos = self._infos(step, every)
        ended = terminated | truncated
        if self._mode is AutoresetMode.SAME_STEP and ended.any():
            final = step
            step = self._hoppers.reset(self._scenarios.next(ended), ended)
            infos = {
                **self._infos(step, every),
                "final_obs": _objects(final.observation, ended),
                "_final_obs": ended.copy(),
                "final_info": self._infos(final, ended),
                "_final_info": ended.copy(),
            }
        self._ended = ended if self._mode is not AutoresetMode.SAME_STEP else np.zeros_like(ended)
        self._last = step
        return step.observation, rewards, terminated, truncated, infos

    def render(self) -> tuple[np.ndarray, ...] | None:
        """A frame for each hopper, or None without a render mode."""
        if self.render_mode is None:
            return None
        if self._last is None:
            raise TegotaeError("there is nothing to draw yet; call reset() before render()")
        return tuple(draw(pose(self.settings, self._last, i)) for i in range(self.num_envs))

    def _infos(self, step: EnvStep, where: np.ndarray) -> Info:
        """`info` of all lanes, as Gymnasium lays it out: a value and a mask by name."""
        infos: Info = {}
        for name, column in zip(TELEMETRY, step.telemetry.T, strict=True):
            infos[name] = np.where(where, column, 0.0)
            infos[f"_{name}"] = where.copy()
        return infos


class TegotaeHopperVectorEnv(HopperVectorEnv):
    """Many `tegotae/TegotaeHopper-v0` at once, with the fields of `TegotaeHopperSettings`."""

    SETTINGS = TegotaeHopperSettings


def _objects(rows: np.ndarray, where: np.ndarray) -> np.ndarray:
    """The rows of a mask as objects, None elsewhere."""
    objects = np.full(len(rows), None, dtype=object)
    for lane in np.flatnonzero(where):
        objects[lane] = rows[lane].copy()
    return objects
