"""Claims 2 to 9, decided by the study's table."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from tegotae.measures.hopping.statistics import (
    Interval,
    balanced_difference,
    has_mean,
    interval,
    stratified_difference,
)
from tegotae.studies.paper.claims.verdict import Part, Verdict
from tegotae.studies.paper.table import Table

NEAR = 0.2
"""Two efficiencies are near each other, or on par, within this share of the second."""

FAR = 0.5
"""An efficiency is far above another if it is greater by more than this share of it."""

FAILING = 0.1
"""An architecture fails if so few of its episodes, or fewer, reach a limit cycle."""

MODELS = 10
"""A correlation needs so many models: among fewer one of 0.6 and more is often mere chance, and of
three models nearly any two metrics go together."""

DRIVES = {"sector": "φ", "tphi": "φ", "reflex": "f", "tf": "f", "both": "φf", "tphif": "φf"}
"""What an actuation follows, vanilla or learned."""


def designs(table: Table, more: tuple[str, ...] = ()) -> dict[tuple, Table]:
    """A table's rows by ω_t, by what the actuation follows, and by more columns.

    A single network has neither; all of its rows are one design.
    """
    omegas = np.nan_to_num(table["omega_t"])
    drives = np.array([DRIVES.get(name, "") for name in table["actuation"]])
    columns = [column.tolist() for column in (omegas, drives, *(table[name] for name in more))]
    keys = list(zip(*columns, strict=True))
    rows = {key: [other == key for other in keys] for key in sorted(set(keys))}
    return {
        key: Table({name: column[at] for name, column in table.columns.items()})
        for key, at in rows.items()
    }


def _minus(
    what: str,
    metric: str,
    ours: Table,
    theirs: Table,
    *,
    low: float = -np.inf,
    high: float = np.inf,
    factor: float = 1.0,
    alike: tuple[str, ...] = (),
) -> Part:
    """The difference of two sets of runs of the same ω_t and the same input of the actuation.

    Then its mean over these. At ω_t = 4 rad/s gaits are twice as efficient as at 8, and settle
    half as often: a difference of overall means would show how many settled at which. A single run
    of a model whose gain is found by search, as in older tables, is exact.
    """
    a, b = designs(ours, alike), designs(theirs, alike)
    pairs = [(a[key][metric], b[key][metric]) for key in a if key in b]
    effect = stratified_difference(pairs, factor=factor, single_is_exact=True)
    used = sum(all(has_mean(row, single_is_exact=True) for row in pair) for pair in pairs)
    if used < len(pairs):
        what += f" ({used} of {len(pairs)} designs)"
    if not pairs:
        return Part(what, interval([]), low, high)
    effect = _counted(effect, metric, ours, theirs)
    return Part(what, effect, low, high, without_cycle=_without_cycle(ours, theirs))


def _counted(effect: Interval, metric: str, *tables: Table) -> Interval:
    """The effect with all runs counted, those of designs that it leaves out, too."""
    values = np.concatenate([table[metric] for table in tables])
    count = int(np.isfinite(values).sum())
    return dataclasses.replace(effect, count=count, undefined=len(values) - count)


def _shares(ours: Table, theirs: Table, names: str, *, alike: tuple[str, ...] = ()) -> list[Part]:
    """For information: how many episodes settle, and recover; the others have no T0 or T1."""
    return [
        _minus(
            f"share with a limit cycle, {names}", "limit_cycle_share", ours, theirs, alike=alike
        ),
        _minus(f"share that recovers, {names}", "recovery_share", ours, theirs, alike=alike),
    ]


def _without_cycle(*tables: Table) -> int:
    return sum(int((table["limit_cycle_share"] == 0.0).sum()) for table in tables)


def claim_2(table: Table) -> Verdict:
    """VG raises CoT⁻¹ far above V, and lengthens T0 and T1."""
    v, vg = table.where(architecture="V"), table.where(architecture="VG", observation="F")
    far = f"CoT⁻¹, VG - {1.0 + FAR:g} V [m/J]"
    return Verdict(
        2,
        "An active gain (VG) raises CoT⁻¹ far above V and lengthens T0 and T1",
        (
            _minus(far, "cot_inverse", vg, v, low=0.0, factor=1.0 + FAR),
            _minus("T0, VG - V [s]", "t0_s", vg, v, low=0.0),
            _minus("T1, VG - V [s]", "t1_s", vg, v, low=0.0),
            *_shares(vg, v, "VG - V"),
        ),
    )


def claim_3(table: Table) -> Verdict:
    """VT stays near V but is smoother."""
    v, vt = table.where(architecture="V"), table.where(architecture="VT")
    above, below = f"CoT⁻¹, VT - {1.0 - NEAR:g} V [m/J]", f"CoT⁻¹, VT - {1.0 + NEAR:g} V [m/J]"
    return Verdict(
        3,
        "A learned actuation (VT) stays near V but is smoother",
        (
            _minus(above, "cot_inverse", vt, v, low=0.0, factor=1.0 - NEAR),
            _minus(below, "cot_inverse", vt, v, high=0.0, factor=1.0 + NEAR),
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
            *_shares(ar, vg, "AR - VG"),
        ),
    )


def claim_5(table: Table) -> Verdict:
    """ART raises efficiency further."""
    only_f = table.where(observation="F")
    ar, art = only_f.where(architecture="AR"), only_f.where(architecture="ART")
    part = _minus("CoT⁻¹, ART - AR [m/J]", "cot_inverse", art, ar, low=0.0)
    return Verdict(
        5,
        "A learned actuation on top (ART) raises efficiency further",
        (part, *_shares(art, ar, "ART - AR")),
    )


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
    """The single network fails on [F_k], is on par on [F_k, ẏ], with long transients.

    It has no ω_t: ART's mean over its designs is what it is compared with.
    """
    single = table.where(architecture="T")
    blind, seeing = single.where(observation="F"), single.where(observation="Fv")
    art = table.where(architecture="ART", observation="Fv")

    def above(
        what: str, metric: str, factor: float = 1.0, low: float = -np.inf, high: float = np.inf
    ) -> Part:
        rows = [design[metric] for design in designs(art).values()]
        effect = balanced_difference([seeing[metric]], rows, factor=factor)
        if not (len(seeing) and rows):
            return Part(what, interval([]), low, high)
        effect = _counted(effect, metric, seeing, art)
        return Part(what, effect, low, high, without_cycle=_without_cycle(seeing, art))

    return Verdict(
        7,
        "The single network fails on [F_k]; on [F_k, ẏ] it equals ART, with long transients",
        (
            Part(
                "share with a limit cycle, T on [F_k]",
                interval(blind["limit_cycle_share"]),
                high=FAILING,
                without_cycle=_without_cycle(blind),
            ),
            above(f"CoT⁻¹, T - {1 - NEAR:g} ART [m/J]", "cot_inverse", 1.0 - NEAR, low=0.0),
            above(f"CoT⁻¹, T - {1 + NEAR:g} ART [m/J]", "cot_inverse", 1.0 + NEAR, high=0.0),
            above("T0, T - ART [s]", "t0_s", low=0.0),
        ),
        "the last three on [F_k, ẏ]",
    )


def claim_8(table: Table) -> Verdict:
    """ẏ lowers CPGu, raises efficiency, and costs stability."""
    with_r = table.where(architecture=("AR", "ART", "ARG", "ARGT"))
    f, fv = with_r.where(observation="F"), with_r.where(observation="Fv")
    alike = ("architecture",)

    def more(what: str, metric: str, *of: Table, **bounds: float) -> Part:
        ours, theirs = of or (fv, f)
        what = what.format("[F_k, ẏ] - [F_k]")
        return _minus(what, metric, ours, theirs, alike=alike, **bounds)

    return Verdict(
        8,
        "Sensing ẏ lowers CPGu, raises efficiency, and costs stability",
        (
            # A run without a gait of its own has none with a clamped phase either.
            more("CPGu of runs with a limit cycle, {}", "cpgu", _cyclic(fv), _cyclic(f), high=0.0),
            more("CoT⁻¹, {} [m/J]", "cot_inverse", low=0.0),
            more("T1, {} [s]", "t1_s", low=0.0),
            *_shares(fv, f, "[F_k, ẏ] - [F_k]", alike=alike),
        ),
    )


def _cyclic(table: Table) -> Table:
    settled = table["limit_cycle_share"] > 0.0
    return Table({name: column[settled] for name, column in table.columns.items()})


def claim_9(table: Table) -> Verdict:
    """Over all models efficiency goes with slow convergence, and CPGu with fast."""
    models = table.per_model()
    without = _without_cycle(models)

    def together(
        what: str, a: str, b: str, low: float = -np.inf, high: float = np.inf
    ) -> list[Part]:
        overall = correlation(models, a, b)
        within = correlation(_centred(models, a, b), a, b)
        return [
            Part(what, overall, low, high, "models", without, MODELS),
            Part(f"{what}, at equal ω_t", within, unit="models", without_cycle=without),
        ]

    return Verdict(
        9,
        "Over all models, efficiency goes with slow convergence, and CPGu with fast",
        (
            *together("correlation of CoT⁻¹ and T0", "cot_inverse", "t0_s", low=0.0),
            *together("correlation of CoT⁻¹ and T1", "cot_inverse", "t1_s", low=0.0),
            *together("correlation of CPGu and T1", "cpgu", "t1_s", high=0.0),
        ),
        f"one value per model, of at least {MODELS} models",
    )


def _centred(models: Table, *names: str) -> Table:
    """Columns over the models that define all of them, less their mean at each ω_t."""
    defined = np.all([np.isfinite(models[name]) for name in names], axis=0)
    columns = dict(models.columns)
    for name in names:
        column = np.where(defined, models[name], np.nan)
        for omega in np.unique(models["omega_t"]):
            at = defined & (models["omega_t"] == omega)
            if at.any():
                column[at] -= column[at].mean()
        column[~np.isfinite(models["omega_t"])] = np.nan
        columns[name] = column
    return Table(columns)


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
    """What the results of the paper's models say about each claim.

    One without data is not measured. Experiments beside the models decide nothing.
    """
    table = table.of_the_paper()
    return [claim(table) for claim in CLAIMS]


def correlation(table: Table, a: str, b: str, *, seed: int = 0, resamples: int = 4000) -> Interval:
    """Pearson correlation of two columns over the rows that define both, with its interval.

    The interval is a percentile bootstrap over rows. All is NaN for fewer than `MODELS` of them.
    """
    x, y = table[a], table[b]
    both = np.isfinite(x) & np.isfinite(y)
    x, y, undefined = x[both], y[both], int((~both).sum())
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
