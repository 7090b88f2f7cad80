"""Maps: basins, phase locking, and other sweeps of gain and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.maps import GainSweep, HopperBasin, locking_ratios
from tegotae.figures.cycles import phase_axis
from tegotae.figures.style import COLOURS, COLUMN_IN, SEQUENTIAL, long_table, new_figure, styled
from tegotae.measures.hopping.metrics import AT_REST, FAILED, LIMIT_CYCLE, REGIMES, UNSETTLED
from tegotae.parts._shapes import AnyArray
from tegotae.training.scoring import VanillaSweep

_FILL = {FAILED: "black", AT_REST: "0.9", UNSETTLED: "white"}
_REST: Any = {"hatch": "/////", "edgecolor": "0.55"}


def quantities() -> Colormap:
    """Return the sequential colour map without its darkest part, which would pass for black."""
    colours = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.12, 1.0, 256))
    return LinearSegmentedColormap.from_list("quantities", colours)


def draw_regimes(axes: Axes, x: np.ndarray, y: np.ndarray, regime: AnyArray) -> None:
    """Colour the cells without limit cycle: hatched at rest, white unsettled, black failed.

    Args:
        x: values along the horizontal axis, shape [columns].
        y: values along the vertical axis, shape [rows].
        regime: indices into `REGIMES`, shape [rows, columns].
    """
    _draw_steps(axes, x, y, np.where(regime == LIMIT_CYCLE, -1, regime), [*_FILL.values()])
    # Contours reach only to the middle of the outer cells, so they go a cell farther.
    wide = [np.pad(values, 1, "reflect", reflect_type="odd") for values in (x, y)]
    rests = np.pad((regime == AT_REST).astype(float), 1, "edge")
    if rests.any():
        hatches = [_REST["hatch"]]
        drawn = axes.contourf(*wide, rests, levels=[0.5, 1.5], colors="none", hatches=hatches)
        drawn.set(edgecolor=_REST["edgecolor"], linewidth=0.0)
    xlim, ylim = ((0.5 * (w[0] + w[1]), 0.5 * (w[-2] + w[-1])) for w in wide)
    axes.set(xlim=xlim, ylim=ylim)
    axes.spines[["top", "right"]].set_visible(True)


def _draw_steps(axes: Axes, x: np.ndarray, y: np.ndarray, step: AnyArray, colours: Any) -> None:
    """Colour the cells by whole numbers from 0 on; those below remain unchanged."""
    cells = np.ma.masked_where(step < 0, step)
    limits = {"vmin": -0.5, "vmax": len(colours) - 0.5, "cmap": ListedColormap(colours)}
    axes.pcolormesh(x, y, cells, rasterized=True, **limits)


def _draw_categories(
    axes: Axes, x: np.ndarray, y: np.ndarray, category: np.ndarray, labels: Sequence[str]
) -> list[Patch]:
    """Colour the cells by category, in steps of lightness, and return the legend's handles.

    Args:
        category: indices into the labels, or -1 for none, shape [rows, columns].
        labels: of the categories; those that do not occur have no handle.
    """
    # The most common category first, in the middle of the scale; its neighbours far from it.
    steps = (0.5, 1.0, 0.0, 0.75, 0.25, 0.88)[: len(labels)]
    colours = [quantities()(step) for step in steps]
    if labels:
        _draw_steps(axes, x, y, category, colours)
    return [
        Patch(facecolor=colour, edgecolor=_REST["edgecolor"], lw=0.5, label=label)
        for number, (colour, label) in enumerate(zip(colours, labels, strict=True))
        if np.any(category == number)
    ]


def regime_legend(figure: Figure, present: AnyArray, *artists: Artist, **options: Any) -> None:
    """Explain the colours without a value below the panels.

    Args:
        present: regimes that occur.
        more: further handles.
    """
    handles = [*artists]
    for kind in (AT_REST, UNSETTLED, FAILED):
        if np.any(present == kind):
            look = {**_REST, "hatch": _REST["hatch"] if kind == AT_REST else None}
            handles.append(Patch(facecolor=_FILL[kind], lw=0.5, label=REGIMES[kind], **look))
    if handles:
        options = {"ncols": 3, "handlelength": 1.6, **options}
        figure.legend(handles=handles, loc="outside lower center", **options)


_MOST = 5  # limit cycles with a colour of their own


@styled()
def basin_figure(basin: HopperBasin, note: str = "") -> Figure:
    """Draw the limit cycle that each release ends in; the legend shows its frequency."""
    labels = [describe_map(cycle) for cycle in basin.cycles[:_MOST].itertuples()]
    if len(rare := basin.cycles[_MOST:]):
        labels.append(f"{len(rare)} other limit cycles ({sum(rare['share']):.1%})")
    figure = new_figure(COLUMN_IN, 2.9 + 0.13 * min(len(labels), _MOST))
    axes = figure.subplots()
    height, across = basin.axes
    regime = np.vectorize(REGIMES.index)(basin.grid("regime"))
    draw_regimes(axes, across, height, regime)
    category = np.minimum(basin.grid("limit_cycle"), _MOST)
    patches = _draw_categories(axes, across, height, category, labels)
    if "phase_rad" in basin.frame:
        phase_axis(axes, "phase at release φ [rad]")
    else:
        axes.set_xlabel("velocity at release ẏ [m/s]")
    axes.set(ylabel="release height y [m]", title=note)
    regime_legend(figure, regime, *patches, ncols=1)
    return figure


def describe_map(cycle: Any) -> str:
    """Describe a limit cycle, a row of `HopperBasin.cycles`: hops, turns, height, share of
    releases.
    """
    hops = "1 hop" if cycle.hops == 1 else f"{cycle.hops} hops"
    turns = {None: "", 1: ", 1 turn"}.get(cycle.turns, f", {cycle.turns} turns")
    return f"{hops}{turns}, apex {cycle.apex_height_m:.2f} m ({cycle.share:.1%})"


_RATIOS = tuple(Fraction(*ratio) for ratio in ((1, 1), (2, 1), (1, 2), (3, 2), (0, 1)))


@styled()
def phase_locking_figure(sweep: GainSweep, cut_sigma: float, note: str = "") -> Figure:
    """Draw the turns of the oscillator per hop over frequency and gain; below, both rates along a
    cut.

    Args:
        sweep: outcomes over gain and frequency.
        cut_sigma: the gain of the cut [rad/(s N)]; the nearest of the sweep's is taken.
        note: a title.
    """
    codes = {None: -1, **{ratio: number for number, ratio in enumerate(_RATIOS)}}
    category = np.vectorize(lambda ratio: codes.get(ratio, len(_RATIOS)))(
        locking_ratios(sweep.outcome)
    )
    labels = [*(f"{_words(ratio)} turns : hops" for ratio in _RATIOS), "another ratio"]
    cut = int(np.argmin(np.abs(sweep.sigma - cut_sigma)))
    sigma, omega = sweep.sigma[cut], sweep.omega
    figure = new_figure(COLUMN_IN, 4.6)
    top, below = figure.subplots(2, 1, height_ratios=(1.5, 1.0), sharex=True)
    draw_regimes(top, omega, sweep.sigma, sweep.outcome.regime)
    patches = _draw_categories(top, omega, sweep.sigma, category, labels)
    top.axhline(sigma, color="white", lw=2.2)
    top.axhline(sigma, color="black", lw=1.0, ls="--")
    top.set(ylabel="gain σ [rad/(s N)]", title=note)

    below.plot(omega, omega, color="0.6", lw=0.8, ls=":", label="ω")
    open_, filled = {"ms": 3.2, "mfc": "none", "mew": 0.5}, {"ms": 2.6, "mew": 0.5}
    phase_rate, hop_rate = sweep.outcome.phase_rate[cut], sweep.outcome.hop_rate[cut]
    below.plot(omega, phase_rate, "o", color=COLOURS[2], label="mean phase rate", **open_)
    below.plot(omega, hop_rate, ".", color=COLOURS[4], label="hopping frequency", **filled)
    below.set(xlabel="frequency ω [rad/s]", ylabel=f"rate [rad/s] at σ = {sigma:.3g}")
    below.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=3, handletextpad=0.3)
    regime_legend(figure, sweep.outcome.regime, *patches)
    return figure


def _words(ratio: Fraction | None) -> str:
    return "" if ratio is None else f"{ratio.numerator}:{ratio.denominator}"


def phase_locking_table(sweep: GainSweep) -> pd.DataFrame:
    """Return the data of the figure, pair by pair of gain and frequency."""
    outcome = {
        "regime": np.asarray(REGIMES)[sweep.outcome.regime],
        "turns_to_hops": list(map(_words, locking_ratios(sweep.outcome).flat)),
        "limit_cycle_period_hops": sweep.outcome.limit_cycle_period,
        "mean_phase_rate_rad_per_s": sweep.outcome.phase_rate,
        "hopping_frequency_rad_per_s": sweep.outcome.hop_rate,
        "winding_ratio": sweep.outcome.winding_ratio,
    }
    axes = ("sigma_rad_per_s_n", sweep.sigma), ("omega_rad_per_s", sweep.omega)
    return long_table(*axes, outcome)


@styled()
def vanilla_sweep_figure(sweep: VanillaSweep, *, fitness: str = "fitness") -> Figure:
    """Draw fitness over ω and σ; dots mark the best gain of each frequency, black failures.

    Args:
        sweep: what was swept.
        fitness: what the colours are called.
    """
    rows, columns = np.arange(len(sweep.sigma)), np.arange(len(sweep.omega))
    figure = new_figure(COLUMN_IN, 3.0)
    axes = figure.add_subplot(facecolor="black")
    sound = np.ma.masked_where(sweep.failed, sweep.fitness)
    mesh = axes.pcolormesh(columns, rows, sound, cmap=quantities(), rasterized=True)
    figure.colorbar(mesh, ax=axes).set_label(fitness)
    axes.plot(
        columns, np.argmax(sweep.fitness, axis=0), "o", ms=3, mfc="white", mec="black", mew=0.6
    )
    selected = rows[:: max(1, len(rows) // 8)]
    axes.set_yticks(selected, [f"{sweep.sigma[i]:.2g}" for i in selected])
    axes.set_xticks(columns, [f"{omega:.3g}" for omega in sweep.omega])
    axes.set(xlabel="frequency ω [rad/s]", ylabel="gain σ [rad/(s N)]")
    return figure
