"""Claims 1, 10 and 11, decided by experiments of their own: small tables beside their figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.statistics import (
    BOOTSTRAP,
    Interval,
    difference,
    interval,
)
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.studies.analysis.ridge import line
from tegotae.studies.paper.claims.verdict import Part, Verdict
from tegotae.training.curves import LearningCurve, groups, read_curves

NEAR_LINEAR = 0.9
"""Points are nearly on a line if it explains at least this share of their variance."""

CLAIM_1 = "PGPE beats SAC and PPO on the same policies"
CLAIM_10 = "More than 128 parameters cannot be trained by PGPE"
CLAIM_11 = "The best σ grows near-linearly with ω for sector actuation, and not for reflex"

_RESAMPLES = 4000
PARAMETERS = 128
"""More than these the paper could not train."""


def claim_1(curves: Sequence[LearningCurve]) -> Verdict:
    """PGPE beats SAC and PPO.

    Compared is CoT⁻¹ late in training, per run: of all of it, as in the paper, and of as much
    simulated time as the shortest run of the two algorithms learned from.

    Args:
        curves: of PGPE and others, such as `figure3.csv` holds.
    """
    found = groups(curves)
    parts = []
    for (model, algorithm), runs in sorted(found.items()):
        pgpe = found.get((model, "pgpe"))
        if algorithm == "pgpe" or pgpe is None:
            continue
        equal = min(run.simulated_s[-1] for run in (*pgpe, *runs))
        for until, words in ((np.inf, "at the end"), (equal, f"after {equal:.0f} simulated s")):
            ours, theirs = ([run.late_mean(until) for run in group] for group in (pgpe, runs))
            what = f"CoT⁻¹, pgpe - {algorithm}, {model}, {words} [m/J]"
            parts.append(Part(what, difference(ours, theirs), low=0.0))
    return Verdict(1, CLAIM_1, tuple(parts))


@dataclass(frozen=True)
class Training:
    """A training of some number of parameters: fitness of its first distribution, and its best."""

    way: str
    parameters: int
    untrained_fitness: float
    fitness: float


def claim_10(trainings: Sequence[Training]) -> Verdict:
    """More than 128 parameters cannot be trained by PGPE.

    Each size is trained if its fitness comes out above half way between that of random weights
    (the median, without those that failed) and that of at most 128 parameters trained the same way.
    """
    parts = []
    for way in dict.fromkeys(t.way for t in trainings):
        own = [t for t in trainings if t.way == way]
        sizes = sorted({t.parameters for t in own})
        small = [t.fitness for t in own if t.parameters <= PARAMETERS]
        start = [t.untrained_fitness for t in own if t.untrained_fitness > 0.5 * FAILED_FITNESS]
        if not small or not start:
            continue
        untrained = float(np.median(start))
        half_way = 0.5 * (untrained + float(np.mean(np.maximum(small, untrained))))
        for size in (size for size in sizes if size > PARAMETERS):
            # A rollout that failed has a fitness of minus a million, which says nothing in a mean.
            fitness = [max(t.fitness, untrained) for t in own if t.parameters == size]
            what = f"fitness of {size} parameters, settings {way}"
            parts.append(Part(what, interval(fitness), high=half_way))
    return Verdict(
        10, CLAIM_10, tuple(parts), "bound: half way from random weights to at most 128 trained"
    )


def claim_11(ridges: dict[str, tuple[np.ndarray, np.ndarray]]) -> Verdict:
    """The best σ grows near-linearly with ω for sector actuation, not for reflex.

    Args:
        ridges: by actuation, "sector" and "reflex": frequencies [rad/s] and the best gain at each
            [rad/(s N)], shape [frequencies]; NaN where it is censored, that is, at the edge of the
            searched range.
    """
    sector, reflex = (_line(*ridges[name]) for name in ("sector", "reflex"))
    return Verdict(
        11,
        CLAIM_11,
        (
            Part("slope of best σ over ω, sector [1/N]", sector[0], low=0.0, unit="frequencies"),
            Part("R² of the line, sector", sector[1], low=NEAR_LINEAR, unit="frequencies"),
            Part("R² of the line, reflex", reflex[1], high=NEAR_LINEAR, unit="frequencies"),
        ),
        "gaits of one turn a hop; a best gain at the edge of the searched range counts as "
        "undefined; neighbouring frequencies are not independent samples",
    )


def _line(omega: np.ndarray, sigma: np.ndarray) -> tuple[Interval, Interval]:
    """Slope and R² of the least-squares line, with bootstrap intervals over the frequencies."""
    defined = np.isfinite(sigma)
    omega, sigma = omega[defined], sigma[defined]
    n, undefined = len(omega), int((~defined).sum())
    if n < 3:
        nothing = Interval(np.nan, np.nan, np.nan, np.nan, n, undefined)
        return nothing, nothing
    drawn = np.random.default_rng(0).integers(0, n, (_RESAMPLES, n))
    slope, _, r_squared = line(omega, sigma)
    slopes, _, r_squares = line(omega[drawn], sigma[drawn])

    def found(value: np.ndarray, values: np.ndarray) -> Interval:
        values = values[np.isfinite(values)]
        if len(values) == 0:
            return Interval(float(value), np.nan, np.nan, np.nan, n, undefined)
        low, high = np.quantile(values, [0.025, 0.975])
        return Interval(
            float(value), float(values.std()), float(low), float(high), n, undefined, BOOTSTRAP
        )

    return found(slope, slopes), found(r_squared, r_squares)


def _verdict_on_curves(path: Path) -> Verdict:
    return claim_1(read_curves([path]))


def _verdict_on_sizes(path: Path) -> Verdict:
    return claim_10(read_trainings(path))


def _verdict_on_ridges(path: Path) -> Verdict:
    return claim_11(read_ridges(path))


def read_trainings(path: Path) -> list[Training]:
    """The trainings of a table such as `parameter_limit.csv`.

    Raises:
        TegotaeError: if it cannot be read.
    """
    columns = ("way", "parameters", "untrained_fitness", "fitness")
    return [Training(*row) for row in _rows(path, columns, (str, int, float, float))]


def read_ridges(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Frequencies and the best gain at each, by actuation, of a table such as `gain_map.ridge.csv`.

    Raises:
        TegotaeError: if it cannot be read.
    """
    columns = ("actuation", "omega_rad_per_s", "best_sigma_rad_per_s_n", "censored")
    rows = _rows(path, columns, (str, float, float, int))

    def points(actuation: str) -> tuple[np.ndarray, np.ndarray]:
        own = np.array([row[1:] for row in rows if row[0] == actuation], float).reshape(-1, 3)
        return own[:, 0], np.where(own[:, 2] == 0.0, own[:, 1], np.nan)

    return {name: points(name) for name in ("sector", "reflex")}


def _rows(
    path: Path, columns: Iterable[str], types: Iterable[Callable[[str], object]]
) -> list[tuple]:
    """Some columns of a table, converted."""
    columns, types = tuple(columns), tuple(types)
    kind = f"table with rows of {', '.join(columns)}"
    cells = tables.read_csv(path, columns, kind=kind)
    try:
        converted = [
            [make(cell) for cell in cells[name].tolist()]
            for name, make in zip(columns, types, strict=True)
        ]
        if any(isinstance(x, float) and not np.isfinite(x) for row in converted for x in row):
            raise ValueError
    except ValueError:
        raise TegotaeError(f"{path} is no {kind}: a cell is no number") from None
    return list(zip(*converted, strict=True))


@dataclass(frozen=True)
class KeptExperiment:
    """An experiment that decides a claim.

    Args:
        number: the claim's.
        claim: the claim.
        table: the name of its table.
        figure: the name of its figure.
        caption: what the figure shows.
        command: what measures it, with {folder} for the folder that table and figure go to.
        verdict: that on the claim, from the table's path.
    """

    number: int
    claim: str
    table: str
    figure: str
    caption: str
    command: str
    verdict: Callable[[Path], Verdict]


EXPERIMENTS = (
    KeptExperiment(
        1,
        CLAIM_1,
        "figure3.csv",
        "figure3.png",
        "CoT⁻¹ in the course of training, by algorithm (Fig. 3 of the paper)",
        "python studies/figure3.py && tegotae figure learning-curves results/figure3 "
        "--out {folder}/figure3.png",
        _verdict_on_curves,
    ),
    KeptExperiment(
        10,
        CLAIM_10,
        "parameter_limit.csv",
        "parameter_limit.png",
        "Fitness over the number of trained parameters",
        "python studies/parameter_limit.py --out {folder}",
        _verdict_on_sizes,
    ),
    KeptExperiment(
        11,
        CLAIM_11,
        "gain_map.ridge.csv",
        "gain_map.png",
        "CoT⁻¹ over gain and frequency, with the best gain per frequency (Fig. 4 of the paper)",
        "tegotae figure gain-map --out {folder}/gain_map.png",
        _verdict_on_ridges,
    ),
)
"""The claims that have experiments of their own."""


def experiment_verdicts(folder: Path | None = None) -> list[Verdict]:
    """What the experiments' tables in a folder say; those that are not there are not measured.

    Args:
        folder: where the tables are looked for; None if there is none.

    Raises:
        TegotaeError: if there is no such folder, or a table cannot be read.
    """
    if folder is not None and not folder.is_dir():
        raise TegotaeError(f"there is no folder {folder}")
    found = []
    for e in EXPERIMENTS:
        if folder is not None and (folder / e.table).exists():
            found.append(e.verdict(folder / e.table))
        else:
            command = e.command.format(folder=folder or "experiments")
            found.append(
                Verdict(e.number, e.claim, (), f"not measured here; to measure: {command}")
            )
    return found
