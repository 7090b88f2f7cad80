"""All controllers under all disturbances, in a folder, and the tables that come of it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tegotae._support.documents import CODE, Document
from tegotae._support.engines import available_cores
from tegotae._support.errors import TegotaeError
from tegotae._support.part_code import code_of
from tegotae._support.tables import write_csv
from tegotae._support.workplace import GENERALISATION, alone
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.trial import Retention, Tested, check_levels, tried
from tegotae.measures.hopping.statistics import wilson
from tegotae.study import CellResult, Study, bundles, here, on_cores
from tegotae.systems.descriptions import describe
from tegotae.systems.registry import parts_in, register

Done = tuple[Tested, Retention]

FORMAT = 3
"""Changed whenever the same configuration would give other numbers."""


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
        """The set's."""
        return self.tested.name

    @property
    def document(self) -> Document:
        """All that decides what is measured, as JSON values."""
        document = {
            "format": FORMAT,
            "name": self.name,
            "weights": hashlib.sha256(
                np.asarray(self.tested.weights, "float32").tobytes()
            ).hexdigest(),
            "runs": len(self.tested.weights),
            "disturbances": [
                _described(each) for each in self.disturbances if not self.tested.lacks(each)
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
        """What the controllers retain."""
        outcome = tried(self.tested, self.disturbances)
        arrays = {
            name: values.astype("float32") if name in ("efficiency", "speed") else values
            for name, values in outcome.columns.items()
        }
        left_out = {"left_out": np.array(json.dumps(outcome.left_out))}
        return CellResult(self.document, {}, arrays | left_out)


def generalise(
    controllers: Sequence[Tested],
    disturbances: Sequence[Disturbance],
    out: Path,
    *,
    anew: bool = False,
) -> list[Done]:
    """Test all controllers under all disturbances, or continue, in the folder `out`.

    Each set has a record; stopped and called again it continues from there, and ends in the
    same numbers. Sets of the same structure share a compiled program.

    Args:
        controllers: those to be tested.
        disturbances: under what.
        out: the folder.
        anew: whether what is there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: for no controllers, two sets of the same name, none that can meet any of the
            disturbances, a level that makes no body, or a folder that cannot be written to.
        KeyboardInterrupt: after Ctrl-C; it says what is kept.
    """
    _check(controllers, disturbances)
    trials = [Trial(tested, tuple(disturbances)) for tested in controllers]
    remedy = "choose another folder with --out, or start again with --anew"
    with alone(out, GENERALISATION, anew=anew):
        study = Study(out / "records", trials, "generalise", "controllers", ".trial.npz", remedy)
        cores = min(available_cores(), len(bundles(trials)))
        study.run(here if cores <= 1 else on_cores)
        return [
            (trial.tested, _retention(result))
            for trial, result in zip(trials, study.results(), strict=True)
        ]


def _retention(result: CellResult) -> Retention:
    columns = dict(result.arrays)
    return Retention(columns, json.loads(str(columns.pop("left_out"))))


def _described(disturbance: Disturbance) -> Document:
    code = code_of(type(disturbance))
    noted = {} if code is None else {CODE: code}
    return {"kind": type(disturbance).__name__, **noted, **describe(disturbance)}


def _check(controllers: Sequence[Tested], disturbances: Sequence[Disturbance]) -> None:
    if not controllers:
        raise TegotaeError("there are no controllers to test")
    names = [each.name for each in controllers]
    for name in names:
        if names.count(name) > 1:
            raise TegotaeError(
                f"{names.count(name)} sets of controllers are called {name}; try them one by one"
            )
    able = 0
    for tested in controllers:
        meets = [each for each in disturbances if not tested.lacks(each)]
        if meets:
            able += 1
            check_levels(tested, meets)
    if not able:
        first = controllers[0]
        why = "; ".join(f"{each.name}: {first.lacks(each)}" for each in disturbances)
        raise TegotaeError(f"{first.name} can meet none of these conditions: {why}")


RESAMPLES = 2000
"""How often runs are drawn anew for the interval of a margin."""


MEASURES = {"keeps": "had", "moves": "moved"}
"""What can be kept, and what it takes to have been there before."""


class Margin(NamedTuple):
    """The tested levels between which half of the runs fail, on one side of none of it."""

    condition: str
    side: str
    """"below" or "above" the neutral level."""
    runs: int
    """How many runs there are that had what can be lost."""
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
    """How many levels in a row, from none on, each run keeps what it had, [runs].

    NaN of a run that had nothing to keep. Of a run that is released several times it is kept where
    most of them keep it.

    Args:
        outcome: of one set of controllers.
        disturbance: which.
        below: whether on the side of lower levels.
        measure: "keeps" or "moves"; the disturbance's own if empty.
    """
    measure = measure or disturbance.measure
    columns = outcome.columns
    levels = disturbance.side(below)
    mine = columns["condition"] == disturbance.name
    runs = int(columns["run"].max()) + 1 if len(columns["run"]) else 0
    alive, count = np.full(runs, True), np.zeros(runs)
    first = mine & (columns["level"] == (levels or [np.nan])[0])
    had = _per_run(outcome, first, MEASURES[measure], runs)
    for level in levels:
        alive &= _per_run(outcome, mine & (columns["level"] == level), measure, runs) > 0.5
        count += alive
    return np.where(had > 0.5, count, np.nan)


def margin(disturbance: Disturbance, below: bool, survived: np.ndarray) -> Margin:
    """The margin of runs that survive so many levels (`levels_survived`)."""
    beyond = -np.inf if below else np.inf
    levels = [disturbance.neutral, *disturbance.side(below), beyond]
    survived = survived[~np.isnan(survived)]
    side, runs = "below" if below else "above", len(survived)
    if not runs:
        return Margin(disturbance.name, side, 0, *[np.nan] * 4)
    half, nearest, farthest = median_interval(survived)
    ends = sorted((levels[nearest], levels[farthest + 1])) if runs > 1 else [np.nan] * 2
    return Margin(disturbance.name, side, runs, levels[half], levels[half + 1], *ends)


def _per_run(outcome: Retention, rows: np.ndarray, name: str, runs: int) -> np.ndarray:
    """Share of a run's releases for which a column holds, [runs]."""
    run, holds = outcome.columns["run"][rows], outcome.columns[name][rows]
    count = np.bincount(run, minlength=runs)
    return np.bincount(run, weights=holds, minlength=runs) / np.maximum(count, 1)


def median_interval(counts: np.ndarray, seed: int = 0) -> tuple[int, int, int]:
    """Median of counts, of two middle ones the lower, and its 95 % interval by the bootstrap.

    Example:
        >>> median_interval(np.array([1, 2, 2, 4]))[0]
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
    """The margins of controllers, for each side of every disturbance that they met."""
    for each in disturbances:
        if each.name in outcome.left_out:
            continue
        for below in (True, False):
            if each.side(below):
                yield margin(each, below, levels_survived(outcome, each, below, measure))


def write_tables(
    done: Sequence[tuple[Tested, Retention]],
    disturbances: Sequence[Disturbance],
    out: Path,
) -> list[Path]:
    """Write `margins.csv`, `curves.csv` and `left_out.csv` into a folder; return their paths."""
    rows: dict[str, list[dict[str, object]]] = {"margins": [], "curves": [], "left_out": []}
    for tested, outcome in done:
        for measure in MEASURES:
            for found in margins(outcome, disturbances, measure):
                rows["margins"].append(
                    {"controller": tested.name, "measure": measure, **found._asdict()}
                )
        rows["curves"] += [{"controller": tested.name, **row} for row in curve(outcome)]
        for name, why in outcome.left_out.items():
            rows["left_out"].append({"controller": tested.name, "condition": name, "why": why})
    paths = []
    for name, table in rows.items():
        if table:
            write_csv(
                out / f"{name}.csv",
                {key: [row[key] for row in table] for key in table[0]},
                digits=4,
            )
            paths.append(out / f"{name}.csv")
        else:
            (out / f"{name}.csv").unlink(missing_ok=True)  # of another run in this folder
    return paths


def share_interval(kept: int, of: int, runs: int) -> tuple[float, float]:
    """95 % interval of the share of lanes of so many runs (Wilson's score); NaN of none.

    Releases of one run are no independent trials: they count as if all of them did the same.

    Example:
        >>> [round(end, 2) for end in share_interval(60, 80, 20)]
        [0.53, 0.89]
    """
    return wilson(round(kept / of * runs), runs) if of else (np.nan, np.nan)


def curve(outcome: Retention) -> Iterator[dict[str, object]]:
    """Shares of the lanes of one set that keep what they had, level by level; the interval is
    over runs."""
    columns = outcome.columns
    for name in dict.fromkeys(columns["condition"].tolist()):
        mine = columns["condition"] == name
        for level in np.unique(columns["level"][mine]):
            at = mine & (columns["level"] == level)
            had = at & columns["had"]
            kept = columns["keeps"][had]
            runs = len(np.unique(columns["run"][had]))
            low, high = share_interval(int(kept.sum()), len(kept), runs)
            yield {
                "condition": name,
                "level": float(level),
                "lanes": int(at.sum()),
                "had": len(kept),
                "moved": int(columns["moved"][at].sum()),
                "moves": _mean(columns["moves"][at & columns["moved"]]),
                "keeps": _mean(kept),
                "keeps_low": low,
                "keeps_high": high,
                "efficiency": _median(columns["efficiency"][at]),
                "speed": _median(columns["speed"][at]),
            }


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if len(values) else np.nan


def _median(values: np.ndarray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else np.nan
