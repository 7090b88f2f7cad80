"""The atlas of learned controllers: what each one's feedback does, and the shortest form that keeps
its score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from reproduction.learning.curves import CurvesOfRuns
from reproduction.learning.forms import FormOfControllers
from reproduction.learning.judged import EvaluatedRuns
from reproduction.learning.runs import joined, rows, where
from reproduction.record import Record
from reproduction.report.markdown import table
from tegotae.analysis.short_forms import SHARES, forms_of_a_leg
from tegotae.study import Arrays, Pool, Study

NOTHING, ALIKE, WAITS, GOOD = 0.01, 0.95, 0.05, 0.9
"""A merit of what does not get anywhere [m/J]; a share of the merit that is all of it; a share of
the time that is a wait; an R² of a formula that is the curve."""
NETWORK = "one network"
KINDS = (
    "does not hop",
    "clock",
    "clock of another frequency",
    "waits in flight",
    "waits in stance",
    "moves all the time",
    NETWORK,
)
"""What a controller's feedback does. Cut, a clock's merit stays; frozen, that of a clock of another
frequency; the feedback of the others makes the merit as it moves."""
NONE = "none"
"""In place of the name of a form where none keeps enough."""
_CURVES = {
    "action_1": "A′: cos φ",
    "action_2": "A′: cos 2φ, too",
    "load": "R: N",
    "latch": "1 - k N",
    "decay": "e^(-k N)",
    "saturating": "saturating",
}
"""Numbers of `curves_of` that are an R², and what a table calls the formula."""


def kinds(runs: pd.DataFrame) -> pd.Series:
    """What the feedback of every run does, one of `KINDS`."""
    enough = ALIKE * runs.merit
    conditions = [
        runs.merit < NOTHING,
        runs.merit_cut.isna(),
        runs.merit_cut >= enough,
        runs.merit_frozen >= enough,
        runs.waits_flight >= WAITS,
        runs.waits_stance >= WAITS,
    ]
    names = (KINDS[0], NETWORK, *KINDS[1:5])
    return pd.Series(np.select(conditions, names, KINDS[5]), runs.index, name="kind")


def forms_by_numbers() -> list[str]:
    """The library, those of fewest numbers first."""
    forms = forms_of_a_leg()
    return sorted(forms, key=lambda name: forms[name].on_a_leg().n_weights)


def measured(folder: Path, records: Sequence[Record], pool: Pool | None = None) -> pd.DataFrame:
    """Measure what a study's folder lacks of its atlas, and return it, a row a run.

    Forms are tried in the order of their numbers, on a run of every model, the best from the first
    half of the releases, as long as no shorter one keeps the largest share.

    Returns:
        The columns of `runs.rows`; `kind`; the numbers of `curves.curves_of`; `best`, whether it is
        the one that is tried; and of those the share that each form keeps of the
        merit, `kept FORM`, and with the numbers of the curves `cloned FORM`; NaN where a shorter
        one kept enough.
    """
    evaluations = [EvaluatedRuns(record) for record in records]
    study = Study(folder / "judged", evaluations, title="judge", suffix=".judged.npz")
    study.run(pool)
    with_feedback = [x for x in records if x.experiment.controller.tegotae is not None]
    cells = [CurvesOfRuns(record) for record in with_feedback]
    of_curves = Study(folder / "curves", cells, title="curves", suffix=".curves.npz")
    of_curves.run(pool)
    curves = {
        cell.record.model: result.arrays
        for cell, result in zip(cells, of_curves.results(), strict=True)
    }
    parts = []
    for cell, result in zip(evaluations, study.results(), strict=True):
        part = rows(cell, result.arrays)
        part["best"] = part.index == part.merit_chosen.argmax()
        known = curves.get(cell.record.model, {})
        numbers = {name: x for name, x in known.items() if not name.startswith("start_")}
        parts.append(part.assign(**numbers))
    runs = joined(parts).reset_index(drop=True)
    return _with_forms(runs.assign(kind=kinds(runs)), folder, with_feedback, curves, pool)


def _with_forms(
    runs: pd.DataFrame,
    folder: Path,
    records: Sequence[Record],
    curves: Mapping[str, Arrays],
    pool: Pool | None,
) -> pd.DataFrame:
    of_model = {record.model: record for record in records}
    for form in forms_by_numbers():
        runs[f"kept {form}"] = np.nan
        left = where(runs, runs.best & ~runs.kind.isin([KINDS[0], NETWORK]))
        kept = left.filter(like="kept ").max(axis=1)
        left = where(left, ~(kept >= SHARES[-1]))
        groups = [same for _, same in left.groupby("omega_t")]
        cells = [
            FormOfControllers(
                form,
                float(same.omega_t.iloc[0]),
                [of_model[model] for model in same.model],
                same.run.tolist(),
                np.array(
                    [
                        curves[model][f"start_{form}"][run]
                        for model, run in zip(same.model, same.run, strict=True)
                    ]
                ),
            )
            for same in groups
        ]
        study = Study(folder / "forms", cells, title=f"{form}, by ω_t", suffix=".form.npz")
        study.run(pool)
        for same, result in zip(groups, study.results(), strict=True):
            for name, kind in (("merit", "kept"), ("cloned", "cloned")):
                runs.loc[same.index, f"{kind} {form}"] = result.arrays[name] / same.merit
    return runs


def shortest(runs: pd.DataFrame, share: float) -> pd.Series:
    """The form of fewest numbers that keeps a share of each best run's merit; `NONE` without."""
    best = where(runs, runs.best & ~runs.kind.isin([KINDS[0], NETWORK]))
    forms = np.array([*forms_by_numbers(), NONE])
    enough = best[[f"kept {form}" for form in forms[:-1]]].to_numpy() >= share
    first = np.where(enough.any(axis=1), enough.argmax(axis=1), len(forms) - 1)
    return pd.Series(forms[first], best.index)


def atlas_tables(runs: pd.DataFrame) -> str:
    """The atlas of a body in Markdown: kinds of feedback, their curves, and shortest forms."""
    parts = []
    for omega, same in runs.groupby("omega_t"):
        parts.append(f"At $\\omega_t$ = {omega:g} rad/s, what the feedback does:")
        lines = [["feedback", "runs", "merit", "best merit", "cut", "frozen", "following"]]
        for kind in KINDS[:-1]:
            group = where(same, same.kind == kind)
            if len(group):
                means = group[["merit", "merit_cut", "merit_frozen", "following"]].mean()
                numbers = [means.iloc[0], group.merit.max(), *means.iloc[1:]]
                lines.append([kind, str(len(group)), *(f"{x:.2f}" for x in numbers)])
        parts.append(table(lines))
    makes = where(runs, runs.kind.isin(KINDS[3:6]))
    parts.append(f"Where the feedback makes the merit, runs with R² of at least {GOOD:g}:")
    lines = [["ω_t", "runs", *_CURVES.values()]]
    for omega, same in makes.groupby("omega_t"):
        shares = [f"{(same[name] >= GOOD).mean():.0%}" for name in _CURVES]
        lines.append([f"{omega:g}", str(len(same)), *shares])
    parts.append(table(lines))
    for omega, same in runs.groupby("omega_t"):
        parts.append(f"Shortest forms at $\\omega_t$ = {omega:g} rad/s, controllers of each:")
        chosen = {share: shortest(same, share) for share in SHARES}
        lines = [["form", "numbers", *(f"keeps {share:.0%}" for share in SHARES), "best merit"]]
        forms = forms_of_a_leg()
        for form in forms_by_numbers():
            counts = [str((names == form).sum()) for names in chosen.values()]
            best = f"{(same[f'kept {form}'] * same.merit).max():.2f}"
            lines.append([form, str(forms[form].on_a_leg().n_weights), *counts, best])
        counts = [str((names == NONE).sum()) for names in chosen.values()]
        lines.append([NONE, "", *counts, ""])
        parts.append(table(lines))
    return "\n\n".join(part.strip() for part in parts) + "\n"
