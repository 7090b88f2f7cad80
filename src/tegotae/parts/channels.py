"""Channels that a part records and commands that it accepts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import jax

Tick: TypeAlias = Any
"""Result of a control tick, a `tegotae.simulation.loop.Tick`: the loop stands above its parts."""
RecordedFrame: TypeAlias = Any
"""A lane at the end of a frame, a `tegotae.simulation.recorder.RecordedFrame`."""

FORCE = ("force",)
"""The force of the leg's actuator [N]."""
FOOT = ("foot_x", "foot_z")
"""Commanded position of the foot relative to its rest position: forward and up, in body axes
[m]."""
FOOT_ASIDE = (*FOOT, "foot_y")
"""The same and to the left [m], for a robot whose hips turn outwards."""

COMMANDED = ("commanded_forward", "commanded_left", "commanded_yaw_rate", "commanded_heading")
"""Entries of an observation that are a robot's command [m/s, m/s, rad/s, rad]."""


@dataclass(frozen=True)
class Channel:
    """Something recorded frame by frame, an array [frames, (limbs,) lanes] or [frames, lanes].

    One of its four kinds: `State`, `Total`, `Latest`, `Combined`.

    Args:
        name: its name, with its unit.
        meaning: its meaning in words.
    """

    name: str
    meaning: str


@dataclass(frozen=True)
class State(Channel):
    """The value at the end of each frame.

    Args:
        of: from a `tegotae.simulation.recorder.RecordedFrame` to the value.
    """

    of: Callable[[RecordedFrame], jax.Array]


@dataclass(frozen=True)
class Total(Channel):
    """The running sum, from the release on, of what every control tick adds.

    Args:
        gain: from a `tegotae.simulation.loop.Tick` to what it adds.
    """

    gain: Callable[[Tick], jax.Array]


@dataclass(frozen=True)
class Latest(Channel):
    """The last event of its kind in a frame; NaN in frames without one.

    Args:
        when: from a `tegotae.simulation.loop.Tick` to whether it has one.
        value: and to what is recorded of it.
    """

    when: Callable[[Tick], jax.Array]
    value: Callable[[Tick], jax.Array]


@dataclass(frozen=True)
class Combined(Channel):
    """A channel computed from totals.

    Args:
        of: from the totals to the value.
        needs: the names of these totals.
    """

    of: Callable[..., jax.Array]
    needs: tuple[str, ...]
