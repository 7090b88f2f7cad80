"""Fig. 4 of the paper: CoT⁻¹ over gain and frequency, for sector and reflex actuation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from tegotae.analysis.gain_sweep import GainSweep
from tegotae.analysis.ridge import Ridge
from tegotae.figures.data import joined, long_table
from tegotae.figures.maps import draw_quantity, regime_legend
from tegotae.figures.style import COLUMN_IN, new_figure, styled
from tegotae.metrics.gait import REGIMES

# Hollow, and drawn whole though they lie on the panel's edge.
_CENSORED: dict[str, Any] = {
    "ls": "",
    "marker": "o",
    "ms": 2.6,
    "mfc": "white",
    "mec": "black",
    "mew": 0.5,
    "clip_on": False,
    "zorder": 3,
    "in_layout": False,
}
_LABELS = ("CoT$^{-1}$ A  [m/J]", "CoT$^{-1}$ B  [m/J]")


def gain_map_figure(sweeps: Mapping[str, GainSweep], ridges: Mapping[str, Ridge]) -> Figure:
    """CoT⁻¹ A and B over frequency and gain, one row of panels per actuation.

    Args:
        sweeps: by the actuation's name.
        ridges: best gain per frequency by CoT⁻¹ A, drawn with its line; by the same names.
    """
    highest = [
        max(np.nanmax(values(sweep)[part], initial=1e-3) for sweep in sweeps.values())
        for part in range(2)
    ]
    is_censored = any(found.censored.any() for found in ridges.values())
    with styled():
        # The line of the legend that tells of censored gains is two lines high.
        figure = new_figure(COLUMN_IN, (1.3 if is_censored else 0.95) + 1.45 * len(sweeps))
        panels = np.atleast_2d(figure.subplots(len(sweeps), 2, sharex=True, sharey=True))
        for line, (name, sweep) in enumerate(sweeps.items()):
            row = panels[line]
            for part, (panel, value) in enumerate(zip(row, values(sweep), strict=True)):
                mesh = draw_quantity(
                    panel,
                    sweep.omega,
                    sweep.sigma,
                    value,
                    sweep.outcome.regime,
                    vmin=0.0,
                    vmax=highest[part],
                )
                if line == 0:
                    bar = figure.colorbar(mesh, ax=panels[:, part], location="top", aspect=18)
                    bar.set_label(_LABELS[part])
            found = ridges[name]
            fitted = ~found.censored
            for colour, size in (("white", 4.5), ("black", 1.5)):
                at = found.omega[fitted], found.sigma[fitted]
                row[0].plot(*at, ".", color=colour, ms=size, mew=0)
            row[0].plot(found.omega[~fitted], found.sigma[~fitted], **_CENSORED)
            if np.isfinite(found.slope):
                ends = sweep.omega[[0, -1]]
                row[0].plot(ends, found.line(ends), color="white", lw=1.8)
                row[0].plot(ends, found.line(ends), color="black", lw=0.9, ls="--")
            row[0].yaxis.set_major_locator(MaxNLocator(5, integer=True))
            row[0].xaxis.set_major_locator(MaxNLocator(5, integer=True))
            row[0].set_ylabel(f"{name}\ngain σ [rad/(s N)]")
        for panel in panels[-1]:
            panel.set_xlabel("frequency ω [rad/s]")
        handles = [
            Line2D([], [], ls="", marker=".", color="black", ms=3, label="best gain, 1 turn a hop"),
            Line2D([], [], color="black", ls="--", lw=0.9, label="its linear fit"),
        ]
        if is_censored:
            numbers = ", ".join(f"{name} {r.censored.sum()}" for name, r in ridges.items())
            label = f"best gain at the map's edge, not fitted\n({numbers} frequencies)"
            handles.append(Line2D([], [], **_CENSORED, label=label))
        regime_legend(
            figure,
            np.concatenate([sweep.outcome.regime.ravel() for sweep in sweeps.values()]),
            *handles,
            ncols=2,
            columnspacing=1.0,
        )
    return figure


def values(sweep: GainSweep) -> tuple[np.ndarray, np.ndarray]:
    """CoT⁻¹ A and B [m/J], [gains, frequencies]."""
    return sweep.outcome.cot_inverse, sweep.outcome.cot_inverse_total


def gain_map_tables(
    sweeps: Mapping[str, GainSweep], ridges: Mapping[str, Ridge]
) -> dict[str, dict[str, np.ndarray]]:
    """What the figure shows: the maps cell by cell, and `ridge`, with its line."""
    maps = {
        name: long_table(
            ("sigma_rad_per_s_n", sweep.sigma),
            ("omega_rad_per_s", sweep.omega),
            {
                "regime": np.asarray(REGIMES)[sweep.outcome.regime],
                "limit_cycle_period_hops": sweep.outcome.limit_cycle_period,
                "winding_ratio": sweep.outcome.winding_ratio,
                "cot_inverse_a_m_per_j": sweep.outcome.cot_inverse,
                "cot_inverse_b_m_per_j": sweep.outcome.cot_inverse_total,
            },
        )
        for name, sweep in sweeps.items()
    }
    lines = {
        name: {
            "omega_rad_per_s": found.omega,
            "best_sigma_rad_per_s_n": found.sigma,
            "censored": found.censored.astype(int),
            "cot_inverse_a_m_per_j": found.value,
            "fitted_sigma_rad_per_s_n": found.line(found.omega),
        }
        for name, found in ridges.items()
    }
    return {"": joined(maps, "actuation"), "ridge": joined(lines, "actuation")}
