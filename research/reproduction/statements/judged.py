"""The further statements, judged in every way to count their tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from research.reproduction.claims.counting import ALL, DROPPED, FIGURE_2, Count, counts
from research.reproduction.claims.designs import DRIVES
from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.claims.estimates import (
    LEVEL,
    NOT_KNOWN,
    EffectEstimate,
    estimate_effect,
)
from research.reproduction.claims.findings import EVERYWHERE, Finding
from research.reproduction.claims.resampling import RESAMPLES, Resampled
from research.reproduction.statements.further import (
    AFTER,
    BEFORE,
    CUT,
    FURTHER,
    HELD,
    PUSHES,
    STUDY,
    WITHOUT_OMEGA,
    Balance,
    JointReach,
    OfHorizon,
    Statement,
)
from research.reproduction.table import StudyTable
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.statistics import difference, mean_defined
from tegotae.training.curves import groups, late_mean, read_curves

FILES = {PUSHES: "pushes.csv", CUT: "pushes.csv", WITHOUT_OMEGA: "cot-only.csv", HELD: "held.csv"}
"""Tables beside the study's by their names."""
_SHUFFLES = 400


def judge(
    study: pd.DataFrame,
    folder: Path,
    experiments: Path,
    statements: Iterable[Statement] = FURTHER,
    resamples: int = RESAMPLES,
) -> list[Finding]:
    """Return the finding of every statement.

    Args:
        study: the study's runs, as `export` writes them.
        folder: where the tables of `FILES` are.
        experiments: where `figure3.csv` and `second_look.csv` are.
        statements: which statements.
        resamples: how often the runs are drawn anew.
    """
    results, resampled = [], {}
    for statement in statements:
        if isinstance(statement.number, OfHorizon):
            by_count = {EVERYWHERE: _of_horizon(statement.number.model, experiments)}
        else:
            key = statement.source, statement.drive
            if key not in resampled:
                table = _table(study, folder, *key)
                resampled[key] = Resampled(StudyTable(_columns(table)), resamples)
            by_count = _by_count(statement, resampled[key])
        results.append(Finding(statement, by_count))
    return results


def _columns(table: pd.DataFrame) -> dict[str, np.ndarray]:
    words = {name: table[name].fillna("").to_numpy(str) for name in _WORDS}
    numbers = {str(name): x.to_numpy(float) for name, x in table.select_dtypes("number").items()}
    return numbers | words


_WORDS = ("model", "architecture", "observation", "actuation")


def _table(study: pd.DataFrame, folder: Path, source: str, drive: str) -> pd.DataFrame:
    """Return the rows that a statement is about; those of changed models as `AFTER`."""
    if source == STUDY:
        return study
    beside = pd.read_csv(folder / FILES[source])
    if drive:
        beside = pd.DataFrame(beside[beside.actuation.map(DRIVES) == drive])
    if source == PUSHES:
        return pd.DataFrame(beside)
    if source == HELD:
        return pd.concat([study.query("architecture == 'V'"), beside], ignore_index=True)
    if source == CUT:
        unchanged, changed = beside, beside.assign(settled=beside.settled_cut)
    else:
        unchanged, changed = study[study.model.isin(beside.model)], beside
    return pd.concat(
        [
            part.assign(model=part.model + "/" + name, architecture=name)
            for part, name in ((unchanged, BEFORE), (changed, AFTER))
        ],
        ignore_index=True,
    )


def _by_count(statement: Statement, runs: Resampled) -> dict[Count, EffectEstimate]:
    number = statement.number
    options = counts(runs.table)
    if isinstance(number, Balance | JointReach):
        average = FIGURE_2 if isinstance(number, Balance) else Count().average
        options = [option for option in options if option.average == average]
    elif statement.source != HELD and statement.source != STUDY:
        # Without a number for the worst there is one way to count what does not settle.
        options = [option for option in options if option.unsettled == DROPPED]
    estimators: dict[type, Callable[..., EffectEstimate]] = {
        Balance: balance,
        JointReach: joint_reach,
    }
    estimate = estimators.get(type(number), estimate_effect)
    return {option: estimate(number, runs, option) for option in options}


def _of_draws(values: np.ndarray, size: float) -> EffectEstimate:
    drawn = values[1:][np.isfinite(values[1:])]
    if not np.isfinite(values[0]) or not len(drawn):
        return NOT_KNOWN
    low, high = np.percentile(drawn, LEVEL)
    return EffectEstimate(float(values[0]), float(low), float(high), size)


def _mask(runs: Resampled, count: Count) -> np.ndarray:
    """Return the mask of the models that count, [models]."""
    omega = runs.models.omega_t
    return np.isfinite(omega) if count.omega_t == ALL else omega == float(count.omega_t)


def balance(number: Balance, runs: Resampled, count: Count) -> EffectEstimate:
    """Return the loss by ẏ minus the gain, and the gain as its size."""
    models, mask = runs.models, _mask(runs, count)

    def change(metric: str) -> np.ndarray:
        values = runs.values(metric, count)
        levels = [
            mean_defined(
                values[:, mask & (models.architecture == name) & (models.observation == s)]
            )
            for s in ("Fv", "F")
            for name in LEARNED_FEEDBACK
        ]
        with_rate, without = np.split(np.stack(levels), 2)
        extent = np.nanmax(values[0]) - np.nanmin(values[0])
        return (with_rate.mean(axis=0) - without.mean(axis=0)) / extent

    loss, gain = change(number.loss), change(number.gain)
    return _of_draws(loss - gain, float(gain[0]))


def joint_reach(number: JointReach, runs: Resampled, count: Count) -> EffectEstimate:
    """Return the reach of the best model minus that of shuffled ones, which is its size."""
    mask = _mask(runs, count)
    groups_of = [
        mask & (runs.models.omega_t == omega) for omega in np.unique(runs.models.omega_t[mask])
    ]
    ranks = []
    for metric in number.metrics:
        sign = 1.0 if HOPPING.find(metric).more_is_better else -1.0
        values = np.where(
            np.isnan(x := runs.values(metric, count)), -np.inf, sign * np.nan_to_num(x)
        )
        ranks.append([_ranks(values[:, group]) for group in groups_of])
    reach = _reach(ranks)
    draw = np.random.default_rng(0)
    shuffled = [
        _reach([[draw.permuted(group[:1], axis=1) for group in metric] for metric in ranks])[0]
        for _ in range(_SHUFFLES)
    ]
    by_chance = float(np.mean(shuffled))
    return _of_draws(reach - by_chance, by_chance)


def _ranks(values: np.ndarray) -> np.ndarray:
    """Return the share of models that each surpasses, [draws, models], 0 for the worst."""
    ordered = np.sort(values, axis=1)
    below = np.stack([np.searchsorted(row, x) for row, x in zip(ordered, values, strict=True)])
    return below / (values.shape[1] - 1)


def _reach(ranks: list[list[np.ndarray]]) -> np.ndarray:
    """Return the largest over models of the least over metrics, mean over ω_t, [draws]."""
    best = [np.min(group, axis=0).max(axis=1) for group in zip(*ranks, strict=True)]
    return np.mean(best, axis=0)


def _of_horizon(model: str, experiments: Path) -> EffectEstimate:
    """Return CoT⁻¹ late in training of PPO with the longer horizon minus PPO as in Fig. 3."""
    runs = {
        name: [late_mean(run) for run in groups(read_curves([experiments / file]))[model, name]]
        for name, file in (("ppo, suited", "second_look.csv"), ("ppo", "figure3.csv"))
    }
    longer, shorter = runs.values()
    estimate = difference(longer, shorter)
    return EffectEstimate(estimate.mean, estimate.low, estimate.high, float(np.mean(shorter)))
