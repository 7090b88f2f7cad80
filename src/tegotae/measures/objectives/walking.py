"""The fitness of a walk: at the speed that is wanted, for little work, without a fall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.places import speed_along_heading_m_per_s
from tegotae.measures.objectives.objective import Objective
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.simulation.rollout import Scenario, Timing, Trajectory
from tegotae.simulation.world import whole_run

TRACKING = 10.0
"""What a speed that is off by all of itself costs, in units of CoT⁻¹."""

_LEAST_POWER = 1e-4
"""Power below which a body is at rest, over m g √(g l0)."""
_MOST_COT_INVERSE = 1e3
"""No walk is as cheap as this; numbers beyond it are of lanes that have failed."""


class WalkOutcome(NamedTuple):
    """What of an episode of walking counts, [lanes] each."""

    speed_m_per_s: jax.Array
    """Speed in the direction in which the body looked when the window began [m/s]."""
    cot_inverse: jax.Array
    """CoT⁻¹ = m g v / P; of a walk backwards negative."""


class WalkingData(NamedTuple):
    """Settings that make a fitness of a walk: data of a compiled program."""

    speed_m_per_s: Numeric
    tracking: Numeric


@dataclass(frozen=True, kw_only=True)
class Walking(Objective):
    """`fitness = CoT⁻¹ - w |v / v* - 1|` over the settled part of an episode of a `Walker`.

    `CoT⁻¹ = m g v / P`, with P the mean of the actuators' |power| and v the speed in the direction
    in which the body looked when the settled part began: who turns or drifts is slower. Whoever
    falls is below all who do not, and the later, the better.

    Args:
        speed_m_per_s: the speed that is wanted v* [m/s].
        settle_s: time left to settle [s].
        tracking: w.

    Raises:
        TegotaeError: for a speed that is not positive, or a time or weight below zero.

    Example:
        >>> Walking(speed_m_per_s=0.25, settle_s=30.0).tracking
        10.0
    """

    speed_m_per_s: float
    settle_s: float
    tracking: float = TRACKING

    needs = ("time_s", "x_m", "y_m", "yaw_rad", "work_absolute_j", "failed")
    COT_UNIT = ""

    def __post_init__(self) -> None:
        require_finite("speed_m_per_s", self.speed_m_per_s, above=0.0)
        require_finite("settle_s", self.settle_s, least=0.0)
        require_finite("tracking", self.tracking, least=0.0)

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves less than two frames after settling."""
        check_settled(self.settle_s, timing)

    @property
    def program(self) -> Walking:
        """The settling time alone: everything else is data."""
        return Walking(speed_m_per_s=1.0, settle_s=self.settle_s)

    @property
    def data(self) -> WalkingData:
        """The speed that is wanted and the weight of it."""
        return WalkingData(np.float32(self.speed_m_per_s), np.float32(self.tracking))

    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> WalkOutcome:
        """Speed and CoT⁻¹ of every lane."""
        return walked(trajectory, scenario, body, timing, self.settle_s)

    def score(self, outcome: WalkOutcome, data: WalkingData) -> dict[str, jax.Array]:
        """`fitness` and `cot_inverse`, [lanes] each."""
        off = jnp.abs(outcome.speed_m_per_s / data.speed_m_per_s - 1.0)
        fitness = outcome.cot_inverse - data.tracking * off
        return {"fitness": fitness, "cot_inverse": outcome.cot_inverse}


def check_settled(settle_s: float, timing: Timing) -> None:
    """Raise `TegotaeError` if an episode leaves less than two frames after settling.

    Args:
        settle_s: time left to settle [s].
        timing: of the episode.
    """
    least = settle_s + 2.0 * timing.frame_s
    if timing.duration_s < least:
        raise TegotaeError(
            f"an episode of {timing.duration_s:g} s leaves nothing after settling for "
            f"{settle_s:g} s; make it at least {least:g} s"
        )


def walked(
    trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing, settle_s: float
) -> WalkOutcome:
    """Speed ahead and CoT⁻¹ over the settled part of an episode of a `Walker`, [lanes] each.

    Args:
        trajectory: arrays of shape [frames, lanes].
        scenario: whose changes of the body for the whole episode count, such as another mass.
        body: the walker.
        timing: of the episode.
        settle_s: time left to settle [s].
    """
    t = trajectory
    walker = unwrapped(whole_run(body, dict(scenario.changes))[0])
    first = round(settle_s / timing.frame_s)
    time = t.time_s[-1] - t.time_s[first]
    speed = speed_along_heading_m_per_s(t, first)
    power = (t.work_absolute_j[-1] - t.work_absolute_j[first]) / time
    weight = walker.mass_kg * walker.gravity_m_per_s2  # type: ignore[attr-defined]
    typical = jnp.sqrt(walker.gravity_m_per_s2 * walker.rest_length_m)  # type: ignore[attr-defined]
    moves = power > _LEAST_POWER * weight * typical
    cot_inverse = jnp.where(moves, weight * speed / jnp.where(moves, power, 1.0), 0.0)
    return WalkOutcome(
        speed_m_per_s=speed,
        cot_inverse=jnp.clip(cot_inverse, -_MOST_COT_INVERSE, _MOST_COT_INVERSE),
    )
