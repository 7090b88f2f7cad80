"""Basins of attraction over release height and phase."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tegotae.analysis.basin import Attractor, HopperBasin
from tegotae.figures.data import long_table
from tegotae.figures.maps import category_patch, draw_categories, draw_regimes, regime_legend
from tegotae.figures.style import COLUMN_IN, new_figure, styled
from tegotae.figures.surface import phase_axis
from tegotae.measures.hopping.gait import REGIMES

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
