"""Maps and fronts of gaits, their basins, stability, and lost legs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.gaits.basin import GaitBasin, GaitShare
from tegotae.analysis.gaits.lesion import Aftermath
from tegotae.analysis.gaits.map import NO_BODY, Cells, GaitMap
from tegotae.analysis.gaits.stability import GaitStability, StabilityBranch
from tegotae.figures.gaits.style import (
    HATCHES,
    MARKERS,
    THIN,
    by_side,
    gait_colour,
    gait_marker,
    label,
)
from tegotae.figures.maps import quantities
from tegotae.figures.style import COLOURS, COLUMN_IN, PAGE_IN, literal, new_figure, styled
from tegotae.measures.gaits.names import (
    AS_RELEASED,
    NO_GAIT,
    NOT_LOCKED,
    STANDING,
)
from tegotae.parts._shapes import AnyArray
from tegotae.systems.tuned import FORCED

_PALE = 0.55
"""How far towards white the colour of a cell is whose starts disagree."""
_COMMON = 0.002
"""Share of the cells below which a gait is not in the legend."""


def map_figure(found: GaitMap, note: str = "") -> Figure:
    """The gait of most starts, pale where they disagree; one lag of it; and its cost of transport.

    The lag is that of the next leg on the reference leg's side: of four legs the fore leg's behind
    the hind one's. Of a body that does not travel, the time to lock is in the cost's place.

    Args:
        found: the map.
        note: the title.
    """
    cells = found.cells
    with styled():
        figure = new_figure(PAGE_IN, 3.1)
        gaits, lag, cost = figure.subplots(1, 3, sharex=True, sharey=True)
        _gaits(figure, gaits, found, cells)
        gaits.set_title(note, loc="left")
        _lag(figure, lag, found, cells)
        _quantity(figure, cost, found, cells)
        gaits.set_ylabel(label(found.y, found.legged))
        for axes in (gaits, lag, cost):
            axes.set_xlabel(label(found.x, found.legged))
            axes.spines[["top", "right"]].set_visible(True)
            axes.set_facecolor("0.92")
    return figure


def _gaits(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    colours = np.array([_rgb(name) for name in cells.gait.ravel()]).reshape(*cells.gait.shape, 3)
    split = (cells.share < 1.0)[..., None]
    shown = np.where(split, colours + _PALE * (1.0 - colours), colours)
    axes.pcolormesh(*_grid(found), shown, rasterized=True)
    for name, hatch in HATCHES.items():
        if (cells.gait == name).sum() > 1 and min(cells.gait.shape) > 1:
            inside = (cells.gait == name).astype(float)
            area = axes.contourf(*_grid(found), inside, (0.5, 1.5), hatches=[hatch], colors="none")
            area.set(**THIN)
    names, counts = np.unique(cells.gait, return_counts=True)
    listed = [
        str(names[i])
        for i in np.lexsort((-counts, np.isin(names, (*NO_GAIT, NO_BODY))))
        if counts[i] >= _COMMON * cells.gait.size
    ]
    handles = [
        Patch(facecolor=_rgb(n), edgecolor="0.4", lw=0.4, label=n, hatch=HATCHES.get(n), **THIN)
        for n in listed
    ]
    if split.any():
        handles.append(Patch(fill=False, lw=0, label="(pale where starts disagree)"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=1.2)


def _lag(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    names, reference = found.legged.names, found.legged.reference
    order = by_side(names)
    leg = order[(order.index(reference) + 1) % len(order)]
    # Lags of what does not lock, or of starts that only share a name, would say nothing.
    locked = ~np.isin(cells.gait, (NOT_LOCKED, STANDING, AS_RELEASED))
    values = np.ma.masked_invalid(np.where(locked, cells.lag[..., leg], np.nan))
    mesh = axes.pcolormesh(*_grid(found), values, cmap="twilight", vmin=0, vmax=1, rasterized=True)
    bar = figure.colorbar(mesh, ax=axes, location="top", aspect=30, ticks=np.linspace(0, 1, 5))
    bar.set_label(f"lag of {names[leg]} behind {names[reference]} [cycles]")


def _quantity(figure: Figure, axes: Axes, found: GaitMap, cells: Cells) -> None:
    travels = np.isfinite(cells.cost_of_transport).any()
    values = cells.cost_of_transport if travels else cells.lock_time_s
    known = values[np.isfinite(values)]
    # A body that hardly moves has any cost: the scale ends where nine tenths of the cells do.
    low, high = np.quantile(known, (0.0, 0.9)) if known.size else (0.0, 1.0)
    mesh = axes.pcolormesh(
        *_grid(found),
        np.ma.masked_invalid(values),
        cmap=quantities(),
        vmin=low,
        vmax=high,
        rasterized=True,
    )
    what = "cost of transport" if travels else f"time to lock [{found.legged.units[1]}]"
    figure.colorbar(mesh, ax=axes, location="top", aspect=30, label=what, extend="max")


def _grid(found: GaitMap) -> tuple[np.ndarray, np.ndarray]:
    return np.array(found.x.values), np.array(found.y.values)


def _rgb(name: str) -> tuple[float, float, float]:
    return to_rgb("#FFFFFF" if name == NO_BODY else gait_colour(name))


_FREE = ("vanilla", "cosine", "vanilla ellipse")
_SHADES = ("0.3", "0.55", "0.75")
"""Their greys: colours, and black, are those of gaits."""


def front_figure(table: Mapping[str, np.ndarray], note: str = "") -> Figure:
    """Cost of transport over speed, each family's.

    Solid lines are of legs with feedback, dashed ones of legs that are forced into a gait. A speed
    that a family does not reach interrupts its line.

    Args:
        table: fronts of a system (`tegotae.measures.fronts.COLUMNS`).
        note: the title.
    """
    family, speed, cost = table["family"], table["speed"], table["cost_of_transport"]
    names = list(dict.fromkeys(family.tolist()))
    with styled():
        figure = new_figure(COLUMN_IN * 1.2, 2.6 + 0.09 * len(names))
        axes = figure.subplots()
        for name in sorted(names, key=lambda name: name not in _FREE):
            own = family == name
            order = np.argsort(speed[own])
            x, y = speed[own][order], cost[own][order]
            apart = np.flatnonzero(np.diff(x) > _APART) + 1
            x, y = (np.insert(values, apart, np.nan) for values in (x, y))
            forced = name.startswith(FORCED)
            gait = name.removeprefix(FORCED)
            colour = gait_colour(gait) if forced else _SHADES[_FREE.index(name)]
            axes.plot(
                x,
                y,
                "--" if forced else "-",
                color=colour,
                lw=0.7 if forced else 1.4,
                marker=gait_marker(gait) if forced else "o",
                ms=2.5,
                label=name,
            )
        axes.set_yscale("log")
        axes.set_yticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
        axes.set_yticks([], minor=True)
        axes.set_ylim(0.8 * np.min(cost), 1.25 * np.max(cost))
        axes.set(xlabel="speed [√(g l0)]", ylabel="cost of transport", title=note)
        figure.legend(loc="outside lower center", ncols=2)
    return figure


_TICKS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0)
_APART = 0.1001
"""Speeds farther apart than two bins are not joined [√(g l0)]."""


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


def stability_figure(found: GaitStability, note: str = "") -> Figure:
    """Above the moduli of all multipliers, the largest filled; below what the fit leaves over.

    Lines join the largest ones. A cross marks where the largest multiplier crosses one. In between,
    a row a gait, are the values at which the body, unkicked, stays in it to the end.

    Args:
        found: the return maps.
        note: the title.
    """
    with styled():
        rows = 0.12 * len(found.branches)
        figure = new_figure(COLUMN_IN, 3.4 + rows)
        moduli, stays, residual = figure.subplots(
            3, 1, sharex=True, height_ratios=(2.4, 0.9 * rows, 1.0)
        )
        values = np.array(found.over.values)
        _stays(stays, values, found)
        moduli.axhline(1.0, color="0.6", lw=0.6, zorder=0)
        for branch in found.branches:
            if np.isfinite(branch.largest).any():
                _moduli(moduli, values, branch)
                shown = [each.residual for each in branch.maps]
                _line(residual, values, shown, branch.gait)
        for each in found.crossings:
            moduli.plot(each.at, 1.0, "x", color="k", ms=5, mew=0.8, zorder=3)
        moduli.set_ylabel("|multipliers| per cycle")
        moduli.set_ylim(bottom=0.0)
        moduli.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, title=note or None)
        residual.set(ylim=(0.0, 1.0), ylabel="unexplained")
        residual.set_xlabel(label(found.over, found.legged))
        residual.set_xlim(values[0], values[-1])
    return figure


def _moduli(axes: Axes, values: np.ndarray, branch: StabilityBranch) -> None:
    colour, marker = gait_colour(branch.gait), gait_marker(branch.gait)
    _line(axes, values, branch.largest, branch.gait)
    for each in np.abs([m.multipliers for m in branch.maps]).T[1:]:
        axes.plot(values, each, marker, color=colour, ms=2.6, mew=0.5, fillstyle="none")


def _stays(axes: Axes, values: np.ndarray, found: GaitStability) -> None:
    for row, branch in enumerate(found.branches):
        there = values[branch.stays]
        axes.plot(
            there,
            np.full(there.size, row),
            "s",
            color=gait_colour(branch.gait),
            ms=3,
            clip_on=False,
        )
    axes.set(ylim=(len(found.branches) - 0.4, -0.6), yticks=[])
    axes.set_ylabel("stays", rotation=0, ha="right", va="center")
    axes.tick_params(axis="x", length=0)


def _line(axes: Axes, values: np.ndarray, shown: object, gait: str) -> None:
    colour, marker = gait_colour(gait), gait_marker(gait)
    axes.plot(values, np.asarray(shown), marker + "-", color=colour, ms=3, lw=0.8, label=gait)


def lesion_figure(found: Aftermath, note: str = "") -> Figure:
    """Left the shares of starts that stand, and that are locked, over time; right the lags.

    Args:
        found: what followed.
        note: the title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.5)
        shares, lags = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
        _shares_lesion(shares, found)
        shares.set_title(note, loc="left")
        _lags(lags, found)
    return figure


def _shares_lesion(axes: Axes, found: Aftermath) -> None:
    time = found.legged.units[1]
    end = found.timing.duration_s - found.lesion.at_s
    stood = found.stood
    fell = np.where(stood, found.after.fall_time_s, np.nan)[stood]
    locked = found.after.lock_time_s[stood]
    at = np.linspace(0.0, end, 400)
    if stood.any():
        standing = 1.0 - (fell[None] <= at[:, None]).mean(axis=1)
        again = (locked[None] <= at[:, None]).mean(axis=1)
        axes.plot(at, standing, color=COLOURS[0], label="standing")
        axes.plot(at, again, "--", color=COLOURS[1], label="locked for good")
        _, low, high = found.share
        axes.errorbar(
            end, found.share[0], [[found.share[0] - low], [high - found.share[0]]],
            color=COLOURS[0], capsize=2, lw=0.8, clip_on=False,
        )  # fmt: skip
    axes.set(xlim=(0.0, end), ylim=(-0.02, 1.04))
    axes.set_xlabel(f"time since {literal(found.lesion.label)} [{time}]")
    axes.set_ylabel(f"share of {int(stood.sum())} starts that stood")
    axes.legend(loc="center right")


def _lags(axes: Axes, found: Aftermath) -> None:
    names, reference = found.legged.names, found.reference
    order = [leg for leg in by_side(names) if leg != reference]
    for row, leg in enumerate(order):
        colour, marker = COLOURS[row % len(COLOURS)], MARKERS[row % len(MARKERS)]
        before = found.before.lag[leg][found.stood] % 1.0
        axes.plot(before, np.full(before.size, row - 0.14), marker, color=colour, ms=3.4,
                  mew=0.6, fillstyle="none")  # fmt: skip
        if leg in found.left:
            after = found.after.lag[found.left.index(leg)][found.stays] % 1.0
            axes.plot(after, np.full(after.size, row + 0.14), marker, color=colour, ms=3.0)
    axes.set_yticks(range(len(order)), [names[leg] for leg in order])
    axes.set(xlim=(-0.02, 1.02), ylim=(len(order) - 0.5, -0.5), xticks=np.linspace(0, 1, 5))
    axes.set_xlabel(f"lag behind {names[reference]} [cycles]: open before, filled after")
