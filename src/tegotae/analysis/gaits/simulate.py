"""One walk: its coordination, footfalls and gait."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.engines import selected
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.files import write_atomically
from tegotae._support.tables import write_csv
from tegotae.measures.gaits.lags import StanceInterval, over_strides, stances
from tegotae.measures.gaits.names import TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination, CoordinationSummary
from tegotae.parts._shapes import AnyArray
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged, lanes_of, random_phases

_OF_LEGS = ("lag", "lag_spread", "touchdown_lag", "step_frequency_hz", "duty_factor")
_UNITS = {name: f"{name}_cycles" for name in ("lag", "lag_spread", "touchdown_lag", "moved")}

DIGITS = 9
"""Significant digits of what is written: more than single precision has."""


def coordination_columns(found: Coordination, legs: Sequence[str]) -> dict[str, np.ndarray]:
    """The coordination of lanes as columns, what belongs to a leg with its name at the end.

    Args:
        found: arrays [limbs, lanes] and [lanes].
        legs: the legs' names.

    Example:
        >>> values = {name: np.zeros(3) for name in Coordination._fields}
        >>> values |= {name: np.zeros((2, 3)) for name in _OF_LEGS}
        >>> list(coordination_columns(Coordination(**values), ("H", "F")))[:3]
        ['lag_cycles_H', 'lag_cycles_F', 'lag_spread_cycles_H']
    """
    columns = {}
    for name, values in found._asdict().items():
        title = _UNITS.get(name, name)
        if name in _OF_LEGS:
            columns |= {f"{title}_{leg}": values[i] for i, leg in enumerate(legs)}
        else:
            columns[title] = values
    return {name: np.asarray(values) for name, values in columns.items()}


def coordination_frame(
    found: Coordination, legs: Sequence[str], tolerance: float, **labels: Any
) -> pd.DataFrame:
    """The gait and the coordination of lanes, a row a lane, behind what tells lanes apart.

    Args:
        found: arrays [limbs, lanes] and [lanes].
        legs: the legs' names.
        tolerance: how far lags may be from a named pattern's [cycles].
        labels: numbers or texts by name, one or [lanes].
    """
    gait = gait_of(found, legs, tolerance)
    return pd.DataFrame({**labels, "gait": gait, **coordination_columns(found, legs)})


def system_document(legged: Legged) -> JsonObject:
    """A system as JSON values.

    Raises:
        TegotaeError: for a part that is not registered (`tegotae.register`).
    """
    return {**describe(legged), "legs": list(legged.names)}


def write(
    folder: Path, name: str, document: Mapping[str, object], rows: Mapping[str, ArrayLike]
) -> list[Path]:
    """Write `NAME.csv` and `NAME.json`, whole or not at all.

    Args:
        folder: where to.
        name: of both files.
        document: what stands before the rows in the document.
        rows: columns of one length, by name.

    Raises:
        TegotaeError: if they cannot be written.
    """
    table = {title: _rounded(column) for title, column in rows.items()}
    csv, whole = folder / f"{name}.csv", folder / f"{name}.json"
    write_csv(csv, table, digits=DIGITS)
    values = {**document, "engine": selected(), "rows": _objects(table)}
    write_atomically(whole, json.dumps(as_json(values), indent=1, allow_nan=False) + "\n")
    return [csv, whole]


def _objects(table: Mapping[str, np.ndarray]) -> list[JsonObject]:
    columns = [column.tolist() for column in table.values()]
    return [dict(zip(table, row, strict=True)) for row in zip(*columns, strict=True)]


def _rounded(column: ArrayLike) -> np.ndarray:
    """Numbers with as many digits as are written, so that both files have the same ones."""
    values = np.asarray(column)
    if values.dtype.kind != "f":
        return values
    return np.array([float(f"{x:.{DIGITS}g}") for x in values.astype(float)])


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
