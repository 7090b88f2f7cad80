"""Fig. 5 of the paper: the actuation surface, and the limit cycle on it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MultipleLocator

from tegotae.analysis.orbit import Orbit
from tegotae.analysis.surface import Surface
from tegotae.figures.data import Table, long_table
from tegotae.figures.style import COLOURS, COLUMN_IN, SEQUENTIAL, new_figure, styled

_NEGLIGIBLE = 0.01
"""Share of α below which a force is next to none, and drawn so."""
_SMALL_FEEDBACK = 0.1
"""The axis of the feedback reaches at least so far [rad/s]: less is next to nothing beside ω."""
_HALO = [Stroke(linewidth=2.6, foreground="white"), Normal()]


def surface_figure(
    surface: Surface, orbit: Orbit | None, *, max_force_n: float, note: str = ""
) -> Figure:
    """F_a over phase and spring force, with the limit cycle; below, F_a and f along the cycle.

    Args:
        surface: the surface.
        orbit: the limit cycle; None if there is none.
        max_force_n: largest actuator force α [N], which the colour scale names. The scale ends at
            the largest force of the surface, or, if the actuator does next to nothing, at α.
        note: a title, such as the slice's velocity.
    """
    largest = float(surface.actuator_force_n.max())
    acts = largest > _NEGLIGIBLE * max_force_n
    with styled():
        figure = new_figure(COLUMN_IN, 3.9 if orbit else 2.6)
        heights = (1.6, 1.0) if orbit else (1.0,)
        top, *below = figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        with_phase = surface.phase_rad is not None
        x = surface.phase_rad if with_phase else surface.velocity_m_per_s
        mesh = top.pcolormesh(
            x,
            surface.spring_force_n,
            surface.actuator_force_n,
            vmin=0.0,
            vmax=largest if acts else max_force_n,
            cmap=SEQUENTIAL,
            rasterized=True,
        )
        bar = figure.colorbar(mesh, ax=top, location="top", aspect=30)
        bar.set_label(_force_label(largest, max_force_n, acts))
        top.set_ylabel("spring force $F_k$ [N]")
        top.set_ylim(0.0, surface.spring_force_n[-1])
        figure.suptitle(note, fontsize=8)
        if with_phase:
            phase_axis(top)
        else:
            top.set_xlabel("velocity ẏ [m/s]")
        if orbit is not None:
            across = orbit.phase_rad if with_phase else orbit.velocity_m_per_s
            draw_path(top, broken(across) if with_phase else across, orbit.spring_force_n)
            _draw_cycle(below[0], orbit, with_phase, max_force_n)
    return figure


def surface_tables(surface: Surface, orbit: Orbit | None) -> dict[str, Table]:
    """What the figure shows: the surface, point by point, and `cycle`."""
    with_phase = surface.phase_rad is not None
    columns = (
        ("phase_rad", surface.phase_rad)
        if surface.phase_rad is not None
        else ("velocity_m_per_s", surface.velocity_m_per_s)
    )
    maps = {
        "actuator_force_n": surface.actuator_force_n,
        "feedback_rad_per_s": surface.feedback_rad_per_s,
    }
    table = long_table(("spring_force_n", surface.spring_force_n), columns, maps)
    if with_phase:
        table["velocity_m_per_s"] = np.full(len(table["phase_rad"]), surface.velocity_m_per_s[0])
    return {"": table, **({} if orbit is None else {"cycle": orbit_table(orbit)})}


def orbit_table(orbit: Orbit) -> dict[str, np.ndarray]:
    """A limit cycle as a table."""
    names = (
        "time_s",
        "height_m",
        "velocity_m_per_s",
        "phase_rad",
        "spring_force_n",
        "feedback_rad_per_s",
        "actuator_force_n",
    )
    return {name: getattr(orbit, name) for name in names}


def draw_path(axes: Axes, x: np.ndarray, spring_force_n: np.ndarray) -> None:
    """A limit cycle on a surface, with an arrow for its direction; x is NaN where it wraps."""
    axes.plot(x, spring_force_n, color="black", lw=1.2, path_effects=_HALO)
    _arrow(axes, x, spring_force_n)


def phase_axis(axes: Axes, label: str = "phase φ [rad]") -> None:
    """A horizontal axis of phase, from 0 to 2π."""
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_xticks(np.arange(5) * 0.5 * np.pi, ["0", "π/2", "π", "3π/2", "2π"])
    axes.set_xlabel(label)


def phase_ticks(axis: Axis) -> None:
    """Ticks of an axis that shows a part of a turn [rad]: fractions of π, three at least."""
    low, high = axis.get_view_interval()
    parts = next((n for n in (1, 2, 4, 8, 16) if (high - low) * n >= 3.0 * np.pi), 32)
    axis.set_major_locator(MultipleLocator(np.pi / parts))
    axis.set_major_formatter(lambda x, _: fraction_of_pi(x))


def fraction_of_pi(angle_rad: float) -> str:
    """An angle as a fraction of π.

    Example:
        >>> [fraction_of_pi(x * np.pi) for x in (0.0, 0.75, -1.0, 2.0)]
        ['0', '3π/4', '-π', '2π']
    """
    share = Fraction(angle_rad / np.pi).limit_denominator(64)
    if not share:
        return "0"
    over, under = abs(share.numerator), share.denominator
    text = ("" if over == 1 else f"{over}") + "π" + ("" if under == 1 else f"/{under}")
    return f"-{text}" if share < 0 else text


def _force_label(largest_n: float, max_force_n: float, acts: bool) -> str:
    """What the colours mean, and how far the force stays below α."""
    words = "actuator force $F_a$ [N]"
    if not acts:
        return f"{words}: next to none, α = {max_force_n:.3g} N"
    if largest_n < 0.995 * max_force_n:
        return f"{words}: at most {largest_n:.2g}, α = {max_force_n:.3g} N"
    return f"{words}: up to α = {max_force_n:.3g} N"


def _draw_cycle(axes: Axes, orbit: Orbit, with_phase: bool, max_force_n: float) -> None:
    """Actuator force, and feedback (or, without phase, spring force), along the limit cycle."""
    x = broken(orbit.phase_rad) if with_phase else orbit.time_s
    axes.plot(x, orbit.actuator_force_n, color=COLOURS[0])
    axes.set_ylabel("actuator $F_a$ [N]", color=COLOURS[0])
    axes.set_ylim(0.0, max(axes.get_ylim()[1], _NEGLIGIBLE * max_force_n))
    other = axes.twinx()
    other.spines["right"].set_visible(True)
    if with_phase:
        phase_axis(axes)
        other.plot(x, orbit.feedback_rad_per_s, color=COLOURS[4], ls="--")
        low, high = other.get_ylim()
        other.set_ylim(min(low, -_SMALL_FEEDBACK), max(high, _SMALL_FEEDBACK))
        other.set_ylabel("feedback f [rad/s]", color=COLOURS[4])
    else:
        axes.set_xlabel("time since the apex [s]")
        axes.set_xlim(0.0, orbit.period_s)
        other.plot(x, orbit.spring_force_n, color=COLOURS[4], ls="--")
        other.set_ylabel("spring $F_k$ [N]", color=COLOURS[4])
        other.set_ylim(bottom=0.0)


def broken(phase_rad: np.ndarray) -> np.ndarray:
    """The phase with a gap where it wraps, so that no line crosses the panel."""
    return np.where(np.abs(np.diff(phase_rad, prepend=phase_rad[:1])) > np.pi, np.nan, phase_rad)


def _arrow(axes: Axes, x: np.ndarray, force: np.ndarray) -> None:
    """An arrow head where the spring force first passes half of its peak, for the direction."""
    here = int(np.argmax(force > 0.5 * np.max(force)))
    before, after = max(here - 3, 0), min(here + 3, len(x) - 1)
    if np.isfinite(x[before] + x[after]):
        axes.annotate(
            "",
            (x[after], force[after]),
            (x[before], force[before]),
            arrowprops={"arrowstyle": "-|>", "color": "black", "mutation_scale": 9},
        )
