"""Claims 2 to 9, decided by the study's table."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import numpy as np

from tegotae.metrics.statistics import Interval, interval, mean_defined, stratified_difference
from tegotae.study.claims.verdict import Part, Verdict
from tegotae.study.table import Table

NEAR = 0.2
"""Two efficiencies are near each other, or on par, within this share of the second."""

FAR = 0.5
"""An efficiency is far above another if it is greater by more than this share of it."""


def _minus(
    what: str,
    metric: str,
    ours: Table,
    theirs: Table,
    *,
    low: float = -np.inf,
    high: float = np.inf,
    within: tuple[str, ...] = ("omega_t",),
) -> Part:
    """The difference of two sets of runs, within each value of some columns, and then their mean.

    At ω_t = 4 rad/s gaits are twice as efficient as at 8, and settle half as often: a difference of
    overall means would tell how many settled at which.
    """
    without = _without_cycle(ours) + _without_cycle(theirs)
    strata = list(_strata(ours, theirs, within))
    effect = stratified_difference([(a[metric], b[metric]) for a, b in strata])
    return Part(what, effect, low, high, without_cycle=without)


def _strata(ours: Table, theirs: Table, columns: tuple[str, ...]) -> Iterator[tuple[Table, Table]]:
    """Rows with the same values of some columns; all of them if the two share none."""
    places = [np.unique([*ours[column], *theirs[column]]) for column in columns]
    found = False
    for place in itertools.product(*places):
        at = dict(zip(columns, place, strict=True))
        pair = ours.where(**at), theirs.where(**at)
        if len(pair[0]) and len(pair[1]):
            found = True
            yield pair
    if not found:
        yield ours, theirs


def _without_cycle(table: Table) -> int:
    return int((table["limit_cycle_share"] == 0.0).sum())


def _level(table: Table, metric: str) -> float:
    """Mean over the frequencies of the mean at each."""
    frequencies = np.unique(table["omega_t"])
    means = [mean_defined(table.where(omega_t=omega)[metric]) for omega in frequencies]
    return float(mean_defined(np.array(means))) if means else np.nan


def claim_2(table: Table) -> Verdict:
    """VG raises CoT⁻¹ far above V, and lengthens T0 and T1."""
    v, vg = table.where(architecture="V"), table.where(architecture="VG", observation="F")
    return Verdict(
        2,
        "An active gain (VG) raises CoT⁻¹ far above V and lengthens T0 and T1",
        (
            _minus("CoT⁻¹, VG - V [m/J]", "cot_inverse", vg, v, low=FAR * _level(v, "cot_inverse")),
            _minus("T0, VG - V [s]", "t0_s", vg, v, low=0.0),
            _minus("T1, VG - V [s]", "t1_s", vg, v, low=0.0),
        ),
    )


def claim_3(table: Table) -> Verdict:
    """VT stays near V but is smoother."""
    v, vt = table.where(architecture="V"), table.where(architecture="VT")
    near = NEAR * _level(v, "cot_inverse")
    return Verdict(
        3,
        "A learned actuation (VT) stays near V but is smoother",
        (
            _minus("CoT⁻¹, VT - V [m/J]", "cot_inverse", vt, v, low=-near, high=near),
            _minus("dF/dt, VT - V [1/s]", "smoothness", vt, v, high=0.0),
        ),
    )


def claim_4(table: Table) -> Verdict:
    """AR raises efficiency, with much shorter transients than VG, at a frequency tied to ω."""
    only_f = table.where(observation="F")
    v, vg, ar = (only_f.where(architecture=name) for name in ("V", "VG", "AR"))
    return Verdict(
        4,
        "Learned A and R (AR) raise efficiency, with shorter transients than VG, tied to ω",
        (
            _minus("CoT⁻¹, AR - V [m/J]", "cot_inverse", ar, v, low=0.0),
            _minus("T0, AR - VG [s]", "t0_s", ar, vg, high=0.0),
            _minus("T1, AR - VG [s]", "t1_s", ar, vg, high=0.0),
            _minus("Δw, AR - VG [rad/s]", "delta_w", ar, vg, high=0.0),
        ),
    )


def claim_5(table: Table) -> Verdict:
    """ART raises efficiency further."""
    only_f = table.where(observation="F")
    ar, art = only_f.where(architecture="AR"), only_f.where(architecture="ART")
    part = _minus("CoT⁻¹, ART - AR [m/J]", "cot_inverse", art, ar, low=0.0)
    return Verdict(5, "A learned actuation on top (ART) raises efficiency further", (part,))


def claim_6(table: Table) -> Verdict:
    """ARG falls below baseline; ARGT below ART."""
    only_f = table.where(observation="F")
    v, arg, art, argt = (only_f.where(architecture=n) for n in ("V", "ARG", "ART", "ARGT"))
    return Verdict(
        6,
        "An active gain on learned terms costs efficiency: ARG below V, ARGT below ART",
        (
            _minus("CoT⁻¹, ARG - V [m/J]", "cot_inverse", arg, v, high=0.0),
            _minus("CoT⁻¹, ARGT - ART [m/J]", "cot_inverse", argt, art, high=0.0),
        ),
    )


def claim_7(table: Table) -> Verdict:
    """The single network fails on [F_k], is on par on [F_k, ẏ], with long transients."""
    single = table.where(architecture="T")
    blind, seeing = single.where(observation="F"), single.where(observation="Fv")
    art = table.where(architecture="ART", observation="Fv")
    par = NEAR * _level(art, "cot_inverse")
    return Verdict(
        7,
        "The single network fails on [F_k]; on [F_k, ẏ] it equals ART, with long transients",
        (
            Part(
                "share of limit cycles, T on [F_k]",
                interval(blind["limit_cycle_share"]),
                high=0.1,
                without_cycle=_without_cycle(blind),
            ),
            _minus(
                "CoT⁻¹, T - ART, [F_k, ẏ] [m/J]", "cot_inverse", seeing, art, low=-par, high=par
            ),
            _minus("T0, T - ART, [F_k, ẏ] [s]", "t0_s", seeing, art, low=0.0),
        ),
    )


def claim_8(table: Table) -> Verdict:
    """ẏ lowers CPGu, raises efficiency, and costs stability."""
    with_r = table.where(architecture=("AR", "ART", "ARG", "ARGT"))
    f, fv = with_r.where(observation="F"), with_r.where(observation="Fv")
    alike = ("architecture", "omega_t")
    return Verdict(
        8,
        "Sensing ẏ lowers CPGu, raises efficiency, and costs stability",
        (
            _minus("CPGu, [F_k, ẏ] - [F_k]", "cpgu", fv, f, high=0.0, within=alike),
            _minus("CoT⁻¹, [F_k, ẏ] - [F_k] [m/J]", "cot_inverse", fv, f, low=0.0, within=alike),
            _minus("T1, [F_k, ẏ] - [F_k] [s]", "t1_s", fv, f, low=0.0, within=alike),
        ),
    )


def claim_9(table: Table) -> Verdict:
    """Over all models efficiency goes with slow convergence, and CPGu with fast."""
    models = table.per_model()

    def together(what: str, a: str, b: str, low: float = -np.inf, high: float = np.inf) -> Part:
        effect, without = correlation(models, a, b), _without_cycle(models)
        return Part(what, effect, low, high, "models", without)

    return Verdict(
        9,
        "Over all models, efficiency goes with slow convergence, and CPGu with fast",
        (
            together("correlation of CoT⁻¹ and T0", "cot_inverse", "t0_s", low=0.0),
            together("correlation of CoT⁻¹ and T1", "cot_inverse", "t1_s", low=0.0),
            together("correlation of CPGu and T1", "cpgu", "t1_s", high=0.0),
        ),
        "one value per model",
    )


CLAIMS: tuple[Callable[[Table], Verdict], ...] = (
    claim_2,
    claim_3,
    claim_4,
    claim_5,
    claim_6,
    claim_7,
    claim_8,
    claim_9,
)
"""The claims that the study's table decides."""


def verdicts(table: Table) -> list[Verdict]:
    """What the results say about each claim; one without data is undecided."""
    return [claim(table) for claim in CLAIMS]


def correlation(table: Table, a: str, b: str, *, seed: int = 0, resamples: int = 4000) -> Interval:
    """Pearson correlation of two columns over the rows that define both, with its interval.

    The interval is a percentile bootstrap over rows; NaN for fewer than three of them.
    """
    x, y = table[a], table[b]
    both = np.isfinite(x) & np.isfinite(y)
    x, y, undefined = x[both], y[both], int((~both).sum())
    if len(x) < 3 or x.std() == 0.0 or y.std() == 0.0:
        return Interval(np.nan, np.nan, np.nan, np.nan, len(x), undefined)
    drawn = np.random.default_rng(seed).integers(0, len(x), (resamples, len(x)))
    xs, ys = x[drawn], y[drawn]
    xs, ys = xs - xs.mean(axis=1, keepdims=True), ys - ys.mean(axis=1, keepdims=True)
    scale = np.sqrt((xs**2).sum(axis=1) * (ys**2).sum(axis=1))
    values = (xs * ys).sum(axis=1)[scale > 0.0] / scale[scale > 0.0]
    low, high = np.quantile(values, [0.025, 0.975])
    r = float(np.corrcoef(x, y)[0, 1])
    return Interval(r, float(values.std(ddof=1)), float(low), float(high), len(x), undefined)
