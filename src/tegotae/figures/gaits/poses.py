"""Where a body's hips and feet are, frame by frame: all that is needed to draw it.

A body of your own is drawn once this is registered for it: `@pose.register`.
"""

from __future__ import annotations

from functools import singledispatch
from typing import NamedTuple

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body, BodyWrapper, Walker
from tegotae.parts.bodies.upright import Upright
from tegotae.parts.bodies.walker.mechanics import from_angles, rotation
from tegotae.simulation.recorder import Trajectory


class LegPositions(NamedTuple):
    """Places in the world, x forward, y left, z up [m]."""

    hips_m: np.ndarray
    """[frames, limbs, 3]"""
    feet_m: np.ndarray
    """[frames, limbs, 3]"""
    stands: np.ndarray
    """Whether a foot is on the ground, [frames, limbs]."""
    heading_rad: np.ndarray | None = None
    """Where the body looks, [frames]; None of one that does not turn."""

    def along_torso(self) -> LegPositions:
        """The same as seen by someone who turns and walks with the torso.

        The torso looks forward in every frame. Forward is how far it has come along its heading,
        so that a foot on the ground still stays where it is, but for the turning.
        """
        if self.heading_rad is None:
            return self
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)

        def turned(xy: np.ndarray) -> np.ndarray:
            c, s = (each.reshape(-1, *[1] * (xy.ndim - 2)) for each in (cos, sin))
            return np.stack(
                [c * xy[..., 0] + s * xy[..., 1], c * xy[..., 1] - s * xy[..., 0]], axis=-1
            )

        middle = self.hips_m[..., :2].mean(axis=1)
        way = np.cumsum(turned(np.diff(middle, axis=0, prepend=middle[:1])), axis=0)

        def moved(places: np.ndarray) -> np.ndarray:
            off = turned(places[..., :2] - middle[:, None])
            return np.concatenate([way[:, None] + off, places[..., 2:]], axis=-1)

        return self._replace(hips_m=moved(self.hips_m), feet_m=moved(self.feet_m))


@singledispatch
def pose(body: Body, trajectory: Trajectory) -> LegPositions:
    """The pose of a body in every frame.

    Args:
        body: the body.
        trajectory: of one lane, [frames, limbs] or [frames].

    Raises:
        TegotaeError: for a body for which none is registered.
    """
    raise TegotaeError(
        f"a {type(body).__name__} cannot be drawn: register its pose with "
        "tegotae.figures.gaits.poses.pose.register"
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
    at = np.stack([t.x_m, t.y_m, t.height_m], axis=-1)[:, None]
    hips = at + np.stack([np.asarray(x) for x in turn.to_world(of_body)], axis=-1)  # type: ignore[arg-type]
    feet = np.stack([t.foot_x_m, t.foot_y_m, t.foot_z_m], axis=-1)
    return LegPositions(hips, feet, np.asarray(t.stands, bool), t.channels["yaw_rad"])
