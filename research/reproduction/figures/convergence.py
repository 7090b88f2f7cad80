"""Has training converged? Best fitness over episodes, and where and why each run stopped."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from tegotae._support.errors import TegotaeError
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.statistics import Interval, interval
from tegotae.training.evolution import CAP, PLATEAU

_ACROSS = 3
_COLOURS = {PLATEAU: COLOURS[5], CAP: COLOURS[4]}
_OTHER = COLOURS[6]


@dataclass(frozen=True)
class Trainings:
    """Fitness in the course of some runs of one kind.

    Args:
        episodes: simulated episodes spent, rising and above 0, shape [points].
        fitness: there, shape [points, runs]; NaN after a run has stopped.
        stop_episode: when each run stopped [episodes], shape [runs].
        reason: why, such as "plateau" or "cap", one per run.
    """

    episodes: np.ndarray
    fitness: np.ndarray
    stop_episode: np.ndarray
    reason: tuple[str, ...]

    def best(self) -> np.ndarray:
        """Return the best fitness so far, shape [points, runs]; a stopped run keeps its last value.

        NaN until a run has its first rollout that did not fail.
        """
        alive = np.where(self.fitness > 0.5 * FAILED_FITNESS, self.fitness, np.nan)
        return np.fmax.accumulate(alive, axis=0)

    def means(self) -> tuple[list[Interval], int]:
        """Return the mean of the best fitness at every point, and how many runs end below 0.

        These do not enter the mean, as the fitness of what does not hop would drown that of what
        does.
        """
        best = self.best()
        hops = best[-1] >= 0.0
        return [interval(row) for row in best[:, hops]], int((~hops).sum())


def convergence_figure(trainings: Mapping[str, Trainings]) -> Figure:
    """Draw the best fitness so far over simulated episodes, one panel per kind; runs, mean, 95 %
    interval.

    A run's line ends where it stopped, in a dot; the same place is marked along the bottom, in a
    colour that says why. A run that stopped stays in the mean with what it reached, so that the
    mean does not change because runs leave it. A panel says how many of its runs end below 0.

    Args:
        trainings: by name, such as the architecture's.

    Raises:
        TegotaeError: if there is nothing to draw.
    """
    if not trainings:
        raise TegotaeError("no trainings to draw; give at least one")
    highest = float(max(np.nanmax(t.best(), initial=0.0) for t in trainings.values()))
    across = min(_ACROSS, len(trainings))
    rows = -(-len(trainings) // across)
    with styled():
        figure = new_figure(PAGE_IN, 0.75 + 1.6 * rows)
        panels = figure.subplots(rows, across, sharex=True, sharey=True, squeeze=False)
        for panel in panels.flat[len(trainings) :]:
            panel.set_visible(False)
        for i, (panel, (name, training)) in enumerate(
            zip(panels.flat, trainings.items(), strict=False)
        ):
            _draw(panel, training)
            ends = ", ".join(f"{n} {why}" for why, n in Counter(training.reason).most_common())
            panel.set_title(f"{name}: {ends}", loc="left", fontsize=7)
            panel.set_xscale("log")
            if i + across >= len(trainings):
                panel.set_xlabel("episodes")
                panel.tick_params(labelbottom=True)
        panels[0, 0].set_ylim(0.0, 1.08 * (highest or 1.0))
        for row in panels:
            row[0].set_ylabel("best fitness so far")
        figure.legend(handles=_handles(trainings), loc="outside lower center", ncols=6)
    return figure


def convergence_table(trainings: Mapping[str, Trainings]) -> dict[str, np.ndarray]:
    """Return the data of the figure's means: a row per name and point, with the interval of the
    mean."""
    rows: dict[str, list] = {}
    for name, training in trainings.items():
        means, below = training.means()
        columns = {
            "name": [name] * len(means),
            "episodes": training.episodes,
            "best_fitness": [m.mean for m in means],
            "low": [m.low for m in means],
            "high": [m.high for m in means],
            "runs": [len(training.reason)] * len(means),
            "runs_below": [below] * len(means),
            "stopped_runs": [int(np.sum(training.stop_episode <= e)) for e in training.episodes],
        }
        for key, column in columns.items():
            rows.setdefault(key, []).extend(column)
    return {key: np.array(column) for key, column in rows.items()}


def _draw(panel: Axes, training: Trainings) -> None:
    colour, best, (means, below) = COLOURS[0], training.best(), training.means()
    low, high = [m.low for m in means], [m.high for m in means]
    panel.fill_between(training.episodes, low, high, color=colour, alpha=0.2, lw=0)
    for run, (stop, reason) in enumerate(zip(training.stop_episode, training.reason, strict=True)):
        on = training.episodes <= stop
        episodes, fitness, why = training.episodes[on], best[on, run], _COLOURS.get(reason, _OTHER)
        panel.plot(episodes, fitness, color=colour, lw=0.4, alpha=0.6)
        panel.plot(episodes[-1:], fitness[-1:], ".", ms=3.5, mew=0, color=why)
        panel.axvline(stop, 0.0, 0.09, lw=0.9, color=why)
    panel.plot(training.episodes, [m.mean for m in means], color=colour, lw=1.3)
    if below:
        words = f"{below} of {len(training.reason)} end below 0, not in the mean"
        panel.text(0.03, 0.97, words, transform=panel.transAxes, va="top", fontsize=6)


def _handles(trainings: Mapping[str, Trainings]) -> list:
    reasons = dict.fromkeys(reason for training in trainings.values() for reason in training.reason)
    others = ", ".join(reason for reason in reasons if reason not in _COLOURS)
    stops = {reason: colour for reason, colour in _COLOURS.items() if reason in reasons}
    stops |= {others: _OTHER} if others else {}
    return [
        Line2D([], [], color=COLOURS[0], lw=1.3, label="mean over runs"),
        Patch(color=COLOURS[0], alpha=0.2, lw=0, label="its 95 % interval"),
        Line2D([], [], color=COLOURS[0], lw=0.4, alpha=0.6, label="runs"),
        *(
            Line2D([], [], ls="", marker="|", ms=7, mew=1.0, color=colour, label=f"stopped: {why}")
            for why, colour in stops.items()
        ),
    ]
