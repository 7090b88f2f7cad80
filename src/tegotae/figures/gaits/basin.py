"""Basins of gaits: how common each is, and where the starts end on the torus of lags."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.gaits.basin import GaitBasin, GaitShare
from tegotae.figures.gaits.colours import by_side, gait_colour, gait_marker
from tegotae.figures.style import PAGE_IN, new_figure, styled
from tegotae.parts._shapes import AnyArray


def basin_figure(basin: GaitBasin, note: str = "") -> Figure:
    """Left the share of each outcome with its 95 % interval, right the lags that starts end at.

    Of two legs the lags are drawn over those of the release; of more, those of two legs over each
    other.

    Args:
        basin: what was found.
        note: the title.
    """
    outcomes = basin.outcomes
    with styled():
        figure = new_figure(PAGE_IN, 2.4)
        bars, torus = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        _shares(bars, outcomes, len(basin.gait), basin.legged.units[1])
        bars.set_title(note, loc="left")
        if basin.legged.body.limbs == 2:
            _from_release(torus, basin)
        else:
            _of_two_legs(torus, basin)
    return figure


def _shares(axes: Axes, outcomes: tuple[GaitShare, ...], starts: int, unit: str) -> None:
    for row, each in enumerate(outcomes):
        axes.barh(row, each.share, height=0.6, color=gait_colour(each.gait))
        axes.plot([each.low, each.high], [row, row], color="k", lw=0.8)
        locked = np.isfinite(each.lock_time_s)
        label = f"{each.count}" + (f", locks in {each.lock_time_s:.3g} {unit}" if locked else "")
        axes.text(1.03, row, label, va="center", fontsize=7, transform=axes.get_yaxis_transform())
    axes.set_yticks(range(len(outcomes)), [each.gait for each in outcomes])
    axes.set(xlim=(0.0, 1.0), ylim=(max(len(outcomes), 3) - 0.4, -0.6))
    axes.set_xlabel(f"share of {starts} random starts")


def _from_release(axes: Axes, basin: GaitBasin) -> None:
    reference, names = basin.legged.reference, basin.legged.names
    other = 1 - reference
    released = (basin.phase_rad[reference] - basin.phase_rad[other]) / (2.0 * np.pi) % 1.0
    _dots(axes, basin, released, _drawn(basin.found.lag[other]))
    axes.set_xlabel(f"lag of {names[other]} behind {names[reference]} at release [cycles]")
    axes.set_ylabel("and in the end [cycles]")


def _of_two_legs(axes: Axes, basin: GaitBasin) -> None:
    reference, names = basin.legged.reference, basin.legged.names
    order = by_side(names)
    at = order.index(reference)
    # The next leg of the same side, and the same leg of the other side.
    along, across = order[(at + 1) % len(order)], order[-1 - at]
    across = across if across not in (reference, along) else order[(at + 2) % len(order)]
    _dots(axes, basin, _drawn(basin.found.lag[along]), _drawn(basin.found.lag[across]))
    axes.set_xlabel(f"lag of {names[along]} behind {names[reference]} [cycles]")
    axes.set_ylabel(f"lag of {names[across]} [cycles]")


def _dots(axes: Axes, basin: GaitBasin, x: np.ndarray, y: np.ndarray) -> None:
    for outcome in basin.outcomes:
        own = basin.gait == outcome.gait
        colour, marker = gait_colour(outcome.gait), gait_marker(outcome.gait)
        axes.scatter(x[own], y[own], s=18, color=colour, marker=marker, lw=0, alpha=0.6)
    ticks = np.linspace(0.0, 1.0, 5)
    axes.set(xlim=(-0.13, 1.0), ylim=(-0.13, 1.0), xticks=ticks, yticks=ticks)
    axes.set_aspect("equal")


def _drawn(lag: AnyArray) -> np.ndarray:
    """Lags from -0.125 to 0.875, so that those beside zero are not torn apart."""
    return (np.asarray(lag) + 0.125) % 1.0 - 0.125
