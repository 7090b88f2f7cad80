"""Footfalls, lags and gaits over time and frequency, and around a lost leg or another change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from tegotae.analysis.gaits.lesion import Aftermath
from tegotae.analysis.gaits.releases import GaitRun
from tegotae.analysis.gaits.sweep import DOWN, UP, GaitSweep
from tegotae.figures.cycles import broken
from tegotae.figures.gaits.style import HATCHED, HATCHES, MARKERS, by_side, gait_colour
from tegotae.figures.style import COLOURS, COLUMN_IN, PAGE_IN, literal_text, new_figure, styled
from tegotae.measures.gaits.names import FALLEN

STRIDES = 6.0
"""Number of final strides drawn."""


@styled()
def footfall_figure(run: GaitRun, note: str = "") -> Figure:
    """Draw the stances of every leg over the last strides, and their duty factors beside them.

    Args:
        run: the rollout.
        note: the title.
    """
    names, end = run.legged.names, float(run.trajectory.time_s[-1])
    long = STRIDES * run.stride_s if np.isfinite(run.stride_s) else 0.25 * end
    begin = max(0.0, end - long)
    rows = by_side(names)
    figure = new_figure(COLUMN_IN, 0.75 + 0.22 * len(names))
    axes = figure.subplots()
    for row, leg in enumerate(rows):
        for stance in run.stances[leg]:
            if stance.liftoff_s > begin:
                start = max(stance.touchdown_s, begin)
                axes.barh(row, stance.liftoff_s - start, left=start, height=0.62, color="0.15")
    axes.set_yticks(range(len(rows)), [names[leg] for leg in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(begin, end)
    axes.set_xlabel(f"time [{run.legged.units[1]}]")
    duty = axes.secondary_yaxis("right")
    duty_factor = run.coordination.duty_factor[:, 0]
    duty.set_yticks(range(len(rows)), [f"{duty_factor[leg]:.2f}" for leg in rows])
    duty.set_ylabel("duty factor")
    for side in (axes, duty):
        side.tick_params(axis="y", length=0)
        side.spines["left" if side is axes else "right"].set_visible(False)
    axes.set_title(note)
    return figure


@styled()
def lags_figure(run: GaitRun, note: str = "") -> Figure:
    """Draw the lag of every leg behind the reference leg, averaged over strides.

    A dotted line is where a lag has settled, and the vertical one when all had.

    Args:
        run: the rollout.
        note: the title.
    """
    names, reference = run.legged.names, run.legged.reference
    other_legs = [leg for leg in by_side(names) if leg != reference]
    time = np.asarray(run.trajectory.time_s)
    figure = new_figure(COLUMN_IN, 2.2)
    axes = figure.subplots()
    for number, leg in enumerate(other_legs):
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(time, broken(run.lag[:, leg], turn=1.0), color=colour, label=names[leg])
        final = float(run.coordination.lag[leg, 0] % 1.0)
        axes.axhline(final, color=colour, lw=0.6, ls=":")
    if np.isfinite(run.coordination.lock_time_s[0]):
        axes.axvline(float(run.coordination.lock_time_s[0]), color="0.5", lw=0.6)
    axes.set(xlim=(0.0, time[-1]), ylim=(0.0, 1.0), yticks=np.linspace(0.0, 1.0, 5))
    axes.set_xlabel(f"time [{run.legged.units[1]}]")
    axes.set_ylabel(f"lag behind {names[reference]} [cycles]")
    axes.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(other_legs), title=note or None
    )
    return figure


_WAYS: Mapping[str, Any] = {UP: {"fillstyle": "full"}, DOWN: {"fillstyle": "none"}}


@styled()
def sweep_figure(sweep: GaitSweep, note: str = "") -> Figure:
    """Draw, from the top, the gaits' names, every leg's lag, and speed and cost, or frequency and
    power.

    Filled is the way up, open the way down. Each start is a dot; lines are medians.

    Args:
        sweep: what was found.
        note: the title.
    """
    length, time = sweep.legged.units
    speed = "√(g l0)" if sweep.legged.dimensionless else f"{length}/{time}"
    quantities = {"speed_m_per_s": f"speed\n[{speed}]", "cost_of_transport": "cost of\ntransport"}
    if not np.isfinite(sweep.frame["speed_m_per_s"]).any():
        quantities = {"cycle_frequency_hz": f"strides [1/{time}]", "power_w": "power [W]"}
    figure = new_figure(COLUMN_IN, 4.6)
    names, lags, *quantity_axes = figure.subplots(
        4, 1, sharex=True, height_ratios=(0.55, 1.6, 1.0, 1.0)
    )
    _names(names, sweep, note)
    _lags(lags, sweep)
    for axes, (quantity, label) in zip(quantity_axes, quantities.items(), strict=True):
        for direction, style in ((UP, "-"), (DOWN, "--")):
            rows = sweep.frame[sweep.frame["direction"] == direction]
            middle = rows.groupby(_OMEGA)[quantity].median()
            axes.plot(middle.index, middle, style, color=COLOURS[0], lw=0.7)
            dots = {"color": COLOURS[0], "ms": 2.6, "mew": 0.6, **_WAYS[direction]}
            axes.plot(rows[_OMEGA], rows[quantity], "o", **dots)
        axes.set_ylabel(label)
        if quantity == "cost_of_transport":
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter("")
    quantity_axes[-1].set_xlabel(f"frequency ω [rad/{time}]")
    return figure


_OMEGA = "omega_rad_per_s"


def _names(axes: Axes, sweep: GaitSweep, note: str) -> None:
    """Draw, as one band per direction, the share of each gait at each level."""
    shares = sweep.frame.groupby(["direction", _OMEGA])["gait"].value_counts(normalize=True)
    shares = shares.unstack(fill_value=0.0)
    looks: dict[str, Any] = {
        name: {"facecolor": gait_colour(name), "hatch": HATCHES.get(name), **HATCHED}
        for name in map(str, shares.columns)
    }
    for row, direction in enumerate(_WAYS):
        bottom = np.full(len(sweep.omega), float(row))
        for name, look in looks.items():
            height = 0.86 * shares.loc[direction, name].to_numpy()
            axes.bar(sweep.omega, height, sweep.omega[1] - sweep.omega[0], bottom, **look)
            bottom += height
    axes.set_yticks([0.43, 1.43], ["up ●", "down ○"])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(0.0, 1.9)
    keys = [Patch(label=name, **look) for name, look in looks.items()]
    axes.legend(
        handles=keys, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, title=note or None
    )
    axes.spines[:].set_visible(False)


def _lags(axes: Axes, sweep: GaitSweep) -> None:
    names, reference = sweep.legged.names, sweep.legged.reference
    leg_names = [names[leg] for leg in by_side(names) if leg != reference]
    for number, leg in enumerate(leg_names):
        marker, colour = MARKERS[number % len(MARKERS)], COLOURS[number % len(COLOURS)]
        for direction, look in _WAYS.items():
            frame = sweep.frame[
                (sweep.frame["direction"] == direction) & (sweep.frame["gait"] != FALLEN)
            ]
            lag = (frame[f"lag_cycles_{leg}"] + 0.2) % 1.0 - 0.2
            size = 2.4 if direction == UP else 3.2
            name = leg if direction == UP else None
            axes.plot(
                frame[_OMEGA], lag, marker, color=colour, ms=size, mew=0.6, label=name, **look
            )
    axes.set(ylim=(-0.22, 0.82), yticks=np.linspace(0.0, 0.75, 4))
    label = f"lag of {leg_names[0]}" if len(leg_names) == 1 else "lag"
    axes.set_ylabel(f"{label} behind {names[reference]}\n[cycles]")
    if len(leg_names) > 1:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=len(leg_names), handletextpad=0.0
        )


@styled()
def lesion_figure(aftermath: Aftermath, note: str = "") -> Figure:
    """Draw the shares of starts that stand, and that are locked, over time (left), and the lags
    (right).

    Args:
        aftermath: what followed.
        note: the title.
    """
    figure = new_figure(PAGE_IN, 2.5)
    shares, lags = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
    _standing(shares, aftermath)
    shares.set_title(note, loc="left")
    _lags_before_and_after(lags, aftermath)
    return figure


def _standing(axes: Axes, aftermath: Aftermath) -> None:
    time = aftermath.legged.units[1]
    end = aftermath.legged.timing.duration_s - aftermath.lesion.at_s
    frame: Any = aftermath.frame
    stood = frame[frame["stood_before"]]
    times = np.linspace(0.0, end, 400)[:, None]
    if len(stood):
        standing = 1.0 - (stood["after_fall_time_s"].to_numpy() <= times).mean(axis=1)
        again = (stood["after_lock_time_s"].to_numpy() <= times).mean(axis=1)
        axes.plot(times, standing, color=COLOURS[0], label="standing")
        axes.plot(times, again, "--", color=COLOURS[1], label="locked for good")
        share = aftermath.share
        axes.errorbar(
            end, share.mean, [[share.mean - share.low], [share.high - share.mean]],
            color=COLOURS[0], capsize=2, lw=0.8, clip_on=False,
        )  # fmt: skip
    axes.set(xlim=(0.0, end), ylim=(-0.02, 1.04))
    axes.set_xlabel(f"time since {literal_text(aftermath.lesion.label)} [{time}]")
    axes.set_ylabel(f"share of {len(stood)} starts that stood")
    axes.legend(loc="center right")


def _lags_before_and_after(axes: Axes, aftermath: Aftermath) -> None:
    names, reference, frame = aftermath.legged.names, aftermath.reference, aftermath.frame
    order = [leg for leg in by_side(names) if leg != reference]
    for row, leg in enumerate(order):
        marker: Any = {
            "marker": MARKERS[row % len(MARKERS)], "color": COLOURS[row % len(COLOURS)], "ls": ""
        }  # fmt: skip
        lags_before = frame.loc[frame["stood_before"], f"before_lag_cycles_{names[leg]}"] % 1.0
        low, high = (np.full(len(frame), row + off) for off in (-0.14, 0.14))
        axes.plot(lags_before, low[: len(lags_before)], ms=3.4, mew=0.6, fillstyle="none", **marker)
        if leg in aftermath.left:
            lags_after = frame.loc[frame["stays_up"], f"after_lag_cycles_{names[leg]}"] % 1.0
            axes.plot(lags_after, high[: len(lags_after)], ms=3.0, **marker)
    axes.set_yticks(range(len(order)), [names[leg] for leg in order])
    axes.set(xlim=(-0.02, 1.02), ylim=(len(order) - 0.5, -0.5), xticks=np.linspace(0, 1, 5))
    axes.set_xlabel(f"lag behind {names[reference]} [cycles]: open before, filled after")
