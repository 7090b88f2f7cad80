"""All controllers under all disturbances, in a folder, and the margins that come of it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import pandas as pd

from tegotae._support.documents import CODE, Document
from tegotae._support.engines import available_cores
from tegotae._support.errors import TegotaeError
from tegotae._support.part_code import code_of
from tegotae._support.workplace import GENERALISATION, alone
from tegotae.analysis.generalisation.disturbances import Disturbance, Tested
from tegotae.measures.statistics import share_interval
from tegotae.study import CellResult, Study, bundles, on_cores, run_locally
from tegotae.systems.descriptions import describe
from tegotae.systems.registry import parts_in, register

FORMAT = 3
"""Changed whenever the same configuration would give other numbers."""
COLUMNS = {
    **{"condition": str, "level": float, "run": int, "start": int},
    **{"had": bool, "moved": bool, "moves": bool, "keeps": bool},
    **{"efficiency": float, "speed": float},
}
"""Columns of a `Retention`, and what they hold."""


@dataclass(frozen=True)
class Retention:
    """Results: a row for each disturbance, level, run and release.

    Args:
        table: `condition`, `level`, `run` and `start`; `moved`, whether it hopped or walked
            without the disturbance, and `moves`, whether it still does; `had`, whether it had a
            gait, and `keeps`, whether it has the same; and what of `efficiency` and `speed` it
            keeps, as shares, NaN where that is not defined.
        left_out: why a disturbance was not tried, by its name.
    """

    table: pd.DataFrame
    left_out: dict[str, str]


Done = tuple[Tested, Retention]


def measure_retention(tested: Tested, disturbances: Sequence[Disturbance]) -> Retention:
    """Test controllers under every disturbance that applies to them, at every level.

    Raises:
        TegotaeError: if a level makes no body, or too quick an oscillator.
    """
    left_out = {
        disturbance.name: reason
        for disturbance in disturbances
        if (reason := tested.lacks(disturbance))
    }
    meets = [disturbance for disturbance in disturbances if disturbance.name not in left_out]
    if not meets:
        empty = {name: pd.Series(dtype=kind) for name, kind in COLUMNS.items()}
        return Retention(pd.DataFrame(empty), left_out)
    tested.check(meets)
    arrays = tested.shares_kept(meets)
    levels = [(disturbance.name, level) for disturbance in meets for level in disturbance.outwards]
    lane = np.arange(len(levels) * tested.size)
    level, run = lane // tested.size, lane % tested.size // tested.starts
    rows = {
        "condition": np.array([name for name, _ in levels])[level],
        "level": np.array([x for _, x in levels])[level],
        "run": run,
        "start": lane % tested.starts,
    }
    return Retention(pd.DataFrame(rows | {n: np.ravel(x) for n, x in arrays.items()}), left_out)


@dataclass(frozen=True)
class Trial:
    """A set of controllers under some disturbances: a cell of a study.

    Args:
        tested: the controllers.
        disturbances: under what; those that do not apply decide nothing.
    """

    tested: Tested
    disturbances: tuple[Disturbance, ...]

    @property
    def name(self) -> str:
        """Name of the set."""
        return self.tested.name

    @property
    def document(self) -> Document:
        """All settings that determine the measurement, as JSON values."""
        document = {
            "format": FORMAT,
            "name": self.name,
            "weights": hashlib.sha256(
                np.asarray(self.tested.weights, "float32").tobytes()
            ).hexdigest(),
            "runs": len(self.tested.weights),
            "disturbances": [
                _described(disturbance)
                for disturbance in self.disturbances
                if not self.tested.lacks(disturbance)
            ],
            **self.tested.document,
        }
        return json.loads(json.dumps(document))

    @property
    def program(self) -> str:
        """Sets of one structure share a compiled program."""
        return repr((self.tested.controller, type(self.tested.body)))

    def prepare(self) -> None:
        """Register a user's parts."""
        for part in parts_in((self.tested.controller, self.tested.body)):
            register(part)

    def measure(self) -> CellResult:
        """Measure the retained gaits of the controllers."""
        outcome = measure_retention(self.tested, self.disturbances)
        kinds = COLUMNS | {"efficiency": "float32", "speed": "float32"}
        arrays = {name: outcome.table[name].to_numpy(kind) for name, kind in kinds.items()}
        left_out = {"left_out": np.array(json.dumps(outcome.left_out))}
        return CellResult(self.document, {}, arrays | left_out)


def generalise(
    controllers: Sequence[Tested],
    disturbances: Sequence[Disturbance],
    out: Path,
    *,
    restart: bool = False,
) -> list[Done]:
    """Test all controllers under all disturbances, or continue, in the folder `out`.

    Each set has a record; stopped and called again it continues from there, and ends in the
    same numbers. Sets of the same structure share a compiled program.

    Args:
        controllers: those to be tested.
        disturbances: under what.
        out: the folder.
        restart: whether what is there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: for no controllers, two sets of the same name, none that can meet any of the
            disturbances, a level that makes no body, or a folder that cannot be written to.
        KeyboardInterrupt: after Ctrl-C; it says what is kept.
    """
    _check(controllers, disturbances)
    trials = [Trial(tested, tuple(disturbances)) for tested in controllers]
    remedy = "choose another folder with --out, or start again with --restart"
    with alone(out, GENERALISATION, restart=restart):
        study = Study(out / "records", trials, "robustness", "controllers", ".trial.npz", remedy)
        cores = min(available_cores(), len(bundles(trials)))
        study.run(run_locally if cores <= 1 else on_cores)
        return [
            (trial.tested, _retention(result))
            for trial, result in zip(trials, study.results(), strict=True)
        ]


def _retention(result: CellResult) -> Retention:
    columns = dict(result.arrays)
    left_out = json.loads(str(columns.pop("left_out")))
    return Retention(pd.DataFrame(columns), left_out)


def _described(disturbance: Disturbance) -> Document:
    code = code_of(type(disturbance))
    noted = {} if code is None else {CODE: code}
    return {"kind": type(disturbance).__name__, **noted, **describe(disturbance)}


def _check(controllers: Sequence[Tested], disturbances: Sequence[Disturbance]) -> None:
    if not controllers:
        raise TegotaeError("there are no controllers to test")
    names = [member.name for member in controllers]
    for name in names:
        if names.count(name) > 1:
            raise TegotaeError(
                f"{names.count(name)} sets of controllers are called {name}; try them one by one"
            )
    met = {member.name: [x for x in disturbances if not member.lacks(x)] for member in controllers}
    for tested in controllers:
        if met[tested.name]:
            tested.check(met[tested.name])
    if not any(met.values()):
        first = controllers[0]
        reason = "; ".join(f"{member.name}: {first.lacks(member)}" for member in disturbances)
        raise TegotaeError(f"{first.name} can meet none of these conditions: {reason}")


RESAMPLES = 2000
"""Number of bootstrap samples of runs for the interval of a margin."""


MEASURES = {"keeps": "had", "moves": "moved"}
"""Retained quantities, and the quantity that each requires before the disturbance."""


class Margin(NamedTuple):
    """The tested levels between which half of the runs fail, on one side of the undisturbed
    level.
    """

    condition: str
    side: str
    """"below" or "above" the neutral level."""
    runs: int
    """Number of runs that had a gait to lose."""
    survived: float
    """The last level, from none on, that more than half of the runs survive."""
    failed: float
    """The next level, which half of them or fewer survive; infinite beyond the last one tested."""
    low: float
    """Lower end of the 95 % interval of both over runs; NaN for a single run."""
    high: float
    """Upper end."""


def levels_survived(
    outcome: Retention, disturbance: Disturbance, below: bool, measure: str = ""
) -> np.ndarray:
    """Return the number of consecutive levels, from the baseline on, at which each run retains its
    gait, [runs].

    NaN of a run that had nothing to keep. Of a run that is released several times it is kept where
    most of them keep it.

    Args:
        outcome: of one set of controllers.
        disturbance: which.
        below: whether on the side of lower levels.
        measure: "keeps" or "moves"; the disturbance's own if empty.
    """
    measure = measure or disturbance.measure
    levels, table = disturbance.side(below), cast(Any, outcome.table)
    mine = table[table["condition"] == disturbance.name]
    if mine.empty:
        return np.zeros(0)
    shares = mine.groupby(["run", "level"])[[measure, MEASURES[measure]]].mean().unstack()
    survived = (shares[measure][levels] > 0.5).cumprod(axis=1).sum(axis=1)
    had = shares[MEASURES[measure]][levels[0]] > 0.5
    return survived.where(had).to_numpy(float)


def margin(disturbance: Disturbance, below: bool, survived: np.ndarray) -> Margin:
    """Return the margin of runs that survive so many levels (`levels_survived`)."""
    beyond = -np.inf if below else np.inf
    levels = [disturbance.neutral, *disturbance.side(below), beyond]
    survived = survived[~np.isnan(survived)]
    side, runs = "below" if below else "above", len(survived)
    if not runs:
        return Margin(disturbance.name, side, 0, *[np.nan] * 4)
    half, nearest, farthest = _median_interval(survived)
    ends = sorted((levels[nearest], levels[farthest + 1])) if runs > 1 else [np.nan] * 2
    return Margin(disturbance.name, side, runs, levels[half], levels[half + 1], *ends)


def _median_interval(counts: np.ndarray, seed: int = 0) -> tuple[int, int, int]:
    """Return the median of counts, the lower of two middle ones, and its 95 % interval by the
    bootstrap.

    Example:
        >>> _median_interval(np.array([1, 2, 2, 4]))[0]
        2
    """
    counts = np.sort(counts).astype(int)
    random = np.random.default_rng(seed)
    drawn = np.sort(random.integers(len(counts), size=(RESAMPLES, len(counts))), axis=1)
    middle = (len(counts) - 1) // 2
    medians = np.sort(counts[drawn[:, middle]])
    low, high = (int(medians[round(share * (RESAMPLES - 1))]) for share in (0.025, 0.975))
    return int(counts[middle]), low, high


def margins(
    outcome: Retention, disturbances: Sequence[Disturbance], measure: str = ""
) -> Iterator[Margin]:
    """Yield the margins of controllers, for each side of every disturbance that they met."""
    for disturbance in disturbances:
        if disturbance.name in outcome.left_out:
            continue
        for below in (True, False):
            if disturbance.side(below):
                yield margin(
                    disturbance, below, levels_survived(outcome, disturbance, below, measure)
                )


def retention_curve(outcome: Retention) -> pd.DataFrame:
    """Return the shares of the lanes of one set that keep their gait, level by level; the
    interval is over runs.
    """
    rows = []
    for name, mine in cast(Any, outcome.table).groupby("condition", sort=False):
        for level, lanes in mine.groupby("level"):
            had, moved = lanes[lanes["had"]], lanes[lanes["moved"]]
            kept = share_interval(int(had["keeps"].sum()), len(had), had["run"].nunique())
            rows.append(
                {
                    "condition": name,
                    "level": level,
                    "lanes": len(lanes),
                    "had": len(had),
                    "moved": len(moved),
                    "moves": moved["moves"].mean(),
                    "keeps": kept.mean,
                    "keeps_low": kept.low,
                    "keeps_high": kept.high,
                    "efficiency": _median(lanes["efficiency"]),
                    "speed": _median(lanes["speed"]),
                }
            )
    return pd.DataFrame(rows)


def _median(values: Any) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else np.nan
