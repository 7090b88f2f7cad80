"""Effects of the experiments beside the study, from their tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from research.reproduction.claims.effects import OfGainMap, OfTrainings
from research.reproduction.claims.estimates import LEVEL, NOT_KNOWN, EffectEstimate
from research.reproduction.claims.experiments import (
    LOSSES,
    PARAMETERS,
    RESONANCES,
    RIDGES,
    read_losses,
    read_resonances,
    read_ridges,
    read_trainings,
)
from research.reproduction.ridge import line
from tegotae._support import tables
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.statistics import Interval, stratified_difference
from tegotae.training.curves import groups, late_mean, read_curves

_MAPS = {"resonance_shift": RESONANCES, "loss": LOSSES}
_RESAMPLES = 4000


def measure_kept(effect: OfTrainings | OfGainMap, folder: Path | None) -> EffectEstimate:
    """Measure an effect from the experiments' tables in a folder, or return `NOT_KNOWN` for a
    missing table.

    Args:
        effect: the claim's effect.
        folder: where the tables are.

    Raises:
        TegotaeError: if a table cannot be read.
    """
    if folder is None:
        return NOT_KNOWN
    if isinstance(effect, OfGainMap):
        path = folder / _MAPS.get(effect.measure, RIDGES)
    else:
        path = folder / effect.table
    if not path.exists():
        return NOT_KNOWN
    if isinstance(effect, OfGainMap):
        estimator = {"resonance_shift": _estimate_resonances, "loss": _estimate_losses}.get(
            effect.measure, _estimate_ridges
        )
        return estimator(effect, folder)
    if effect.metric == "nearer_resonance":
        return _estimate_gaits(effect, path)
    return (
        _estimate_curves(effect, path) if effect.metric == "cot_inverse" else _estimate_sizes(path)
    )


def _estimate_curves(effect: OfTrainings, path: Path) -> EffectEstimate:
    """Return CoT⁻¹ late in training, one algorithm minus another, averaged over the policies.

    Both have learned for the simulated time of the one that ends first.
    """
    curves = groups(read_curves([path]))
    algorithms = (effect.ours, effect.theirs)
    models = dict.fromkeys(model for model, _ in curves)
    pairs = []
    for model in models:
        if all((model, algorithm) in curves for algorithm in algorithms):
            sides = [curves[model, algorithm] for algorithm in algorithms]
            end_s = min(run["simulated_s"].to_numpy()[-1] for runs in sides for run in runs)
            pairs.append(tuple([late_mean(run, end_s) for run in runs] for runs in sides))
    size = float(np.mean([np.mean(theirs) for _, theirs in pairs])) if pairs else np.nan
    return _from_interval(stratified_difference(pairs), size)


def _estimate_gaits(effect: OfTrainings, path: Path) -> EffectEstimate:
    """Return a metric of an algorithm's trained gaits, averaged over the policies, each over its
    runs.
    """
    cells = tables.read_csv(path, ("algorithm", "model", effect.metric), kind="table of gaits")
    ours = cells["algorithm"] == effect.ours
    values = tables.parse_numbers(cells[effect.metric])
    pairs = [
        (values[ours & (cells["model"] == model)], [0.0])
        for model in dict.fromkeys(cells["model"].tolist())
    ]
    return _from_interval(stratified_difference(pairs, single_is_exact=True), np.nan)


def _estimate_sizes(path: Path) -> EffectEstimate:
    """Return the best fitness of more parameters than the paper could train, minus that of fewer.

    At equal settings, averaged over these. A rollout that failed counts as an untrained one.
    """
    trainings = read_trainings(path)
    pairs = []
    for method in dict.fromkeys(training.method for training in trainings):
        runs = [training for training in trainings if training.method == method]
        start = [t.untrained_fitness for t in runs if t.untrained_fitness > 0.5 * FAILED_FITNESS]
        if not start:
            continue
        floor = float(np.median(start))
        larger, smaller = (
            [max(t.fitness, floor) for t in runs if (t.parameters > PARAMETERS) == large]
            for large in (True, False)
        )
        pairs.append((larger, smaller))
    pairs = [pair for pair in pairs if all(pair)]
    size = float(np.mean([np.mean(smaller) for _, smaller in pairs])) if pairs else np.nan
    return _from_interval(stratified_difference(pairs), size)


def _from_interval(interval: Interval, size: float) -> EffectEstimate:
    return EffectEstimate(interval.mean, interval.low, interval.high, size)


def _estimate_ridges(effect: OfGainMap, folder: Path) -> EffectEstimate:
    """Return the slope of the ridge's line, or the share of its variance that the line explains."""
    ridges = read_ridges(folder)
    lines = {name: _line(*ridges[name]) for name in (effect.ours, effect.theirs) if name}
    if effect.measure == "slope":
        values, size = lines[effect.ours]["slope"], lines[effect.ours]["r_squared"][0]
    else:
        base = lines[effect.theirs]["r_squared"] if effect.theirs else np.zeros(1)
        values, size = lines[effect.ours]["r_squared"] - base, base[0]
    return _from_draws(values, size)


def _estimate_resonances(effect: OfGainMap, folder: Path) -> EffectEstimate:
    """Return the spread of the best frequency over the gains (standard deviation), minus that
    of another.
    """
    resonances = read_resonances(folder)
    ours, theirs = (
        _resample(resonances[name]).std(axis=1) for name in (effect.ours, effect.theirs)
    )
    return _from_draws(ours - theirs, theirs[0])


def _estimate_losses(effect: OfGainMap, folder: Path) -> EffectEstimate:
    """Return the mean loss over the frequencies, of both actuations alike."""
    losses = read_losses(folder)
    means = [_resample(loss).mean(axis=1) for loss in losses.values()]
    return _from_draws(np.mean(means, axis=0), np.nan)


def _resample(values: np.ndarray) -> np.ndarray:
    """Return values unchanged and resampled, [1 + resamples, values]; NaN for fewer than three."""
    n = len(values)
    if n < 3:
        return np.full((1 + _RESAMPLES, 1), np.nan)
    drawn = np.random.default_rng(0).integers(0, n, (_RESAMPLES, n))
    return values[np.concatenate([np.arange(n)[None], drawn])]


def _from_draws(values: np.ndarray, size: float) -> EffectEstimate:
    drawn = values[1:][np.isfinite(values[1:])]
    if not np.isfinite(values[0]) or len(drawn) == 0:
        return NOT_KNOWN
    low, high = np.percentile(drawn, LEVEL)
    return EffectEstimate(float(values[0]), float(low), float(high), float(size))


def _line(omega: np.ndarray, sigma: np.ndarray) -> dict[str, np.ndarray]:
    """Fit the line through a ridge, and through its resampled frequencies, [1 + resamples] each."""
    defined = np.isfinite(sigma)
    omega, sigma = omega[defined], sigma[defined]
    n = len(omega)
    if n < 3:
        undefined = np.full(1 + _RESAMPLES, np.nan)
        return {"slope": undefined, "r_squared": undefined}
    drawn = np.random.default_rng(0).integers(0, n, (_RESAMPLES, n))
    drawn = np.concatenate([np.arange(n)[None], drawn])
    slope, _, r_squared = line(omega[drawn], sigma[drawn])
    return {"slope": slope, "r_squared": r_squared}
