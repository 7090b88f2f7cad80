"""How well controllers walk: many of one structure, at many frequencies, from random phases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import jax
import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_RAD_PER_S, MOST_SEEDS
from tegotae.measures.gaits.names import NO_GAIT, TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination, total_mass_kg
from tegotae.parts._shapes import AnyArray, LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import whole_run, with_changes
from tegotae.systems.legged import Legged, lanes_of, random_phases

MEASURES = {
    "upright": "share of the starts that does not fall",
    "locked": "share of them whose legs lock into one gait",
    "lock_time_s": "median time to lock [s]",
    "speed_m_per_s": "mean speed [m/s]",
    "cost_of_transport": "mean power / (weight · mean speed)",
    "froude": "Froude number of the mean speed",
    "slip": "way that each foot slips, over the way of the body",
}
"""The evaluation of a controller at a frequency."""


@dataclass(frozen=True)
class GaitEvaluation:
    """What controllers of one structure did; arrays of the coordination end [runs, ω, starts]."""

    legged: Legged
    """The system that they drive."""
    omega: np.ndarray
    """The frequencies [rad/s], [ω]; a single NaN without an oscillator."""
    found: Coordination
    """How the legs go together in the end."""
    gait: np.ndarray
    """The name of every start's gait, or why it has none, [runs, ω, starts]."""
    body: Body
    """The body with what was changed for the whole run, such as its mass."""

    @property
    def measures(self) -> dict[str, np.ndarray]:
        """`MEASURES` of every controller at every frequency, [runs, ω]; of starts that stay up."""
        found = self.found
        stands = ~np.isfinite(found.fall_time_s)
        locks = stands & ~np.isin(self.gait, NO_GAIT[1:])
        speed, power = _mean(found.speed_m_per_s), _mean(found.power_w)
        legs = self.body.limbs
        weight, gravity = _weight_n(self.body), _gravity(self.body)
        with np.errstate(divide="ignore", invalid="ignore"):
            return {
                "upright": stands.mean(axis=-1),
                "locked": locks.mean(axis=-1),
                "lock_time_s": _median(np.where(locks, found.lock_time_s, np.nan)),
                "speed_m_per_s": speed,
                "cost_of_transport": np.where(speed > 0.0, power / (weight * speed), np.nan),
                "froude": speed**2 / (gravity * float(self.body.rest_length_m)),
                "slip": _mean(np.where(stands, found.slip_m / found.distance_m / legs, np.nan)),
            }

    def commonest(self, run: int, omega: int) -> tuple[str, float]:
        """What most starts of a controller at a frequency end in, and their share."""
        (name, count), *_ = Counter(self.gait[run, omega].tolist()).most_common()
        return name, count / self.gait.shape[-1]


def evaluate_gaits(
    legged: Legged,
    weights: np.ndarray,
    omegas: Sequence[float] = (),
    starts: int = 32,
    *,
    seed: int = 1,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
    changes: Mapping[str, LaneNumbers] | None = None,
) -> GaitEvaluation:
    """Release controllers at random phases, the same ones for all, at every frequency.

    Args:
        legged: the system that they drive; its own weights do not count.
        weights: of the controllers, [runs, n_weights].
        omegas: frequencies ω [rad/s]; the system's own if none is given.
        starts: how many releases of each; of legs without oscillators all would be alike, and one
            is made.
        seed: of the phases.
        tolerance: how far lags may be from a named pattern's [cycles].
        timing: of each rollout; that of the system by default.
        changes: what they meet, numbers by the names of the body's fields (`with_changes`).

    Raises:
        TegotaeError: for weights of another number, a frequency of what has none, or one that is
            not positive.

    Example:
        >>> from tegotae.analysis.gaits import system
        >>> bar = system("bar-light")
        >>> found = evaluate_gaits(bar, np.array([[1.0]]), starts=4)
        >>> found.commonest(0, 0), float(found.measures["locked"][0, 0])
        (('antiphase', 1.0), 1.0)
    """
    require_count("starts", starts, most=MOST_SEEDS)
    weights = np.atleast_2d(np.asarray(weights, float))
    if weights.shape[1] != legged.controller.n_weights:
        raise TegotaeError(
            f"weights have shape {weights.shape}; this controller has "
            f"{legged.controller.n_weights} of them"
        )
    if legged.omega is None:
        if len(omegas):
            raise TegotaeError("the controller has no oscillator, and so no omega")
        asked, starts = np.array([np.nan]), 1
    else:
        asked = np.array(list(omegas) or [legged.omega], float)
        for omega in asked.tolist():
            require_finite("omega", omega, above=0.0, most=MOST_RAD_PER_S)
    phase = random_phases(legged.body.limbs, starts, seed)
    shape = (len(weights), len(asked), starts)
    lanes = np.repeat(weights, len(asked) * starts, axis=0)
    released = legged.scenario(np.tile(phase, len(weights) * len(asked)))
    scenario = with_changes(released, legged.body, changes or {})
    if legged.omega is not None:
        omega = np.tile(np.repeat(asked, starts), len(weights))
        scenario = scenario._replace(omega=omega)
    engine = legged.engine(legged.summary(), timing)
    found = lanes_of(engine.run(lanes, scenario, legged.body))
    gait = gait_of(found, legged.names, tolerance)

    def sorted_out(x: np.ndarray) -> np.ndarray:
        return x.reshape(*x.shape[:-1], *shape)

    body, _ = whole_run(legged.body, dict(scenario.changes))
    return GaitEvaluation(legged, asked, jax.tree.map(sorted_out, found), sorted_out(gait), body)


def _mean(x: AnyArray) -> np.ndarray:
    """Mean over the starts of what is defined; NaN where nothing is."""
    defined = np.isfinite(x)
    count = defined.sum(axis=-1)
    total = np.where(defined, x, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _median(x: np.ndarray) -> np.ndarray:
    flat = x.reshape(-1, x.shape[-1])
    middle = [
        np.median(row[np.isfinite(row)]) if np.isfinite(row).any() else np.nan for row in flat
    ]
    return np.array(middle).reshape(x.shape[:-1])


def _weight_n(body: Body) -> float:
    return float(total_mass_kg(unwrapped(body))) * _gravity(body)


def _gravity(body: Body) -> float:
    return float(unwrapped(body).gravity_m_per_s2)  # type: ignore[attr-defined]
