"""The hopper with Gymnasium's interfaces: one alone, many at once, and their pictures."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from tegotae._support.errors import TegotaeError, unknown
from tegotae.envs._types import Info
from tegotae.envs.core import TELEMETRY, EnvStep, Hoppers, action_space, observation_space
from tegotae.envs.settings import HopperSettings, TegotaeHopperSettings, hopper_settings_of

_SIZE = 256
"""Width and height of a frame [pixels]."""
_FRAMES_PER_SECOND = 50
_SKY, _GROUND, _LEG, _PUSH, _MASS, _RIM = (
    np.array(colour, np.uint8)
    for colour in (
        (245, 246, 248),
        (120, 113, 105),
        (60, 66, 74),
        (214, 72, 48),
        (38, 92, 160),
        (160, 166, 174),
    )
)
_COLUMN, _ROW = np.meshgrid(np.arange(_SIZE), np.arange(_SIZE))
_LEG_COLUMN, _MASS_RADIUS = _SIZE * 0.4, 11.0
_DIAL_CENTRE, _DIAL_RADIUS = (_SIZE - 36.0, 36.0), 24.0


def draw_frame(settings: HopperSettings, step: EnvStep | None, lane: int = 0) -> np.ndarray:
    """Draw the hopper of a lane on its ground, uint8, shape [SIZE, SIZE, 3].

    The leg reddens with the actuator force; the dial at the upper right shows the phase, zero to
    the right and growing counterclockwise. The frame reaches from half a leg under the undropped
    ground to two and a half legs above it; who hops higher leaves it.

    Raises:
        TegotaeError: before the first episode.
    """
    if step is None:
        raise TegotaeError("there is nothing to draw yet; call reset() before render()")
    info, length = step.info(lane), settings.body.rest_length_m
    ground, height = info["ground_m"], info["height_m"]
    pixels_per_m = _SIZE / (3.0 * length)

    def row(height_m: float) -> float:
        return _SIZE - (height_m + 0.5 * length) * pixels_per_m

    frame = np.empty((_SIZE, _SIZE, 3), np.uint8)
    frame[:] = _SKY
    frame[row(ground) <= _ROW] = _GROUND
    mass = row(height)
    # In flight the leg has its rest length; in stance its foot is on the ground.
    foot = row(max(ground, height - length))
    share = float(np.clip(info["actuator_force_n"] / settings.body.max_force_n, 0.0, 1.0))
    leg = ((1.0 - share) * _LEG + share * _PUSH).astype(np.uint8)
    frame[(np.abs(_COLUMN - _LEG_COLUMN) < 3.0) & (mass <= _ROW) & (foot > _ROW)] = leg
    frame[_disc((_LEG_COLUMN, mass), _MASS_RADIUS)] = _MASS
    if settings.controller.oscillator is not None:
        ring = _disc(_DIAL_CENTRE, _DIAL_RADIUS) & ~_disc(_DIAL_CENTRE, _DIAL_RADIUS - 2.0)
        frame[ring] = _RIM
        hand = (
            _DIAL_CENTRE[0] + _DIAL_RADIUS * np.cos(info["phase_rad"]),
            _DIAL_CENTRE[1] - _DIAL_RADIUS * np.sin(info["phase_rad"]),
        )
        frame[_disc(hand, 5.0)] = _PUSH
    return frame


def _disc(centre: tuple[float, float], radius: float) -> np.ndarray:
    return (_COLUMN - centre[0]) ** 2 + (_ROW - centre[1]) ** 2 < radius**2


class _Window:
    """A matplotlib window that shows frames; without a display it draws and shows nothing."""

    def __init__(self, title: str) -> None:
        import matplotlib.pyplot as plt

        self._plt = plt
        self._figure, axes = plt.subplots(figsize=(4, 4), num=title, clear=True)
        axes.set_axis_off()
        self._image = axes.imshow(np.zeros((_SIZE, _SIZE, 3), np.uint8))
        self._interactive = plt.get_backend().lower() not in ("agg", "pdf", "svg", "ps", "template")

    def show(self, frame: np.ndarray) -> None:
        """Show a frame for a while."""
        self._image.set_data(frame)
        if self._interactive:
            self._plt.pause(1.0 / _FRAMES_PER_SECOND)

    def close(self) -> None:
        """Close the window."""
        self._plt.close(self._figure)


def check_render_mode(mode: str | None, modes: list[str]) -> None:
    """Raise `TegotaeError` for a mode that is neither None nor one of these."""
    if mode is not None and mode not in modes:
        raise TegotaeError(f"render_mode is {mode!r}; it must be None or {', '.join(modes)}")


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
        "render_modes": ["rgb_array", "human"],
        "render_fps": _FRAMES_PER_SECOND,
    }
    SETTINGS: ClassVar[type[HopperSettings]] = HopperSettings

    def __init__(self, render_mode: str | None = None, **settings: object) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.settings = hopper_settings_of(self.SETTINGS, settings)
        self.render_mode = render_mode
        self.observation_space = observation_space(self.settings)
        self.action_space = action_space()
        self._hoppers = Hoppers(self.settings, 1)
        self._last: EnvStep | None = None
        self._window: _Window | None = None
        self._shown_s = 0.0

    def reset(
        self, *, seed: int | None = None, options: Info | None = None
    ) -> tuple[np.ndarray, Info]:
        """Start an episode; `options` may set any chosen number for it, such as `height_m`."""
        super().reset(seed=seed)
        self._hoppers.random[0] = self.np_random
        last = self._last = self._hoppers.reset(options=options)
        self._shown_s = -np.inf
        self._show(last)
        return last.observation[0], last.info(0)

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
        last = self._last = self._hoppers.step(action[None])
        self._show(last)
        ended = bool(last.terminated[0]), bool(last.truncated[0])
        return last.observation[0], float(last.reward[0]), *ended, last.info(0)

    def render(self) -> np.ndarray | None:
        """Return the present frame if `render_mode` is `rgb_array`; a window updates itself.

        Raises:
            TegotaeError: before `reset`.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(
                "render() without a render_mode; choose one of "
                f"{', '.join(self.metadata['render_modes'])} when making the environment"
            )
        return draw_frame(self.settings, self._last) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _show(self, step: EnvStep) -> None:
        """Update the window, at most a number of times per simulated second."""
        if self.render_mode != "human":
            return
        time_s = step.info(0)["time_s"]
        if time_s - self._shown_s < 0.999 / _FRAMES_PER_SECOND:
            return
        self._shown_s = time_s
        self._window = self._window or _Window(type(self).__name__)
        self._window.show(draw_frame(self.settings, step))


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
        "render_fps": _FRAMES_PER_SECOND,
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
        check_render_mode(render_mode, self.metadata["render_modes"])
        try:
            mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = [mode.value for mode in AutoresetMode]
            raise unknown("autoreset_mode", str(autoreset_mode), modes) from None
        self.settings = hopper_settings_of(self.SETTINGS, settings)
        self._hoppers = Hoppers(self.settings, num_envs)
        self.num_envs, self.render_mode, self._mode = num_envs, render_mode, mode
        self.metadata = {**self.metadata, "autoreset_mode": mode}
        self.single_observation_space = observation_space(self.settings)
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
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
        self._hoppers.seed(seed, where)
        self._last = self._hoppers.reset(where, options)
        begun = np.ones(self.num_envs, np.bool_) if where is None else where
        self._ended = self._ended & ~begun
        return self._last.observation, _infos(self._last, begun)

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Info]:
        """Hold actions, shape [num_envs, 1], for `decimation` control ticks.

        Raises:
            TegotaeError: before `reset`, for bad actions, or, where lanes are not reset
                automatically, if one has ended.
        """
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise TegotaeError(
                f"the episode of lane {int(self._ended.argmax())} has ended; reset it with "
                "reset(options={'reset_mask': mask})"
            )
        step = self._hoppers.step(actions)
        rewards = step.reward.astype(np.float64)
        terminated, truncated = step.terminated, step.truncated
        if self._mode is AutoresetMode.NEXT_STEP and self._ended.any():
            begin = self._ended
            step = self._hoppers.reset(begin)
            rewards[begin] = 0.0
            terminated, truncated = terminated & ~begin, truncated & ~begin
        ended, final = terminated | truncated, step
        at_once = self._mode is AutoresetMode.SAME_STEP and bool(ended.any())
        if at_once:
            step = self._hoppers.reset(ended)
        infos = _infos(step, np.ones(self.num_envs, np.bool_))
        if at_once:
            observations = np.full(self.num_envs, None, dtype=object)
            for lane in np.flatnonzero(ended):
                observations[lane] = final.observation[lane].copy()
            infos |= {"final_obs": observations, "_final_obs": ended.copy()}
            infos |= {"final_info": _infos(final, ended), "_final_info": ended.copy()}
        self._ended = np.zeros_like(ended) if self._mode is AutoresetMode.SAME_STEP else ended
        self._last = step
        return step.observation, rewards, terminated, truncated, infos

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Return a frame for each hopper, or None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(draw_frame(self.settings, self._last, lane) for lane in range(self.num_envs))


class TegotaeHopperVectorEnv(HopperVectorEnv):
    """Many `tegotae/TegotaeHopper-v0` at once, with the fields of `TegotaeHopperSettings`."""

    SETTINGS = TegotaeHopperSettings


def _infos(step: EnvStep, where: np.ndarray) -> Info:
    """Return `info` of all lanes in Gymnasium's layout: a value and a mask by name."""
    infos: dict[str, Any] = {}
    for name, column in zip(TELEMETRY, step.telemetry.T, strict=True):
        infos[name] = np.where(where, column, 0.0)
        infos[f"_{name}"] = where.copy()
    return infos
