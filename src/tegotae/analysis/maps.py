"""Maps of what a hopper does: over gain and frequency, and over its release (basins)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_GAIN, MOST_POINTS, require_memory
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.hopping import LimitCycle, at_frame, find_limit_cycle, hops
from tegotae.measures.hopping.metrics import FAILED, LIMIT_CYCLE, REGIMES
from tegotae.measures.hopping.signals import require_measurable
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body, require_one_limb
from tegotae.parts.controller import Controller
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.systems.controller_file import SavedController


class Outcome(NamedTuple):
    """Outcome of each rollout: arrays of one shape, NaN where undefined."""

    regime: AnyArray
    """Index into `tegotae.measures.hopping.REGIMES`."""
    limit_cycle_period: AnyArray
    """Period k of the limit cycle [hops]."""
    cot_inverse: AnyArray
    """CoT⁻¹ A, of the heights climbed in flight [m/J]."""
    cot_inverse_total: AnyArray
    """CoT⁻¹ B, of all heights climbed [m/J]."""
    apex_height_m: AnyArray
    """Mean height of the apexes [m]."""
    hop_rate: AnyArray
    """Angular frequency of hopping, 2π / mean time between apexes [rad/s]."""
    phase_rate: AnyArray
    """Mean phase rate of the oscillator [rad/s]; zero without one."""

    @property
    def winding_ratio(self) -> AnyArray:
        """Revolutions of the oscillator per hop: mean phase rate over hopping frequency."""
        return self.phase_rate / self.hop_rate


def turn(phase_rad: AnyArray) -> AnyArray:
    """Return the same angle in [-π, π) [rad]."""
    return (phase_rad + 0.5 * TWO_PI) % TWO_PI - 0.5 * TWO_PI


@dataclass(frozen=True)
class OutcomeSummary:
    """The outcome of a rollout, as a `Rollout`'s summary: an `Outcome` of arrays [lanes].

    Rates and apex height are means over the last whole limit cycles. Where nothing settles they are
    means from the first to the last hop in the second half of the rollout; where there are no two
    such hops, the phase rate is the mean over the second half and the others are undefined.

    Args:
        gait: how the gait is measured.

    Example:
        >>> import numpy as np
        >>> from tegotae import Rollout, Scenario
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> rollout = Rollout(controller=reflex, summary=OutcomeSummary())
        >>> found = rollout.run(np.array([[2.0]]), Scenario(omega=8.0))
        >>> f"{found.winding_ratio[0]:.3f} turns a hop"
        '1.000 turns a hop'
    """

    gait: GaitSummary = GaitSummary()  # noqa: RUF009 - immutable

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Outcome:
        """Return the outcome, each entry of shape [lanes]."""
        gait = self.gait(trajectory, scenario, body, timing)
        table = hops(trajectory, body.rest_length_m)
        end_s = trajectory.time_s[-1]
        middle = (timing.n_frames - 1) // 2
        cycle = find_limit_cycle(table, LimitCycle(), -jnp.inf, end_s)
        has_cycle = jnp.isfinite(gait.limit_cycle_period)
        final = jnp.maximum(table.n_hops - 1, 0)
        early = jnp.sum(table.time_s <= trajectory.time_s[middle][None], axis=0, dtype=final.dtype)
        first = jnp.where(has_cycle, cycle.from_hop.astype(final.dtype), jnp.minimum(early, final))
        last = jnp.where(has_cycle, cycle.to_hop.astype(final.dtype), final)
        number = (last - first).astype(end_s.dtype)

        travelled = _unwrapped_phase(trajectory.phase_rad)
        row = jnp.arange(timing.n_frames, dtype=last.dtype)[:, None]
        counts = (row > first[None]) & (row <= last[None])
        apex_height = jnp.sum(jnp.where(counts, table.height_m, 0.0), axis=0)

        def travelled_at(hop: AnyArray) -> AnyArray:
            frame = at_frame(table.frame, hop)
            since = turn(at_frame(table.phase_rad, hop) - at_frame(trajectory.phase_rad, frame))
            return at_frame(travelled, frame) + since

        hopping = last > first
        between_s = at_frame(table.time_s, last) - at_frame(table.time_s, first)
        lasted = jnp.where(hopping, between_s, 1.0)
        over_hops = (travelled_at(last) - travelled_at(first)) / lasted
        over_half = (travelled[-1] - travelled[middle]) / (end_s - trajectory.time_s[middle])
        sound = gait.regime != FAILED
        return Outcome(
            regime=gait.regime,
            limit_cycle_period=gait.limit_cycle_period,
            cot_inverse=gait.cot_inverse,
            cot_inverse_total=gait.cot_inverse_total,
            apex_height_m=jnp.where(hopping & sound, apex_height / number, jnp.nan),
            hop_rate=jnp.where(hopping & sound, TWO_PI * number / lasted, jnp.nan),
            phase_rate=jnp.where(sound, jnp.where(hopping, over_hops, over_half), jnp.nan),
        )


def _unwrapped_phase(phase_rad: AnyArray) -> jax.Array:
    """Return a phase recorded modulo 2π without its jumps [rad], shape [frames, lanes].

    Right as long as it moves by less than half a turn between frames.
    """
    steps = turn(jnp.diff(phase_rad, axis=0))
    return jnp.concatenate([phase_rad[:1], phase_rad[:1] + jnp.cumsum(steps, axis=0)])


_MAP_DURATION_S = 40.0
"""Simulated time of every rollout of a map [s], as of the undisturbed part of an evaluation: what
has not settled by its end counts as without limit cycle."""


def axis(
    name: str,
    low: float,
    high: float,
    points: int,
    *,
    above: float | None = None,
    upper: float = MOST_GAIN,
) -> np.ndarray:
    """Return `points` evenly spaced values from `low` to `high`.

    Args:
        name: of the quantity.
        low: the first value.
        high: the last one.
        points: how many values, `MOST_POINTS` at most.
        above: all values must be greater than this.
        upper: no value may be larger than this, either way.

    Raises:
        TegotaeError: for values that are not finite or beyond their bounds, an empty range, or
            fewer than two points.
    """
    for end, value in (("low", low), ("high", high)):
        require_finite(f"{name} ({end} end)", value, above=above, least=-upper, most=upper)
    require_count(f"points along {name}", points, least=2, most=MOST_POINTS)
    if not low < high:
        raise TegotaeError(
            f"{name} goes from {low:g} to {high:g}; the second must be greater than the first"
        )
    return np.linspace(low, high, points)


def lanes(rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return every pair of a row's and a column's value, each of shape [rows · columns]."""
    # Each lane is a rollout, whose outcome is some thirty numbers.
    require_memory(256.0 * len(rows) * len(columns), f"{len(rows)} x {len(columns)} rollouts")
    row, column = np.meshgrid(rows, columns, indexing="ij")
    return row.ravel(), column.ravel()


def as_maps(outcome: Outcome, rows: np.ndarray, columns: np.ndarray) -> Outcome:
    """Return the outcome of lanes as maps, shape [rows, columns]."""
    return Outcome(*(np.reshape(x, (len(rows), len(columns))) for x in outcome))


def locking_ratios(outcome: Outcome) -> np.ndarray:
    """Return the turns of the oscillator per hop as fractions p/q in lowest terms, or None without
    limit cycle.

    On a limit cycle of k hops the oscillator makes a whole number of turns, so that p/q is exact:
    the nearest fraction with denominator k.

    Args:
        outcome: arrays of any shape.

    Returns:
        Array of `Fraction` or None, of that shape.
    """
    ratios = np.full(outcome.regime.shape, None, object)
    for index in zip(*np.nonzero(outcome.regime == LIMIT_CYCLE), strict=True):
        k = int(outcome.limit_cycle_period[index])
        ratios[index] = Fraction(round(float(outcome.winding_ratio[index]) * k), k)
    return ratios


@dataclass(frozen=True)
class GainSweep:
    """Outcomes over gain σ and frequency ω."""

    sigma: np.ndarray
    """Gains σ [rad/(s N)], shape [gains]."""
    omega: np.ndarray
    """Frequencies ω [rad/s], shape [frequencies]."""
    outcome: Outcome
    """Maps of shape [gains, frequencies]."""


def sweep_gain(
    controller: Controller,
    sigma: np.ndarray,
    omega: np.ndarray,
    body: Body | None = None,
    *,
    timing: Timing | None = None,
    work: str = "absolute",
    height_m: float = 1.2,
) -> GainSweep:
    """Roll out every pair of a gain and a frequency, as one batch.

    Args:
        controller: one whose only weight is σ, such as `V-sector-w4`.
        sigma: gains σ [rad/(s N)], shape [gains].
        omega: frequencies ω [rad/s], shape [frequencies].
        body: the paper's hopper by default.
        timing: 40 s by default. What has not settled by its end counts as without limit cycle.
        work: definition of work, one of "absolute", "positive", "net".
        height_m: height of the release [m].

    Raises:
        TegotaeError: for a controller that has other weights than σ, or an unknown work.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> sector = recipe("V-sector-w4").controller()
        >>> sweep = sweep_gain(sector, np.array([0.0, 3.0]), np.array([5.0]))
        >>> sweep.outcome.phase_rate[0].round(3)  # σ = 0: the oscillator runs at ω
        array([5.], dtype=float32)
    """
    if controller.n_weights != 1:
        raise TegotaeError(
            f"the controller has {controller.n_weights} weights; a gain sweep needs one whose only "
            "weight is the gain σ"
        )
    rollout = Rollout(
        controller=controller,
        timing=timing or Timing(duration_s=_MAP_DURATION_S),
        summary=OutcomeSummary(GaitSummary(work=work)),
    )
    gains, frequencies = lanes(sigma, omega)
    outcome = rollout.run(gains[:, None], Scenario(omega=frequencies, height_m=height_m), body)
    return GainSweep(np.asarray(sigma), np.asarray(omega), as_maps(outcome, sigma, omega))


_SAME_HEIGHT_M = 0.02
"""Limit cycles of equal period and winding are the same if their mean apexes differ by less [m]."""


@dataclass(frozen=True)
class HopperBasin:
    """Limit cycles that releases lead to."""

    frame: pd.DataFrame
    """A row a release, height by height: `height_m`, and `phase_rad` or, without an oscillator,
    `velocity_m_per_s`; the regime, the number of its limit cycle in `cycles` (-1 without), and the
    outcome."""
    cycles: pd.DataFrame
    """The limit cycles that releases end in, by falling `share`: `hops`, `turns` of the oscillator
    (None without one), and the means of `apex_height_m` and `cot_inverse_a_m_per_j`."""

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """The heights [m], and the phases [rad] or velocities [m/s]."""
        height, across = (self.frame.iloc[:, i].unique() for i in range(2))
        return np.asarray(height), np.asarray(across)

    def grid(self, column: str) -> np.ndarray:
        """Return a column of the frame, [heights, columns]."""
        return self.frame[column].to_numpy().reshape(*map(len, self.axes))


def map_basin(
    saved: SavedController,
    height_m: np.ndarray,
    across: np.ndarray,
    *,
    timing: Timing | None = None,
) -> HopperBasin:
    """Release the body at rest from every height at every phase, and see where it ends.

    A controller without oscillator has no phase: its body is released with every velocity instead.

    Args:
        saved: the system and its weights.
        height_m: release heights [m], shape [heights].
        across: phases [rad], or without an oscillator velocities [m/s], shape [columns].
        timing: 40 s by default, of the system's control period where that is held. What has not
            settled by its end counts as without limit cycle.

    Raises:
        TegotaeError: for values that the rollout refuses, or a body of several limbs.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> saved = SavedController.from_weights(reflex, np.array([2.0]), 8.0)
        >>> found = map_basin(saved, np.array([1.1, 1.2]), np.array([0.0, 3.0]))
        >>> found.cycles[["hops", "turns", "share"]].values.tolist()
        [[1.0, 1.0, 1.0]]
    """
    require_one_limb(saved.body, "a map of basins")
    with_phase = saved.controller.oscillator is not None
    height, column = lanes(height_m, across)
    timing = saved.system.timing_over(_MAP_DURATION_S) if timing is None else timing
    require_measurable(timing.tick_s)
    rollout = saved.system.rollout(OutcomeSummary(), timing)
    scenario = saved.system.scenario(
        height_m=height,
        velocity_m_per_s=0.0 if with_phase else column,
        phase_rad=column if with_phase else 0.0,
    )
    outcome = rollout.run(saved.weights, scenario, saved.body)
    number, cycles = distinct_cycles(outcome)
    frame = {
        "height_m": height,
        "phase_rad" if with_phase else "velocity_m_per_s": column,
        "regime": np.asarray(REGIMES)[outcome.regime],
        "limit_cycle": number,
        "limit_cycle_period_hops": outcome.limit_cycle_period,
        "winding_ratio": outcome.winding_ratio,
        "apex_height_m": outcome.apex_height_m,
        "cot_inverse_a_m_per_j": outcome.cot_inverse,
    }
    return HopperBasin(pd.DataFrame(frame), cycles if with_phase else cycles.assign(turns=None))


def distinct_cycles(outcome: Outcome) -> tuple[np.ndarray, pd.DataFrame]:
    """Distinguish limit cycles by period, turns of the oscillator, and mean apex height.

    Args:
        outcome: of rollouts of one controller, arrays of shape [lanes].

    Returns:
        Number of each lane's limit cycle, -1 without one, [lanes]; and the cycles
        (`HopperBasin.cycles`).
    """
    lanes: Any = pd.DataFrame(
        {
            "hops": outcome.limit_cycle_period,
            "turns": np.round(outcome.winding_ratio * outcome.limit_cycle_period),
            "apex_height_m": outcome.apex_height_m,
            "cot_inverse_a_m_per_j": outcome.cot_inverse,
        }
    )
    settled = lanes[outcome.regime == LIMIT_CYCLE].sort_values(["hops", "turns", "apex_height_m"])
    steps = settled[["hops", "turns", "apex_height_m"]].diff()
    same = (steps.hops == 0) & (steps.turns == 0) & (steps.apex_height_m <= _SAME_HEIGHT_M)
    groups = settled.groupby((~same).cumsum())
    means = groups.agg(lambda values: values.to_numpy().mean()).astype(float)
    cycles = means.assign(share=groups.size() / len(lanes))
    order = cycles.sort_values("share", ascending=False, kind="stable").index
    number = np.full(len(lanes), -1)
    number[settled.index] = order.get_indexer((~same).cumsum())
    cycles = cycles.loc[order].astype({"hops": int, "turns": int}).reset_index(drop=True)
    return number, cycles
