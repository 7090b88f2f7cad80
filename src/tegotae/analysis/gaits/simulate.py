"""One release of a legged body, looked at closely: its lags over time, and every stance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.footfall import StanceInterval, stances
from tegotae.measures.gaits.lags import over_strides
from tegotae.measures.gaits.names import TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination, CoordinationSummary
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.systems.legged import Legged, lanes_of, random_phases


@dataclass(frozen=True)
class GaitRun:
    """A rollout of one lane: arrays [frames, limbs] of legs, else [frames]."""

    legged: Legged
    """The released system."""
    timing: Timing
    """And for how long."""
    phase_rad: np.ndarray
    """Phases at release [rad], [limbs]."""
    trajectory: Trajectory
    """All channels."""
    lag: np.ndarray
    """Lags averaged over strides [cycles], [frames, limbs]."""
    found: Coordination
    """How the legs go together in the end, of one lane: [limbs, 1] and [1]."""
    gait: str
    """The gait's name, or why it has none."""

    @property
    def stances(self) -> tuple[tuple[StanceInterval, ...], ...]:
        """The stances of every leg."""
        return stances(self.trajectory.time_s, self.trajectory.stance_time_s)

    @property
    def stride_s(self) -> float:
        """How long a stride lasts in the end [s]; NaN if it makes none."""
        hz = float(self.found.cycle_frequency_hz[0])
        return 1.0 / hz if hz > 0.0 else float("nan")


@dataclass(frozen=True)
class _Closely:
    """A summary that keeps the trajectory beside the coordination."""

    own: CoordinationSummary

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[Trajectory, Coordination]:
        return trajectory, self.own(trajectory, scenario, body, timing)


def simulate(
    legged: Legged,
    phase_rad: Sequence[float] | None = None,
    *,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
    window_s: float | None = None,
) -> GaitRun:
    """Release a body once, and record everything.

    Args:
        legged: the body and what drives it.
        phase_rad: phases at release [rad], one a leg; drawn at random by default.
        seed: of random phases; the first start that a basin of this seed has.
        tolerance: how far lags may be from a named pattern's [cycles].
        timing: that of the system by default.
        window_s: length of the end that is measured [s]; the last quarter by default.

    Raises:
        TegotaeError: for phases of another number of legs, or what the engine refuses.

    Example:
        >>> from tegotae.analysis.gaits import system
        >>> simulate(system("bar-heavy"), (0.0, 2.0)).gait
        'in phase'
    """
    limbs = legged.body.limbs
    phase = random_phases(limbs, 1, seed)[:, 0] if phase_rad is None else np.asarray(phase_rad)
    if phase.shape != (limbs,):
        raise TegotaeError(f"{phase.size} phases are given; this body has {limbs} legs")
    for each in phase:
        require_finite("a phase", each)
    timing = timing or legged.timing
    summary = legged.summary(window_s=window_s)
    trajectory, found = legged.run(_Closely(summary), legged.scenario(phase[:, None]), timing)
    found = lanes_of(found)
    return GaitRun(
        legged=legged,
        timing=timing,
        phase_rad=phase,
        trajectory=jax.tree.map(lambda x: x[..., 0], trajectory),
        lag=_course(summary, trajectory, found, timing),
        found=found,
        gait=str(gait_of(found, legged.names, tolerance)[0]),
    )


def _course(
    summary: CoordinationSummary, trajectory: Trajectory, found: Coordination, timing: Timing
) -> np.ndarray:
    """Lags averaged over the stride of the end, [frames, limbs]; over a frame without any."""
    hz = float(found.cycle_frequency_hz[0])
    frames = round(1.0 / (hz * timing.frame_s)) if hz * timing.duration_s > 1.0 else 1
    lag = summary.rhythm.lag(trajectory, summary.reference)
    return np.asarray(over_strides(lag, np.array([frames])), float)[..., 0]


def columns(run: GaitRun) -> dict[str, AnyArray]:
    """The frames as a table: every channel, the lags, and the share of each frame in stance.

    What belongs to a leg is a column a leg, such as `phase_rad_LH`.
    """
    t, names = run.trajectory, run.legged.names
    share = np.diff(t.stance_time_s, axis=0, prepend=0.0) / run.timing.frame_s
    more = {"lag_cycles": run.lag, "stance_share": np.clip(share, 0.0, 1.0)}
    table: dict[str, AnyArray] = {}
    for title, values in {**t.channels, **more}.items():
        if np.ndim(values) == 1:
            table[title] = values
        else:
            table |= {f"{title}_{name}": values[:, leg] for leg, name in enumerate(names)}
    return table
