"""Thousands of hoppers as a Stable-Baselines3 `VecEnv`, one compiled call a step."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

import gymnasium
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require, require_count
from tegotae.envs._types import Info
from tegotae.envs.core import TELEMETRY, EnvStep, Hoppers
from tegotae.envs.settings import HopperSettings
from tegotae.envs.spaces import action_space, draw, observation_space, pose
from tegotae.envs.vector import LaneScenarios

require("stable_baselines3", "sb3")

from stable_baselines3.common.monitor import Monitor  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402


class LaneVecEnv(VecEnv):
    """Lanes that are stepped together, without environments of their own: they share attributes."""

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute, the same for each lane asked for."""
        value = getattr(self, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(
        self, attr_name: str, value: object, indices: int | Iterable[int] | None = None
    ) -> None:
        """Set an attribute of all lanes."""
        if len(list(self._get_indices(indices))) != self.num_envs:
            raise TegotaeError("the lanes of a batch share their attributes; set them for all")
        setattr(self, attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: object,
        indices: int | Iterable[int] | None = None,
        **method_kwargs: object,
    ) -> NoReturn:
        """There are no environments behind the lanes whose methods could be called."""
        raise TegotaeError(
            f"lanes have no environments of their own, and so no method {method_name!r}"
        )

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """False for each lane asked for, but true of `Monitor`, whose record is kept here."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]


class HopperVecEnv(LaneVecEnv):
    """Many hopper environments as one Stable-Baselines3 `VecEnv`; see `make_sb3`.

    A lane whose episode ends is reset within the same step; its `info` then holds
    `terminal_observation`, `TimeLimit.truncated`, the episode's `telemetry`, and what SB3's
    `Monitor` writes as `episode` (return r, length l, seconds t), so that SB3 logs its usual
    curves. In other steps a lane's `info` is empty.

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
        require_count("num_envs", num_envs)
        if render_mode not in (None, "rgb_array"):
            raise TegotaeError(f"render_mode is {render_mode!r}; a batch knows 'rgb_array' or None")
        self.settings = settings
        self.render_mode = render_mode
        self._hoppers = Hoppers(settings, num_envs)
        self._scenarios = LaneScenarios(settings, num_envs)
        self._actions = np.zeros((num_envs, 1), np.float32)
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, np.int64)
        self._last: EnvStep | None = None
        self._begun = time.time()
        super().__init__(num_envs, observation_space(settings), action_space())

    def reset(self) -> np.ndarray:
        """Start an episode in every lane, with the seeds and options set before."""
        self._scenarios.seed(self._seeds)
        step = self._hoppers.reset(self._scenarios.next(None, _columns(self._options)))
        self._reset_seeds()
        self._reset_options()
        self._returns[:] = 0.0
        self._lengths[:] = 0
        self._last = step
        self.reset_infos = [_telemetry(step, lane) for lane in range(self.num_envs)]
        return step.observation

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, shape [num_envs, 1], for the step to come."""
        actions = np.asarray(actions, np.float32)
        if actions.shape != (self.num_envs, 1):
            raise TegotaeError(
                f"the actions have shape {actions.shape}; they must be ({self.num_envs}, 1)"
            )
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[Info]]:
        """Step, and begin new episodes where one ended."""
        step = self._hoppers.step(self._actions[:, 0])
        self._returns += step.reward
        self._lengths += 1
        done = step.terminated | step.truncated
        infos: list[Info] = [{} for _ in range(self.num_envs)]
        observation = step.observation
        self._last = step
        if done.any():
            elapsed = round(time.time() - self._begun, 6)
            self._last = self._hoppers.reset(self._scenarios.next(done), done)
            observation = self._last.observation
            for lane in np.flatnonzero(done).tolist():
                infos[lane] = {
                    "terminal_observation": step.observation[lane].copy(),
                    "TimeLimit.truncated": bool(step.truncated[lane]),
                    "telemetry": _telemetry(step, lane),
                    "episode": {
                        "r": round(float(self._returns[lane]), 6),
                        "l": int(self._lengths[lane]),
                        "t": elapsed,
                    },
                }
                self.reset_infos[lane] = _telemetry(self._last, lane)
            self._returns[done] = 0.0
            self._lengths[done] = 0
        return observation, step.reward, done, infos

    def close(self) -> None:
        """Nothing is held open."""

    def get_images(self) -> Sequence[np.ndarray | None]:
        """A frame for each hopper."""
        if self._last is None:
            raise TegotaeError("there is nothing to draw yet; call reset() before render()")
        return [draw(pose(self.settings, self._last, lane)) for lane in range(self.num_envs)]


def _telemetry(step: EnvStep, lane: int) -> dict[str, float]:
    return dict(zip(TELEMETRY, step.telemetry[lane].tolist(), strict=True))


def _columns(options: list[Info]) -> Mapping[str, ArrayLike]:
    """Options by lane, as SB3 keeps them, by name."""
    names = {name for lane in options for name in lane}
    for name in names:
        if any(name not in lane for lane in options):
            raise TegotaeError(f"option {name} is set for some lanes only; set it for all")
    return {name: [lane[name] for lane in options] for name in sorted(names)}
