"""The channels of a walker beside those of every body."""

from __future__ import annotations

from typing import cast

import jax
import jax.numpy as jnp

from tegotae.parts.bodies.attitude import angles
from tegotae.parts.bodies.walker.legs import ground_under, stance_of
from tegotae.parts.bodies.walker.numbers import WalkerNumbers
from tegotae.parts.bodies.walker.state import WalkerState
from tegotae.parts.channels import Channel, RecordedFrame, State, Total


def _state(frame: RecordedFrame) -> WalkerState:
    return frame.lane.moment.body


CHANNELS: tuple[Channel, ...] = (
    State("x_m", "Centre of mass, forward [m].", lambda f: _state(f).position[0]),
    State("y_m", "Centre of mass, to the left [m].", lambda f: _state(f).position[1]),
    State("roll_rad", "Roll, to the right [rad].", lambda f: angles(_state(f).attitude)[0]),
    State("pitch_rad", "Pitch, nose down [rad].", lambda f: angles(_state(f).attitude)[1]),
    State("yaw_rad", "Yaw, to the left [rad].", lambda f: angles(_state(f).attitude)[2]),
    State("slid_m", "How far the feet have slid [m], a limb.", lambda f: _state(f).slid),
    State("stands", "1 of a foot on the ground, else 0, a limb.", lambda f: _state(f).stands),
    State("foot_x_m", "Where the foot is, forward [m], a limb.", lambda f: _foot(f, 0)),
    State("foot_y_m", "Where the foot is, to the left [m], a limb.", lambda f: _foot(f, 1)),
    State("foot_z_m", "Where the foot is, upwards [m], a limb.", lambda f: _foot(f, 2)),
    Total(
        "stance_s",
        "Total of the time on the ground [s], a limb.",
        lambda t: t.contact.stance_share * t.tick_s,
    ),
)
"""What a walker records beside what is recorded of every body."""


def _foot(frame: RecordedFrame, axis: int) -> jax.Array:
    """Where the feet are: their anchors on the ground, else the commanded places."""
    state, body = _state(frame), cast(WalkerNumbers, frame.body)
    stance = stance_of(body, state, frame.ground_m)
    stands = stance.contact & (state.stands > 0.5)
    ahead, aside = stance.anchor
    at = (ahead, aside, ground_under(body, ahead, aside, frame.ground_m))[axis]
    return jnp.where(stands, at, stance.place[axis])
