"""Limit cycles: on the actuation surface, in portraits, as a return map, and under pushes."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MaxNLocator, MultipleLocator

from tegotae.analysis.orbit import SIGNALS, Orbit
from tegotae.analysis.poincare import NUMERICAL, Poincare
from tegotae.analysis.surface import Surface
from tegotae.figures.style import (
    COLOURS,
    COLUMN_IN,
    PAGE_IN,
    SEQUENTIAL,
    Table,
    long_table,
    new_figure,
    styled,
)
from tegotae.simulation.recorder import Trajectory


def phase_axis(axes: Axes, label: str = "phase φ [rad]") -> None:
    """Set a horizontal axis of phase, from 0 to 2π."""
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_xticks(np.arange(5) * 0.5 * np.pi, ["0", "π/2", "π", "3π/2", "2π"])
    axes.set_xlabel(label)


def phase_ticks(axis: Axis) -> None:
    """Set the ticks of an axis that shows a part of a turn [rad]: fractions of π, three at
    least.
    """
    low, high = axis.get_view_interval()
    parts = next((n for n in (1, 2, 4, 8, 16) if (high - low) * n >= 3.0 * np.pi), 32)
    axis.set_major_locator(MultipleLocator(np.pi / parts))
    axis.set_major_formatter(lambda x, _: _fraction_of_pi(x))


def _fraction_of_pi(angle_rad: float) -> str:
    """Return an angle as text in fractions of π.

    Example:
        >>> [_fraction_of_pi(x * np.pi) for x in (0.0, 0.75, -1.0, 2.0)]
        ['0', '3π/4', '-π', '2π']
    """
    share = Fraction(angle_rad / np.pi).limit_denominator(64)
    over = {0: "0", 1: "π", -1: "-π"}.get(share.numerator, f"{share.numerator}π")
    return over if share.denominator == 1 else f"{over}/{share.denominator}"


def broken(phase: np.ndarray, turn: float = 2.0 * np.pi) -> np.ndarray:
    """Return phases [frames, ...] with a gap where they wrap, so that no line crosses the panel.

    Args:
        phase: of any unit.
        turn: a whole turn in that unit, such as 1 of lags in cycles.

    Example:
        >>> broken(np.array([0.8, 0.95, 0.1]), turn=1.0).tolist()
        [0.8, 0.95, nan]
    """
    jumps = np.abs(np.diff(phase, axis=0, prepend=phase[:1])) > 0.5 * turn
    return np.where(jumps, np.nan, phase)


# The actuation surface.

_NEGLIGIBLE = 0.01
"""Share of α below which a force is next to none, and drawn so."""
_SMALL_FEEDBACK = 0.1
"""The axis of the feedback reaches at least so far [rad/s]: less is next to nothing beside ω."""


@styled()
def surface_figure(
    surface: Surface, orbit: Orbit | None, *, max_force_n: float, note: str = ""
) -> Figure:
    """Draw F_a over phase and spring force with the limit cycle; below, F_a and f along the cycle.

    Args:
        surface: the surface.
        orbit: the limit cycle; None if there is none.
        max_force_n: largest actuator force α [N], which the colour scale names. The scale ends at
            the largest force of the surface, or, if the actuator does next to nothing, at α.
        note: a title, such as the slice's velocity.
    """
    largest = float(surface.actuator_force_n.max())
    acts = largest > _NEGLIGIBLE * max_force_n
    with_phase = surface.phase_rad is not None
    figure = new_figure(COLUMN_IN, 3.9 if orbit else 2.6)
    heights = (1.6, 1.0) if orbit else (1.0,)
    top, *below = figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    figure.suptitle(note, fontsize=8)
    mesh = draw_surface(top, surface, largest if acts else max_force_n)
    reaches = "up to " if largest >= 0.995 * max_force_n else f"at most {largest:.2g}, "
    words = f"{reaches if acts else 'next to none, '}α = {max_force_n:.3g} N"
    bar = figure.colorbar(mesh, ax=top, location="top", aspect=30)
    bar.set_label(f"actuator force $F_a$ [N]: {words}")
    top.set_ylim(0.0, surface.spring_force_n[-1])
    if orbit is not None:
        across = broken(orbit.phase_rad) if with_phase else orbit.velocity_m_per_s
        draw_path(top, across, orbit.spring_force_n)
        _draw_cycle(below[0], orbit, with_phase, max_force_n)
    return figure


def draw_surface(axes: Axes, surface: Surface, most_n: float | None = None) -> QuadMesh:
    """Draw the actuator force over phase (or velocity) and spring force; colours end at `most_n`
    [N], or at the largest force.
    """
    name, across = surface.columns
    axes.set(xlabel="velocity ẏ [m/s]", ylabel="spring force $F_k$ [N]")
    if name == "phase_rad":
        phase_axis(axes)
    look: Any = {"cmap": SEQUENTIAL, "vmin": 0.0, "vmax": most_n, "rasterized": True}
    return axes.pcolormesh(across, surface.spring_force_n, surface.actuator_force_n, **look)


def surface_tables(surface: Surface, orbit: Orbit | None) -> dict[str, Table]:
    """Return the data of the figure: the surface, point by point, and `cycle`."""
    maps = {
        "actuator_force_n": surface.actuator_force_n,
        "feedback_rad_per_s": surface.feedback_rad_per_s,
    }
    rows = ("spring_force_n", surface.spring_force_n)
    table = long_table(rows, surface.columns, maps)
    if surface.phase_rad is not None:
        table["velocity_m_per_s"] = surface.velocity_m_per_s[0]
    tables: dict[str, Table] = {"": table}
    if orbit is not None:
        height, velocity, *forces = SIGNALS
        names = ("time_s", height, velocity, "phase_rad", *forces)
        tables["cycle"] = {name: getattr(orbit, name) for name in names}
    return tables


def draw_path(axes: Axes, x: np.ndarray, spring_force_n: np.ndarray) -> None:
    """Draw a limit cycle on a surface, with an arrow for its direction; x is NaN where it wraps."""
    halo = [Stroke(linewidth=2.6, foreground="white"), Normal()]
    axes.plot(x, spring_force_n, color="black", lw=1.2, path_effects=halo)
    half = int(np.argmax(spring_force_n > 0.5 * np.max(spring_force_n)))
    tail, head = max(half - 3, 0), min(half + 3, len(x) - 1)
    if np.isfinite(x[tail] + x[head]):
        look = {"arrowstyle": "-|>", "color": "black", "mutation_scale": 9}
        ends = [(x[i], spring_force_n[i]) for i in (head, tail)]
        axes.annotate("", *ends, arrowprops=look)


def _draw_cycle(axes: Axes, orbit: Orbit, with_phase: bool, max_force_n: float) -> None:
    """Draw actuator force, and feedback (or, without phase, spring force), along the limit
    cycle.
    """
    twin = axes.twinx()
    twin.spines["right"].set_visible(True)
    x = broken(orbit.phase_rad) if with_phase else orbit.time_s
    along = orbit.feedback_rad_per_s if with_phase else orbit.spring_force_n
    axes.plot(x, orbit.actuator_force_n, color=COLOURS[0])
    axes.set_ylabel("actuator $F_a$ [N]", color=COLOURS[0])
    axes.set_ylim(0.0, max(axes.get_ylim()[1], _NEGLIGIBLE * max_force_n))
    twin.plot(x, along, color=COLOURS[4], ls="--")
    if with_phase:
        phase_axis(axes)
        low, high = twin.get_ylim()
        twin.set_ylim(min(low, -_SMALL_FEEDBACK), max(high, _SMALL_FEEDBACK))
        twin.set_ylabel("feedback f [rad/s]", color=COLOURS[4])
    else:
        axes.set(xlabel="time since the apex [s]", xlim=(0.0, orbit.period_s))
        twin.set_ylabel("spring $F_k$ [N]", color=COLOURS[4])
        twin.set_ylim(bottom=0.0)


# Portraits.

_LATE = 0.75
"""Share of the time after which a path is drawn as the final gait."""


@styled()
def portrait_figure(paths: Trajectory, *, rest_length_m: float, note: str = "") -> Figure:
    """Draw velocity over height, and spring force over phase, or over velocity without an
    oscillator.

    Thin lines lead from the releases, the squares; the last quarter of the time is thick and black.
    A cross is where a leg has no length left.

    Args:
        paths: the rollouts.
        rest_length_m: rest length of the leg l0 [m], above which it flies.
        note: a title.
    """
    figure = new_figure(PAGE_IN, 2.9)
    body, felt = figure.subplots(1, 2)
    figure.suptitle(note, fontsize=8)
    body.axvline(rest_length_m, color="0.4", ls=":", lw=0.8)
    _draw_paths(body, paths.height_m, paths.velocity_m_per_s, paths)
    body.set(xlabel="height y [m]", ylabel="velocity ẏ [m/s]")
    handles, labels = body.get_legend_handles_labels()
    place = {"loc": "outside right center", "title_fontsize": 7}
    figure.legend(handles, labels, title="released from", **place)
    if "phase_rad" not in paths.channels:
        _draw_paths(felt, paths.velocity_m_per_s, paths.spring_force_n, paths)
        felt.set_xlabel("velocity ẏ [m/s]")
    else:
        _draw_paths(felt, broken(paths.phase_rad % (2.0 * np.pi)), paths.spring_force_n, paths)
        phase_axis(felt)
    felt.set_ylabel("spring force $F_k$ [N]")
    felt.set_ylim(bottom=0.0)
    return figure


_RELEASES = tuple(colour for colour in COLOURS if colour != "#000000")
"""Colours of releases: black is what they settle to."""


def _draw_paths(axes: Axes, x: np.ndarray, y: np.ndarray, paths: Trajectory) -> None:
    late = round(_LATE * len(x))
    for i, (across, up) in enumerate(zip(x.T, y.T, strict=True)):
        colour = _RELEASES[i % len(_RELEASES)]
        label = f"{paths.height_m[0, i]:.3g} m"
        axes.plot(across[: late + 1], up[: late + 1], color=colour, lw=0.6, label=label)
        axes.plot(
            across[late:], up[late:], color="black", lw=1.3, label="settled" * (i == len(x.T) - 1)
        )
        axes.plot(across[0], up[0], "s", color=colour, ms=4)
        if paths.failed[-1, i]:
            axes.plot(across[-1], up[-1], "x", color=colour, ms=6, clip_on=False)


def portrait_table(paths: Trajectory) -> pd.DataFrame:
    """Return the data of the figure, one row per frame and release."""
    height, velocity, spring, _, actuator = SIGNALS
    names = (height, velocity, "phase_rad", spring, actuator)
    columns = {name: paths.channels[name].T for name in names if name in paths.channels}
    axes = ("release_height_m", paths.height_m[0]), ("time_s", paths.time_s[:, 0])
    return long_table(*axes, columns)


# The return map.


@styled()
def poincare_figure(section: Poincare, transient: np.ndarray, note: str = "") -> Figure:
    """Draw apexes after the release; decay of a nudge; multipliers in the complex plane.

    Args:
        section: the fixed point and its multipliers.
        transient: apexes from a release on, height [m] and phase [rad], shape [hops, 1 or 2].
        note: a title.
    """
    figure = new_figure(PAGE_IN, 2.4)
    apexes, decay, plane = figure.subplots(1, 3)
    figure.suptitle(note, fontsize=8)
    _draw_apexes(apexes, section, transient)

    turns = np.arange(len(section.distance))
    simulated = {"color": COLOURS[0], "ms": 3, "mfc": "none", "label": "simulated"}
    decay.semilogy(turns, predicted(section), color="black", lw=0.9, label="linear map")
    decay.semilogy(turns, section.distance, "o", **simulated)
    indices = np.flatnonzero(section.distance > NUMERICAL)
    decay.set(xlim=(-0.5, indices[-1] + 1.5), ylim=(NUMERICAL, 3.0 * np.nanmax(section.distance)))
    decay.set_xlabel("hops" if section.hops == 1 else f"turns of {section.hops} hops")
    decay.set_ylabel("distance from x* [m, rad]")
    decay.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    decay.legend()

    values = section.multipliers
    plane.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color="0.5", lw=0.8))
    plane.axhline(0.0, color="0.85", lw=0.5, zorder=0)
    plane.axvline(0.0, color="0.85", lw=0.5, zorder=0)
    plane.plot(np.real(values), np.imag(values), "o", color=COLOURS[4], ms=4)
    reach = 1.15 * max(1.0, float(np.abs(values).max()))
    plane.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="Re λ", ylabel="Im λ")
    plane.set(aspect="equal", title=f"|λ₁| = {abs(values[0]):.3f}")
    return figure


def _draw_apexes(axes: Axes, section: Poincare, transient: np.ndarray) -> None:
    """Draw heights over phases or, without phases, over the heights before."""
    star = section.fixed_point
    if len(star) > 1:
        x, y = transient[:, 1], transient[:, 0]
        marked = [(star[1], star[0])]
        axes.plot(x, y, color="0.75", lw=0.5)
        axes.set_xlabel("phase at the apex φ [rad]")
    else:
        x, y = transient[:-1, 0], transient[1:, 0]
        marked = [(star[0], star[0])] if section.hops == 1 else []
        axes.axline((x[0], x[0]), slope=1.0, color="0.6", lw=0.6)
        axes.set_xlabel("height of the apex before [m]")
    axes.plot(x, y, ".", color=COLOURS[0], ms=4)
    axes.plot(x[0], y[0], "s", color=COLOURS[2], ms=4, label="first apex")
    for point in marked:
        label = "x*" if section.refined else "x*, not refined"
        axes.plot(*point, "x", color=COLOURS[4], ms=7, mew=1.4, label=label)
    if len(star) > 1:
        phase_ticks(axes.xaxis)
    axes.set_ylabel("height of the apex y [m]")
    axes.legend(handletextpad=0.2)


def predicted(section: Poincare) -> np.ndarray:
    """Return the nudge's distance from the fixed point if the return map were linear, shape
    [turns].
    """
    points = [section.nudged[0] - section.fixed_point]
    for _ in section.distance[1:]:
        points.append(section.jacobian @ points[-1])
    return np.linalg.norm(points, axis=-1)


def poincare_tables(section: Poincare, transient: np.ndarray) -> dict[str, Table]:
    """Return the data of the figure: `decay` of the perturbation, apexes of the `transient`,
    `multipliers`."""
    # An oscillator may have more state than its phase, which is not shown.
    names = ("apex_height_m", "apex_phase_rad")[: len(section.fixed_point)]
    decay = dict(zip(names, section.nudged.T, strict=False))
    decay |= {"distance": section.distance, "predicted_distance": predicted(section)}
    apexes = pd.DataFrame(transient, columns=list(names))
    multipliers = {
        "real": np.real(section.multipliers),
        "imaginary": np.imag(section.multipliers),
        "modulus": np.abs(section.multipliers),
        "observed_factor": section.observed,
        "refined": section.refined,
        "period_hops": section.hops,
        "period_s": section.period_s,
        "decay_time_s": section.decay_s,
    }
    return {
        "": pd.DataFrame(decay).rename_axis("turn").reset_index(),
        "transient": apexes.rename_axis("hop").reset_index(),
        "multipliers": multipliers,
    }


# The phase response.

_NEGLIGIBLE_RAD = 0.01
"""A shift below this, 1/600 of a period, is negligible, and drawn as the flat line that it is."""


@styled()
def phase_response_figure(response: pd.DataFrame, note: str = "") -> Figure:
    """Shift of the rhythm over the phase of the cycle at which the push comes.

    The axis reaches at least to twice `_NEGLIGIBLE_RAD`, so that a gait that does not respond does
    not look like one that does; the picture then says so.
    """
    figure = new_figure(COLUMN_IN, 2.6)
    axes = figure.subplots()
    pushes: Any = list(response.groupby("push_ns", sort=False))
    _, first = pushes[0]
    x, stance = first["cycle_phase_rad"].to_numpy() / (2.0 * np.pi), first["stance"].tolist()
    style = {"transform": axes.get_xaxis_transform(), "step": "post"}
    axes.fill_between(x, 0.0, 1.0, where=stance, color="0.88", lw=0, **style)
    axes.axhline(0.0, color="0.5", lw=0.6)
    for i, (push, curve) in enumerate(pushes):
        look: Any = {"ls": ("-", "--", "-.", ":")[i % 4], "color": COLOURS[(0, 4, 2, 5)[i % 4]]}
        shift = broken(curve["shift_rad"].to_numpy())
        axes.plot(x, shift, label=f"push of {1e3 * push:+.3g} mN s", **look)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -2.0 * _NEGLIGIBLE_RAD), max(high, 2.0 * _NEGLIGIBLE_RAD))
    shifts = np.abs(response["shift_rad"].dropna().to_numpy())
    words = "the gait never returns to its limit cycle"
    if shifts.size:
        largest, share = shifts.max(), shifts.max() / (2.0 * np.pi)
        words = f"negligible response: at most {largest:.1g} rad,\n{share:.1g} of a period"
    if not shifts.size or shifts.max() < _NEGLIGIBLE_RAD:
        axes.text(0.5, 0.95, words, transform=axes.transAxes, ha="center", va="top")
    axes.set(xlabel="when the push comes, t / T since the apex", xlim=(0.0, 1.0), title=note)
    axes.set_ylabel("shift of the rhythm Δθ [rad]")
    handles = [*axes.get_legend_handles_labels()[0], Patch(color="0.88", label="stance")]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def phase_response_notes(response: pd.DataFrame) -> list[str]:
    """Return the largest shift of each push, in a sentence each.

    Args:
        response: the table of `measure_phase_response`.
    """
    notes = []
    for impulse, rows in response.groupby("push_ns", sort=False):
        shift = rows["shift_rad"].to_numpy()
        pushed, share_undefined = f"push of {impulse:g} N s: ", float(np.mean(np.isnan(shift)))
        if share_undefined == 1.0:
            notes.append(f"{pushed}no return to the limit cycle")
            continue
        index = int(np.nanargmax(np.abs(shift)))
        where = rows["cycle_phase_rad"].iloc[index] / (2.0 * np.pi)
        tiny = ", which is negligible" if abs(shift[index]) < _NEGLIGIBLE_RAD else ""
        gone = f"; no return from {share_undefined:.0%} of the points" if share_undefined else ""
        notes.append(
            f"{pushed}largest shift {shift[index]:+.3g} rad at t/T = {where:.2f}{tiny}{gone}"
        )
    return notes
