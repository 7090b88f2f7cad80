"""The study's figure: metrics per architecture, and how the metrics go together (Fig. 2)."""

from __future__ import annotations

import dataclasses

import numpy as np
from matplotlib.figure import Figure

from tegotae.evaluation import METRICS
from tegotae.figures.style import COLOURS, COLUMN_IN, DIVERGING, PAGE_IN, new_figure, styled
from tegotae.metrics.statistics import Interval, balanced_difference
from tegotae.study.claims import correlation, designs
from tegotae.study.table import Table

ARCHITECTURES = ("V", "VG", "VT", "VGT", "AR", "ART", "ARG", "ARGT", "T")
"""The paper's architectures, in its order."""

SHOWN = {
    "cot_inverse": "CoT⁻¹",
    "t0_s": "T0",
    "t1_s": "T1",
    "delta_w": "Δw",
    "cpgu": "CPGu",
    "limit_cycle_share": "limit cycles",
}
"""Metrics of the figure, and how they are called there."""

_TOP = 1.5

OBSERVATIONS = {"F": "$s = [F_k]$", "Fv": r"$s = [F_k, \dot y]$"}


def architecture_metrics(table: Table) -> dict[tuple[str, str, str], Interval]:
    """Mean and interval per (observation, metric, architecture): designs count alike.

    A design is a value of ω_t and an input of the actuation. Architectures that sense nothing but
    F_k (V and VT) stand in both columns, as in the paper.
    """
    found = {}
    for observation in OBSERVATIONS:
        for architecture in ARCHITECTURES:
            rows = table.where(architecture=architecture)
            if architecture not in ("V", "VT"):
                rows = rows.where(observation=observation)
            for metric in SHOWN:
                values = [design[metric] for design in designs(rows).values()]
                mean = balanced_difference(values, single_is_exact=True)
                undefined = int(np.isnan(rows[metric]).sum())
                found[observation, metric, architecture] = dataclasses.replace(
                    mean, count=len(rows) - undefined, undefined=undefined
                )
    return found


def architectures_figure(table: Table) -> Figure:
    """Fig. 2, II: per architecture every metric over its largest mean, with 95 % intervals."""
    found = architecture_metrics(table)
    with styled():
        figure = new_figure(PAGE_IN, 5.6)
        panels = figure.subplots(len(SHOWN), 2, sharex=True, sharey=True)
        places = np.arange(len(ARCHITECTURES))
        for row, (metric, label) in zip(panels, SHOWN.items(), strict=True):
            means = [i.mean for (_, m, _), i in found.items() if m == metric]
            largest = np.nanmax(np.abs(means)) if np.isfinite(means).any() else np.nan
            scale = largest if largest > 0.0 else 1.0
            for panel, observation in zip(row, OBSERVATIONS, strict=True):
                _bars(panel, places, [found[observation, metric, a] for a in ARCHITECTURES], scale)
            row[0].set_ylabel(f"{label}\n1 is {_of_unit(largest, METRICS[metric])}")
        for panel, title in zip(panels[0], OBSERVATIONS.values(), strict=True):
            panel.set_title(title)
        for panel in panels.flat:
            panel.tick_params(axis="x", length=0)
        for panel in panels[-1]:
            panel.set_xticks(places, ARCHITECTURES)
        panels[0][0].set(ylim=(0.0, _TOP), yticks=(0.0, 0.5, 1.0))
        figure.align_ylabels(panels[:, 0])
    return figure


def _of_unit(value: float, unit: str) -> str:
    return "–" if np.isnan(value) else f"{value:.2g} {unit}".strip()


def _bars(panel, places: np.ndarray, values: list[Interval], scale: float) -> None:
    for place, value in zip(places, values, strict=True):
        if np.isnan(value.mean):
            panel.text(place, 0.06, "–", ha="center")
            continue
        panel.bar(place, abs(value.mean) / scale, width=0.72, color=COLOURS[3], alpha=0.75, lw=0)
        if not np.isnan(value.low):
            ends = np.abs([value.low, value.high]) / scale
            panel.plot([place, place], np.minimum(ends, _TOP), color="black", lw=1.2)
        share = value.undefined / max(value.undefined + value.count, 1)
        if share > 0.005:
            panel.text(place, 1.3, f"{share:.0%}", ha="center", fontsize=6, color="0.35")


def correlations(table: Table) -> np.ndarray:
    """Pearson correlations of the metrics over all models, shape [metrics, metrics]."""
    models = table.per_model()
    return np.array(
        [[1.0 if a == b else correlation(models, a, b).mean for b in SHOWN] for a in SHOWN]
    )


def correlation_figure(table: Table) -> Figure:
    """Fig. 2, III: correlation of the metrics over all models."""
    values = correlations(table)
    labels = list(SHOWN.values())
    with styled():
        figure = new_figure(COLUMN_IN, 2.8)
        panel = figure.subplots()
        image = panel.imshow(values, cmap=DIVERGING, vmin=-1.0, vmax=1.0, aspect="auto")
        panel.set_xticks(range(len(labels)), labels, rotation=45, ha="right")
        panel.set_yticks(range(len(labels)), labels)
        for i, row in enumerate(values):
            for j, value in enumerate(row):
                text = "–" if np.isnan(value) else f"{value:.2f}"
                dark = abs(value) > 0.6
                panel.text(
                    j,
                    i,
                    text,
                    ha="center",
                    va="center",
                    fontsize=7,
                    color="white" if dark else "black",
                )
        panel.spines[:].set_visible(False)
        panel.tick_params(length=0)
        bar = figure.colorbar(image, label="correlation", ticks=(-1.0, -0.5, 0.0, 0.5, 1.0))
        bar.ax.spines[:].set_visible(False)
    return figure


def pictograms_figure() -> Figure:
    """Fig. 2, I: the architectures; vanilla terms in outline, learned ones filled."""
    with styled():
        figure = new_figure(PAGE_IN, 2.2)
        panels = figure.subplots(1, len(ARCHITECTURES))
        for panel, name in zip(panels, ARCHITECTURES, strict=True):
            _pictogram(panel, name)
    return figure


def _pictogram(panel, name: str) -> None:
    panel.set(xlim=(0.0, 1.0), ylim=(0.0, 0.96), xticks=[], yticks=[])
    panel.set_title(name, fontweight="bold")
    panel.spines[:].set_visible(False)
    single = name == "T"

    def box(x: float, y: float, letter: str, learned: bool) -> None:
        face, ink = (COLOURS[0], "white") if learned else ("white", "black")
        style = {"boxstyle": "round,pad=0.35", "fc": face, "ec": "black", "lw": 0.7}
        panel.text(x, y, letter, ha="center", va="center", color=ink, bbox=style)

    def arrow(start: tuple[float, float], end: tuple[float, float]) -> None:
        panel.annotate(
            "",
            end,
            start,
            arrowprops={"arrowstyle": "-|>", "lw": 0.7, "shrinkA": 7, "shrinkB": 7, "color": "0.3"},
        )

    if not single:
        box(0.22, 0.84, "A", "A" in name)
        box(0.78, 0.84, "R", "R" in name)
        box(0.5, 0.6, "G", "G" in name)
        panel.text(
            0.5,
            0.36,
            "φ",
            ha="center",
            va="center",
            fontsize=9,
            bbox={"boxstyle": "circle,pad=0.25", "fc": "white", "ec": "0.3", "lw": 0.7},
        )
        arrow((0.22, 0.84), (0.5, 0.6))
        arrow((0.78, 0.84), (0.5, 0.6))
        arrow((0.5, 0.6), (0.5, 0.36))
        arrow((0.5, 0.36), (0.5, 0.1))
    else:
        panel.text(0.5, 0.6, "s", ha="center", va="center")
        arrow((0.5, 0.6), (0.5, 0.1))
    box(0.5, 0.1, "T" if "T" in name else "$F_a$", "T" in name)
