"""One hopper with Gymnasium's interface."""

from __future__ import annotations

from typing import ClassVar

import gymnasium
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.envs._types import Info
from tegotae.envs.core import TELEMETRY, EnvStep, Hoppers
from tegotae.envs.settings import HopperSettings, TegotaeHopperSettings, settings_of
from tegotae.envs.spaces import Window, action_space, draw, observation_space, pose

RENDER_MODES = ["rgb_array", "human"]
_FRAMES_PER_SECOND = 50


class HopperEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """`tegotae/Hopper-v0`: the agent's action is the actuator force of a hopper.

    Args:
        render_mode: `rgb_array`, `human` (a matplotlib window), or None.
        settings: the fields of `HopperSettings`, by name.

    Raises:
        TegotaeError: for a setting or render mode that does not exist or cannot be used.

    Example:
        >>> env = HopperEnv(observation=("spring_force", "velocity", "height"))
        >>> observation, info = env.reset(seed=0)
        >>> env.observation_space.shape, round(info["height_m"], 3)
        ((3,), 1.2)
        >>> observation, reward, terminated, truncated, info = env.step(np.array([1.0], np.float32))
        >>> reward, terminated, truncated
        (0.0, False, False)
    """

    metadata: Info = {  # noqa: RUF012 - Gymnasium's own type
        "render_modes": RENDER_MODES,
        "render_fps": _FRAMES_PER_SECOND,
    }
    SETTINGS: ClassVar[type[HopperSettings]] = HopperSettings

    def __init__(self, render_mode: str | None = None, **settings: object) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise TegotaeError(
                f"render_mode is {render_mode!r}; it must be one of {', '.join(RENDER_MODES)}"
            )
        self.settings = settings_of(self.SETTINGS, settings)
        self.render_mode = render_mode
        self.observation_space = observation_space(self.settings)
        self.action_space = action_space()
        self._hoppers = Hoppers(self.settings, 1)
        self._last: EnvStep | None = None
        self._window: Window | None = None
        self._shown_s = 0.0

    def reset(
        self, *, seed: int | None = None, options: Info | None = None
    ) -> tuple[np.ndarray, Info]:
        """Start an episode; `options` may set any chosen number for it, such as `height_m`."""
        super().reset(seed=seed)
        scenario = self.settings.scenario(self.np_random, options)
        self._last = self._hoppers.reset([scenario])
        self._shown_s = -np.inf
        self._show()
        return self._last.observation[0], self._info()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, Info]:
        """Hold an action, shape [1], for `decimation` control ticks.

        Raises:
            TegotaeError: before `reset`, after the episode's end, or for a bad action.
        """
        if self._last is not None and (self._last.terminated[0] or self._last.truncated[0]):
            raise TegotaeError("the episode has ended; call reset() before step()")
        action = np.asarray(action, np.float32)
        if action.shape != (1,):
            raise TegotaeError(f"the action has shape {action.shape}; it must be (1,)")
        last = self._last = self._hoppers.step(action)
        self._show()
        ended = bool(last.terminated[0]), bool(last.truncated[0])
        return last.observation[0], float(last.reward[0]), *ended, self._info()

    def render(self) -> np.ndarray | None:
        """The present frame where `render_mode` is `rgb_array`; a window shows itself.

        Raises:
            TegotaeError: before `reset`.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(
                "render() without a render_mode; choose one of "
                f"{', '.join(RENDER_MODES)} when making the environment"
            )
            return None
        if self._last is None:
            raise TegotaeError("there is nothing to draw yet; call reset() before render()")
        return draw(pose(self.settings, self._last, 0)) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _info(self) -> Info:
        assert self._last is not None
        return dict(zip(TELEMETRY, self._last.telemetry[0].tolist(), strict=True))

    def _show(self) -> None:
        """Update the window, at most so many times a simulated second."""
        if self.render_mode != "human":
            return
        assert self._last is not None
        now = float(self._last.telemetry[0, TELEMETRY.index("time_s")])
        if now - self._shown_s < 0.999 / _FRAMES_PER_SECOND:
            return
        self._shown_s = now
        self._window = self._window or Window(type(self).__name__)
        self._window.show(draw(pose(self.settings, self._last, 0)), 1.0 / _FRAMES_PER_SECOND)


class TegotaeHopperEnv(HopperEnv):
    """`tegotae/TegotaeHopper-v0`: the agent's action is the Tegotae feedback f.

    Oscillator and actuation are part of the environment, so that the agent's network stands where
    `G · A′(φ) · R(s)` stood. Its settings are those of `TegotaeHopperSettings`.

    Example:
        >>> env = TegotaeHopperEnv(omega=8.0, actuation="sector")
        >>> observation, info = env.reset()
        >>> observation.tolist()
        [0.0, 1.0, 0.0]
        >>> _, _, _, _, info = env.step(np.array([0.0], np.float32))
        >>> round(info["phase_rad"], 4)  # 10 ms at 8 rad/s
        0.08
    """

    SETTINGS = TegotaeHopperSettings
