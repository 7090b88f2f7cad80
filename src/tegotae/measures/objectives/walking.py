"""The fitness of a walk: at the speed that is wanted, for little work, without a fall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.objectives.objective import Objective, with_failures
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.simulation.rollout import Scenario, Timing, Trajectory

TRACKING = 10.0
"""What a speed that is off by all of itself costs, in units of CoT⁻¹."""

_LEAST_POWER = 1e-4
"""Power below which a body is at rest, over m g √(g l0)."""
_MOST_COT_INVERSE = 1e3
"""No walk is as cheap as this; numbers beyond it are of lanes that have failed."""


class Walk(NamedTuple):
    """What an episode is judged by: shape [lanes] each."""

    speed_m_per_s: Any
    """Speed in the direction in which the body looked when the window began [m/s]."""
    cot_inverse: Any
    """CoT⁻¹ = m g v / P; of a walk backwards negative."""
    survived: Any
    """Share of the episode before the body fell; 1 if it did not."""
    failed: Any
    """Whether it fell."""


@dataclass(frozen=True, kw_only=True)
class WalkJudged:
    """An `Engine`'s summary: the `Walk` of every lane.

    Args:
        settle_s: time left to settle [s].
    """

    settle_s: float

    needs: ClassVar[tuple[str, ...]] = (
        *("time_s", "x_m", "y_m", "yaw_rad", "work_absolute_j", "failed"),
    )
    """The channels that it reads."""

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Walk:
        """The walk of every lane."""
        t, walker = trajectory, unwrapped(body)
        first = round(self.settle_s / timing.frame_s)
        time = t.time_s[-1] - t.time_s[first]
        looks = t.yaw_rad[first]
        ahead = (t.x_m[-1] - t.x_m[first]) * jnp.cos(looks)
        speed = (ahead + (t.y_m[-1] - t.y_m[first]) * jnp.sin(looks)) / time
        power = (t.work_absolute_j[-1] - t.work_absolute_j[first]) / time
        weight = walker.mass_kg * walker.gravity_m_per_s2  # type: ignore[attr-defined]
        typical = jnp.sqrt(walker.gravity_m_per_s2 * walker.rest_length_m)  # type: ignore[attr-defined]
        moves = power > _LEAST_POWER * weight * typical
        cot_inverse = jnp.where(moves, weight * speed / jnp.where(moves, power, 1.0), 0.0)
        return Walk(
            speed_m_per_s=speed,
            cot_inverse=jnp.clip(cot_inverse, -_MOST_COT_INVERSE, _MOST_COT_INVERSE),
            survived=jnp.mean(jnp.where(t.failed, 0.0, 1.0), axis=0),
            failed=t.failed[-1],
        )


class WalkWeighing(NamedTuple):
    """What makes a fitness of a walk: data of a compiled program."""

    speed_m_per_s: Any
    tracking: Any


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

    needs = WalkJudged.needs
    COT_UNIT = ""

    def __post_init__(self) -> None:
        require_finite("speed_m_per_s", self.speed_m_per_s, above=0.0)
        require_finite("settle_s", self.settle_s, least=0.0)
        require_finite("tracking", self.tracking, least=0.0)

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves less than two frames after settling."""
        least = self.settle_s + 2.0 * timing.frame_s
        if timing.duration_s < least:
            raise TegotaeError(
                f"an episode of {timing.duration_s:g} s leaves nothing after settling for "
                f"{self.settle_s:g} s; make it at least {least:g} s"
            )

    @property
    def program(self) -> Walking:
        """The settling time alone: everything else is data."""
        return Walking(speed_m_per_s=1.0, settle_s=self.settle_s)

    @property
    def data(self) -> WalkWeighing:
        """How a walk makes a fitness."""
        return WalkWeighing(np.float32(self.speed_m_per_s), np.float32(self.tracking))

    @property
    def judged(self) -> WalkJudged:
        """What of an episode counts."""
        return WalkJudged(settle_s=self.settle_s)

    def weigh(self, judged: Walk, data: WalkWeighing) -> dict[str, Any]:
        """Fitness and its parts, each of shape [lanes]."""
        off = jnp.abs(judged.speed_m_per_s / data.speed_m_per_s - 1.0)
        fitness = judged.cot_inverse - data.tracking * off
        return {
            "fitness": with_failures(fitness, judged.failed, judged.survived),
            "cot_inverse": jnp.where(judged.failed, 0.0, judged.cot_inverse),
            "failed": judged.failed,
        }

    def score(self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing) -> Any:
        """The fitness of every lane, [lanes]."""
        return self(trajectory, scenario, body, timing)["fitness"]

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> dict[str, Any]:
        """Fitness and its parts, each of shape [lanes]: an `Engine`'s summary."""
        return self.weigh(self.judged(trajectory, scenario, body, timing), self.data)
