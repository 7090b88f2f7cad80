"""A walker from the side and from above."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from tegotae._support.errors import TegotaeError
from tegotae.analysis.gaits.releases import GaitRun
from tegotae.figures.animation import FRAMES_PER_S, Animation
from tegotae.figures.style import COLOURS, new_figure
from tegotae.parts.bodies import Body, BodyWrapper, Walker
from tegotae.parts.bodies.upright import Upright
from tegotae.parts.bodies.walker.mechanics import from_angles, rotation
from tegotae.simulation.recorder import Trajectory
from tegotae.systems.legged import Legged

_PLANE = np.array([1.0, 1j, 0.0])
"""Makes of a place x + iy, which turns by a factor."""


class LegPositions(NamedTuple):
    """Places in the world, x forward, y left, z up [m]."""

    hips_m: np.ndarray
    """[frames, limbs, 3]"""
    feet_m: np.ndarray
    """[frames, limbs, 3]"""
    stands: np.ndarray
    """True for feet on the ground, [frames, limbs]."""
    heading_rad: np.ndarray | None = None
    """Heading of the body, [frames]; None of one that does not turn."""

    def along_torso(self) -> LegPositions:
        """Return the pose as seen by an observer who turns and walks with the torso.

        The torso looks forward in every frame. Forward is how far it has come along its heading,
        so that a foot on the ground still stays where it is, but for the turning.
        """
        if self.heading_rad is None:
            return self
        turn = np.exp(-1j * self.heading_rad)[:, None]
        middle = (self.hips_m @ _PLANE).mean(axis=1, keepdims=True)
        path = np.cumsum(turn * np.diff(middle, axis=0, prepend=middle[:1]), axis=0)

        def moved(places: np.ndarray) -> np.ndarray:
            seen = path + turn * (places @ _PLANE - middle)
            return np.stack([seen.real, seen.imag, places[..., 2]], axis=-1)

        return self._replace(hips_m=moved(self.hips_m), feet_m=moved(self.feet_m))


@singledispatch
def pose(body: Body, trajectory: Trajectory) -> LegPositions:
    """Return the pose of a body in every frame.

    Args:
        body: the body.
        trajectory: of one lane, [frames, limbs] or [frames].

    Raises:
        TegotaeError: for a body for which none is registered.
    """
    raise TegotaeError(
        f"a {type(body).__name__} cannot be drawn: register its pose with "
        "tegotae.figures.gaits.animation.pose.register"
    )


@pose.register
def _(body: BodyWrapper, trajectory: Trajectory) -> LegPositions:
    return pose(body.body, trajectory)


@pose.register
def _(body: Upright, trajectory: Trajectory) -> LegPositions:
    z = np.repeat(trajectory.height_m[:, None], body.limbs, axis=1)
    for turn in body.turns:
        z = z + np.asarray(turn.arms_m) * trajectory.channels[f"{turn.name}_rad"][:, None]
    x = getattr(body, "hips_x_m", None) or body.hips_m  # type: ignore[attr-defined]
    y = getattr(body, "hips_z_m", (0.0,) * body.limbs)
    x, y = (np.broadcast_to(np.asarray(places), z.shape) for places in (x, y))
    ground = trajectory.ground_m[:, None]
    foot = np.maximum(ground, z - body.rest_length_m)
    return LegPositions(
        np.stack([x, y, z], axis=-1),
        np.stack([x, y, foot], axis=-1),
        z - body.rest_length_m < ground,
    )


@pose.register
def _(body: Walker, trajectory: Trajectory) -> LegPositions:
    t = trajectory
    turn = rotation(
        from_angles(*(t.channels[f"{a}_rad"][:, None] for a in ("roll", "pitch", "yaw")))
    )
    of_body = (
        np.asarray(body.hips_x_m)[None] - body.com_x_m,
        np.asarray(body.hips_y_m)[None] - body.com_y_m,
        np.full((1, body.limbs), -body.com_z_m),
    )
    positions = np.stack([t.x_m, t.y_m, t.height_m], axis=-1)[:, None]
    hips = positions + np.stack([np.asarray(x) for x in turn.to_world(of_body)], axis=-1)  # type: ignore[arg-type]
    feet = np.stack([t.foot_x_m, t.foot_y_m, t.foot_z_m], axis=-1)
    return LegPositions(hips, feet, np.asarray(t.stands, bool), t.channels["yaw_rad"])


STRIDES = 4.0
"""Number of final strides shown, a stride a second."""
_SIDE, _ABOVE = (0, 2), (0, 1)
_MARGIN = 0.25


def gait_animation(run: GaitRun) -> Animation:
    """Return the animation, one stride a second; without strides, of the last quarter at once.

    Raises:
        TegotaeError: for a body that cannot be drawn.
    """
    return moving(run.legged, run.trajectory, _frames(run), lambda _: run.gait)


def moving(
    legged: Legged, trajectory: Trajectory, frames: np.ndarray, note: Callable[[int], str]
) -> Animation:
    """Return the animation of some frames of a rollout of one lane.

    Args:
        legged: the system.
        trajectory: all channels, [frames, limbs] of legs, else [frames].
        frames: the recorded frames that are shown, in their order.
        note: what the title says at a frame, such as the gait.

    Raises:
        TegotaeError: for a body that cannot be drawn.
    """
    shape = pose(legged.body, trajectory).along_torso()
    names, wide = legged.names, np.ptp(shape.hips_m[0, :, 1]) > 0.0
    views = (_SIDE, _ABOVE) if wide else (_SIDE,)
    long = np.ptp(shape.hips_m[0, :, 0]) + 2.0 * _MARGIN + 0.5 * legged.body.rest_length_m  # type: ignore[attr-defined]
    figure = new_figure(4.4, 4.2 if wide else 2.8)
    scenes = np.atleast_1d(figure.subplots(len(views), 1))  # type: ignore[call-overload]
    artists = [
        _View(axes, shape, view, long, legged, frames)
        for axes, view in zip(scenes, views, strict=True)
    ]
    scenes[-1].set_xlabel(f"forward [{legged.units[0]}]")
    label = scenes[0].set_title(" ")

    def draw(index: int) -> None:
        time = float(trajectory.time_s[index])
        standing = " ".join(
            name if on else "·" * len(name)
            for name, on in zip(names, shape.stands[index], strict=True)
        )
        label.set_text(f"{time:6.2f} {legged.units[1]}   {note(index)}   {standing}")
        for artist in artists:
            artist.draw(index)

    draw(int(frames[0]))
    return Animation(figure, draw, frames.tolist())


class _View:
    """The body from one side: its outline, its legs and its feet."""

    def __init__(
        self,
        axes: Axes,
        shape: LegPositions,
        view: tuple[int, int],
        long: float,
        legged: Legged,
        frames: np.ndarray,
    ) -> None:
        self.axes, self.shape, self.view, self.long = axes, shape, view, long
        axes.set_aspect("equal", adjustable="box")
        axes.set_ylabel(f"{'up' if view is _SIDE else 'left'} [{legged.units[0]}]")
        if view is _SIDE:
            top = max(shape.hips_m[frames][..., 2].max(), np.nanmax(shape.feet_m[frames][..., 2]))
            axes.axhspan(-1e3, 0.0, color="0.88", lw=0)
            axes.set_ylim(-0.15, float(top) + _MARGIN)
        (self.outline,) = axes.fill([0.0], [0.0], color="0.75", ec="k", lw=1.0, zorder=2)
        colours = [COLOURS[i % len(COLOURS)] for i in range(legged.body.limbs)]
        self.legs = [axes.plot([], [], "-", color=x, lw=1.6, zorder=3)[0] for x in colours]
        self.feet = [axes.plot([], [], "o", color=x, ms=6, zorder=4)[0] for x in colours]
        self.order = _hips_in_order(shape.hips_m[0])

    def draw(self, index: int) -> None:
        """Move everything to a frame; the view follows the body."""
        across, up = self.view
        hips, feet = self.shape.hips_m[index], self.shape.feet_m[index]
        self.outline.set_xy(hips[self.order][:, self.view])
        for i, (leg, foot) in enumerate(zip(self.legs, self.feet, strict=True)):
            leg.set_data([hips[i, across], feet[i, across]], [hips[i, up], feet[i, up]])
            foot.set_data([feet[i, across]], [feet[i, up]])
            foot.set_fillstyle("full" if self.shape.stands[index, i] else "none")
        middle = float(hips[:, across].mean())
        self.axes.set_xlim(middle - 0.5 * self.long, middle + 0.5 * self.long)
        if self.view is _ABOVE:
            aside = float(hips[:, up].mean())
            self.axes.set_ylim(aside - 0.45 * self.long, aside + 0.45 * self.long)


def _hips_in_order(hips: np.ndarray) -> np.ndarray:
    """Return the hips in their order along a line around the body."""
    off = hips[:, :2] - hips[:, :2].mean(axis=0)
    return np.argsort(np.arctan2(off[:, 1], off[:, 0]), kind="stable")


def _frames(run: GaitRun) -> np.ndarray:
    """Return the recorded frames that are shown: of the last strides, evenly in time."""
    last = len(run.trajectory.time_s) - 1
    if np.isfinite(run.stride_s) and STRIDES * run.stride_s < last * run.timing.frame_s:
        count, back = round(STRIDES * FRAMES_PER_S), STRIDES * run.stride_s / run.timing.frame_s
    else:
        count, back = min(4 * FRAMES_PER_S, last), 0.25 * last
    return np.unique(np.round(np.linspace(last - back, last, count)).astype(int))
