"""The report: figures, claims and every model on one page without a server."""

from __future__ import annotations

import dataclasses
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from research.reproduction.claims.budgets import by_budget
from research.reproduction.claims.counting import Count, with_sampled
from research.reproduction.claims.designs import MODELS
from research.reproduction.claims.effects import OfGainMap, OfTrainings
from research.reproduction.claims.experiments import EXPERIMENTS, command_for
from research.reproduction.claims.findings import (
    NOT_MEASURED,
    OPPOSITE,
    REPRODUCED,
    TOO_SMALL,
    Finding,
    findings,
)
from research.reproduction.claims.kept import RIDGES
from research.reproduction.endings import endings_by_architecture
from research.reproduction.figures.optimum import optimum_figure
from research.reproduction.figures.study import (
    architectures_figure,
    correlation_figure,
    pictograms_figure,
)
from research.reproduction.optimum import optimal_stances
from research.reproduction.readings.designs import selecting_body
from research.reproduction.record import Record
from research.reproduction.report import convergence
from research.reproduction.report.atomic import (
    CLAIMED,
    effect_in_words,
    grouped_findings,
    quoted,
    shown_effect,
    tally,
)
from research.reproduction.report.models import (
    best_of_architectures,
    gaits_of_best_run,
    pages_of_models,
)
from research.reproduction.report.values import embedded_figure, embedded_file, json_number
from research.reproduction.table import StudyTable, record_place, tabulate, tabulate_sampled
from tegotae._support.documents import JsonObject
from tegotae._support.pages import as_script, filled_page
from tegotae.measures.metric import REPORT
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper
from tegotae.systems.observations import OBSERVATIONS

_DESIGN = {
    "model": ("Model", "its name in this software"),
    "architecture": ("Arch.", "which terms are learned"),
    "observation": ("Senses", "what is sensed: F_k, the spring force, and ẏ, the velocity"),
    "actuation": ("Actuation", "what the actuator force follows"),
    "omega_t": ("ω_t", "frequency in training [rad/s]"),
    "parameters": ("Parameters", "numbers that are learned"),
}
_FITNESS = {"best_fitness": ("Fitness", "of the best distribution in training")}
_COUNTS = {
    "runs": ("Runs", "trainings from random weights"),
    "without": ("No cycle", "runs without a limit cycle in any episode"),
}
_OWN = "its own"
"""Placeholder in a column of the design for an experiment that has no place in it."""


def report_page(
    records: list[Record],
    subtitle: str,
    experiments: Path | None = None,
    budgets: StudyTable | None = None,
) -> str:
    """Return the page, as HTML with everything in it.

    Args:
        records: the study's records.
        subtitle: one line on what study this is.
        experiments: folder with tables and figures of the experiments beside the study
            (`research.reproduction.claims.experiments`); what is not there is said to be missing.
        budgets: the same runs after several budgets of training.

    Raises:
        TegotaeError: if there is no such folder, or it holds a table or figure that is none.
    """
    table, selected = tabulate(records), selecting_body(records[0].experiment.body)
    runs = with_sampled(table, tabulate_sampled(records))
    results = findings(runs, experiments, selected=selected)
    data = {
        "about": subtitle,
        "software": records[0].software,
        "runs": len(table),
        "without_cycle": int((table["limit_cycle_share"] == 0.0).sum()),
        "first": first_finding(results, table),
        "figures": [*_figures(table), *_optimum(records), *_convergence(records)],
        **_claims(results, experiments),
        "by_budget": _by_budget(budgets, table, selected),
        "endings": [
            [name, *dataclasses.astuple(results)]
            for name, results in endings_by_architecture(table).items()
        ],
        "experiments": [
            {"caption": f"{e.caption}.", **embedded_file(experiments / e.figure)}
            for e in EXPERIMENTS
            if experiments is not None and (experiments / e.figure).exists()
        ],
        "models": _models(table),
        "pages": {
            "metrics": [[key, *words] for key, words in _measures(table).items()],
            "best": best_of_architectures(table),
            "of": pages_of_models(records, table, tuple(_measures(table))),
        },
    }
    page = files("research.reproduction.report").joinpath("page.html").read_text(encoding="utf-8")
    return filled_page(page, {"DATA": as_script(data)})


_SAID = {
    REPRODUCED: "Here it is so",
    OPPOSITE: "Here it is the opposite",
    TOO_SMALL: "Here it is too small to tell",
}


def first_finding(results: list[Finding], table: StudyTable) -> JsonObject | None:
    """Return the paper's main claim in a sentence, with its number as the study counts it, and its
    figure.

    None of a study whose models do not measure it.
    """
    finding = next(candidate for candidate in results if candidate.claim.headline)
    effect = next(iter(finding.by_count.values()))
    if not effect.is_known:
        return None
    words = (REPRODUCED, TOO_SMALL, OPPOSITE)
    counts = ", ".join(f"{word} in {finding.tally[word]}" for word in words)
    title = finding.claim.title
    numbers = f"{effect.effect:+.2f} [{effect.low:.2f}, {effect.high:.2f}], of {effect.size:.2f}"
    return {
        "sentence": f"The paper's main claim: {title}. {_SAID[finding.verdict(effect)]}.",
        "number": numbers.replace("-", "−"),
        "what": f"{effect_in_words(finding.claim.effect)}, with its 95 % interval over runs. Of "
        f"{finding.tally.total()} ways to count the same runs: {counts}.",
        "figure": {
            "caption": "CoT⁻¹ per architecture and training frequency ω_t, with 95 % intervals.",
            **embedded_figure(architectures_figure(table, only="cot_inverse")),
        },
    }


def _figures(table: StudyTable) -> list[JsonObject]:
    def entry(caption: str, figure: Figure) -> JsonObject:
        return {"caption": caption, **embedded_figure(figure)}

    entries = []
    if len(table.of_the_paper()):
        caption = "I. The architectures. Filled terms are learned networks, outlined are vanilla."
        entries.append(entry(caption, pictograms_figure(table)))
    entries.append(
        entry(
            "II. Each metric per architecture and training frequency ω_t, with 95 % intervals over "
            "runs. Inputs of the actuation count alike. At the top, the share of runs [%] that do "
            "not define the metric, because they do not settle or recover.",
            architectures_figure(table),
        )
    )
    if len(table.per_model()) >= MODELS:
        caption = "III. Correlation of the metrics over all models"
        caption += f"; at least {MODELS} must define both."
        entries.append(entry(caption, correlation_figure(table)))
    return entries


def _measures(table: StudyTable) -> dict[str, tuple[str, str]]:
    """Label and meaning of the metrics that the page shows, and of the fitness, by column."""
    labels = {}
    for metric in table.metrics_shown(REPORT):
        unit = f" [{metric.unit}]" if metric.unit else ""
        better = {None: "", True: "; more is better", False: "; less is better"}
        labels[metric.name] = (metric.label, f"{metric.about}{unit}{better[metric.more_is_better]}")
    return labels | _FITNESS


def _optimum(records: list[Record]) -> list[JsonObject]:
    """Draw CoT⁻¹ over hop frequency, beside the best that is possible; nothing for another body."""
    gaits = {}
    for vanilla, name in ((False, "learned"), (True, "V")):
        selected = [r for r in records if (record_place(r)["architecture"] == "V") == vanilla]
        series = [gaits_of_best_run(record) for record in selected]
        if any(len(omega) for omega, _ in series):
            gaits[name] = tuple(np.concatenate(parts) for parts in zip(*series, strict=True))
    if not gaits:
        return []
    tabulated = optimal_stances()
    best = {f"optimum, {omega:g} rad/s": tabulated[omega] for omega in (4.0, 8.0)}
    figure = optimum_figure(curve(), gaits, best, max_force_n=Hopper().max_force_n)
    caption = (
        "CoT⁻¹ over hop frequency of each model's best run, a point an episode that repeats itself "
        "with every hop, under the best that any force can do. The share of it is in the table "
        'below as "of optimum".'
    )
    return [{"caption": caption, **embedded_figure(figure)}]


def _convergence(records: list[Record]) -> list[JsonObject]:
    caption = (
        "Training at ω_t = {} rad/s: best fitness so far over episodes, runs, mean and 95 % "
        "interval; below, where runs stopped and why."
    )
    return [
        {"caption": caption.format(omega), **embedded_figure(figure)}
        for omega, figure in convergence.convergence_figures(records).items()
    ]


def _claims(results: list[Finding], experiments: Path | None) -> JsonObject:
    """Return the claims that are measured, a group after the other, the paper's account of itself
    first; how many are not, and the commands that measure some of them.
    """
    measured = [finding for finding in results if finding.outcome != NOT_MEASURED]
    effects = [f.claim.effect for f in results if f.outcome == NOT_MEASURED]
    commands = {
        command_for(getattr(effect, "table", RIDGES), experiments): None
        for effect in effects
        if isinstance(effect, OfTrainings | OfGainMap)
    }
    return {
        "claims": [
            {"heading": heading, "claims": [_claim(finding) for finding in group]}
            for heading, group in grouped_findings(measured).items()
        ],
        "unmeasured": {"count": len(effects), "of": len(results), "commands": list(commands)},
    }


def _claim(finding: Finding) -> JsonObject:
    claim, estimate = finding.claim, shown_effect(finding)
    return {
        "name": claim.name,
        "title": claim.title,
        "words": quoted(claim),
        "section": claim.section,
        "what": effect_in_words(claim.effect),
        "sign": claim.sign,
        "claimed": CLAIMED[claim.sign],
        "effect": None
        if estimate is None
        else [
            json_number(value)
            for value in (estimate.effect, estimate.low, estimate.high, estimate.size)
        ],
        "outcome": finding.outcome,
        "ways": tally(finding),
        "note": claim.note,
    }


def _by_budget(
    budgets: StudyTable | None, final: StudyTable, selected: frozenset[str]
) -> JsonObject:
    """Return headings, and one row per measured claim: its verdict after each budget."""
    if budgets is None:
        return {"headings": [], "rows": []}
    by = {
        name: findings(runs, options=[Count()], selected=selected)
        for name, runs in by_budget(budgets, final).items()
    }
    rows = [
        [group[0].claim.name, quoted(group[0].claim), *(finding.outcome for finding in group)]
        for group in zip(*by.values(), strict=True)
    ]
    decided = [row for row in rows if set(row[2:]) - {NOT_MEASURED}]
    return {"headings": list(by), "rows": decided}


def _models(table: StudyTable) -> JsonObject:
    models = table.per_model()
    names = models["model"]
    runs = {name: table["model"] == name for name in names}
    settled = table["limit_cycle_share"] > 0.0
    measures = _measures(table)
    columns = {name: models[name] for name in (*_DESIGN, *measures)}
    sensed = {name: observation.symbols for name, observation in OBSERVATIONS.items()}
    columns["observation"] = np.array([sensed.get(name, _OWN) for name in models["observation"]])
    columns["actuation"] = np.array([name or _OWN for name in models["actuation"]])
    columns["runs"] = np.array([float(runs[name].sum()) for name in names])
    columns["without"] = np.array([float((runs[name] & ~settled).sum()) for name in names])
    labels = _DESIGN | measures | _COUNTS
    barred = {metric.name for metric in table.metrics_shown(REPORT) if metric.range[0] == 0.0}
    return {
        "columns": [
            {"key": key, "label": label, "about": description, "bar": key in barred}
            for key, (label, description) in ((key, labels[key]) for key in columns)
        ],
        "rows": [list(map(_cell, row)) for row in zip(*columns.values(), strict=True)],
    }


def _cell(value: Any) -> str | float | None:
    return str(value) if isinstance(value, str) else json_number(float(value))
