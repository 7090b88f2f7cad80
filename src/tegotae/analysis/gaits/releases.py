"""Releases of a body with several legs: one in full, or many in the coordination of their legs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np
import pandas as pd

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_RAD_PER_S, MOST_SEEDS
from tegotae.measures.gaits.lags import (
    StanceInterval,
    circular_mean,
    circular_spread,
    over_strides,
    stances,
)
from tegotae.measures.gaits.metrics import WALKING, WalkMetric, Walks, over_starts
from tegotae.measures.gaits.names import TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination, CoordinationSummary, coordination_columns
from tegotae.measures.metric import Metric
from tegotae.measures.statistics import share_interval
from tegotae.parts._shapes import AnyArray, LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Timing
from tegotae.simulation.summaries import KeptChannels, Together, whole_trajectory
from tegotae.simulation.world import whole_run, with_changes
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged, lanes_of, random_phases


def coordination_frame(
    coordination: Coordination, legs: Sequence[str], tolerance: float, **labels: Any
) -> pd.DataFrame:
    """Return the gait and the coordination of lanes, one row per lane after the columns that name
    it.

    Args:
        coordination: arrays [limbs, lanes] and [lanes].
        legs: the legs' names.
        tolerance: how far lags may be from a named pattern's [cycles].
        labels: numbers or texts by name, one or [lanes].
    """
    gait = gait_of(coordination, legs, tolerance)
    return pd.DataFrame({**labels, "gait": gait, **coordination_columns(coordination, legs)})


def gait_counts(names: pd.Series) -> pd.Series:
    """Return the numbers of occurrences, the highest first, equal ones in the order of letters.

    Args:
        names: such as gaits.

    Example:
        >>> gait_counts(pd.Series(["walk", "trot", "pace", "walk"])).to_dict()
        {'walk': 2, 'pace': 1, 'trot': 1}
    """
    return names.value_counts().sort_index().sort_values(ascending=False, kind="stable")


def system_document(legged: Legged) -> JsonObject:
    """Return a system as JSON values.

    Raises:
        TegotaeError: for a part that is not registered (`tegotae.register`).
    """
    return {**describe(legged), "legs": list(legged.names)}


@dataclass(frozen=True)
class GaitRun:
    """A rollout of one lane: arrays [frames, limbs] of legs, else [frames]."""

    legged: Legged
    """The released system."""
    phase_rad: np.ndarray
    """Phases at release [rad], [limbs]."""
    trajectory: Trajectory
    """All channels."""
    lag: np.ndarray
    """Lags averaged over strides [cycles], [frames, limbs]."""
    coordination: Coordination
    """Final coordination of the legs of one lane: [limbs, 1] and [1]."""
    gait: str
    """The gait's name, or why it has none."""

    @property
    def timing(self) -> Timing:
        """For how long, and how closely it is recorded."""
        return self.legged.timing

    @property
    def stances(self) -> tuple[tuple[StanceInterval, ...], ...]:
        """The stances of every leg."""
        return stances(self.trajectory.time_s, self.trajectory.stance_time_s)

    @property
    def stride_s(self) -> float:
        """Final duration of a stride [s]; NaN if there is none."""
        hz = float(self.coordination.cycle_frequency_hz[0])
        return 1.0 / hz if hz > 0.0 else float("nan")

    @property
    def numbers(self) -> dict[str, Any]:
        """The final coordination, the gait, the phases at release and the stances, by name."""
        columns = coordination_columns(self.coordination, self.legged.names)
        legs = zip(self.legged.names, self.stances, strict=True)
        return {
            **{name: x[0].item() for name, x in columns.items()},
            "gait": self.gait,
            "release_phase_rad": self.phase_rad,
            "stances": {name: [list(stance) for stance in leg] for name, leg in legs},
        }

    @property
    def limbs(self) -> pd.DataFrame:
        """The final coordination in a table for people, one row per leg."""
        _, time = self.legged.units
        return pd.DataFrame(
            {
                "leg": self.legged.names,
                "lag [cycles]": self.coordination.lag[:, 0] % 1.0,
                "footfall lag": self.coordination.touchdown_lag[:, 0] % 1.0,
                "duty factor": self.coordination.duty_factor[:, 0],
                f"steps [1/{time}]": self.coordination.step_frequency_hz[:, 0],
            }
        )

    @property
    def series(self) -> dict[str, AnyArray]:
        """The frames as a table: every channel, the lags, and the share of each frame in stance.

        What belongs to a leg is a column a leg, such as `phase_rad_LH`.
        """
        t, names = self.trajectory, self.legged.names
        share = np.diff(t.stance_time_s, axis=0, prepend=0.0) / self.timing.frame_s
        columns = {"lag_cycles": self.lag, "stance_share": np.clip(share, 0.0, 1.0)}
        table: dict[str, AnyArray] = {}
        for title, values in {**t.channels, **columns}.items():
            if np.ndim(values) == 1:
                table[title] = values
            else:
                table |= {f"{title}_{name}": values[:, leg] for leg, name in enumerate(names)}
        return table


def simulate_gaits(
    legged: Legged,
    phase_rad: Sequence[float] | None = None,
    *,
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> GaitRun:
    """Release a body once, and record everything.

    Args:
        legged: the body and what drives it.
        phase_rad: phases at release [rad], one a leg; drawn at random by default.
        seed: of random phases; the first start that a basin of this seed has.
        tolerance: how far lags may be from a named pattern's [cycles].

    Raises:
        TegotaeError: for phases of another number of legs, or what the engine refuses.

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> simulate_gaits(system("bar-heavy"), (0.0, 2.0)).gait
        'in phase'
    """
    limbs = legged.body.limbs
    phase = random_phases(limbs, 1, seed)[:, 0] if phase_rad is None else np.asarray(phase_rad)
    if phase.shape != (limbs,):
        raise TegotaeError(f"{phase.size} phases are given; this body has {limbs} legs")
    for angle in phase:
        require_finite("a phase", angle)
    summary = legged.summary()
    closely = Together((whole_trajectory, summary))
    trajectory, coordination = legged.run(closely, legged.scenario(phase[:, None]))
    coordination = lanes_of(coordination)
    return GaitRun(
        legged=legged,
        phase_rad=phase,
        trajectory=jax.tree.map(lambda x: x[..., 0], trajectory),
        lag=_course(summary, trajectory, coordination, legged.timing),
        coordination=coordination,
        gait=str(gait_of(coordination, legged.names, tolerance)[0]),
    )


def _course(
    summary: CoordinationSummary, trajectory: Trajectory, coordination: Coordination, timing: Timing
) -> np.ndarray:
    """Return the lags averaged over the last stride, [frames, limbs], or over a frame without
    any stride.
    """
    hz = float(coordination.cycle_frequency_hz[0])
    frames = round(1.0 / (hz * timing.frame_s)) if hz * timing.duration_s > 1.0 else 1
    lag = summary.rhythm.lag(trajectory, summary.reference)
    return np.asarray(over_strides(lag, np.array([frames])), float)[..., 0]


@dataclass(frozen=True)
class Releases:
    """Gaits of controllers of one structure from the same random phases."""

    legged: Legged
    """The system that they drive."""
    frame: pd.DataFrame
    """A row a run, frequency `omega` [rad/s] (NaN without an oscillator) and start: the phases at
    release, the gait and the coordination (`coordination_frame`)."""
    starts: int
    """Number of releases of each run at each frequency."""
    body: Body
    """The body with what was changed for the whole run, such as its mass."""
    metrics: tuple[Metric, ...] | None = None
    """Metrics of the summary; all by default, and the common gait."""
    channels: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])
    """Recorded channels that these read, [frames, (limbs,) releases] each."""

    @property
    def summary(self) -> pd.DataFrame:
        """Metrics of the releases (`over_starts`), one row per run and frequency."""
        rows = self.frame[["run", "omega"]].iloc[:: self.starts].reset_index(drop=True)
        walks = Walks(dict(self.frame), self.starts, self.body, self.channels)
        return rows.assign(**over_starts(walks, self.metrics))

    @property
    def outcomes(self) -> pd.DataFrame:
        """Final gaits, or reasons to have none, one row each, the most common first; equally common
        ones in the order of letters.

        The `share` of the starts has a 95 % interval from `low` to `high`. `lag` has the
        circular means of the lags over these starts, and `between` their circular standard
        deviations, a leg [cycles]: near zero if the starts end in one gait and not merely in gaits
        of one name. `lock_time_s` is the median time to lock [s].
        """
        lags, rows = [f"lag_cycles_{leg}" for leg in self.legged.names], []
        for gait, ending in self.frame.groupby("gait"):
            lag = ending[lags].to_numpy().T
            share = share_interval(len(ending), len(self.frame))
            rows.append(
                {
                    "gait": gait,
                    "count": len(ending),
                    "share": share.mean,
                    "low": share.low,
                    "high": share.high,
                    "lag": np.asarray(circular_mean(lag, axis=1), float).tolist(),
                    "between": np.asarray(circular_spread(lag, axis=1), float).tolist(),
                    "lock_time_s": ending["lock_time_s"].median(),
                }
            )
        listed = pd.DataFrame(rows).sort_values("count", ascending=False, kind="stable")
        return listed.reset_index(drop=True)


def release_all(
    legged: Legged,
    weights: np.ndarray | None = None,
    omegas: Sequence[float] = (),
    starts: int = 32,
    *,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    changes: Mapping[str, LaneNumbers] | None = None,
    metrics: tuple[Metric, ...] | None = None,
) -> Releases:
    """Release controllers at random phases, the same ones for all, at every frequency.

    Args:
        legged: the system that they drive.
        weights: of the controllers, [runs, n_weights]; the system's own by default.
        omegas: frequencies ω [rad/s]; the system's own if none is given.
        starts: how many releases of each, their phases independent and even on the circle; of legs
            without oscillators all would be alike, and one is made.
        seed: of the phases; more starts of a seed begin with the same ones.
        tolerance: how far lags may be from a named pattern's [cycles].
        changes: what they meet, numbers by the names of the body's fields (`with_changes`).
        metrics: metrics of the summary; all by default.

    Raises:
        TegotaeError: for weights of another number, a frequency of what has none, or one that is
            not positive.

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> found = release_all(system("bar-light"), starts=4)
        >>> found.outcomes[["gait", "share"]].values.tolist()
        [['antiphase', 1.0]]
    """
    require_count("starts", starts, most=MOST_SEEDS)
    weights = np.atleast_2d(np.asarray(legged.weights if weights is None else weights, float))
    if weights.shape[1] != legged.controller.n_weights:
        raise TegotaeError(
            f"weights have shape {weights.shape}; this controller has "
            f"{legged.controller.n_weights} of them"
        )
    if legged.omega is None:
        if len(omegas):
            raise TegotaeError("the controller has no oscillator, and so no omega")
        frequencies, starts = np.array([np.nan]), 1
    else:
        frequencies = np.array(list(omegas) or [legged.omega], float)
        for omega in frequencies.tolist():
            require_finite("omega", omega, above=0.0, most=MOST_RAD_PER_S)
    repeats = len(weights) * len(frequencies)
    phase = np.tile(random_phases(legged.body.limbs, starts, seed), repeats)
    run = np.repeat(np.arange(len(weights)), len(frequencies) * starts)
    omega = np.tile(np.repeat(frequencies, starts), len(weights))
    scenario = with_changes(legged.scenario(phase), legged.body, changes or {})
    if legged.omega is not None:
        scenario = scenario._replace(omega=omega)
    selected = WALKING.metrics() if metrics is None else metrics
    read = {x: None for m in selected if isinstance(m, WalkMetric) for x in m.channels}
    rollout = legged.rollout(Together((legged.summary(), KeptChannels((*read,)))))
    coordination, recorded = lanes_of(rollout.run(weights[run], scenario, legged.body))
    labels = {"run": run, "omega": omega, "start": np.tile(np.arange(starts), repeats)}
    labels |= {f"release_phase_rad_{leg}": x for leg, x in zip(legged.names, phase, strict=True)}
    frame = coordination_frame(coordination, legged.names, tolerance, **labels)
    body, _ = whole_run(legged.body, dict(scenario.changes))
    return Releases(legged, frame, starts, body, metrics, recorded.channels)
