"""The atlas of learned controllers: what each one's feedback does, and the shortest form that keeps
its score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import markdown_table
from research.reproduction.learning.curves import CurvesOfRuns
from research.reproduction.learning.forms import FormOfControllers, Retuning, leg_controller
from research.reproduction.learning.judged import EvaluatedRuns
from research.reproduction.learning.runs import concatenate_runs, run_rows, where
from research.reproduction.record import Record
from tegotae.analysis.explanation import ALIKE, NOTHING
from tegotae.analysis.short_forms import SHARES, forms_of_a_leg
from tegotae.study import Arrays, Pool, Study

WAITS, GOOD = 0.05, 0.9
"""A share of the time that is a wait; an R² of a formula that is the curve."""
NETWORK = "one network"
KINDS = (
    "does not hop",
    "feedback costs",
    "clock",
    "clock of another frequency",
    "waits in flight",
    "waits in stance",
    "moves all the time",
    NETWORK,
)
"""Kinds of a controller's feedback. Cutting it raises the merit of a harmful one, and leaves that
of a clock; freezing it leaves a clock of another frequency; else the merit needs its variation."""
DRIVES_OF_FORCE = ("φ", "φf", "f")
"""Inputs of a force. Cutting the feedback leaves nothing of a force that follows it alone."""
NONE = "none"
"""Placeholder for the name of a form where none keeps enough."""
_CURVES = {
    "A": {"action_1": "cos φ", "action_2": "cos φ and cos 2φ"},
    "R": {
        "load": "N",
        "latch": "1 - k N",
        "decay": "e^(-k N)",
        "saturating": "1 - k N / (1 + s N)",
    },
}
"""Coefficients of determination of `curves_of` for a learned term, and their formulas."""


def feedback_kinds(runs: pd.DataFrame) -> pd.Series:
    """Classify the feedback of every run, one of `KINDS`."""
    enough = ALIKE * runs.merit
    conditions = [
        runs.merit < NOTHING,
        runs.merit_cut.isna(),
        runs.merit_cut > runs.merit / ALIKE,
        runs.merit_cut >= enough,
        runs.merit_frozen >= enough,
        runs.waits_flight >= WAITS,
        runs.waits_stance >= WAITS,
    ]
    names = (KINDS[0], NETWORK, *KINDS[1:6])
    return pd.Series(np.select(conditions, names, KINDS[6]), runs.index, name="kind")


def forms_by_numbers() -> list[str]:
    """Return the library, the forms of fewest numbers first."""
    return sorted(forms_of_a_leg(), key=lambda name: leg_controller(name).n_weights)


def measure_atlas(
    folder: Path, records: Sequence[Record], retuning: Retuning, pool: Pool | None = None
) -> pd.DataFrame:
    """Measure the missing part of a study's atlas, and return it, one row per run.

    Forms are tried in the order of their numbers, on a run of every model, the best from the first
    half of the releases, as long as no shorter one keeps the largest share.

    Returns:
        The columns of `runs.run_rows`; `kind`; the numbers of `curves.curve_numbers`; `best`,
        whether the forms are tried on the run; and of those runs the share of the merit that each
        form keeps, `kept FORM`, and with the numbers of the curves `cloned FORM`; NaN where a
        shorter form kept enough.
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
        part = run_rows(cell.record.experiment, cell.record.best_fitness, result.arrays)
        part["best"] = part.index == part.merit_chosen.argmax()
        fits = curves.get(cell.record.model, {})
        numbers = {name: x for name, x in fits.items() if not name.startswith("start_")}
        parts.append(part.assign(**numbers))
    runs = concatenate_runs(parts).reset_index(drop=True)
    return _with_forms(
        runs.assign(kind=feedback_kinds(runs)), folder, with_feedback, curves, retuning, pool
    )


def _with_forms(
    runs: pd.DataFrame,
    folder: Path,
    records: Sequence[Record],
    curves: Mapping[str, Arrays],
    retuning: Retuning,
    pool: Pool | None,
) -> pd.DataFrame:
    of_model = {record.model: record for record in records}
    for form in forms_by_numbers():
        runs[f"kept {form}"] = np.nan
        remaining = where(runs, runs.best & ~runs.kind.isin([KINDS[0], NETWORK]))
        shares = remaining.filter(like="kept ").max(axis=1)
        remaining = where(remaining, ~(shares >= SHARES[-1]))
        groups = [group for _, group in remaining.groupby("omega_t")]
        cells = [
            FormOfControllers(
                form,
                float(group.omega_t.iloc[0]),
                [of_model[model] for model in group.model],
                group.run.tolist(),
                np.array(
                    [
                        curves[model][f"start_{form}"][run]
                        for model, run in zip(group.model, group.run, strict=True)
                    ]
                ),
                retuning,
            )
            for group in groups
        ]
        study = Study(folder / "forms", cells, title=f"{form}, by ω_t", suffix=".form.npz")
        study.run(pool)
        for group, result in zip(groups, study.results(), strict=True):
            for name, kind in (("merit", "kept"), ("cloned", "cloned")):
                runs.loc[group.index, f"{kind} {form}"] = result.arrays[name] / group.merit
    return runs


def shortest_form(runs: pd.DataFrame, share: float) -> pd.Series:
    """Return the form of fewest numbers that keeps a share of each best run's merit, or `NONE`."""
    best = where(runs, runs.best & ~runs.kind.isin([KINDS[0], NETWORK]))
    forms = np.array([*forms_by_numbers(), NONE])
    enough = best[[f"kept {form}" for form in forms[:-1]]].to_numpy() >= share
    first = np.where(enough.any(axis=1), enough.argmax(axis=1), len(forms) - 1)
    return pd.Series(forms[first], best.index)


def atlas_tables(runs: pd.DataFrame) -> str:
    """Return the atlas of a body in Markdown: kinds of feedback, learned curves, and shortest
    forms.
    """
    parts = []
    for omega, group in runs.groupby("omega_t"):
        parts.append(f"At $\\omega_t$ = {omega:g} rad/s, what the feedback does:")
        parts.append(markdown_table(_kinds_table(group)))
    parts.append(f"Where feedback makes the merit, learned curves with R² of at least {GOOD:g}:")
    parts.append(markdown_table(_curves_table(where(runs, runs.kind.isin(KINDS[4:7])))))
    for omega, group in runs.groupby("omega_t"):
        parts.append(f"Shortest forms at $\\omega_t$ = {omega:g} rad/s, controllers of each:")
        parts.append(markdown_table(_forms_table(group)))
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _kinds_table(runs: pd.DataFrame) -> list[list[str]]:
    """Return the runs of each kind by the inputs of their force, and the means of those that
    follow φ alone.
    """
    drives = DRIVES_OF_FORCE
    lines = [["feedback", *(f"runs on {x}" for x in drives), "merit", "cut", "frozen", "following"]]
    for kind in KINDS[:-1]:
        group = where(runs, runs.kind == kind)
        counts = [int((group.drive == drive).sum()) for drive in drives]
        of_phase = where(group, group.drive == drives[0])
        means = of_phase[["merit", "merit_cut", "merit_frozen", "following"]].mean()
        lines.append([kind, *map(str, counts), *(f"{x:.2f}" for x in means)])
    return lines


def _curves_table(runs: pd.DataFrame) -> list[list[str]]:
    """Return the shares of the runs that learn a term in which a formula is its curve, by ω_t.

    A reaction counts where no gain moves, which would be part of its curve.
    """
    omegas = sorted(runs.omega_t.unique())
    lines = [["learned term", "formula", *(f"{omega:g} rad/s" for omega in omegas)]]
    for term, formulas in _CURVES.items():
        learned = runs.architecture.str.contains(term)
        if term == "R":
            learned &= ~runs.architecture.str.contains("G")
        for name, formula in formulas.items():
            for state in ("", "untrained "):
                cells = [
                    runs[f"{state.replace(' ', '_')}{name}"][learned & (runs.omega_t == omega)]
                    for omega in omegas
                ]
                shares = [f"{(x >= GOOD).mean():.0%} of {len(x)}" for x in cells]
                lines.append([f"{state}{term}", formula, *shares])
    return lines


def _forms_table(runs: pd.DataFrame) -> list[list[str]]:
    """Count the controllers whose shortest form is each form, with the largest merit kept by it."""
    shortest_forms = {share: shortest_form(runs, share) for share in SHARES}
    lines = [["form", "numbers", *(f"keeps {share:.0%}" for share in SHARES), "best merit"]]
    for form in forms_by_numbers():
        counts = [str((names == form).sum()) for names in shortest_forms.values()]
        best = f"{(runs[f'kept {form}'] * runs.merit).max():.2f}"
        lines.append([form, str(leg_controller(form).n_weights), *counts, best])
    counts = [str((names == NONE).sum()) for names in shortest_forms.values()]
    return [*lines, [NONE, "", *counts, ""]]
