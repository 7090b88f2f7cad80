"""Fitness of walking: a speed that is wanted, or one that ω commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.names import speed_along_heading_m_per_s
from tegotae.measures.objectives.objective import Objective, require_settled
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.parts.parameters import finite, not_negative
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.world import whole_run

TRACKING = 10.0
"""Penalty of a speed error of 100 %, in units of CoT⁻¹."""

_LEAST_POWER = 1e-4
"""Power below which a body is at rest, over m g √(g l0)."""
_MOST_COT_INVERSE = 1e3
"""No walk is as cheap as this; numbers beyond it are of lanes that have failed."""


class WalkOutcome(NamedTuple):
    """Outcome of an episode of walking, [lanes] each."""

    speed_m_per_s: jax.Array
    """Speed in the direction in which the body looked when the window began [m/s]."""
    cot_inverse: jax.Array
    """CoT⁻¹ = m g v / P; of a walk backwards negative."""
    omega: jax.Array
    """The frequency ω of the episode [rad/s]."""


class _SettledWalk(Objective):
    """Part of a fitness of walking: its quantities after settling."""

    settle_s: float
    tracking: float

    needs = ("time_s", "x_m", "y_m", "yaw_rad", "work_absolute_j", "failed")
    COT_UNIT = ""

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode leaves less than two frames after settling."""
        require_settled(timing, self.settle_s, 2.0 * timing.frame_s)

    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> WalkOutcome:
        """Return speed ahead, CoT⁻¹ and frequency of every lane.

        A change of the body for the whole episode counts, such as another mass.
        """
        t = trajectory
        walker = unwrapped(whole_run(body, dict(scenario.changes))[0])
        first = round(self.settle_s / timing.frame_s)
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
            omega=jnp.broadcast_to(jnp.asarray(scenario.omega, speed.dtype), speed.shape),
        )


@dataclass(frozen=True, kw_only=True)
class Walking(_SettledWalk):
    """`fitness = CoT⁻¹ - w |v / v* - 1|` over the settled part of an episode of a `Walker`.

    `CoT⁻¹ = m g v / P`, with P the mean of the actuators' |power| and v the speed in the direction
    in which the body looked when the settled part began: who turns or drifts is slower. Whoever
    falls is below all who do not, and the later, the better.

    Args:
        speed_m_per_s: the speed that is wanted v* [m/s].
        settle_s: time at the start of an episode that does not count [s].
        tracking: w.

    Raises:
        TegotaeError: for a speed that is not positive, or a time or weight below zero.

    Example:
        >>> Walking(speed_m_per_s=0.25, settle_s=30.0).tracking
        10.0
    """

    speed_m_per_s: float = finite(above=0.0)
    settle_s: float = finite(least=0.0)
    tracking: float = not_negative(TRACKING)

    DATA = ("speed_m_per_s", "tracking")

    def score(self, outcome: WalkOutcome, data: Mapping[str, Any]) -> dict[str, jax.Array]:
        """Return `fitness` and `cot_inverse`, [lanes] each."""
        off = jnp.abs(outcome.speed_m_per_s / data["speed_m_per_s"] - 1.0)
        fitness = outcome.cot_inverse - data["tracking"] * off
        return {"fitness": fitness, "cot_inverse": outcome.cot_inverse}


COMMANDED_TRACKING = 2.0
"""Penalty of a speed error of 100 %, in units of the logarithm of a share."""
_LEAST_GAIN = 0.25
"""Below this gain its logarithm goes on as a straight line: who stands or goes back has no
logarithm, and the next step up must count."""
_MOST_GAIN = 20.0
"""Beyond this share of the front, above or below, nothing counts."""


@dataclass(frozen=True, kw_only=True)
class CommandedWalking(_SettledWalk):
    """`fitness = ln(c(v) CoT⁻¹) - w |v / (b ω) - 1|` over the settled part of an episode.

    c(v) is the cost of transport of a baseline at the same speed, its *front*: the logarithm is 0
    for who walks at the baseline's cost, and ln 2 for who needs half of it. The wanted speed b ω
    follows from the frequency of the episode, so that one law is trained for a range of them. The
    mean of logarithms is the largest for a law that is cheap at every speed: who halves its cost at
    one speed and doubles it at another has gained nothing. Below a gain of a quarter, and for who
    goes backwards, the logarithm goes on as its tangent. A fall is below all walks.

    Args:
        front: pairs of speed [m/s] and cost of transport, by rising speed; between them straight
            lines, beyond the ends the last value.
        advance_m_per_rad: the way per radian of the command that is wanted, b [m/rad].
        settle_s: time at the start of an episode that does not count [s].
        tracking: w.

    Raises:
        TegotaeError: for a front of fewer than two speeds, not in this order, or with a number that
            is not positive; an advance that is not positive; or a time or weight below zero.

    Example:
        >>> front = ((0.1, 0.5), (0.5, 0.4))
        >>> CommandedWalking(front=front, advance_m_per_rad=0.127, settle_s=30.0).tracking
        2.0
    """

    front: tuple[tuple[float, float], ...]
    advance_m_per_rad: float = finite(above=0.0)
    settle_s: float = finite(least=0.0)
    tracking: float = not_negative(COMMANDED_TRACKING)

    DATA = ("front", "advance_m_per_rad", "tracking")

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.front) < 2:
            raise TegotaeError(f"a front has two speeds at least; this one has {len(self.front)}")
        for speed, cost in self.front:
            require_finite("a speed of the front", speed, above=0.0)
            require_finite("a cost of the front", cost, above=0.0)
        speeds = [speed for speed, _ in self.front]
        if any(b <= a for a, b in pairwise(speeds)):
            raise TegotaeError(f"the speeds of the front are {speeds}; they must rise")

    def check_frequencies(self, lower: float, upper: float) -> None:
        """Raise `TegotaeError` if no walker of the front is as slow or as fast as is commanded."""
        slowest, fastest = self.front[0][0], self.front[-1][0]
        for omega in (lower, upper):
            speed = omega * self.advance_m_per_rad
            if not slowest <= speed <= fastest:
                raise TegotaeError(
                    f"omega {omega:g} commands a speed of {speed:.3g} m/s, and the front has none "
                    f"below {slowest:.3g} or above {fastest:.3g}; choose omega from "
                    f"{slowest / self.advance_m_per_rad:.3g} to "
                    f"{fastest / self.advance_m_per_rad:.3g}"
                )

    def without_frequency(self) -> Objective:
        """Return the objective itself: the speed follows from the frequency."""
        raise TegotaeError(
            "the speed that is wanted follows from omega, and the controller has no oscillator; "
            "train it with Walking(speed_m_per_s=...)"
        )

    def score(self, outcome: WalkOutcome, data: Mapping[str, Any]) -> dict[str, jax.Array]:
        """Return `fitness`, `cot_inverse` and `gain`, CoT⁻¹ over that of the front, [lanes]
        each.
        """
        speed = outcome.speed_m_per_s
        speeds, costs = jnp.asarray(data["front"]).T
        gain = outcome.cot_inverse * jnp.interp(speed, speeds, costs)
        off = jnp.abs(speed / (data["advance_m_per_rad"] * outcome.omega) - 1.0)
        fitness = log_gain(gain) - data["tracking"] * off
        return {"fitness": fitness, "cot_inverse": outcome.cot_inverse, "gain": gain}


def log_gain(gain: AnyArray) -> jax.Array:
    """Return the logarithm of a gain; below a quarter, its tangent there.

    Args:
        gain: CoT⁻¹ over that of the front; what is beyond twentyfold counts as that.

    Example:
        >>> print(", ".join(f"{x:.2f}" for x in log_gain(jnp.array([1.0, 0.25, 0.0]))))
        0.00, -1.39, -2.39
    """
    limited = jnp.clip(gain, -_MOST_GAIN, _MOST_GAIN)
    line = jnp.log(_LEAST_GAIN) + limited / _LEAST_GAIN - 1.0
    return jnp.where(limited > _LEAST_GAIN, jnp.log(jnp.maximum(limited, _LEAST_GAIN)), line)
