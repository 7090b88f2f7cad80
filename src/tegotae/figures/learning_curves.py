"""Learning curves of algorithms on the same models, over simulated time and over episodes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from tegotae.figures.style import COLOURS, PAGE_IN, Table, literal, new_figure, styled
from tegotae.measures.hopping.registry import range_of
from tegotae.measures.hopping.statistics import UNBOUNDED, Interval, difference, interval
from tegotae.training.curves import COT, FITNESS, LearningCurve, groups, shared, table

LABELS = {COT: "CoT⁻¹ [m/J]", FITNESS: "fitness"}
"""What the vertical axis is called, by the measure of the curves."""
_TITLES = {
    "pgpe": "PGPE",
    "cma-es": "CMA-ES",
    "openai-es": "OpenAI-ES",
    "ppo": "PPO",
    "sac": "SAC",
}
"""Algorithms as they are written."""
_OTHERS = "0.72"
_BESIDE = 3  # panels side by side


def algorithms_figure(curves: Sequence[LearningCurve]) -> Figure:
    """CoT⁻¹, or the fitness, during training: runs, their mean and its 95 % interval (Fig. 3).

    One panel a model and algorithm, so that no interval hides another; the means of the other
    algorithms are grey lines behind. Below is the simulated time that was learned from, the same
    for all; above, where that is in episodes (of an agent) or generations (of an evolution), as in
    the paper. Both axes are logarithmic; the point before any training is left out.

    Args:
        curves: of at least one run (`tegotae.training.curves.read_curves`).
    """
    found = groups(curves)
    algorithms = sorted({curve.algorithm for curve in curves})
    models = sorted({curve.model for curve in curves})
    across = min(len(algorithms), _BESIDE)
    down = -(-len(algorithms) // across)
    rows = len(models) * down
    measure = curves[0].measure
    with styled():
        figure = new_figure(PAGE_IN, 0.5 + 1.95 * rows)
        panels = figure.subplots(rows, across, sharex=True, sharey=False, squeeze=False)
        for m, model in enumerate(models):
            own = panels[m * down : (m + 1) * down].ravel()
            for panel in own[len(algorithms) :]:
                panel.set_visible(False)
            means = {a: _mean(found[model, a]) for a in algorithms if (model, a) in found}
            # Intervals of few runs reach far beyond what any run did.
            values = np.concatenate([c.value for c in curves if c.model == model])
            most, least = float(values.max()), min(0.0, float(values.min()))
            for i, (panel, algorithm) in enumerate(zip(own, algorithms, strict=False)):
                name = algorithm_title(algorithm)
                title = f"{model}: {name}"
                title = title if len(title) < 36 else f"{model}:\n{name}"
                panel.set_title("\n".join(map(literal, title.split("\n"))), loc="left")
                room = 0.1 * (most - least) or 1.0
                panel.set_ylim(least - room if least < 0.0 else 0.0, most + room)
                panel.set_xscale("log")
                if i % across:
                    panel.tick_params(labelleft=False)
                else:
                    panel.set_ylabel(LABELS[measure])
                for other, mean in means.items():
                    if other != algorithm:
                        _line(panel, mean, color=_OTHERS, lw=0.8)
                if algorithm in means:
                    colour = COLOURS[algorithms.index(algorithm) % len(COLOURS)]
                    _draw(
                        panel,
                        found[model, algorithm],
                        means[algorithm],
                        colour,
                        m == 0 and i < across,
                    )
        for panel in panels[-1]:
            panel.set_xlabel("simulated time learned from [s]")
        several = any(len(runs) > 1 for runs in found.values())
        figure.legend(
            handles=_handles(several, len(algorithms) > 1), loc="outside lower center", ncols=4
        )
    return figure


def algorithm_title(name: str) -> str:
    """An algorithm as it is written in a figure.

    Example:
        >>> algorithm_title("pgpe, usual settings"), algorithm_title("mine")
        ('PGPE, usual settings', 'mine')
    """
    first, comma, rest = name.partition(",")
    return _TITLES.get(first, first) + comma + rest


def _handles(several_runs: bool, several_algorithms: bool) -> list[Artist]:
    """The legend, of what is drawn."""
    if not several_runs:
        handles: list[Artist] = [Line2D([], [], color="black", lw=1.2, label="run")]
    else:
        handles = [
            Line2D([], [], color="black", lw=1.2, label="mean over runs"),
            Patch(color="black", alpha=0.15, lw=0, label="its 95 % interval"),
            Line2D([], [], color="black", lw=0.4, alpha=0.6, label="runs"),
        ]
    if several_algorithms:
        others = "means of the other algorithms" if several_runs else "other algorithms"
        handles.append(Line2D([], [], color=_OTHERS, lw=0.8, label=others))
    return handles


def _draw(
    panel: Axes,
    runs: Sequence[LearningCurve],
    mean: dict[str, np.ndarray],
    colour: str,
    first_row: bool,
) -> None:
    """An algorithm's interval, runs and mean, and its episodes along the top."""
    trained = mean["simulated_s"] > 0.0
    low, high = mean["low"][trained], mean["high"][trained]
    panel.fill_between(
        mean["simulated_s"][trained], low, high, color=colour, alpha=0.15, lw=0, zorder=2.1
    )
    for run in runs:
        moved = run.simulated_s > 0.0
        panel.plot(run.simulated_s[moved], run.value[moved], color=colour, lw=0.4, alpha=0.6)
    _line(panel, mean, color=colour, lw=1.2, zorder=2.3)
    if trained.any():
        # Episodes are of one length, so the two scales differ by a factor.
        per_s = mean["episode"][trained][-1] / mean["simulated_s"][trained][-1]
        top = panel.secondary_xaxis("top", functions=(lambda s: s * per_s, lambda e: e / per_s))
        top.tick_params(labelsize=6, pad=1)
        top.xaxis.set_minor_formatter(NullFormatter())  # labels within a decade overlap
        if first_row:
            top.set_xlabel("episode, or generation of an evolution", fontsize=6, labelpad=1)
        panel.spines["top"].set_visible(True)


def _line(panel: Axes, mean: dict[str, np.ndarray], **look) -> None:
    """A mean over simulated time; a dot where there is only one point."""
    trained = mean["simulated_s"] > 0.0
    look["marker"] = "o" if trained.sum() == 1 else ""
    panel.plot(mean["simulated_s"][trained], mean["value"][trained], **look)


def algorithms_tables(curves: Sequence[LearningCurve]) -> dict[str, Table]:
    """All points of all runs, and as `mean` what is drawn."""
    rows: dict[str, list[np.ndarray]] = {}
    for (model, algorithm), runs in groups(curves).items():
        mean = _mean(runs)
        mean = {curves[0].measure if name == "value" else name: x for name, x in mean.items()}
        n = len(mean["episode"])
        own = {
            "algorithm": np.repeat(algorithm, n),
            "model": np.repeat(model, n),
            "runs": np.repeat(len(runs), n),
            **mean,
        }
        for name, column in own.items():
            rows.setdefault(name, []).append(column)
    return {
        "": table(curves),
        "mean": {name: np.concatenate(columns) for name, columns in rows.items()},
    }


def algorithms_compared(curves: Sequence[LearningCurve]) -> pd.DataFrame:
    """Late in training: each algorithm, and how far PGPE is above it on the same model."""
    is_cot = curves[0].measure == COT
    within, called = (range_of(COT), "CoT⁻¹") if is_cot else (UNBOUNDED, "fitness")
    runs_of = groups(curves)
    shortest: dict[str, float] = {}
    for curve in curves:
        end_s = float(curve.simulated_s[-1])
        shortest[curve.model] = min(end_s, shortest.get(curve.model, np.inf))
    rows = []
    for (model, algorithm), runs in sorted(runs_of.items()):
        pgpe = runs_of.get((model, "pgpe"), []) if algorithm != "pgpe" else []
        row = {"model": model, "algorithm": algorithm, "runs": len(runs)}
        row["learned from"] = f"{runs[0].simulated_s[-1]:.0f} s"
        for when, time in (("at the end", np.inf), ("after equal time", shortest[model])):
            late, others = ([run.late_mean(time) for run in group] for group in (runs, pgpe))
            row[f"{called} {when}"] = _words(interval(late, within=within))
            row[f"PGPE's lead {when}"] = _words(difference(others, late)) if pgpe else ""
        rows.append(row)
    return pd.DataFrame(rows).set_index(["model", "algorithm"])


def _words(mean: Interval) -> str:
    ends = "" if np.isnan(mean.low) else f" [{mean.low:.3f}, {mean.high:.3f}]"
    return f"{mean.mean:.3f}{ends}"


def _mean(runs: Sequence[LearningCurve]) -> dict[str, np.ndarray]:
    """Mean over runs with its interval, at the points that all have; a single run has none."""
    episode, simulated_s, values = shared(runs)
    within = range_of(COT) if runs[0].measure == COT else UNBOUNDED
    found = [interval(row, within=within) for row in values]
    return {
        "episode": episode,
        "simulated_s": simulated_s,
        "value": np.array([i.mean for i in found]),
        "low": np.array([i.low for i in found]),
        "high": np.array([i.high for i in found]),
    }
