"""Spaces and pictures of the hopper's environments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box

from tegotae.envs.core import TELEMETRY, EnvStep, observation_bounds
from tegotae.envs.settings import HopperSettings

SIZE = 256
"""Width and height of a frame [pixels]."""

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
_COLUMN, _ROW = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
_LEG_COLUMN, _MASS_RADIUS = SIZE * 0.4, 11.0
_DIAL_CENTRE, _DIAL_RADIUS = (SIZE - 36.0, 36.0), 24.0


@dataclass(frozen=True, kw_only=True)
class Pose:
    """What there is to draw."""

    height_m: float
    """Height of the mass [m]."""
    ground_m: float
    """Height of the ground [m]."""
    rest_length_m: float
    """Rest length of the leg [m]."""
    push_share: float
    """Actuator force as a share of the largest, 0 ... 1."""
    phase_rad: float | None
    """Phase of the oscillator [rad]; None without one."""


def draw(pose: Pose) -> np.ndarray:
    """The hopper on its ground, uint8, shape [SIZE, SIZE, 3].

    The leg reddens with the actuator force; the dial at the upper right shows the phase, zero to
    the right and growing counterclockwise. The frame reaches from half a leg under the undropped
    ground to two and a half legs above it; who hops higher leaves it.
    """
    pixels_per_m = SIZE / (3.0 * pose.rest_length_m)

    def row(height_m: float) -> float:
        return SIZE - (height_m + 0.5 * pose.rest_length_m) * pixels_per_m

    frame = np.empty((SIZE, SIZE, 3), np.uint8)
    frame[:] = _SKY
    frame[row(pose.ground_m) <= _ROW] = _GROUND
    mass = row(pose.height_m)
    # In flight the leg has its rest length; in stance its foot is on the ground.
    foot = row(max(pose.ground_m, pose.height_m - pose.rest_length_m))
    share = float(np.clip(pose.push_share, 0.0, 1.0))
    leg = ((1.0 - share) * _LEG + share * _PUSH).astype(np.uint8)
    frame[(np.abs(_COLUMN - _LEG_COLUMN) < 3.0) & (mass <= _ROW) & (foot > _ROW)] = leg
    frame[_disc((_LEG_COLUMN, mass), _MASS_RADIUS)] = _MASS
    if pose.phase_rad is not None:
        ring = _disc(_DIAL_CENTRE, _DIAL_RADIUS) & ~_disc(_DIAL_CENTRE, _DIAL_RADIUS - 2.0)
        frame[ring] = _RIM
        hand = (
            _DIAL_CENTRE[0] + _DIAL_RADIUS * np.cos(pose.phase_rad),
            _DIAL_CENTRE[1] - _DIAL_RADIUS * np.sin(pose.phase_rad),
        )
        frame[_disc(hand, 5.0)] = _PUSH
    return frame


def _disc(centre: tuple[float, float], radius: float) -> np.ndarray:
    return (_COLUMN - centre[0]) ** 2 + (_ROW - centre[1]) ** 2 < radius**2


class Window:
    """A matplotlib window that shows frames; without a display it draws and shows nothing."""

    def __init__(self, title: str) -> None:
        import matplotlib.pyplot as plt

        self._plt = plt
        self._figure, axes = plt.subplots(figsize=(4, 4), num=title, clear=True)
        axes.set_axis_off()
        self._image = axes.imshow(np.zeros((SIZE, SIZE, 3), np.uint8))
        self._interactive = plt.get_backend().lower() not in ("agg", "pdf", "svg", "ps", "template")

    def show(self, frame: np.ndarray, pause_s: float) -> None:
        """Show a frame for a while."""
        self._image.set_data(frame)
        if self._interactive:
            self._plt.pause(pause_s)

    def close(self) -> None:
        """Close the window."""
        self._plt.close(self._figure)


def action_space() -> Box:
    """One number in [-1, 1]."""
    return Box(-1.0, 1.0, (1,), np.float32)


def observation_space(settings: HopperSettings) -> Box:
    """The observed entries in their bounds."""
    bounds = observation_bounds(settings)
    one_sided = np.array([name == "spring_force" for name in settings.observed])
    return Box(np.where(one_sided, np.float32(0.0), -bounds), bounds, dtype=np.float32)


def pose(settings: HopperSettings, step: EnvStep, lane: int) -> Pose:
    """What there is to draw of one lane."""
    now = dict(zip(TELEMETRY, step.telemetry[lane].tolist(), strict=True))
    return Pose(
        height_m=now["height_m"],
        ground_m=now["ground_m"],
        rest_length_m=settings.body.rest_length_m,
        push_share=now["actuator_force_n"] / settings.body.max_force_n,
        phase_rad=None if settings.controller.oscillator is None else now["phase_rad"],
    )
