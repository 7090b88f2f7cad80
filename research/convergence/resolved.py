"""Tell which results the control period resolves, and judge and train laws where it does.

    python -m research.convergence.resolved check     # 100 laws against the solver, 12 min
    python -m research.convergence.resolved zoo       # all runs of the study at five ticks, 12 min
    python -m research.convergence.resolved train     # 72 models trained at 0.5 ms, 40 min of CPU
    python -m research.convergence.resolved report    # the page's tables

Each continues where it was stopped. Plan, made before the runs:

A result is resolved at a tick T if half of T leaves it as it is. If halving at least halves the
error, the error at T is at most twice the change; so a change of half of the accuracy is allowed.
- An apex: accuracy 1 mm, so that the heights of a rollout of 20 s change by at most 0.5 mm.
- An episode of the evaluation: accuracy 1 %, so that CoT⁻¹ changes by at most 0.5 %, and both
  settle or neither does.

`check`: 100 laws of the zoo `paper`, drawn at random, of every family equally many but for one. At
2, 1 and 0.5 ms, in float32, a flag is raised by the change from T to T/2; an apex more than 1 mm
off the adaptive solver is wrong. Hits, misses and false alarms are counted in regular laws, and the
flags in others. Expected: no miss at 1 ms or below; at 2 ms at most 3 of the regular laws.

`zoo`: every run at five frequencies at 2, 1, 0.5, 0.25 and 0.125 ms, in float32. The last is the
reference of hits and misses. A run is judged at the first of 1, 0.5 and 0.25 ms at which all of its
episodes are resolved, and at 0.125 ms if none is; the study judges all at 1 ms. A family's table
changes if the 95 % interval over its runs of the paired difference excludes zero, and materially
so from 0.01 m/J or 0.01 of settled episodes on.

`train`: every model of AR, ART, ARG and ARGT, three seeds, at 0.5 ms, otherwise as in the study,
and evaluated at 0.5 ms; models that sense F_k alone first, others as time allows. They are paired
by seed with the study's runs, trained at 2 ms, at the same evaluation. Statements on gain networks:
`arg-cot` and `argt-cot` (CoT⁻¹ with a gain network minus without, at equal senses of R and
actuation), and `arg-feedback-off` (the same of `feedback_share`). One changes if its sign does, or
its interval's exclusion of zero.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from research.convergence.run import Reference, kind, learned, reference
from research.frame import Row, Table, main, markdown_table, with_interval, write_text
from research.reproduction.claims.designs import DRIVES
from research.reproduction.plan import plan
from research.reproduction.unit import Unit, work
from tegotae.analysis.simulation import largest_change_m, simulate
from tegotae.measures.evaluation import Evaluation, evaluate
from tegotae.parts.fields import replace
from tegotae.simulation.timing import Timing
from tegotae.systems.controller_file import SavedController, load
from tegotae.systems.zoo import FOLDER as ZOO, Zoo, open_zoo

FOLDER = Path(__file__).parent
LAWS = Table(FOLDER / "resolved_laws.csv", ("law",))
RUNS = Table(FOLDER / "resolved_runs.csv", ("model",))
TRAINED = Table(FOLDER / "resolved_trained.csv", ("model",))
TICKS_MS = (2.0, 1.0, 0.5, 0.25, 0.125)
SEEDS = 3
COLUMNS = ("cot_inverse", "limit_cycle_share", "feedback_share")
"""Metrics of runs that are kept."""
METRICS = {"cot_inverse": "CoT⁻¹ [m/J]", "feedback_share": "share of the feedback"}
"""Headings of metrics."""


@cache
def zoo_of_study() -> Zoo:
    """Return the study's controllers."""
    return open_zoo(ZOO / "paper.npz")


def family(model: str) -> str:
    """Return the architecture of a model's name."""
    return model.partition("-")[0]


def drawn_laws(count: int, seed: int = 0) -> list[str]:
    """Draw laws of the zoo, one family after the other."""
    draw, models = np.random.default_rng(seed), list(zoo_of_study().models)
    families = list(dict.fromkeys(map(family, models)))
    laws: dict[str, None] = {}
    while len(laws) < count:
        name = families[len(laws) % len(families)]
        model = draw.choice([model for model in models if family(model) == name])
        laws[f"{model}/{draw.integers(zoo_of_study().models[model])}"] = None
    return list(laws)


def apexes_m(saved: SavedController, tick_s: float) -> np.ndarray:
    """Return the apex heights of 20 s of a law, in float32 [m]."""
    timing = Timing(duration_s=20.0, tick_s=tick_s, frame_s=0.01)
    return simulate(saved.system, saved.weights, timing).apexes[1]


def law_rows(law: str) -> list[Row]:
    """Return the errors of a law at ticks, and its changes by half of them [mm]."""
    saved = load(f"zoo:paper:{law}")
    try:
        solution = reference(learned(saved), saved.omega or 0.0)
    except RuntimeError:  # touchdowns without end: no law of a hop
        solution = Reference(np.zeros(0), np.inf)
    apexes = {tick_ms: apexes_m(saved, 1e-3 * tick_ms) for tick_ms in TICKS_MS[:4]}
    row: Row = {"family": family(law), "law": law, "amplification": solution.amplification}
    row |= {"kind": kind(solution.amplification), "hops": len(solution.hops_m)}
    for tick_ms, half_ms in pairwise(apexes):
        heights = apexes[tick_ms]
        row[f"error_mm_{tick_ms:g}"] = 1e3 * largest_change_m(heights, solution.hops_m, 1.0)
        row[f"change_mm_{tick_ms:g}"] = 1e3 * largest_change_m(heights, apexes[half_ms], 1.0)
    return [row]


def check(count: int = 100) -> None:
    """Compare random laws with the solver and with themselves at half the tick."""
    LAWS.measure([(law,) for law in drawn_laws(count)], law_rows)


def evaluated(
    saved: SavedController, weights: np.ndarray, ticks_ms: Iterable[float]
) -> dict[float, Evaluation]:
    """Return the evaluations of a model's runs by tick [ms]."""
    assert saved.experiment is not None
    protocol = saved.system.evaluated_by(saved.experiment.protocol)
    return {
        tick_ms: evaluate(
            *(saved.controller, weights, saved.omega, saved.body),
            dataclasses.replace(protocol, tick_s=1e-3 * tick_ms),
            COLUMNS,
        )
        for tick_ms in ticks_ms
    }


def unresolved(evaluations: Mapping[float, Evaluation]) -> dict[float, np.ndarray]:
    """Return by tick [ms] in which episodes half of it changes CoT⁻¹, [runs, episodes]."""
    efficiency = {
        tick_ms: dataclasses.replace(x, episodes={"cot_inverse": x.episodes["cot_inverse"]})
        for tick_ms, x in evaluations.items()
    }
    return {
        tick_ms: ~efficiency[tick_ms].resolved(efficiency[half_ms])
        for tick_ms, half_ms in pairwise(evaluations)
    }


def run_rows(model: str) -> list[Row]:
    """Return the values of a model's runs at the study's tick and judged resolved, and how many
    episodes are wrong and flagged at each tick."""
    # A gain that a search found is the same in all runs.
    weights = zoo_of_study().weights(model)[: 1 if family(model) == "V" else None]
    evaluations = evaluated(load(f"zoo:paper:{model}/0"), weights, TICKS_MS)
    flags, values = (
        unresolved(evaluations),
        {tick_ms: x.runs() for tick_ms, x in evaluations.items()},
    )
    finest = evaluations[TICKS_MS[-1]].episodes["cot_inverse"]
    rows: list[Row] = []
    for run in range(len(weights)):
        judged_ms = next((x for x in TICKS_MS[1:-1] if not flags[x][run].any()), TICKS_MS[-1])
        row: Row = {"model": model, "run": run, "judged_at_ms": judged_ms}
        for name in COLUMNS:
            for key, tick_ms in {"2": 2.0, "1": 1.0, "judged": judged_ms}.items():
                row[f"{name}_{key}"] = values[tick_ms][name][run]
        for tick_ms, flag in flags.items():
            efficiency = evaluations[tick_ms].episodes["cot_inverse"][run]
            wrong = ~np.isclose(efficiency, finest[run], rtol=0.01, atol=0.0, equal_nan=True)
            row[f"flagged_{tick_ms:g}"] = int(flag[run].sum())
            row[f"wrong_{tick_ms:g}"] = int(wrong.sum())
            row[f"missed_{tick_ms:g}"] = int((wrong & ~flag[run]).sum())
        rows.append(row | {"episodes": finest.shape[1]})
    return rows


def zoo() -> None:
    """Judge all runs of the study's zoo."""
    RUNS.measure([(model,) for model in zoo_of_study().models], run_rows)


def trained_rows(model: str) -> list[Row]:
    """Train a model at 0.5 ms, and return its runs beside those of the study, at 0.5 ms."""
    (unit,) = plan("paper", model).units
    ticks = {"system.timing.tick_s": 0.0005, "protocol.tick_s": 0.0005}
    run = dataclasses.replace(
        unit.run, experiment=replace(unit.run.experiment, ticks), seeds=tuple(range(SEEDS))
    )
    record, saved = work(Unit(run)), load(f"zoo:paper:{model}/0")
    archive = zoo_of_study()
    assert archive.runs(model)["seed"][:SEEDS].tolist() == list(run.seeds)
    rows: list[Row] = []
    for tick_ms, weights, fitness in (
        (0.5, record.weights, record.best_fitness),
        (2.0, archive.weights(model)[:SEEDS], archive.runs(model)["fitness"]),
    ):
        evaluations = evaluated(saved, weights, TICKS_MS[:4])
        values, flags = evaluations[0.5].runs(), unresolved(evaluations)
        for seed in run.seeds:
            row: Row = {"model": model, "trained_at_ms": tick_ms, "run": seed}
            row |= {"fitness": fitness[seed]} | {name: values[name][seed] for name in COLUMNS}
            for tick, flag in flags.items():
                row[f"flagged_{tick:g}"] = int(flag[seed].sum())
            rows.append(row)
    return rows


def train() -> None:
    """Train the models of learned feedback at a resolving tick."""
    models = [m for m in zoo_of_study().models if family(m) in ("AR", "ART", "ARG", "ARGT")]
    # Senses, then inputs of the actuation: a part of the study has all architectures alike.
    models.sort(key=lambda model: ("Fv" in model, DRIVES[model.split("-")[-2]], model[-2:]))
    TRAINED.measure([(model,) for model in models], trained_rows)


def percent(share: float) -> str:
    """Return a share in percent."""
    return f"{100.0 * share:.1f} %"


def count_table(laws: pd.DataFrame, runs: pd.DataFrame) -> str:
    """Return how often the change by half the tick tells what is wrong: apexes of regular laws, and
    CoT⁻¹ in the episodes of runs that are resolved by the finest tick but one."""
    heads = ("subject", "tick", "judged", "wrong", "hits", "misses", "false alarms")
    rows: list[list[object]] = [list(heads)]
    regular = laws[laws.kind == "regular"]
    for tick in ("2", "1", "0.5"):
        wrong, flag = regular[f"error_mm_{tick}"] > 1.0, regular[f"change_mm_{tick}"] > 0.5
        counts = [x.sum() for x in (wrong, wrong & flag, wrong & ~flag, flag & ~wrong)]
        rows.append(["regular laws", f"{tick} ms", len(regular), *counts])
    comparable = runs[runs["flagged_0.25"] == 0]
    for tick in ("2", "1", "0.5"):
        wrong, missed, flagged = (
            comparable[f"{name}_{tick}"].sum() for name in ("wrong", "missed", "flagged")
        )
        hits = wrong - missed
        counts = [comparable.episodes.sum(), wrong, hits, missed, flagged - hits]
        rows.append(["episodes", f"{tick} ms", *counts])
    return markdown_table(rows)


def family_table(laws: pd.DataFrame, runs: pd.DataFrame) -> str:
    """Return errors of random laws and unresolved episodes of all runs, by family."""
    rows: list[list[object]] = [
        [
            *("family", "regular of the drawn", "error at 2 ms [mm]", "1 ms", "0.5 ms"),
            *("unresolved episodes at 2 ms", "1 ms", "0.5 ms"),
        ]
    ]
    for name, group in runs.groupby(runs.model.map(family), sort=False):
        drawn = laws[laws.family == name]
        regular = drawn[drawn.kind == "regular"]
        errors = [_millimetres(regular[f"error_mm_{tick}"].max()) for tick in ("2", "1", "0.5")]
        shares = [group[f"flagged_{x}"].sum() / group.episodes.sum() for x in ("2", "1", "0.5")]
        cells = errors if len(regular) else ["–"] * 3
        rows.append([name, f"{len(regular)} of {len(drawn)}", *cells, *map(percent, shares)])
    return markdown_table(rows)


def _millimetres(error: float) -> str:
    """Return an error with two digits; an infinite one is another number of hops."""
    return "other hops" if np.isinf(error) else f"{float(f'{error:.2g}'):g}"


def resolved_table(runs: pd.DataFrame) -> str:
    """Return the difference of resolved values to those at 1 and 2 ms, by family."""
    rows: list[list[object]] = [
        [
            *("family", "CoT⁻¹ at 1 ms", "resolved minus 1 ms", "resolved minus 2 ms"),
            *("settled at 1 ms", "resolved minus 1 ms", "resolved minus 2 ms"),
        ]
    ]
    for name, group in runs.groupby(runs.model.map(family), sort=False):
        row: list[object] = [name]
        for column in COLUMNS[:2]:
            row.append(f"{group[f'{column}_1'].mean():.3f}")
            for tick in ("1", "2"):
                change = group[f"{column}_judged"] - group[f"{column}_{tick}"]
                row.append(with_interval(change, "+.4f"))
        rows.append(row)
    return markdown_table(rows)


def gain_effects(trained: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield statement, metric, and the effect of a gain network on every run, a column per tick
    of the training [ms]."""
    base_of = trained.model.str.replace(r"^ARG", "AR", regex=True)
    trained = trained.assign(base=base_of.str.replace(r"-gFv?", "", regex=True))
    for claim, metric, families in (
        ("arg-cot", "cot_inverse", ("ARG",)),
        ("argt-cot", "cot_inverse", ("ARGT",)),
        ("arg-feedback-off", "feedback_share", ("ARG", "ARGT")),
    ):
        with_gain = trained[trained.model.map(family).isin(families)]
        pairs = with_gain.merge(
            trained,
            left_on=["base", "trained_at_ms", "run"],
            right_on=["model", "trained_at_ms", "run"],
        )
        pairs["effect"] = pairs[f"{metric}_x"] - pairs[f"{metric}_y"]
        yield (
            claim,
            metric,
            pairs.pivot(index=["model_x", "run"], columns="trained_at_ms", values="effect"),
        )


def trained_table(trained: pd.DataFrame) -> str:
    """Return statements on gain networks by the tick of the training."""
    heads = ("statement", "metric", "pairs", "trained at 2 ms", "at 0.5 ms", "difference")
    rows: list[list[object]] = [list(heads)]
    for claim, metric, effects in gain_effects(trained):
        columns = (effects[2.0], effects[0.5], effects[0.5] - effects[2.0])
        cells = [with_interval(x, "+.3f") for x in columns]
        rows.append([f"`{claim}`", METRICS[metric], len(effects), *cells])
    return markdown_table(rows)


def selected_table(trained: pd.DataFrame) -> str:
    """Return unresolved episodes and values of the trained runs, by family and tick of training."""
    rows: list[list[object]] = [
        [
            *("family", "trained at", "runs", "unresolved at 2 ms", "1 ms", "0.5 ms"),
            *("CoT⁻¹ [m/J]", "settled"),
        ]
    ]
    for name in ("AR", "ART", "ARG", "ARGT"):
        for tick_ms in (2.0, 0.5):
            group = trained[
                (trained.model.map(family) == name) & (trained.trained_at_ms == tick_ms)
            ]
            shares = [group[f"flagged_{x}"].mean() / 5.0 for x in ("2", "1", "0.5")]
            cells = [with_interval(group[column]) for column in COLUMNS[:2]]
            rows.append([name, f"{tick_ms:g} ms", len(group), *map(percent, shares), *cells])
    return markdown_table(rows)


def report() -> None:
    """Write the tables of the page."""
    laws, runs, trained = (table.read() for table in (LAWS, RUNS, TRAINED))
    for name, text in {
        "counts": count_table(laws, runs),
        "families": family_table(laws, runs),
        "judged": resolved_table(runs),
        "trained": trained_table(trained),
        "selected": selected_table(trained),
    }.items():
        write_text(FOLDER / f"resolved_{name}.md", text)


if __name__ == "__main__":
    main(check, zoo, train, report)
