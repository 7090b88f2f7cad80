"""The study's figure: metrics per architecture, and how the metrics go together (Fig. 2)."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, Locator, MaxNLocator

from research.reproduction.claims.designs import MODELS, correlation_within_omega, designs
from research.reproduction.table import ARCHITECTURES, StudyTable
from tegotae.figures.style import COLOURS, COLUMN_IN, PAGE_IN, new_figure, styled
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.metric import FIGURE, Metric
from tegotae.measures.optimum import curve
from tegotae.measures.statistics import SHARE, Interval, balanced_difference, mean_defined

OBSERVATIONS = {"F": "$s = [F_k]$", "Fv": r"$s = [F_k, \dot y]$"}

_NOTE = (
    "At the top: share of the runs in which the metric is undefined [%], as they have no limit "
    "cycle or do not recover,\na line for each bar from left to right; the bar is the mean of the "
    "others.  0: a bar without height.  "
    "–: undefined in all runs."
)
_ROOM = 1.4
"""Height of a panel over its highest bar, interval or limit: above is a strip of numbers."""
_STRIP = 0.99
"""Height of the numbers, as a share of a panel's height."""
_LINE = 0.11
"""Height of a line of numbers: those of neighbouring bars would touch in one."""
_PANEL_IN, _LEGEND_IN = 1.0, 0.9
"""Height of a row of panels, and of what stands below them all [in]."""
_WIDE = 0.8
"""Width of an architecture's bars together."""
_LETTERS = 30
"""Names of this length together stand side by side below a panel."""
_LESS = 0.005
"""Share of runs without the metric that is too small to be mentioned."""


_OF_FORCE_ALONE = ("V", "VT", "A", "AT")
"""Architectures whose learned terms, if any, sense nothing but F_k."""


def architectures(table: StudyTable) -> tuple[str, ...]:
    """Return the table's architectures: those of the paper's figure first.

    That is models that learn A or R alone, and experiments beside the models.
    """
    held = dict.fromkeys(table["architecture"].tolist())
    return tuple(sorted(held, key=(*ARCHITECTURES, *held).index))


def frequencies(table: StudyTable) -> tuple[float | None, ...]:
    """Return the training frequencies ω_t in a table [rad/s], rising; None for rows without one
    comes last.
    """
    omegas = np.unique(table["omega_t"])
    defined = [float(omega) for omega in omegas[np.isfinite(omegas)]]
    return (*defined, *([None] if np.isnan(omegas).any() else []))


def architecture_metrics(
    table: StudyTable,
) -> dict[tuple[str, str, str, float | None], Interval]:
    """Return mean and interval per (observation, metric, architecture, ω_t): inputs of the
    actuation count alike.

    A value of ω_t stands for itself, as a body that can do little at one of them would hide what
    differs at another; the single network has none. Architectures that sense nothing but F_k (V and
    VT, A and AT) stand in both columns, as in the paper, and so does what senses something else.
    What a table does not hold has no entry. Where too few runs define a metric for an interval, it
    is their mean alone.
    """
    names = [metric.name for metric in table.metrics_shown(FIGURE)]
    intervals = {}
    for observation in OBSERVATIONS:
        for architecture in architectures(table):
            rows = table.where(architecture=architecture)
            if architecture not in _OF_FORCE_ALONE:
                rows = rows.where(observation=(observation, ""))
            for omega_t in frequencies(rows):
                cell = rows if omega_t is None else rows.where(omega_t=omega_t)
                for metric in names:
                    values = [design[metric] for design in designs(cell).values()]
                    within = HOPPING.range_of(metric)
                    mean = balanced_difference(values, single_is_exact=True, within=within)
                    undefined = int(np.isnan(cell[metric]).sum())
                    if np.isnan(mean.mean):
                        mean = dataclasses.replace(mean, mean=float(mean_defined(cell[metric])))
                    intervals[observation, metric, architecture, omega_t] = dataclasses.replace(
                        mean, count=len(cell) - undefined, undefined=undefined
                    )
    return intervals


def architectures_figure(table: StudyTable, only: str = "") -> Figure:
    """Draw every metric per architecture and ω_t, in its unit, with 95 % intervals (Fig. 2, II).

    The line in the panels of CoT⁻¹ is the physical limit (`largest_possible`). It is left out for
    another body or another definition of work than those whose optimum is known.

    Args:
        table: the study's runs.
        only: the one metric that is drawn, such as `cot_inverse`; by default all of the figure's.
    """
    intervals = architecture_metrics(table)
    metrics = [metric for metric in table.metrics_shown(FIGURE) if only in ("", metric.name)]
    limited = "optimum_share" in table.metrics and np.isfinite(table["optimum_share"]).any()
    omegas, names = frequencies(table), architectures(table)
    extra = set(table.beside_the_paper()["architecture"].tolist())
    colours = dict(zip(omegas, _colours(omegas), strict=True))
    with styled():
        figure = new_figure(PAGE_IN, _LEGEND_IN + _PANEL_IN * len(metrics))
        panels = figure.subplots(len(metrics), 2, sharex=True, sharey="row", squeeze=False)
        for row, metric in zip(panels, metrics, strict=True):
            row_intervals = {
                key: value for key, value in intervals.items() if key[1] == metric.name
            }
            limit = _LIMITS[metric.name]() if metric.name in _LIMITS and limited else None
            bottom, top = _ends(row_intervals.values(), [] if limit is None else [limit])
            for panel, observation in zip(row, OBSERVATIONS, strict=True):
                for place, architecture in enumerate(names):
                    bars = {
                        omega: row_intervals[observation, metric.name, architecture, omega]
                        for omega in omegas
                        if (observation, metric.name, architecture, omega) in row_intervals
                    }
                    _bars(panel, place, bars, colours, top - bottom)
                if limit is not None:
                    panel.axhline(limit, color="0.3", lw=0.8, ls="--")
            row[0].set_ylabel(_axis(metric))
            row[0].set_ylim(_ROOM * bottom, _ROOM * top)
            row[0].yaxis.set_major_locator(_ticks(metric, top))
        for panel, title in zip(panels[0], OBSERVATIONS.values(), strict=True):
            panel.set_title(title)
        for panel in panels.flat:
            panel.tick_params(axis="x", length=0)
        for panel in panels[-1]:
            panel.set_xticks(range(len(names)), names)
            if sum(map(len, names)) > _LETTERS:  # there may be many, and long ones
                panel.tick_params(axis="x", labelrotation=90)
        figure.align_ylabels(panels[:, 0])
        handles: list[Artist] = [
            Patch(color=colours[omega], lw=0, label=_omega_label(omega, extra)) for omega in omegas
        ]
        handles.append(Line2D([], [], color="black", lw=1.0, label="95 % interval over runs"))
        if limited:
            of_whom = " for the paper's hopper" if extra else ""
            limit = f"what is physically possible{of_whom}"
            handles.append(Line2D([], [], color="0.3", lw=0.8, ls="--", label=limit))
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=len(handles),
            title=_NOTE,
            title_fontsize=7,
        )
    return figure


def largest_possible() -> float:
    """Return the largest CoT⁻¹ that any force can have on the default hopper, at any frequency
    [m/J].
    """
    return float(np.max(curve()["cot_inverse"]))


_LIMITS = {"cot_inverse": largest_possible, "optimum_share": lambda: 1.0}
"""Upper limits of metrics, where they are known."""


def _axis(metric: Metric) -> str:
    """Return the label of a metric with its unit, beside its panel."""
    label = metric.math or metric.label
    if metric.unit:
        return f"{label} [{metric.unit}]"
    return f"{label}\n(share)" if metric.range == SHARE else label


def _omega_label(omega: float | None, extra: Collection[str]) -> str:
    if omega is None:
        return "no $\\omega_t$" if extra else "T, which has no $\\omega_t$"
    return rf"$\omega_t$ = {omega:g} rad/s"


def _colours(omegas: tuple[float | None, ...]) -> list[str]:
    """Return one colour per frequency, and grey for none."""
    palette = iter((COLOURS[3], COLOURS[0], COLOURS[5], COLOURS[6], COLOURS[4]) * len(omegas))
    return ["0.55" if omega is None else next(palette) for omega in omegas]


def _ends(values: Iterable[Interval], limits: Iterable[float]) -> tuple[float, float]:
    """Return a range from the lowest to the highest of the means, the ends of the intervals, zero
    and more.

    They are 0 and 1 if there is nothing but zeros.
    """
    ends = [end for v in values for end in (v.mean, v.low, v.high) if np.isfinite(end)]
    bottom, top = min([*ends, *limits, 0.0]), max([*ends, *limits, 0.0])
    return (bottom, top) if bottom < top else (0.0, 1.0)


def _ticks(metric: Metric, top: float) -> Locator:
    """Return a locator of few round numbers; for a share none beyond 1."""
    if metric.range[1] == 1.0 and top > 0.5:
        return FixedLocator([0.0, 0.5, 1.0])
    return MaxNLocator(3)


def _bars(
    panel: Axes,
    place: int,
    values: Mapping[float | None, Interval],
    colours: Mapping[float | None, str],
    span: float,
) -> None:
    """Draw the bars of one architecture, side by side around its place."""
    width = _WIDE / max(len(values), 2)
    for i, (omega, value) in enumerate(values.items()):
        x = place + (i - 0.5 * (len(values) - 1)) * width
        if np.isnan(value.mean):
            panel.text(x, 0.02 * span, "–", ha="center", va="bottom", fontsize=7)
            continue
        panel.bar(x, value.mean, width=0.92 * width, color=colours[omega], lw=0)
        if abs(value.mean) < 0.005 * span:
            panel.text(x, 0.02 * span, "0", ha="center", va="bottom", fontsize=6)
        if np.isfinite(value.low):
            panel.vlines(x, value.low, value.high, color="black", lw=1.0)
        share = value.undefined / max(value.undefined + value.count, 1)
        if share > _LESS:
            panel.text(
                x,
                _STRIP - _LINE * i,
                f"{100.0 * share:.0f}",
                transform=panel.get_xaxis_transform(),
                fontsize=4.5,
                color="0.25",
                ha="center",
                va="top",
            )


def correlations(table: StudyTable) -> np.ndarray:
    """Return the Pearson correlations of the metrics over all models, shape [metrics, metrics]."""
    models = table.per_model()
    names = [metric.name for metric in table.metrics_shown(FIGURE)]
    return np.array(
        [
            [1.0 if a == b else correlation_within_omega(models, a, b).mean for b in names]
            for a in names
        ]
    )


def correlation_figure(table: StudyTable) -> Figure:
    """Draw the correlation of the metrics over all models (Fig. 2, III)."""
    values = correlations(table)
    labels = [metric.math or metric.label for metric in table.metrics_shown(FIGURE)]
    with styled():
        figure = new_figure(COLUMN_IN, 1.0 + 0.3 * len(labels))
        panel = figure.subplots()
        image = panel.imshow(values, cmap="PuOr", vmin=-1.0, vmax=1.0, aspect="auto")
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
        if np.isnan(values).any():
            panel.set_xlabel(f"–: fewer than {MODELS} models define both, or all alike", fontsize=7)
        panel.spines[:].set_visible(False)
        panel.tick_params(length=0)
        bar = figure.colorbar(image, label="correlation", ticks=(-1.0, -0.5, 0.0, 0.5, 1.0))
        bar.ax.spines[:].set_visible(False)
    return figure


def pictograms_figure(table: StudyTable | None = None) -> Figure:
    """Draw the architectures; vanilla terms in outline, learned ones filled (Fig. 2, I).

    Args:
        table: the study's runs, for the paper's architectures that it holds; without it, for all.
    """
    names = ARCHITECTURES if table is None else architectures(table.of_the_paper())
    columns = min(len(names), len(ARCHITECTURES))
    rows = -(-len(names) // columns)
    with styled():
        figure = new_figure(PAGE_IN * columns / len(ARCHITECTURES), 2.2 * rows)
        panels = figure.subplots(rows, columns, squeeze=False).flat
        for panel, name in zip(panels, names, strict=False):
            _pictogram(panel, name)
        for panel in panels[len(names) :]:
            panel.set_visible(False)
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
