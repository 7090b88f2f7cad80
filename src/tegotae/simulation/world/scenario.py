"""The scenario of a lane: release, frequency, a ground that may drop, and what else changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp

from tegotae.parts._shapes import LaneNumbers

GROUND = "ground_m"
"""The name of a change of the ground's height, which is no field of the body."""


ByName = Mapping[str, LaneNumbers] | tuple[tuple[str, LaneNumbers], ...]
"""Numbers by name; () for none."""


class Scenario(NamedTuple):
    """What a lane meets: each entry a number, or an array of shape [lanes].

    Of a controller for several limbs, `omega` and `phase_rad` may be of shape [limbs, lanes]; else
    they are the same for all limbs.
    """

    omega: LaneNumbers
    """Prescribed frequency ω [rad/s]."""
    height_m: LaneNumbers = 1.2
    """Release height [m]."""
    velocity_m_per_s: LaneNumbers = 0.0
    """Release velocity [m/s]."""
    phase_rad: LaneNumbers = 0.0
    """Oscillator phase at release [rad]."""
    drop_m: LaneNumbers = 0.0
    """Height by which the ground drops [m]."""
    drop_time_s: LaneNumbers = math.inf
    """When it drops [s]; at the first control tick not earlier."""
    initial_pose: ByName = ()
    """What else the body's release takes, by name: {"pitch_rad": 0.1} for a bar."""
    oscillator_state: ByName = ()
    """What else than the phase the oscillator starts with, by name: {"radius": 0.5}
    (`Oscillator.STATE`)."""
    changes: ByName = ()
    """Fields of the body that are otherwise, and a frequency that changes on the way.

    By name, such as {"mass_kg": [0.08, 0.1, 0.12]} for a mass a lane, or {"mass_kg": Step(0.13,
    from_s=10.0)}; "omega" names the frequency, and "ground_m" the height of the ground
    (`tegotae.simulation.world.changes`)."""

    @classmethod
    def of(cls, omega: float | None, **entries: LaneNumbers) -> Scenario:
        """A scenario at a prescribed frequency [rad/s], None without an oscillator.

        Nothing reads a frequency then; a number, which the lanes are made of, stands in for it.
        """
        return cls(0.0 if omega is None else omega, **entries)


def ground_m(scenario: Scenario, tick: jax.Array, tick_s: jax.Array) -> jax.Array:
    """Height of the ground during a control tick [m].

    Args:
        scenario: the world of every lane.
        tick: number of the control tick.
        tick_s: control period [s].
    """
    drop_tick = jnp.ceil(scenario.drop_time_s / tick_s - 1e-3)
    ground = jnp.where(tick.astype(drop_tick.dtype) >= drop_tick, -scenario.drop_m, 0.0)
    change = dict(scenario.changes).get(GROUND)
    return ground if change is None else change.at(tick, ground, tick_s)
