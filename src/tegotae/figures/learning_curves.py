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

from tegotae.figures.style import COLOURS, PAGE_IN, Table, literal_text, new_figure, styled
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.statistics import UNBOUNDED, Interval, difference, interval
from tegotae.systems.registry import kinds
from tegotae.training.curves import COT, FITNESS, groups, late_mean, measure_of, shared

LABELS = {COT: "CoT⁻¹ [m/J]", FITNESS: "fitness"}
"""Labels of the vertical axis, by the quantity of the curves."""
_OTHERS = "0.72"
_BESIDE = 3  # panels side by side


@styled()
def algorithms_figure(curves: pd.DataFrame) -> Figure:
    """Draw CoT⁻¹, or the fitness, during training: runs, their mean and its 95 % interval (Fig. 3).

    One panel a model and algorithm, so that no interval hides another; the means of the other
    algorithms are grey lines behind. Below is the simulated time that was learned from, the same
    for all; above, where that is in episodes (of an agent) or generations (of an evolution), as in
    the paper. Both axes are logarithmic; the point before any training is left out.

    Args:
        curves: of at least one run (`tegotae.training.curves.read_curves`).
    """
    runs_of = groups(curves)
    means = {key: _mean(runs) for key, runs in runs_of.items()}
    algorithms, models = sorted(set(curves["algorithm"])), sorted(set(curves["model"]))
    measure = measure_of(curves)
    across = min(len(algorithms), _BESIDE)
    down = -(-len(algorithms) // across)
    figure = new_figure(PAGE_IN, 0.5 + 1.95 * len(models) * down)
    rows = figure.subplots(len(models) * down, across, sharex=True, squeeze=False)
    for m, (model, panels) in enumerate(zip(models, np.split(rows, len(models)), strict=True)):
        for panel in panels.flat[len(algorithms) :]:
            panel.set_visible(False)
        # Intervals of few runs reach far beyond what any run did.
        values = curves.loc[curves["model"] == model, measure].to_numpy()
        highest, lowest = float(values.max()), min(0.0, float(values.min()))
        room = 0.1 * (highest - lowest) or 1.0
        for i, (panel, algorithm) in enumerate(zip(panels.flat, algorithms, strict=False)):
            title, key = f"{model}: {_algorithm_title(algorithm)}", (model, algorithm)
            if len(title) >= 36:
                title = title.replace(": ", ":\n", 1)
            panel.set_title("\n".join(map(literal_text, title.split("\n"))), loc="left")
            panel.set(ylim=(lowest - room if lowest < 0.0 else 0.0, highest + room), xscale="log")
            panel.tick_params(labelleft=i % across == 0)
            if i % across == 0:
                panel.set_ylabel(LABELS[measure])
            for algorithm_name in algorithms:
                if algorithm_name != algorithm and (model, algorithm_name) in means:
                    _draw_mean(panel, means[model, algorithm_name], color=_OTHERS, lw=0.8)
            if key in means:
                colour = COLOURS[algorithms.index(algorithm) % len(COLOURS)]
                _draw_runs(panel, runs_of[key], means[key], colour)
                _draw_episodes(panel, means[key], labelled=m == 0 and i < across)
    for panel in rows[-1]:
        panel.set_xlabel("simulated time learned from [s]")
    several = any(len(runs) > 1 for runs in runs_of.values())
    handles = _handles(several, len(algorithms) > 1)
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _algorithm_title(name: str) -> str:
    """Return the title of an algorithm in a figure.

    Example:
        >>> _algorithm_title("pgpe, usual settings"), _algorithm_title("mine")
        ('PGPE, usual settings', 'mine')
    """
    first, comma, settings = name.partition(",")
    return getattr(kinds().get(first), "TITLE", first) + comma + settings


def _handles(several_runs: bool, several_algorithms: bool) -> list[Artist]:
    """Return the legend's entries for the drawn lines."""
    label = "mean over runs" if several_runs else "run"
    handles: list[Artist] = [Line2D([], [], color="black", lw=1.2, label=label)]
    if several_runs:
        handles.append(Patch(color="black", alpha=0.15, lw=0, label="its 95 % interval"))
        handles.append(Line2D([], [], color="black", lw=0.4, alpha=0.6, label="runs"))
    if several_algorithms:
        caption = "means of the other algorithms" if several_runs else "other algorithms"
        handles.append(Line2D([], [], color=_OTHERS, lw=0.8, label=caption))
    return handles


def _draw_runs(panel: Axes, runs: Sequence[pd.DataFrame], mean: pd.DataFrame, colour: str) -> None:
    """Draw an algorithm's interval, runs and mean."""
    later = mean[mean["simulated_s"] > 0.0]
    look = {"color": colour, "alpha": 0.15, "lw": 0, "zorder": 2.1}
    panel.fill_between(later["simulated_s"], later["low"], later["high"], **look)
    for run in runs:
        moved = run[run["simulated_s"] > 0.0]
        value = moved[measure_of(run)]
        panel.plot(moved["simulated_s"], value, color=colour, lw=0.4, alpha=0.6)
    _draw_mean(panel, mean, color=colour, lw=1.2, zorder=2.3)


def _draw_mean(panel: Axes, mean: pd.DataFrame, **look) -> None:
    """Draw a mean over simulated time, as a dot if there is only one point."""
    later = mean[mean["simulated_s"] > 0.0]
    marker = "o" if len(later) == 1 else ""
    panel.plot(later["simulated_s"], later["value"], marker=marker, **look)


def _draw_episodes(panel: Axes, mean: pd.DataFrame, *, labelled: bool) -> None:
    """Set an axis of episodes along the top; they are of one length, so the two scales differ
    by a factor.
    """
    last = mean.iloc[-1]
    if last["simulated_s"] > 0.0:
        per_s = last["episode"] / last["simulated_s"]
        top = panel.secondary_xaxis("top", functions=(lambda s: s * per_s, lambda e: e / per_s))
        top.tick_params(labelsize=6, pad=1)
        top.xaxis.set_minor_formatter(NullFormatter())  # labels within a decade overlap
        if labelled:
            top.set_xlabel("episode, or generation of an evolution", fontsize=6, labelpad=1)
        panel.spines["top"].set_visible(True)


def algorithms_tables(curves: pd.DataFrame) -> dict[str, Table]:
    """Return all points of all runs, and the drawn means as `mean`."""
    means = []
    for (model, algorithm), runs in groups(curves).items():
        mean = _mean(runs).rename(columns={"value": measure_of(curves)})
        means.append(mean.assign(algorithm=algorithm, model=model, runs=len(runs)))
    combined = pd.concat(means, ignore_index=True).set_index(["algorithm", "model", "runs"])
    return {"": curves, "mean": combined.reset_index()}


def algorithms_compared(curves: pd.DataFrame) -> pd.DataFrame:
    """Return, for late training, each algorithm, and how far PGPE is above it on the same model."""
    quantity = "CoT⁻¹" if measure_of(curves) == COT else "fitness"
    runs_of, rows = groups(curves), []
    for (model, algorithm), runs in sorted(runs_of.items(), key=lambda group: group[0]):
        pgpe = runs_of.get((model, "pgpe"), []) if algorithm != "pgpe" else []
        of_model = [
            run
            for (model_name, _), group in runs_of.items()
            if model_name == model
            for run in group
        ]
        shortest = min(float(run["simulated_s"].iloc[-1]) for run in of_model)
        row = {"model": model, "algorithm": algorithm, "runs": len(runs)}
        row["learned from"] = f"{runs[0]['simulated_s'].iloc[-1]:.0f} s"
        for when, time in (("at the end", np.inf), ("after equal time", shortest)):
            late, values = ([late_mean(run, time) for run in group] for group in (runs, pgpe))
            row[f"{quantity} {when}"] = _words(interval(late, within=_range(curves)))
            row[f"PGPE's lead {when}"] = _words(difference(values, late)) if pgpe else ""
        rows.append(row)
    return pd.DataFrame(rows).set_index(["model", "algorithm"])


def _words(mean: Interval) -> str:
    ends = "" if np.isnan(mean.low) else f" [{mean.low:.3f}, {mean.high:.3f}]"
    return f"{mean.mean:.3f}{ends}"


def _range(curves: pd.DataFrame) -> tuple[float, float]:
    return HOPPING.range_of(COT) if measure_of(curves) == COT else UNBOUNDED


def _mean(runs: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the mean over runs with its interval, at the points that all have; a single run
    has none.
    """
    episode, simulated_s, values = shared(runs)
    means = [interval(row, within=_range(runs[0])) for row in values]
    rows = [(mean.mean, mean.low, mean.high) for mean in means]
    frame = pd.DataFrame({"episode": episode, "simulated_s": simulated_s})
    frame[["value", "low", "high"]] = rows
    return frame
