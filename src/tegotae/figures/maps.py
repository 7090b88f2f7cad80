"""Maps: surfaces of force, basins, sweeps of gain and frequency."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MultipleLocator
from matplotlib.typing import ColorType

from tegotae.analysis.maps import Attractor, HopperBasin
from tegotae.analysis.orbit import Orbit
from tegotae.analysis.surface import Surface
from tegotae.figures.style import (
    COLOURS,
    COLUMN_IN,
    SEQUENTIAL,
    Table,
    long_table,
    new_figure,
    styled,
)
from tegotae.measures.hopping.episode import AT_REST, FAILED, REGIMES, UNSETTLED
from tegotae.parts._shapes import AnyArray
from tegotae.training.environments.baseline import VanillaSweep

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


_FILL = {AT_REST: "0.9", UNSETTLED: "white", FAILED: "black"}
_HATCH = {AT_REST: "/////", UNSETTLED: None, FAILED: None}
_HATCH_COLOUR = "0.55"


def quantities() -> Colormap:
    """The sequential colour map without its darkest part, which would pass for black."""
    colours = matplotlib.colormaps[SEQUENTIAL](np.linspace(0.12, 1.0, 256))
    return LinearSegmentedColormap.from_list("quantities", colours)


def draw_regimes(axes: Axes, x: np.ndarray, y: np.ndarray, regime: AnyArray) -> None:
    """Colour the cells without limit cycle: hatched at rest, white unsettled, black failed.

    Args:
        x: values along the horizontal axis, shape [columns].
        y: values along the vertical axis, shape [rows].
        regime: indices into `REGIMES`, shape [rows, columns].
    """
    for kind, colour in _FILL.items():
        cells = np.ma.masked_where(regime != kind, np.ones(regime.shape))
        axes.pcolormesh(x, y, cells, cmap=ListedColormap([colour]), rasterized=True)
    rests = regime == AT_REST
    if rests.any():
        # Contours reach only to the middle of the outer cells.
        wide = np.pad(rests.astype(float), 1, mode="edge")
        hatched = axes.contourf(
            _outer(x), _outer(y), wide, levels=[0.5, 1.5], colors="none", hatches=[_HATCH[AT_REST]]
        )
        hatched.set(edgecolor=_HATCH_COLOUR, linewidth=0.0)
    axes.set(xlim=_edges(x), ylim=_edges(y))
    axes.spines[["top", "right"]].set_visible(True)


def draw_quantity(
    axes: Axes, x: np.ndarray, y: np.ndarray, value: AnyArray, regime: AnyArray, **how: Any
) -> QuadMesh:
    """Draw a quantity where there is a limit cycle, and elsewhere the regime; returns the mesh.

    Args:
        value: shape [rows, columns], NaN where undefined.
        how: limits and colours, as for matplotlib's `pcolormesh`.
    """
    draw_regimes(axes, x, y, regime)
    shown = np.ma.masked_where((regime <= UNSETTLED) | ~np.isfinite(value), value)
    how.setdefault("cmap", quantities())
    return axes.pcolormesh(x, y, shown, rasterized=True, **how)


def draw_categories(
    axes: Axes, x: np.ndarray, y: np.ndarray, category: np.ndarray, number: int
) -> list[tuple[float, float, float, float]]:
    """Colour the cells by category, in steps of lightness; returns the colours.

    Args:
        category: 0 ... number - 1, or -1 for none, shape [rows, columns].
        number: how many categories there are.
    """
    # The most common category first, in the middle of the scale; its neighbours far from it.
    steps = [0.5, 1.0, 0.0, 0.75, 0.25, 0.88][:number]
    colours = [quantities()(step) for step in steps]
    if number:
        cells = np.ma.masked_where(category < 0, category)
        mesh = axes.pcolormesh(x, y, cells, cmap=ListedColormap(colours), rasterized=True)
        mesh.set_clim(-0.5, number - 0.5)
    return colours


def category_patch(colour: ColorType, label: str) -> Patch:
    """A category's handle in the legend."""
    return Patch(facecolor=colour, edgecolor=_HATCH_COLOUR, lw=0.5, label=label)


def regime_legend(figure: Figure, present: AnyArray, *more: Artist, **how: Any) -> None:
    """Say below the panels what the colours without a value mean.

    Args:
        present: regimes that occur.
        more: further handles.
    """
    patches = [
        Patch(
            facecolor=_FILL[kind], hatch=_HATCH[kind], edgecolor=_HATCH_COLOUR, lw=0.5,
            label=REGIMES[kind],
        )
        for kind in (AT_REST, UNSETTLED, FAILED)
        if np.any(present == kind)
    ]  # fmt: skip
    handles = [*more, *patches]
    if handles:
        how.setdefault("ncols", 3)
        figure.legend(handles=handles, loc="outside lower center", handlelength=1.6, **how)


def _outer(x: np.ndarray) -> np.ndarray:
    """The values, and one more at the outer edge of either end."""
    low, high = _edges(x)
    return np.concatenate([[low], x, [high]])


def _edges(x: np.ndarray) -> tuple[float, float]:
    """The outer edges of cells centred at these values."""
    return float(x[0] - 0.5 * (x[1] - x[0])), float(x[-1] + 0.5 * (x[-1] - x[-2]))


_MOST = 5  # limit cycles with a colour of their own


def basin_figure(basin: HopperBasin, note: str = "") -> Figure:
    """Which limit cycle each release ends in; the legend says how common it is."""
    shown = min(len(basin.attractors), _MOST)
    category = np.minimum(basin.attractor, shown)
    with styled():
        figure = new_figure(COLUMN_IN, 2.9 + 0.13 * shown)
        axes = figure.subplots()
        with_phase = basin.phase_rad is not None
        x = basin.phase_rad if basin.phase_rad is not None else basin.velocity_m_per_s
        draw_regimes(axes, x, basin.height_m, basin.outcome.regime)
        rest = len(basin.attractors) > shown
        colours = draw_categories(axes, x, basin.height_m, category, shown + rest)
        if with_phase:
            phase_axis(axes, "phase at release φ [rad]")
        else:
            axes.set_xlabel("velocity at release ẏ [m/s]")
        axes.set_ylabel("release height y [m]")
        axes.set_title(note)
        patches = [
            category_patch(colour, describe(attractor))
            for colour, attractor in zip(colours, basin.attractors[:shown], strict=False)
        ]
        if rest:
            share = sum(attractor.share for attractor in basin.attractors[shown:])
            label = f"{len(basin.attractors) - shown} other limit cycles ({share:.1%})"
            patches.append(category_patch(colours[-1], label))
        regime_legend(figure, basin.outcome.regime, *patches, ncols=1)
    return figure


def describe(attractor: Attractor) -> str:
    """A limit cycle in a line: hops, turns, height, share of releases."""
    hops = "1 hop" if attractor.hops == 1 else f"{attractor.hops} hops"
    turns = {None: "", 1: ", 1 turn"}.get(attractor.turns, f", {attractor.turns} turns")
    return f"{hops}{turns}, apex {attractor.apex_height_m:.2f} m ({attractor.share:.1%})"


def basin_tables(basin: HopperBasin) -> dict[str, dict[str, np.ndarray]]:
    """What the figure shows, release by release, and `cycles`."""
    across = (
        ("phase_rad", basin.phase_rad)
        if basin.phase_rad is not None
        else ("velocity_m_per_s", basin.velocity_m_per_s)
    )
    releases = long_table(
        ("height_m", basin.height_m),
        across,
        {
            "regime": np.asarray(REGIMES)[basin.outcome.regime],
            "limit_cycle": basin.attractor,
            "limit_cycle_period_hops": basin.outcome.limit_cycle_period,
            "winding_ratio": basin.outcome.winding_ratio,
            "apex_height_m": basin.outcome.apex_height_m,
            "cot_inverse_a_m_per_j": basin.outcome.cot_inverse,
        },
    )
    found = basin.attractors
    cycles = {
        "limit_cycle": np.arange(len(found)),
        "hops": np.array([a.hops for a in found]),
        "turns": np.array([np.nan if a.turns is None else a.turns for a in found]),
        "apex_height_m": np.array([a.apex_height_m for a in found]),
        "cot_inverse_a_m_per_j": np.array([a.cot_inverse for a in found]),
        "share": np.array([a.share for a in found]),
    }
    return {"": releases, "cycles": cycles}


def vanilla_sweep_figure(sweep: VanillaSweep, *, fitness: str = "fitness") -> Figure:
    """Fitness over ω and σ; dots mark the best gain of each frequency, black what failed.

    Args:
        sweep: what was swept.
        fitness: what the colours are called.
    """
    rows, columns = np.arange(len(sweep.sigma)), np.arange(len(sweep.omega))
    sound = np.ma.masked_where(sweep.failed, sweep.fitness)
    with styled():
        figure = new_figure(3.5, 3.0)
        axes = figure.add_subplot()
        failed = np.ma.masked_where(~sweep.failed, np.ones(sweep.failed.shape))
        axes.pcolormesh(columns, rows, failed, cmap=ListedColormap(["black"]), rasterized=True)
        mesh = axes.pcolormesh(columns, rows, sound, cmap=quantities(), rasterized=True)
        figure.colorbar(mesh, ax=axes).set_label(fitness)
        best = np.argmax(sweep.fitness, axis=0)
        axes.plot(columns, best, "o", ms=3, mfc="white", mec="black", mew=0.6)
        shown = rows[:: max(1, len(rows) // 8)]
        axes.set_yticks(shown, [f"{sweep.sigma[i]:.2g}" for i in shown])
        axes.set_xticks(columns, [f"{omega:.3g}" for omega in sweep.omega])
        axes.set(xlabel="frequency ω [rad/s]", ylabel="gain σ [rad/(s N)]")
    return figure


def vanilla_sweep_table(sweep: VanillaSweep) -> dict[str, np.ndarray]:
    """What the figure shows, a row a cell."""
    return long_table(
        ("sigma_rad_per_s_n", sweep.sigma),
        ("omega_rad_per_s", sweep.omega),
        {
            "fitness": sweep.fitness,
            "cot_inverse_m_per_j": sweep.cot_inverse,
            "failed": sweep.failed.astype(int),
        },
    )
