"""Maps and fronts of gaits, their basins and stability."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.gaits.map import NO_BODY, GaitMap
from tegotae.analysis.gaits.releases import Releases
from tegotae.analysis.gaits.stability import GaitStability
from tegotae.figures.gaits.style import HATCHED, HATCHES, by_side, gait_colour, gait_marker, label
from tegotae.figures.maps import quantities
from tegotae.figures.style import COLUMN_IN, PAGE_IN, new_figure, styled
from tegotae.measures.gaits.names import AS_RELEASED, NO_GAIT, NOT_LOCKED, STANDING
from tegotae.systems.tuned import FORCED

_PALE = 0.55
"""Lightening towards white of the colour of a cell whose starts disagree."""
_COMMON = 0.002
"""Share of the cells below which a gait is not in the legend."""


@styled()
def map_figure(gait_map: GaitMap, note: str = "") -> Figure:
    """Draw the gait of most starts, pale where they disagree; one lag of it; and its cost of
    transport.

    The lag is that of the next leg on the reference leg's side: of four legs the fore leg's behind
    the hind one's. Of a body that does not travel, the time to lock is in the cost's place.

    Args:
        gait_map: the map.
        note: the title.
    """
    shape = len(gait_map.y.values), len(gait_map.x.values)
    cells = {name: x.to_numpy().reshape(shape) for name, x in gait_map.cells.items()}
    grid = np.array(gait_map.x.values), np.array(gait_map.y.values)
    figure = new_figure(PAGE_IN, 3.1)
    gaits, *quantity_axes = figure.subplots(1, 3, sharex=True, sharey=True)
    _gaits(figure, gaits, grid, cells)
    gaits.set_title(note, loc="left")
    gaits.set_ylabel(label(gait_map.y, gait_map.legged))
    for axes, panel in zip(
        quantity_axes, (_lag(gait_map, cells), _quantity(gait_map, cells)), strict=True
    ):
        values, title, scale, bar = panel
        defined = np.ma.masked_invalid(values)
        mesh = axes.pcolormesh(*grid, defined, rasterized=True, **scale)
        figure.colorbar(mesh, ax=axes, location="top", aspect=30, label=title, **bar)
    for axes in (gaits, *quantity_axes):
        axes.set_xlabel(label(gait_map.x, gait_map.legged))
        axes.spines[["top", "right"]].set_visible(True)
        axes.set_facecolor("0.92")
    return figure


_Grid = tuple[np.ndarray, np.ndarray]
Cells = Mapping[Any, np.ndarray]
"""Numbers of every cell, [rows, columns]."""


def _gaits(figure: Figure, axes: Axes, grid: _Grid, cells: Cells) -> None:
    gait = cells["gait"]
    colours = np.array([_rgb(name) for name in gait.ravel()]).reshape(*gait.shape, 3)
    split = (cells["share"] < 1.0)[..., None]
    colours_shown = np.where(split, colours + _PALE * (1.0 - colours), colours)
    axes.pcolormesh(*grid, colours_shown, rasterized=True)
    for name, hatch in HATCHES.items():
        inside = (gait == name).astype(float)
        if inside.sum() > 1 and min(gait.shape) > 1:
            area = axes.contourf(*grid, inside, (0.5, 1.5), hatches=[hatch], colors="none")
            area.set(**HATCHED)
    names, counts = np.unique(gait.astype(str), return_counts=True)
    order = np.lexsort((-counts, np.isin(names, (*NO_GAIT, NO_BODY))))
    listed = [str(names[i]) for i in order if counts[i] >= _COMMON * gait.size]
    handles = [Patch(facecolor=_rgb(n), label=n, hatch=HATCHES.get(n), **HATCHED) for n in listed]
    if split.any():
        handles.append(Patch(fill=False, lw=0, label="(pale where starts disagree)"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=1.2)


Shown = tuple[np.ndarray, str, dict[str, Any], dict[str, Any]]
"""Values, what they are, and how they and their colours are drawn."""


def _lag(gait_map: GaitMap, cells: Cells) -> Shown:
    names, reference = gait_map.legged.names, gait_map.legged.reference
    order = by_side(names)
    leg = names[order[(order.index(reference) + 1) % len(order)]]
    # Lags of what does not lock, or of starts that only share a name, would say nothing.
    unlocked = np.isin(cells["gait"].astype(str), (NOT_LOCKED, STANDING, AS_RELEASED))
    values = np.where(unlocked, np.nan, cells[f"lag_cycles_{leg}"])
    label = f"lag of {leg} behind {names[reference]} [cycles]"
    return (
        values,
        label,
        {"cmap": "twilight", "vmin": 0, "vmax": 1},
        {"ticks": np.linspace(0, 1, 5)},
    )


def _quantity(gait_map: GaitMap, cells: Cells) -> Shown:
    travels = np.isfinite(cells["cost_of_transport"]).any()
    values = cells["cost_of_transport" if travels else "lock_time_s"]
    defined = values[np.isfinite(values)]
    # A body that hardly moves has any cost: the scale ends where nine tenths of the cells do.
    low, high = np.quantile(defined, (0.0, 0.9)) if defined.size else (0.0, 1.0)
    label = "cost of transport" if travels else f"time to lock [{gait_map.legged.units[1]}]"
    return values, label, {"cmap": quantities(), "vmin": low, "vmax": high}, {"extend": "max"}


def _rgb(name: str) -> tuple[float, float, float]:
    return to_rgb("#FFFFFF" if name == NO_BODY else gait_colour(name))


_FREE = ("vanilla", "cosine", "vanilla ellipse")
_SHADES = ("0.3", "0.55", "0.75")
"""Their greys: colours, and black, are those of gaits."""


@styled()
def front_figure(table: Mapping[str, Any] | pd.DataFrame, note: str = "") -> Figure:
    """Draw each family's cost of transport over speed.

    Solid lines are of legs with feedback, dashed ones of legs that are forced into a gait. A speed
    that a family does not reach interrupts its line.

    Args:
        table: fronts of a system (`tegotae.measures.fronts.COLUMNS`).
        note: the title.
    """
    family, speed, cost = (
        np.asarray(table[name]) for name in ("family", "speed", "cost_of_transport")
    )
    names = list(dict.fromkeys(family.tolist()))
    figure = new_figure(COLUMN_IN * 1.2, 2.6 + 0.09 * len(names))
    axes = figure.subplots()
    for name in sorted(names, key=lambda name: name not in _FREE):
        mask = family == name
        order = np.argsort(speed[mask])
        x, y = speed[mask][order], cost[mask][order]
        gaps = np.flatnonzero(np.diff(x) > _APART) + 1
        x, y = (np.insert(values, gaps, np.nan) for values in (x, y))
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
    axes.set(yscale="log", yticks=_TICKS, yticklabels=[f"{tick:g}" for tick in _TICKS])
    axes.set_yticks([], minor=True)
    axes.set_ylim(0.8 * np.min(cost), 1.25 * np.max(cost))
    axes.set(xlabel="speed [√(g l0)]", ylabel="cost of transport", title=note)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


_TICKS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0)
_APART = 0.1001
"""Speeds farther apart than two bins are not joined [√(g l0)]."""


@styled()
def gait_basin_figure(basin: Releases, note: str = "") -> Figure:
    """Draw the share of each outcome with its 95 % interval (left), and the lags at which starts
    end (right).

    Of two legs the lags are drawn over those of the release; of more, those of two legs over each
    other.

    Args:
        basin: what was found.
        note: the title.
    """
    outcomes = basin.outcomes
    figure = new_figure(PAGE_IN, 2.4)
    bars, torus = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    _shares(bars, outcomes, len(basin.frame), basin.legged.units[1])
    bars.set_title(note, loc="left")
    if basin.legged.body.limbs == 2:
        _from_release(torus, basin)
    else:
        _draw_two_legs(torus, basin)
    return figure


def _shares(axes: Axes, outcomes: Any, starts: int, unit: str) -> None:
    for row, outcome in enumerate(outcomes.itertuples()):
        axes.barh(row, outcome.share, height=0.6, color=gait_colour(outcome.gait))
        axes.plot([outcome.low, outcome.high], [row, row], color="k", lw=0.8)
        locked = np.isfinite(outcome.lock_time_s)
        label = f"{outcome.count}" + (
            f", locks in {outcome.lock_time_s:.3g} {unit}" if locked else ""
        )
        axes.text(1.03, row, label, va="center", fontsize=7, transform=axes.get_yaxis_transform())
    axes.set_yticks(range(len(outcomes)), outcomes["gait"])
    axes.set(xlim=(0.0, 1.0), ylim=(max(len(outcomes), 3) - 0.4, -0.6))
    axes.set_xlabel(f"share of {starts} random starts")


def _from_release(axes: Axes, basin: Releases) -> None:
    reference = basin.legged.names[basin.legged.reference]
    second = basin.legged.names[1 - basin.legged.reference]
    phase = (basin.frame[f"release_phase_rad_{leg}"].to_numpy() for leg in (reference, second))
    released = np.subtract(*phase) / (2.0 * np.pi) % 1.0
    _dots(axes, basin, released, _shifted_lags(basin, second))
    axes.set_xlabel(f"lag of {second} behind {reference} at release [cycles]")
    axes.set_ylabel("and in the end [cycles]")


def _draw_two_legs(axes: Axes, basin: Releases) -> None:
    reference, names = basin.legged.reference, basin.legged.names
    order = by_side(names)
    position = order.index(reference)
    # The next leg of the same side, and the same leg of the other side.
    along, across = order[(position + 1) % len(order)], order[-1 - position]
    across = across if across not in (reference, along) else order[(position + 2) % len(order)]
    _dots(axes, basin, _shifted_lags(basin, names[along]), _shifted_lags(basin, names[across]))
    axes.set_xlabel(f"lag of {names[along]} behind {names[reference]} [cycles]")
    axes.set_ylabel(f"lag of {names[across]} [cycles]")


def _dots(axes: Axes, basin: Releases, x: np.ndarray, y: np.ndarray) -> None:
    for gait in basin.outcomes["gait"]:
        mask = basin.frame["gait"].to_numpy() == gait
        colour, marker = gait_colour(gait), gait_marker(gait)
        axes.scatter(x[mask], y[mask], s=18, color=colour, marker=marker, lw=0, alpha=0.6)
    ticks = np.linspace(0.0, 1.0, 5)
    axes.set(xlim=(-0.13, 1.0), ylim=(-0.13, 1.0), xticks=ticks, yticks=ticks, aspect="equal")


def _shifted_lags(basin: Releases, leg: str) -> np.ndarray:
    """Return the lags of a leg from -0.125 to 0.875, so that those around zero stay together."""
    return (basin.frame[f"lag_cycles_{leg}"].to_numpy() + 0.125) % 1.0 - 0.125


@styled()
def stability_figure(result: GaitStability, note: str = "") -> Figure:
    """Draw the moduli of all multipliers, the largest filled (above), and the residuals of the fit
    (below).

    Lines join the largest ones. A cross marks where the largest multiplier crosses one. In between,
    a row a gait, are the values at which the body, unkicked, stays in it to the end.

    Args:
        result: the return maps.
        note: the title.
    """
    rows = 0.12 * len(result.jacobians)
    figure = new_figure(COLUMN_IN, 3.4 + rows)
    moduli, stays, residual = figure.subplots(
        3, 1, sharex=True, height_ratios=(2.4, 0.9 * rows, 1.0)
    )
    moduli.axhline(1.0, color="0.6", lw=0.6, zorder=0)
    frame: Any = result.frame
    for row, (gait, group) in enumerate(frame.groupby("gait", sort=False)):
        values = group[result.over.name]
        look: Any = {"color": gait_colour(str(gait)), "marker": gait_marker(str(gait))}
        stable = values[group["stays"]]
        style = {"color": look["color"], "ms": 3, "clip_on": False}
        stays.plot(stable, np.full(len(stable), row), "s", **style)
        if group["largest"].notna().any():
            line: Any = {**look, "ms": 3, "lw": 0.8, "label": gait}
            moduli.plot(values, group["largest"], **line)
            residual.plot(values, group["unexplained"], **line)
            for k in range(2, len(result.legged.names)):
                parts = (group[f"multiplier_{k}_{part}"] for part in ("real", "imaginary"))
                smaller: Any = {**look, "ls": "", "ms": 2.6, "mew": 0.5, "fillstyle": "none"}
                moduli.plot(values, np.hypot(*parts), **smaller)
    moduli.plot(result.crossings["at"], np.ones(len(result.crossings)), "x", color="k", ms=5,
                mew=0.8, zorder=3)  # fmt: skip
    moduli.set_ylabel("|multipliers| per cycle")
    moduli.set_ylim(bottom=0.0)
    moduli.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, title=note or None)
    stays.set(ylim=(len(result.jacobians) - 0.4, -0.6), yticks=[])
    stays.set_ylabel("stays", rotation=0, ha="right", va="center")
    stays.tick_params(axis="x", length=0)
    residual.set(ylim=(0.0, 1.0), ylabel="unexplained")
    residual.set_xlabel(label(result.over, result.legged))
    residual.set_xlim(result.over.values[0], result.over.values[-1])
    return figure
