"""Numbers in the prose of pages, held to their tables.

A comment after a number has the expression that it follows from:

    gains +0.19 [0.17, 0.21]<!-- = effect("study", "learned-beats-v") --> m/J
    91 %<!-- = learned(8) --> of the runs
    between 1.2 and 2 times<!-- = [1.2, 2.0] --> the mass

A value is a number, or three for a mean and its interval, or a list for the last numbers before the
comment. It is shown with the decimals that the page shows, as a share where a % follows (the last
of a list: all are shares). The build of the pages fails where the two differ.

    python docs/prose_numbers.py          # what is stale, page by page
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "docs" / "_static"

MARK = re.compile(r"<!-- = (.+?) -->", re.S)
_ONE = r"[+−-]?\d(?:[\d \u202f]*\d)?(?:\.\d+)?"
LISTED = re.compile(rf"(?<![\w.])({_ONE})(\s*%)?")
NUMBER = re.compile(rf"({_ONE})(?:\s*%)?(?: \[({_ONE})(?: %)?, ({_ONE})(?:\s*%)?\])?(\s*%)?\Z")


def kept_file(name: str) -> Path:
    """A kept file, by its path in research, in that of the reproduction, or in docs/_static."""
    folders = (ROOT / "research", ROOT / "research" / "reproduction" / "kept", KEPT)
    return next((path for at in folders if (path := at / name).exists()), KEPT / name)


@cache
def table(name: str) -> pd.DataFrame:
    """A kept table, by its path in research or docs/_static without `.csv`."""
    return pd.read_csv(kept_file(f"{name}.csv"), comment="#")


def rows(name: str, **values: object) -> pd.DataFrame:
    """The rows of a kept table whose columns have these values (of a list: any of them)."""
    kept = table(name)
    for column, value in values.items():
        kept = kept[kept[column].isin(value if isinstance(value, list) else [value])]
    return kept


def interval(values: pd.Series) -> tuple[float, float, float]:
    """Mean of runs with its 95 % interval."""
    from tegotae.measures import statistics

    found = statistics.interval(values.to_numpy())
    return found.mean, found.low, found.high


def load_gain(cell: str, first: str = "load", second: str = "clock") -> tuple[float, ...]:
    """The merit of one law less that of another in a cell of the map of load, and its interval."""
    pair = {"first": first, "second": second, "generations": 40}
    (row,) = rows("load_map/gains", cell=cell, **pair).itertuples()
    return row.mean, row.low, row.high


def load_map(law: str, cell: str, column: str = "merit", generations: int = 40) -> float:
    """The mean of a column over the searches of a law in a cell of the map of load."""
    return rows("load_map/rows", cell=cell, law=law, generations=generations)[column].mean()


def load_verdicts(out_of_step: bool, verdict: str, held_out: bool = False, budget: int = 40) -> int:
    """How many walkers' and plates' cells of the map of load have this verdict on load − clock."""
    from research.load_map.cells import CELLS

    cells = {c.name: c for c in CELLS if c.mechanics.limbs > 1}
    kept = rows("load_map/gains", first="load", second="clock", generations=budget, verdict=verdict)
    found = [cells[name] for name in kept.cell if name in cells]
    return sum((c.loses_phase, c.held_out) == (out_of_step, held_out) for c in found)


def cells(page: str, column: str, *row: str, part: int = 0) -> list[float]:
    """One number of a column's cells in a table that a page includes, by its path without `.md`.

    The rows are those that have all texts of `row` among their cells; `part` counts the numbers of
    a cell. A column is named by the start of its head.
    """
    found, index, head = [], 0, ""
    for line in kept_file(f"{page}.md").read_text(encoding="utf-8").splitlines():
        entries = [entry.strip(" `*") for entry in line.strip("| ").split("|")]
        if not line.startswith("|"):
            head = ""
        elif not head:
            head = line
            index = next((i for i, x in enumerate(entries) if x.startswith(column)), -1)
        elif index >= 0 and set(row) <= set(entries) and not set(line) <= set("|-: "):
            numbers = re.findall(r"-?\d+(?:\.\d+)?", entries[index].replace("−", "-"))
            found.append(float(numbers[part]))
    if not found:
        raise LookupError(f"{page}.md has no {column} in a row of {row}")
    return found


def cell(page: str, column: str, *row: str, part: int = 0) -> float:
    """The number of `cells` in the one row that has these texts."""
    (number,) = cells(page, column, *row, part=part)
    return number


def effect(study: str, claim: str, omega_t: str = "both", **counted: str) -> tuple[float, ...]:
    """A claim's effect and its 95 % interval, counted as the study counts unless said."""
    row = rows(f"{study}/effects", claim=claim, omega_t=omega_t, **counted).iloc[0]
    return row.effect, row.low, row.high


def with_sign(study: str, *intervals: str) -> int:
    """How many effects over designs have intervals without 0, counted as the study counts.

    `intervals` are "" for that over runs, and "designs_".
    """
    kept = table(f"{study}/effects").drop_duplicates("claim").dropna(subset="designs_low")
    signs = [kept[f"{name}low"] * kept[f"{name}high"] > 0.0 for name in intervals]
    return int(np.all(signs, axis=0).sum())


def decided(study: str, by: str) -> int:
    """How many claims have a verdict at seven frequencies: "By runs" or "By designs"."""
    text = kept_file("learning/claims/claims-by-design.md").read_text(encoding="utf-8")
    head, _, *lines = ([x.strip() for x in line.split("|")] for line in text.splitlines())
    words = [line[head.index(by)] for line in lines if line[head.index("Study")] == study]
    return sum(word != "too small to tell" for word in words)


def outcomes(word: str) -> int:
    """How many claims have an outcome that begins with these words, over all ways to count."""
    text = kept_file("study/claims.md").read_text(encoding="utf-8")
    return sum(found.startswith(word) for found in re.findall(r"\| \*\*([^*|]+)\*\* \|", text))


def learned_runs(omega_t: float) -> pd.DataFrame:
    """The study's learned runs of one ω_t: all architectures but V and T."""
    return table("study/paper").query("omega_t == @omega_t and architecture not in ['V', 'T']")


def on_force(omega_t: float) -> pd.DataFrame:
    """Those of `learned_runs` that sense the leg's force alone."""
    return learned_runs(omega_t).query("observation == 'F'")


def best_runs() -> pd.DataFrame:
    """The best run of each learned model, and its CoT⁻¹ over the line at its mean hop rate."""
    kept = table("figures/optimum.points")
    kept = kept[kept.gaits.str.startswith("best run")]
    line = [optimum(omega) for omega in kept.hop_rate_rad_per_s]
    return kept.assign(over=kept.cot_inverse_a_m_per_j / line)


def runs_between(low: float, high: float) -> pd.DataFrame:
    """Those of `best_runs` with a hop rate between two [rad/s]."""
    return best_runs().query("@low <= hop_rate_rad_per_s < @high")


def bound(omega: float | None = None) -> float:
    """The proved bound of CoT⁻¹ of period 1 at a hop frequency; at any, by default [m/J]."""
    from research.reproduction.optimum.proofs import read_certificates
    from tegotae.measures.optimum import curve

    return float(
        read_certificates()[0].bound if omega is None else curve().bound("upper_bound", omega)
    )


def gap(omega: float) -> float:
    """The bound over the best known gait, less 1."""
    return bound(omega) / optimum(omega) - 1.0


def push_s(omega: float, after: float = 0.0, before: float = 1.0) -> float:
    """How long full force lasts that has the impulse of a part of the best stance [s]."""
    from research.reproduction.optimum.best import optimal_stances

    kept = optimal_stances()[omega]
    chosen = (kept["time_s"] >= after) & (kept["time_s"] <= before)
    steps = np.diff(kept["time_s"], append=kept["time_s"][-1])
    return float((kept["force_n"] * steps)[chosen].sum() / 4.0)


def strongest(omega: float, after: float = 0.0, before: float = 1.0) -> float:
    """The largest force in a part of the best stance [N]."""
    from research.reproduction.optimum.best import optimal_stances

    kept = optimal_stances()[omega]
    return float(kept["force_n"][(kept["time_s"] >= after) & (kept["time_s"] <= before)].max())


def sizes() -> pd.Series:
    """Fitness of the trainings of `parameter_limit` with our settings, those alike once."""
    kept = table("experiments/parameter_limit")
    return kept[
        ~kept.duplicated(["parameters", "seed", "std", "learning_rate"]) & (kept.way != "pgpelib")
    ].fitness


def endings(study: str) -> pd.Series:
    """How the runs of a study's table ended, by `research.reproduction.endings`."""
    from dataclasses import asdict

    from research.reproduction.endings import endings
    from research.reproduction.export import read_study_csv

    return pd.Series(asdict(endings(read_study_csv(kept_file(f"{study}.csv")))))


def optimum(omega: float) -> float:
    """CoT⁻¹ of the best known gait that repeats with every hop, at one hop frequency [m/J]."""
    from tegotae.measures.optimum import curve

    return float(curve().interpolate("cot_inverse", omega))


def learned(omega_t: float) -> float:
    """Share of learned runs that end within 2 % of the best known gait of ω_t, or above."""
    return float((learned_runs(omega_t).best_fitness >= 0.98 * optimum(omega_t)).mean())


def ended(how: str) -> int:
    """How many of the study's trainings ended in a way: "plateau" or "cap"."""
    return int((table("study/paper").ended == how).sum())


def settled(omega_t: float) -> float:
    """Share of the evaluated episodes of learned runs that have a limit cycle."""
    return float(learned_runs(omega_t).limit_cycle_share.mean())


def settled_v(study: str) -> float:
    """Share of V's evaluated episodes that have a limit cycle, in one study."""
    return float(table(study).query("architecture == 'V'").limit_cycle_share.mean())


def of_optimum(omega_t: float) -> float:
    """Mean CoT⁻¹ of learned runs over the best known at the gait's own hop rate."""
    return float(learned_runs(omega_t).optimum_share.mean())


def readings(
    claim: str, verdict: str = "", but: int | None = None, among: str | None = None
) -> int:
    """In how many of the other readings a claim has a verdict, or by default a number.

    One of them may be left out (`but`), or only those count that the text allows (`among`, a
    heading of `research.reproduction.readings.readings.ALLOWED`).
    """
    from research.reproduction.readings.readings import ALLOWED
    from research.reproduction.readings.tables import read_tables

    rows = table("multiverse/effects").query("claim == @claim and omega_t == 'both'")
    if among is not None:
        every, _ = read_tables(kept_file("multiverse"))
        rows = rows[[ALLOWED[among](every[n]) for n in rows.reading]]
    said = rows.verdict == verdict if verdict else rows.effect.notna()
    return int((said & (rows.reading != but)).sum())


_TRAINED = ("equal", "80", "plateau")


def figure3(policy: str, arm: str, trained: str, column: str, best: bool = False) -> tuple:
    """A cell of Fig. 3's comparison with its interval: after equal time, 80 generations, the end.

    `column` is "CoT" or "over SAC" or "over PPO"; of the last policies, or of the best ones.
    """
    head = f"CoT⁻¹ of the {'best' if best else 'last'}" if column == "CoT" else column
    at = _TRAINED.index(trained) + (3 if best and column != "CoT" else 0)
    page = "experiments/figure3"
    return tuple(cells(page, head, policy, arm, part=part)[at] for part in range(3))


@cache
def late(name: str, algorithm: str, model: str) -> tuple[float, ...]:
    """CoT⁻¹ late in the trainings of a kept table of curves, run by run."""
    from tegotae.training.curves import groups, late_mean, read_curves

    kept = groups(read_curves([kept_file(f"experiments/{name}.csv")]))
    return tuple(late_mean(run) for run in kept[model, algorithm])


def second_look(algorithm: str, policy: str, over: bool = False) -> tuple[float, float, float]:
    """CoT⁻¹ at the end of the second look's trainings, or PGPE's lead over it."""
    from tegotae.measures.statistics import difference, interval

    model = f"AR-rF-{policy}-w8"
    theirs = late("second_look", f"{algorithm}, suited", model)
    found = interval(theirs, within=(0.0, np.inf))
    if over:
        found = difference(late("figure3", "pgpe-figure3", model), theirs)
    return found.mean, found.low, found.high


def gaits_of(arm: str) -> pd.DataFrame:
    """The best policies of Fig. 3's trainings by one algorithm that settle within 40 s."""
    return rows("experiments/figure3_gaits", algorithm=arm).dropna(subset="hop_rate")


def least_best(name: str, algorithm: str, policy: str) -> float:
    """The best CoT⁻¹ on the way of the run whose best is the least, in a kept table of curves."""
    runs = rows(f"experiments/{name}", algorithm=algorithm, model=f"AR-rF-{policy}-w8")
    return float(runs.groupby("seed").cot_inverse.max().min())


@cache
def of_calibrated_optimum(kind: str) -> np.ndarray:
    """CoT⁻¹ of the best run of each model in the calibrated body, over the best known gait's."""
    from research.experiments.calibrated_optimum import best_runs
    from research.reproduction.export import read_study_csv

    rate, value = best_runs(read_study_csv(kept_file("study-calibrated/calibrated.csv")))[kind]
    line = table("study-calibrated/optimum")
    return value / np.interp(rate, line.omega, line.cot_inverse)


def contrast(body: str, comparison: str, episodes: str = "all") -> tuple[float, float, float]:
    """An equal comparison over all training frequencies [m/J], with its 95 % interval.

    A body such as "study-80s" is one whose evaluation or work was changed; episodes are all or
    locked.
    """
    both = pd.concat([table("learning/contrasts"), table("learning/contrasts-window")])
    named = (both.body == body) & (both.comparison == comparison) & (both.episodes == episodes)
    kept = both[named]
    return kept["all"].item(), kept.low.item(), kept.high.item()


def random_laws(subject: str, omega: float, column: str = "moves") -> float:
    """Mean of a column of the map of short laws over all laws that a body meets at a command."""
    kept = rows("law_map/summary", subject=subject, omega=omega)
    return float(np.average(kept[column], weights=kept.laws))


@cache
def legs(family: str) -> pd.DataFrame:
    """Evaluations of the learned legs' families, with their costs over that of the vanilla front.

    `off` is the share by which the speed is off the wanted one, ω times 0.153.
    """
    from tegotae.measures.fronts import front

    kept = table("learned_legs/range")
    kept = kept[kept.cell.str.match(re.escape(family) + "[-+]")]
    cost = front("quadruped-c", "vanilla").cost_at(kept.speed_m_per_s)
    off = abs(kept.speed_m_per_s / (kept.omega * 1.2 * 0.4 / np.pi) - 1.0)
    return kept.assign(of_front=kept.cost_of_transport / cost, off=off)


def sweep(name: str, way: str, omega: float) -> pd.Series:
    """The lag of LF, speed, cost and duty factor of one level of a sweep, medians over starts."""
    kept = rows(f"gaits/findings-sweep-{name}", direction=way, omega_rad_per_s=omega)
    duty = kept.filter(like="duty_factor").mean(axis=1)
    kept = kept.assign(lag=kept.lag_cycles_LF, speed=kept.speed_m_per_s, duty=duty)
    return kept.assign(cost=kept.cost_of_transport)[["lag", "speed", "cost", "duty"]].median()


def crossing(name: str, gait: str, over: str, rises: bool) -> float:
    """Where a gait's largest multiplier rises through 1, or falls, between two values."""
    kept = rows(f"gaits/{name}", gait=gait).dropna(subset="largest")
    x, above = kept[over].to_numpy(), kept.largest.to_numpy() - 1.0
    (at,) = np.flatnonzero((above[1:] * above[:-1] < 0) & ((above[1:] > 0) == rises))
    return float(x[at] - above[at] * (x[at + 1] - x[at]) / (above[at + 1] - above[at]))


def ticks(tick: float, column: str) -> float:
    """The largest error of a walker's tick: paths at all ω, gaits from ω = 2.1 on."""
    kept = table("gaits/legs_validation_ticks")
    kept = kept[np.isclose(kept.tick, tick, atol=1e-4)]
    paths = column in ("place_error", "phase_error_rad", "load_error")
    return float(kept[column][(kept.omega > 2.0) | paths].abs().max())


def apex_errors(scheme: str, tick_ms: float, dtype: str = "float64", kind: str = "regular"):
    """Errors of the apexes of a scheme's cases [mm], by actuation."""
    kept = rows("convergence/convergence", scheme=scheme, tick_ms=tick_ms, dtype=dtype, kind=kind)
    return kept.groupby("actuation").largest_apex_error_mm


def learned_errors(tick_ms: float, dtype: str = "float64", kind: str = "regular", **where: str):
    """Errors of the apexes of learned laws under the predictor-corrector [mm]."""
    kept = rows("convergence/convergence_learned", tick_ms=tick_ms, dtype=dtype, kind=kind, **where)
    return kept.largest_apex_error_mm


def drawn_laws(*kinds: str) -> pd.DataFrame:
    """Random laws of the zoo of some kinds, with their errors and changes by half the tick [mm]."""
    return rows("convergence/resolved_laws", kind=list(kinds))


def resolved_change(family: str, metric: str) -> float:
    """Mean change of a metric of a family, judged resolved and not at 1 ms."""
    kept = table("convergence/resolved_runs")
    kept = kept[kept.model.str.partition("-")[0] == family]
    return (kept[f"{metric}_judged"] - kept[f"{metric}_1"]).mean()


def trained_unresolved(family: str, trained_at_ms: float) -> float:
    """Share of a family's episodes that 1 ms does not resolve, by the tick of the training."""
    kept = rows("convergence/resolved_trained", trained_at_ms=trained_at_ms)
    return (kept[kept.model.str.partition("-")[0] == family].flagged_1 / 5.0).mean()


def setting(name: str, column: str) -> pd.Series:
    """A column of the sensitivity of limit cycles, over the values of one setting."""
    return rows("experiments/limit_cycle_sensitivity", setting=name).set_index("value")[column]


def oscillators(oscillator: str, omega_t: int, architecture: str, column: str) -> float:
    """Mean of a column over the runs of one architecture with an oscillator."""
    kept = rows("oscillators/matter", oscillator=oscillator, omega_t=omega_t)
    return kept[kept.architecture == architecture][column].mean()


def matter(oscillator: str, omega_t: int, column: str = "fitness") -> tuple[float, ...]:
    """Difference of an oscillator to the phase, learned terms, with its 95 % interval."""
    page = f"oscillators/matter-w{omega_t}"
    return tuple(cells(page, column, oscillator, part=part)[0] for part in range(3))


SHOWN = ("V", "VG", "AR", "ART", "ARG", "ARGT")
"""The architectures with an oscillator on the page of generalisation."""


def brackets(name: str, condition: str, side: str = "above", among: tuple = SHOWN) -> list[float]:
    """Where half of the runs fail, over architectures: the least level passed, the most failed.

    Of "moving" or "architectures" (keep their gait) in research/generalisation.
    """
    kept = rows(f"generalisation/{name}", condition=condition, side=side, architecture=list(among))
    if side == "above":
        return [kept.survived.min(), kept.failed.max()]
    return [kept.survived.max(), kept.failed.min()]


def varied(column: str, model: str, trained: str, *conditions: str) -> float:
    """A number of trainings under changing conditions, over all levels or undisturbed."""
    how = {"steady": "always the same episode", "varied": "changing conditions"}[trained]
    page = "overall" if conditions else "undisturbed"
    return cell(f"generalisation/{page}", column, model, how, *conditions)


@cache
def atlas(body: str, omega_t: float, drive: str = "φ") -> pd.DataFrame:
    """The runs of a body's atlas at an ω_t, by what their force follows.

    `learns_push` is whether their actuation is learned, or vanilla's.
    """
    kept = rows(f"atlas/{body}", omega_t=omega_t, drive=drive)
    return kept.assign(learns_push=kept.architecture.str.contains("T"))


def kind(omega_t: float, of: str | list[str], drive: str, body: str = "study") -> pd.DataFrame:
    """The runs of the atlas whose feedback is of a kind."""
    kept = atlas(body, omega_t, drive)
    return kept[kept.kind.isin(of if isinstance(of, list) else [of])]


def share_of(
    omega_t: float, of: str | list[str], body: str = "study", learns_push: bool | None = None
) -> float:
    """The share of the runs on φ whose feedback is of a kind; of those with such a push alone."""
    kept, found = atlas(body, omega_t), kind(omega_t, of, "φ", body)
    if learns_push is not None:
        kept, found = (x[x.learns_push == learns_push] for x in (kept, found))
    return len(found) / len(kept)


def costs_or_nothing(omega_t: float, body: str = "study") -> float:
    """The share of the runs on φ that are no worse without their feedback."""
    return share_of(omega_t, ["feedback costs", "clock"], body)


def replaced(
    omega_t: float, share: float, table: str = "study", among: str = "study", most: int = 9
) -> pd.Series:
    """Whether some form of at most so many numbers keeps so much of a model's merit, of an atlas'
    models in another."""
    from research.reproduction.learning.forms import leg_controller
    from tegotae.analysis.short_forms import forms_of_a_leg

    models = rows(f"atlas/{among}").model.unique().tolist()
    kept = rows(f"atlas/{table}", omega_t=omega_t, best=True, model=models)
    kept = kept[~kept.kind.isin(["does not hop", "one network"])]
    forms = [x for x in forms_of_a_leg() if leg_controller(x).n_weights <= most]
    return kept[[f"kept {name}" for name in forms]].max(axis=1) >= share


def repeated() -> pd.DataFrame:
    """Effects of the study's runs beside those of a set of other runs, as the study counts.

    `apart` is their difference over the standard error of the two, `turned` a changed verdict.
    """
    kept = table("study/effects").drop_duplicates("claim").set_index("claim")
    other = table("study/effects-repeated").set_index("claim")
    both = kept.merge(other, on="claim", suffixes=("", "_other")).query("low < high")
    error = np.hypot(both.high - both.low, both.high_other - both.low_other) / (2 * 1.96)
    apart = (both.effect - both.effect_other).abs() / error
    return both.assign(apart=apart, turned=both.verdict != both.verdict_other)


@cache
def ridge(actuation: str):
    """The line through the best gains of the gain map, as `research.reproduction.ridge` fits it."""
    from research.reproduction.ridge import find_ridge

    kept = rows("experiments/gain_map.ridge", actuation=actuation)
    sigma = np.linspace(0.0, 12.0, 100)
    value = np.zeros((len(sigma), len(kept)))
    best = abs(sigma[:, None] - kept.best_sigma_rad_per_s_n.to_numpy()).argmin(axis=0)
    value[best, np.arange(len(kept))] = kept.cot_inverse_a_m_per_j
    return find_ridge(sigma, kept.omega_rad_per_s.to_numpy(), value)


def statements_met(strictness: str) -> pd.Series:
    """How many of the eight statements on V each reading of the calibration meets."""
    from research.reproduction.calibration.posterior import STRICTNESS, met

    (levels,) = (each.target for each in STRICTNESS if each.name == strictness)
    return pd.Series(met(table("calibration/coarse").iloc[:, -8:], levels).sum(axis=1))


def shortfall(look: str, names: str = "body") -> pd.Series:
    """How far readings fall short at the middle level, by their number or name."""
    from research.reproduction.calibration.posterior import STRICTNESS, shortfalls

    kept = table(f"calibration/{look}")
    return pd.Series(shortfalls(kept.iloc[:, -8:], STRICTNESS[1].target), kept[names])


def met_together(one: str, other: str) -> float:
    """How often two statements are met together at the middle level, over chance."""
    from research.reproduction.calibration.posterior import STRICTNESS, meeting_ratio

    kept = table("calibration/coarse").iloc[:, -8:]
    found = meeting_ratio(kept.to_numpy(), STRICTNESS[1].target)
    return float(found[kept.columns.get_loc(one), kept.columns.get_loc(other)])


def accepted(share: float = 0.02) -> pd.DataFrame:
    """The nearest readings of the calibration, with their weights in the posterior."""
    from research.reproduction.calibration.posterior import posterior

    found = posterior(shortfall("coarse").to_numpy(), share)
    return table("calibration/coarse").iloc[found.accepted].assign(weight=found.weights)


def legs_limit(feet: str = "ellipse") -> pd.DataFrame:
    """The least costs of transport that are known for quadruped C, by speed."""
    from research.legs_limit.known import limit_table

    kept = pd.DataFrame(limit_table())
    return kept[kept.feet == feet]


def over_bound(kept: pd.DataFrame) -> pd.Series:
    """The costs of kept gaits over the proved bound for their longest stances."""
    from research.legs_limit.known import bound
    from tegotae.parts.bodies import Walker

    return kept.cost_of_transport / bound(Walker(), kept.speed, kept.longest_stance)


def searched(speed: float) -> float:
    """What the search alone shows between its speeds: a straight line in log CoT, as for limits."""
    kept = legs_limit().query("source == 'search'")
    return float(np.exp(np.interp(speed, kept.speed, np.log(kept.cost_of_transport))))


def kept_front(system: str, family: str = "vanilla") -> pd.DataFrame:
    """The points of a kept front, by speed."""
    from tegotae.measures.fronts import front

    return pd.DataFrame(front(system, family).columns)


def marks(text: str) -> Iterator[tuple[str, str]]:
    """The text before each mark, to the end of its number, and the mark's expression."""
    for mark in MARK.finditer(text):
        yield text[: mark.start()], mark[1]


def stale(text: str) -> list[str]:
    """What a page says other than its tables: a line for each such number.

    Example:
        >>> stale("twice 2 is 5<!-- = 2 * 2 -->")
        ['5 is shown, and 2 * 2 is 4']
    """
    wrong = []
    for before, expression in marks(text):
        value = eval(expression, globals())  # the pages are the project's own
        if isinstance(value, list):
            wrong += _stale_list(before, value, expression)
            continue
        shown = NUMBER.search(before)
        if shown is None:
            wrong.append(f"no number stands before the mark {expression}")
            continue
        values = [float(x) for x in (value if isinstance(value, tuple) else (value,))]
        numbers = [number for number in shown.groups()[:3] if number is not None]
        scale = 100.0 if "%" in shown[0] else 1.0
        right = [_as(number, scale * x) for number, x in zip(numbers, values, strict=False)]
        if len(numbers) != len(values) or numbers != right:
            wrong.append(f"{' '.join(numbers)} is shown, and {expression} is {' '.join(right)}")
    return wrong


def _stale_list(before: str, values: list[float], expression: str) -> list[str]:
    """The same for a list: the last numbers of its sentence or cell, one for each value."""
    shown = LISTED.findall(MARK.sub("", before)[-300:])[-len(values) :]
    numbers = [number for number, _ in shown]
    scales = [100.0 if share or shown[-1][1] else 1.0 for _, share in shown]
    right = [_as(n, s * float(x)) for n, s, x in zip(numbers, scales, values, strict=False)]
    if len(numbers) == len(values) and numbers == right:
        return []
    return [f"{' '.join(numbers)} is shown, and {expression} is {' '.join(right)}"]


def _as(number: str, value: float) -> str:
    """A value as a number of a page is written: its decimals, signs and thin spaces."""
    decimals = len(number.partition(".")[2])
    text = f"{abs(value):.{decimals}f}"
    is_zero = not float(text)
    sign = ("−" if "−" in number else "-") if value < 0 and not is_zero else ""
    if value < 0 and not is_zero and number[0] not in "−-":
        sign = "-"
    if number.startswith("+") and value > 0:
        sign = "+"
    if " " in number or "\u202f" in number:
        space = "\u202f" if "\u202f" in number else " "
        whole, point, rest = text.partition(".")
        text = f"{int(whole):,}".replace(",", space) + point + rest
    return sign + text


def pages() -> list[Path]:
    """The pages that have prose: README, docs, and those of research."""
    folders = (ROOT / "docs", ROOT / "research")
    return [
        *sorted(ROOT.glob("README*.md")),
        *(x for at in folders for x in sorted(at.rglob("*.md"))),
    ]


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    faults = [f"{page.relative_to(ROOT)}: {x}" for page in pages() for x in stale(page.read_text())]
    sys.exit("\n".join(faults) or None)
