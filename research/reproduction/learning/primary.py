"""The primary analysis of what learning adds, fixed before the runs that it judges.

The outcome is a run's merit: its mean CoT⁻¹ over five frequencies and fifteen common releases, in
which an episode without a limit cycle counts as 0. It joins the two things that matter, whether a
run settles and how efficient it is then, and both are shown beside it, as is its following of ω.

Two contrasts are primary, in each of two bodies:

1. learned feedback (AR, ARG, ART, ARGT on [F_k]) over V of the same drive and ω_t, whose gain is
   searched at that ω_t;
2. learned feedback over the best short law: the one of highest merit on the first half of the
   releases, mean over runs and ω_t, judged on the other half, as the learned runs are.

Units are the differences of a design (architecture and drive) at an ω_t, each the mean over its
runs. Design and ω_t are crossed random effects: what is claimed is of designs and frequencies like
these, not of these alone. The interval is Student's, from the two-way analysis of variance, with
Satterthwaite's degrees of freedom. Beside it stand the interval over runs alone, and a bootstrap
that draws designs, frequencies and runs anew (Owen's pigeonhole).

Everything else, other ways to count, other groups, the best run of each, is sensitivity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.claims.random_effects import crossed
from research.reproduction.learning.runs import LAW, where
from tegotae._support.errors import TegotaeError

RESAMPLES = 4000
MEAN_RUN, BEST_RUN = "mean of runs", "run of best fitness"


@dataclass(frozen=True)
class Contrast:
    """A difference of merits, with its 95 % intervals [m/J].

    Args:
        effect: mean over designs and frequencies.
        crossed: interval with design and ω_t as random effects.
        runs: interval over runs alone.
        drawn: interval of the pigeonhole bootstrap.
        base: the merit of what it is compared with.
        of_omega: the difference at each ω_t, mean over designs, by ω_t [rad/s].
    """

    effect: float
    crossed: tuple[float, float]
    runs: tuple[float, float]
    drawn: tuple[float, float]
    base: float
    of_omega: dict[float, float]


def contrast(
    runs: pd.DataFrame,
    law: str | None = None,
    *,
    outcome: str = "merit",
    run: str = MEAN_RUN,
    learned: Sequence[str] = LEARNED_FEEDBACK,
) -> Contrast:
    """Compare learned feedback with V, or with a short law.

    Args:
        runs: rows of `research.reproduction.learning.runs.run_rows`.
        law: the short law; None compares with V.
        outcome: the column.
        run: `MEAN_RUN`, or `BEST_RUN` for the one of best training fitness of each design.
        learned: the architectures that are compared.

    Returns:
        The contrast, over all ω_t that both have.
    """
    selected = where(runs, runs.senses == "F")
    if run == BEST_RUN:
        selected = selected.sort_values("fitness", kind="stable").drop_duplicates(
            "model", keep="last"
        )
    mine = where(selected, selected.architecture.isin(learned))
    base = where(selected, selected.architecture == (LAW if law else "V"))
    base = where(base, base.drive == law) if law else base
    values = _cells(mine, ("architecture", "drive", "omega_t"), outcome)
    theirs = _cells(base, ("drive", "omega_t"), outcome)
    designs = sorted({(architecture, drive) for architecture, drive, _ in values})
    omegas = sorted({omega for *_, omega in values} & {omega for _, omega in theirs})
    means = np.array([[values[*design, w].mean() for w in omegas] for design in designs])
    bases = np.array([[theirs[law or drive, w].mean() for w in omegas] for _, drive in designs])
    draw = np.random.default_rng(0)
    # A cell of the base is shared by designs: it is drawn once.
    base_means = {key: _resampled_means(draw, cell) for key, cell in theirs.items()}
    gaps = np.array(
        [
            [
                _resampled_means(draw, values[*design, w]) - base_means[law or design[1], w]
                for w in omegas
            ]
            for design in designs
        ]
    )
    rows = draw.integers(0, len(designs), (len(designs), 1, RESAMPLES))
    columns = draw.integers(0, len(omegas), (1, len(omegas), RESAMPLES))
    drawn = gaps[rows, columns, np.arange(RESAMPLES)]
    differences = means - bases
    return Contrast(
        float(differences.mean()),
        crossed(differences),
        _ends(gaps.mean(axis=(0, 1))),
        _ends(drawn.mean(axis=(0, 1))),
        float(bases.mean()),
        dict(zip(omegas, differences.mean(axis=0).tolist(), strict=True)),
    )


def _cells(runs: pd.DataFrame, keys: Sequence[str], outcome: str) -> dict[tuple, np.ndarray]:
    """Return an outcome's values by the field that the keys describe."""
    cells: dict[tuple, list[float]] = {}
    places = zip(*(runs[key].tolist() for key in keys), strict=True)
    for place, value in zip(places, runs[outcome].tolist(), strict=True):
        cells.setdefault(place, []).append(value)
    return {place: np.array(values) for place, values in cells.items()}


def _resampled_means(draw: np.random.Generator, cell: np.ndarray) -> np.ndarray:
    """Return resampled means of a cell's runs, [`RESAMPLES`]."""
    return draw.choice(cell, (RESAMPLES, len(cell))).mean(axis=1)


def _ends(values: np.ndarray) -> tuple[float, float]:
    low, high = np.percentile(values, (2.5, 97.5))
    return float(low), float(high)


def best_law(runs: pd.DataFrame) -> str:
    """Return the short law of highest merit on the first half of the releases, over runs and
    ω_t.

    Raises:
        TegotaeError: if there is none.
    """
    laws = _cells(where(runs, runs.architecture == LAW), ("drive",), "merit_chosen")
    if not laws:
        raise TegotaeError(f"the table has no runs of {LAW}; judge a whole study")
    return max(laws, key=lambda law: laws[law].mean())[0]
