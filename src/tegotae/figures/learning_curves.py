"""Learning curves of algorithms on the same models, over episodes and over simulated time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.data import Table
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.metrics.statistics import interval
from tegotae.training.curves import LearningCurve, groups, shared, table

_LINES = ("-", "--", "-.", ":")


def algorithms_figure(curves: Sequence[LearningCurve]) -> Figure:
    """CoT⁻¹ during training: runs, their mean and its 95 % interval (Fig. 3 of the paper).

    One row of panels a model: on the left over episodes (of an agent) or generations (of an
    evolution), as in the paper; on the right over the simulated time that was learned from. Both
    axes are logarithmic; the point before any training is left out.

    Args:
        curves: of at least one run (`tegotae.training.curves.read_curves`).
    """
    models = sorted({curve.model for curve in curves})
    algorithms = sorted({curve.algorithm for curve in curves})
    found = groups(curves)
    with styled():
        figure = new_figure(PAGE_IN, 0.7 + 1.9 * len(models))
        panels = figure.subplots(len(models), 2, sharey="row", sharex="col", squeeze=False)
        for (by_episode, by_time), model in zip(panels, models, strict=True):
            for i, algorithm in enumerate(algorithms):
                if (model, algorithm) not in found:
                    continue
                mean = _mean(found[model, algorithm])
                look: dict[str, Any] = {
                    "color": COLOURS[i % len(COLOURS)],
                    "ls": _LINES[i % len(_LINES)],
                }
                trained = mean["simulated_s"] > 0.0
                look["marker"] = "o" if trained.sum() == 1 else ""
                for panel, x in ((by_episode, "episode"), (by_time, "simulated_s")):
                    at = mean[x][trained]
                    panel.fill_between(
                        at,
                        mean["low"][trained],
                        mean["high"][trained],
                        color=look["color"],
                        alpha=0.1,
                        lw=0,
                    )
                    for run in found[model, algorithm]:
                        moved = run.simulated_s > 0.0
                        x_run, y_run = getattr(run, x)[moved], run.cot_inverse[moved]
                        panel.plot(x_run, y_run, color=look["color"], lw=0.4, alpha=0.6)
                    panel.plot(at, mean["cot_inverse"][trained], label=algorithm, **look)
                    panel.set_xscale("log")
            by_episode.set_ylabel("CoT⁻¹ [m/J]")
            # Intervals of few runs reach far beyond what any run did.
            most = max(c.cot_inverse.max() for c in curves if c.model == model)
            by_episode.set_ylim(0.0, 1.1 * most if most > 0.0 else 1.0)
            by_episode.set_title(model, loc="left")
        panels[-1, 0].set_xlabel("episode, or generation of an evolution")
        panels[-1, 1].set_xlabel("simulated time learned from [s]")
        lines = {line.get_label(): line for panel in panels.flat for line in panel.get_lines()}
        figure.legend(
            [lines[name] for name in algorithms],
            algorithms,
            loc="outside lower center",
            ncols=1 if max(map(len, algorithms)) > 30 else len(algorithms),
        )
    return figure


def algorithms_tables(curves: Sequence[LearningCurve]) -> dict[str, Table]:
    """All points of all runs, and as `mean` what is drawn."""
    rows: dict[str, list[np.ndarray]] = {}
    for (model, algorithm), runs in groups(curves).items():
        mean = _mean(runs)
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


def _mean(runs: Sequence[LearningCurve]) -> dict[str, np.ndarray]:
    """Mean over runs with its interval, at the points that all have; a single run has none."""
    episode, simulated_s, values = shared(runs)
    found = [interval(row) for row in values]
    return {
        "episode": episode,
        "simulated_s": simulated_s,
        "cot_inverse": np.array([i.mean for i in found]),
        "low": np.array([i.low for i in found]),
        "high": np.array([i.high for i in found]),
    }
