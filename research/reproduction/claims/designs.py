"""The places of a study's models in its design, and correlations over the models."""

from __future__ import annotations

import numpy as np

from research.reproduction.table import StudyTable
from tegotae.measures.statistics import Interval, mean_defined

MODELS = 10
"""A correlation needs so many models: among fewer one of 0.6 and more is often mere chance, and of
three models nearly any two metrics go together."""

DRIVES = {"sector": "φ", "tphi": "φ", "reflex": "f", "tf": "f", "both": "φf", "tphif": "φf"}
"""Input of an actuation, vanilla or learned."""


def designs(table: StudyTable) -> dict[tuple, StudyTable]:
    """Return a table's rows by ω_t and by the inputs of the actuation.

    A single network has neither; all of its rows are one design.
    """
    omegas = np.nan_to_num(table["omega_t"])
    drives = np.array([DRIVES.get(name, "") for name in table["actuation"]])
    columns = [column.tolist() for column in (omegas, drives)]
    keys = list(zip(*columns, strict=True))
    rows = {key: [candidate == key for candidate in keys] for key in sorted(set(keys))}
    return {
        key: StudyTable({name: column[mask] for name, column in table.columns.items()})
        for key, mask in rows.items()
    }


def within_omega(values: np.ndarray, omega_t: np.ndarray) -> np.ndarray:
    """Return values [..., models] minus the mean of their models of the same ω_t; NaN where
    undefined.

    Two metrics that differ with ω_t alone go together over all models and within no ω_t.
    """
    centred = np.array(values, float)
    for omega in np.unique(np.nan_to_num(omega_t)):
        mask = np.nan_to_num(omega_t) == omega
        centred[..., mask] -= mean_defined(centred[..., mask])[..., None]
    return centred


def correlation_within_omega(
    table: StudyTable, a: str, b: str, *, seed: int = 0, resamples: int = 4000
) -> Interval:
    """Return the Pearson correlation within ω_t of two columns over the rows that define both.

    The interval is a percentile bootstrap over rows. All is NaN for fewer than `MODELS` of them.
    """
    x, y = table[a], table[b]
    defined = np.isfinite(x) & np.isfinite(y)
    omega_t, undefined = table["omega_t"][defined], int((~defined).sum())
    x, y = (within_omega(column[defined], omega_t) for column in (x, y))
    if len(x) < MODELS or x.std() == 0.0 or y.std() == 0.0:
        return Interval(np.nan, np.nan, np.nan, np.nan, len(x), undefined)
    drawn = np.random.default_rng(seed).integers(0, len(x), (resamples, len(x)))
    xs, ys = x[drawn], y[drawn]
    xs, ys = xs - xs.mean(axis=1, keepdims=True), ys - ys.mean(axis=1, keepdims=True)
    scale = np.sqrt((xs**2).sum(axis=1) * (ys**2).sum(axis=1))
    values = (xs * ys).sum(axis=1)[scale > 0.0] / scale[scale > 0.0]
    low, high = np.quantile(values, [0.025, 0.975])
    r = float(np.corrcoef(x, y)[0, 1])
    return Interval(r, float(values.std(ddof=1)), float(low), float(high), len(x), undefined)
