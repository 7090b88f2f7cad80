"""The limit cycle of a controller, and its phase portrait."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.hopping import Hops, hops
from tegotae.measures.hopping.metrics import LIMIT_CYCLE, REGIMES, limit_cycle_period
from tegotae.measures.hopping.signals import require_measurable
from tegotae.parts.bodies import Body, Hopper, require_one_limb
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Timing
from tegotae.simulation.summaries import KeptChannels, Together
from tegotae.systems.controller_file import SavedController

_ORBIT_AFTER_S = 60.0
"""Simulated time in which a gait has to settle before its orbit is looked at [s]."""
SIGNALS = (
    *("height_m", "velocity_m_per_s", "spring_force_n"),
    *("feedback_rad_per_s", "actuator_force_n"),
)
"""Signals of a path, beside its phase."""
_PERIOD = GaitSummary(metrics=(limit_cycle_period,))


class NoLimitCycleError(TegotaeError):
    """The controller does not settle on a limit cycle."""


@dataclass(frozen=True)
class Orbit:
    """One turn of a limit cycle: k hops, from an apex to the k-th apex after it.

    Samples are a control tick apart; the first lies at most a tick after the first apex.
    """

    hops: int
    """Period k [hops]."""
    period_s: float
    """Period T [s]."""
    apex_height_m: np.ndarray
    """Heights of its apexes [m], shape [k]."""
    apex_phase_rad: np.ndarray
    """Phases at its apexes [rad], shape [k]; zero without an oscillator."""
    time_s: np.ndarray
    """Time since the first apex [s], shape [samples]."""
    height_m: np.ndarray
    """Height y [m], [samples]."""
    velocity_m_per_s: np.ndarray
    """Velocity ẏ [m/s], [samples]."""
    phase_rad: np.ndarray
    """Phase φ modulo 2π [rad], [samples]; zero without an oscillator."""
    spring_force_n: np.ndarray
    """Spring force F_k [N], [samples]."""
    feedback_rad_per_s: np.ndarray
    """Tegotae feedback f [rad/s], [samples]."""
    actuator_force_n: np.ndarray
    """Actuator force F_a [N], [samples]; zero in flight."""
    apex_oscillator_state: dict[str, np.ndarray] = field(default_factory=dict)
    """State of the oscillator at its apexes beside the phase, by name, each of shape [k]."""
    oscillator_state: dict[str, np.ndarray] = field(default_factory=dict)
    """State of the oscillator beside the phase, by name, each [samples]."""


def require_hopper(body: Body, purpose: str) -> Hopper:
    """Return the body; raise `TegotaeError` if it is no hopper."""
    if not isinstance(body, Hopper):
        raise TegotaeError(f"{purpose} needs a hopper, not a {type(body).__name__}")
    return body


def require_enterable(saved: SavedController, purpose: str) -> None:
    """Raise `TegotaeError` unless an orbit can be entered, which needs its whole state.

    An oscillator that does not name all of its state, or has no phase, would start off the cycle.
    """
    oscillator = saved.controller.oscillator
    require_one_limb(saved.body, purpose)
    if oscillator is not None and not oscillator.is_open:
        reason = "more state than it names in STATE" if oscillator.has_phase else "no phase"
        raise TegotaeError(
            f"{purpose} starts rollouts on the limit cycle, with the state that the oscillator has "
            f"there; {type(oscillator).__name__} has {reason}"
        )


def find_orbit(
    saved: SavedController,
    *,
    settle_s: float = _ORBIT_AFTER_S,
    tick_s: float = 0.001,
) -> Orbit:
    """Release a system, let it settle, and return its last limit cycle.

    Args:
        saved: the system and its weights; `replace(saved, {"height_m": 1.1})` is released lower.
        settle_s: simulated time in which to settle [s].
        tick_s: control period in continuous time, and the time between samples [s]; what is held
            over its control period keeps that.

    Raises:
        NoLimitCycleError: if it does not settle; says what it does instead.
        TegotaeError: for a body of several limbs, or a held control period of which 20 ms is no
            multiple.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> saved = SavedController.from_weights(reflex, np.array([2.0]), 8.0)
        >>> found = find_orbit(saved)
        >>> found.hops, round(found.period_s, 3)
        (1, 0.846)
    """
    require_one_limb(saved.body, "a limit cycle's orbit")
    system = saved.system
    timing = system.timing_over(settle_s, tick_s=tick_s, frame_s=system.period_s(tick_s))
    require_measurable(timing.tick_s)
    names = oscillator_state_names(saved)
    channels = KeptChannels(("time_s", "phase_rad", *SIGNALS, *names))
    rollout = system.rollout(Together((channels, _PERIOD, _Apexes(names))), timing)
    recorded = rollout.run(saved.weights, system.scenario(), saved.body, dtype="float64")
    lane, gait, (table, *state) = jax.tree.map(lambda x: x[..., 0], recorded)
    if gait.regime != LIMIT_CYCLE:
        raise NoLimitCycleError(
            f"released from {system.release.height_m:g} m at phase "
            f"{float(np.ravel(system.release.phase_rad)[0]):g} rad, the gait has no limit cycle "
            f"after {settle_s:g} s: {REGIMES[gait.regime]}"
        )
    k = int(gait.limit_cycle_period)
    last = int(table.n_hops) - 1
    first = last - k
    path = jax.tree.map(lambda x: x[table.frame[first] : table.frame[last]], lane)
    return Orbit(
        hops=k,
        period_s=float(table.time_s[last] - table.time_s[first]),
        apex_height_m=table.height_m[first:last],
        apex_phase_rad=table.phase_rad[first:last],
        time_s=path.time_s - table.time_s[first],
        phase_rad=path.phase_rad % TWO_PI,
        **{name: getattr(path, name) for name in SIGNALS},
        apex_oscillator_state={n: x[first:last] for n, x in zip(names, state, strict=True)},
        oscillator_state={name: path.channels[name] for name in names},
    )


def oscillator_state_names(saved: SavedController) -> tuple[str, ...]:
    """Return the names of the oscillator's state beside its phase."""
    oscillator = saved.controller.oscillator
    return () if oscillator is None else oscillator.STATE


def check_heights(height_m: np.ndarray, duration_s: float) -> np.ndarray:
    """Return the heights [m], [releases]; raise `TegotaeError` for impossible ones, or for none."""
    heights = np.atleast_1d(np.asarray(height_m, float))
    if not len(heights):
        raise TegotaeError("no release is given; name at least one height")
    for height in heights:
        require_finite("height", height, above=0.0, most=MOST_M)
    require_finite("duration", duration_s, least=1.0, most=3600.0)
    return heights


def release_paths(
    saved: SavedController,
    height_m: np.ndarray,
    *,
    duration_s: float = 30.0,
) -> Trajectory:
    """Release a system on a hopper from several heights.

    Args:
        saved: the system and its weights.
        height_m: heights in place of the system's [m], [releases].
        duration_s: simulated time [s].

    Returns:
        Time, `SIGNALS`, and the phase of an oscillator, frames of shape [frames, releases].

    Raises:
        TegotaeError: for a body that is no hopper, or a release that is not finite.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> saved = SavedController.from_weights(reflex, np.array([2.0]), 8.0)
        >>> release_paths(saved, np.array([1.1, 1.3]), duration_s=1.0).height_m.shape
        (100, 2)
    """
    require_hopper(saved.body, "a phase portrait")
    heights = check_heights(height_m, duration_s)
    system = saved.system
    phase = () if saved.controller.oscillator is None else ("phase_rad",)
    channels = KeptChannels(("time_s", *SIGNALS, *phase, "failed"))
    rollout = system.rollout(channels, system.timing_over(duration_s, frame_s=0.01))
    return rollout.run(saved.weights, system.scenario(height_m=heights), saved.body)


@dataclass(frozen=True)
class _Apexes:
    """The table of hops, and the rest of the oscillator's state at their apexes, row by row."""

    names: tuple[str, ...]

    @property
    def needs(self) -> tuple[str, ...]:
        return (*_PERIOD.needs, *(f"apex_{name}" for name in self.names))

    def __call__(self, trajectory, scenario, body, timing):
        table = hops(trajectory, body.rest_length_m)
        state = (trajectory.channels[f"apex_{name}"] for name in self.names)
        return table, *(jnp.take_along_axis(x, table.frame, axis=0) for x in state)


def hops_of(
    saved: SavedController, timing: Timing, **start: Any
) -> tuple[Hops, tuple[np.ndarray, ...]]:
    """Return the hops of rollouts and, at their apexes, the rest of the oscillator's state, in
    float64.

    Args:
        saved: the system and its weights.
        timing: of the rollouts.
        start: entries of the scenario in place of the system's own.
    """
    rollout = saved.system.rollout(_Apexes(oscillator_state_names(saved)), timing)
    table, *state = rollout.run(
        saved.weights, saved.system.scenario(**start), saved.body, dtype="float64"
    )
    return table, tuple(state)
