"""Thousands of hoppers as a Stable-Baselines3 `VecEnv`, one compiled call a step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

import gymnasium
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import Info
from tegotae.envs.core import EnvStep, Hoppers, action_space, observation_space
from tegotae.envs.hoppers import check_render_mode, draw_frame
from tegotae.envs.settings import HopperSettings

require("stable_baselines3", "sb3")

from stable_baselines3.common.vec_env import VecEnv  # noqa: E402


class LaneVecEnv(VecEnv):
    """Lanes that are stepped together, without environments of their own: they share attributes."""

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """Return an attribute, the same for each requested lane."""
        value = getattr(self, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(
        self, attr_name: str, value: object, indices: int | Iterable[int] | None = None
    ) -> None:
        """Set an attribute of all lanes."""
        if len(list(self._get_indices(indices))) != self.num_envs:
            raise TegotaeError("the lanes of a batch share their attributes; set them for all")
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *_: object, **__: object) -> NoReturn:
        """Refuse the call: no environments with methods are behind the lanes."""
        raise TegotaeError(
            f"lanes have no environments of their own, and so no method {method_name!r}"
        )

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """Return False for each requested lane."""
        return [False for _ in self._get_indices(indices)]


class HopperVecEnv(LaneVecEnv):
    """Many hopper environments as one Stable-Baselines3 `VecEnv`; see `make_sb3`.

    A lane whose episode ends is reset within the same step; its `info` then holds
    `terminal_observation`, `TimeLimit.truncated` and the episode's `telemetry`. In other steps a
    lane's `info` is empty.

    Args:
        settings: `HopperSettings` or `TegotaeHopperSettings`.
        num_envs: how many hoppers.
        render_mode: `rgb_array` or None.

    Raises:
        TegotaeError: for settings or a mode that cannot be used.
    """

    def __init__(
        self, settings: HopperSettings, num_envs: int, render_mode: str | None = None
    ) -> None:
        check_render_mode(render_mode, ["rgb_array"])
        self.settings = settings
        self.render_mode = render_mode
        self._hoppers = Hoppers(settings, num_envs)
        self._actions = np.zeros((num_envs, 1), np.float32)
        self._last: EnvStep | None = None
        super().__init__(num_envs, observation_space(settings), action_space())

    def reset(self) -> np.ndarray:
        """Start an episode in every lane, with the seeds and options set before."""
        self._hoppers.seed(self._seeds)
        step = self._last = self._hoppers.reset(options=_columns(self._options))
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [step.info(lane) for lane in range(self.num_envs)]
        return step.observation

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, shape [num_envs, 1], for the step to come."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[Info]]:
        """Step, and begin new episodes where one ended."""
        step = self._last = self._hoppers.step(self._actions)
        ended = step.terminated | step.truncated
        infos: list[Info] = [{} for _ in range(self.num_envs)]
        if ended.any():
            self._last = self._hoppers.reset(ended)
            for lane in np.flatnonzero(ended).tolist():
                infos[lane] = {
                    "terminal_observation": step.observation[lane].copy(),
                    "TimeLimit.truncated": bool(step.truncated[lane]),
                    "telemetry": step.info(lane),
                }
                self.reset_infos[lane] = self._last.info(lane)
        return self._last.observation, step.reward, ended, infos

    def close(self) -> None:
        """Do nothing, since nothing is open."""

    def get_images(self) -> Sequence[np.ndarray | None]:
        """Return a frame for each hopper."""
        return [draw_frame(self.settings, self._last, lane) for lane in range(self.num_envs)]


def _columns(options: list[Info]) -> Mapping[str, ArrayLike]:
    """Return options by lane, as SB3 keeps them, by name."""
    names = {name for lane in options for name in lane}
    for name in names:
        if any(name not in lane for lane in options):
            raise TegotaeError(f"option {name} is set for some lanes only; set it for all")
    return {name: [lane[name] for lane in options] for name in sorted(names)}
