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
from tegotae.measures.statistics import interval
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

    Raises:
        TegotaeError: for shapes that do not fit, or episodes that do not rise from above 0.
    """

    episodes: np.ndarray
    fitness: np.ndarray
    stop_episode: np.ndarray
    reason: tuple[str, ...]

    def __post_init__(self) -> None:
        points, runs = np.shape(self.episodes)[0], len(self.reason)
        if np.shape(self.fitness) != (points, runs) or np.shape(self.stop_episode) != (runs,):
            raise TegotaeError(
                f"fitness has shape {np.shape(self.fitness)} and stop_episode "
                f"{np.shape(self.stop_episode)}; {points} points and {runs} reasons need "
                f"({points}, {runs}) and ({runs},)"
            )
        if points == 0 or runs == 0:
            raise TegotaeError("no trainings to draw; give at least one run with one point")
        if not (self.episodes[0] > 0 and np.all(np.diff(self.episodes) > 0)):
            raise TegotaeError("episodes must rise, from above 0 on")

    def best(self) -> np.ndarray:
        """Return the best fitness so far, shape [points, runs]; a stopped run keeps its last value.

        NaN until a run has its first rollout that did not fail.
        """
        alive = np.where(self.fitness > 0.5 * FAILED_FITNESS, self.fitness, np.nan)
        return np.fmax.accumulate(alive, axis=0)


def convergence_figure(trainings: Mapping[str, Trainings], *, lowest: float = 0.0) -> Figure:
    """Draw the best fitness so far over simulated episodes, one panel per kind; runs, mean, 95 %
    interval.

    A run's line ends where it stopped, in a dot; the same place is marked along the bottom, in a
    colour that says why. A run that stopped stays in the mean with what it reached, so that the
    mean does not change because runs leave it.

    Args:
        trainings: by name, such as the architecture's.
        lowest: where the axis begins. Runs that end below it do not enter the mean, as the fitness
            of what does not hop would drown that of what does; the panel says how many they are.

    Raises:
        TegotaeError: if there is nothing to draw.
    """
    if not trainings:
        raise TegotaeError("no trainings to draw; give at least one")
    best = {name: training.best() for name, training in trainings.items()}
    highest = float(max(np.nanmax(b, initial=lowest) for b in best.values()))
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
            _draw(panel, training, best[name], lowest)
            panel.set_title(f"{name}: {_counts(training)}", loc="left", fontsize=7)
            below = int((~_is_visible(best[name], lowest)).sum())
            if below:
                words = f"{below} of {len(training.reason)} end below {lowest:g}, not in the mean"
                panel.text(0.03, 0.97, words, transform=panel.transAxes, va="top", fontsize=6)
            panel.set_xscale("log")
            if i + across >= len(trainings):
                panel.set_xlabel("episodes")
                panel.tick_params(labelbottom=True)
        panels[0, 0].set_ylim(lowest, lowest + 1.08 * (highest - lowest or 1.0))
        for row in panels:
            row[0].set_ylabel("best fitness so far")
        figure.legend(handles=_handles(trainings), loc="outside lower center", ncols=6)
    return figure


def convergence_table(
    trainings: Mapping[str, Trainings], *, lowest: float = 0.0
) -> dict[str, np.ndarray]:
    """Return the data of the figure's means: a row per name and point, with the interval of the
    mean."""
    rows: dict[str, list] = {}
    for name, training in trainings.items():
        best = training.best()
        means = [interval(row) for row in best[:, _is_visible(best, lowest)]]
        columns = {
            "name": [name] * len(means),
            "episodes": training.episodes,
            "best_fitness": [m.mean for m in means],
            "low": [m.low for m in means],
            "high": [m.high for m in means],
            "runs": [len(training.reason)] * len(means),
            "runs_below": [int((~_is_visible(best, lowest)).sum())] * len(means),
            "stopped_runs": [int(np.sum(training.stop_episode <= e)) for e in training.episodes],
        }
        for key, column in columns.items():
            rows.setdefault(key, []).extend(column)
    return {key: np.array(column) for key, column in rows.items()}


def _is_visible(best: np.ndarray, lowest: float) -> np.ndarray:
    """Return a mask of the runs that end at the lowest fitness shown, or above, shape [runs]."""
    return best[-1] >= lowest


def _draw(panel: Axes, training: Trainings, best: np.ndarray, lowest: float) -> None:
    colour = COLOURS[0]
    means = [interval(row) for row in best[:, _is_visible(best, lowest)]]
    low, high = (np.array(ends) for ends in zip(*((m.low, m.high) for m in means), strict=True))
    panel.fill_between(training.episodes, low, high, color=colour, alpha=0.2, lw=0)
    for run, (stop, reason) in enumerate(zip(training.stop_episode, training.reason, strict=True)):
        on = training.episodes <= stop
        panel.plot(training.episodes[on], best[on, run], color=colour, lw=0.4, alpha=0.6)
        colour = _COLOURS.get(reason, _OTHER)
        if on.any():
            panel.plot(
                training.episodes[on][-1], best[on, run][-1], ".", ms=3.5, mew=0, color=colour
            )
        panel.axvline(stop, 0.0, 0.09, lw=0.9, color=colour)
    panel.plot(training.episodes, [m.mean for m in means], color=colour, lw=1.3)


def _counts(training: Trainings) -> str:
    """Return the counts of runs by reason of their end, the most common first."""
    return ", ".join(f"{n} {reason}" for reason, n in Counter(training.reason).most_common())


def _handles(trainings: Mapping[str, Trainings]) -> list:
    reasons = dict.fromkeys(reason for training in trainings.values() for reason in training.reason)
    coloured = [reason for reason in _COLOURS if reason in reasons]
    uncoloured = [reason for reason in reasons if reason not in _COLOURS]
    stops = [(f"stopped: {reason}", _COLOURS[reason]) for reason in coloured]
    if uncoloured:
        stops.append((f"stopped: {', '.join(uncoloured)}", _OTHER))
    several = any(len(training.reason) > 1 for training in trainings.values())
    of_several = [
        Patch(color=COLOURS[0], alpha=0.2, lw=0, label="its 95 % interval"),
        Line2D([], [], color=COLOURS[0], lw=0.4, alpha=0.6, label="runs"),
    ]
    mean = "mean over runs" if several else "run"
    return [
        Line2D([], [], color=COLOURS[0], lw=1.3, label=mean),
        *(of_several if several else []),
        *(
            Line2D([], [], ls="", marker="|", ms=7, mew=1.0, color=colour, label=label)
            for label, colour in stops
        ),
    ]
