"""Fig. 4 of the paper: CoT⁻¹ over gain and frequency, for sector and reflex actuation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from research.reproduction.ridge import Ridge, find_losses, find_resonance
from tegotae.analysis.maps import GainSweep
from tegotae.figures.maps import draw_regimes, quantities, regime_legend
from tegotae.figures.style import COLOURS, COLUMN_IN, long_table, new_figure, styled
from tegotae.measures.hopping.metrics import REGIMES, UNSETTLED
from tegotae.measures.optimum import curve
from tegotae.parts._shapes import AnyArray

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


def gain_map_figure(
    sweeps: Mapping[str, GainSweep], ridges: Mapping[str, Ridge], *, optimum: bool = False
) -> Figure:
    """Draw CoT⁻¹ A and B over frequency and gain, one row of panels per actuation.

    Below, the best of each frequency beside the largest CoT⁻¹ A that any force can have
    (`tegotae.measures.optimum.curve`), where that is known for the body. It is that at any
    frequency: strong
    feedback slows the oscillator, so that a gait of one turn a hop hops more slowly than ω.

    Args:
        sweeps: by the actuation's name.
        ridges: best gain per frequency by CoT⁻¹ A, drawn with its line; by the same names.
        optimum: whether the body and the definition of work are those of the kept optimum.
    """
    highest = [
        max(np.nanmax(cot_inverse_maps(sweep)[part], initial=1e-3) for sweep in sweeps.values())
        for part in range(2)
    ]
    is_censored = any(ridge.censored.any() for ridge in ridges.values())
    with styled():
        # The line of the legend on censored gains is two lines high.
        height = (1.3 if is_censored else 0.95) + 1.45 * len(sweeps) + 1.0
        figure = new_figure(COLUMN_IN, height)
        rows = figure.subplots(
            len(sweeps) + 1, 2, sharex=True, height_ratios=[1.45] * len(sweeps) + [1.0]
        )
        panels, (below, unused) = rows[:-1], rows[-1]
        unused.axis("off")
        for panel in panels[:, 1]:
            panel.sharey(panels[0, 0])
            panel.tick_params(labelleft=False)
        for line, (name, sweep) in enumerate(sweeps.items()):
            row = panels[line]
            for part, (panel, value) in enumerate(zip(row, cot_inverse_maps(sweep), strict=True)):
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
            ridge = ridges[name]
            fitted = ~ridge.censored
            for colour, size in (("white", 4.5), ("black", 1.5)):
                points = ridge.omega[fitted], ridge.sigma[fitted]
                row[0].plot(*points, ".", color=colour, ms=size, mew=0)
            row[0].plot(ridge.omega[~fitted], ridge.sigma[~fitted], **_CENSORED)
            if np.isfinite(ridge.slope):
                ends = sweep.omega[[0, -1]]
                row[0].plot(ends, ridge.line(ends), color="white", lw=1.8)
                row[0].plot(ends, ridge.line(ends), color="black", lw=0.9, ls="--")
            row[0].yaxis.set_major_locator(MaxNLocator(5, integer=True))
            row[0].xaxis.set_major_locator(MaxNLocator(5, integer=True))
            row[0].set_ylabel(f"{name}\ngain σ [rad/(s N)]")
        _beside_the_optimum(below, ridges, has_optimum=optimum)
        unused.legend(*below.get_legend_handles_labels(), loc="center left")
        panels[-1, 1].tick_params(labelbottom=True)
        for panel in (below, panels[-1, 1]):
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


def _beside_the_optimum(panel: Axes, ridges: Mapping[str, Ridge], *, has_optimum: bool) -> None:
    """Draw the best CoT⁻¹ A of each frequency, and the largest possible."""
    for colour, (name, ridge) in zip((COLOURS[0], COLOURS[4]), ridges.items(), strict=False):
        panel.plot(ridge.omega, ridge.value, ".", ms=2.5, mew=0, color=colour, label=f"best {name}")
    if has_optimum:
        largest = np.max(curve()["cot_inverse"])
        panel.axhline(largest, color="black", lw=0.9, label="physical optimum")
    panel.set_ylim(0.0, 1.08 * panel.get_ylim()[1])
    panel.set_ylabel("CoT$^{-1}$ A\n[m/J]")


def cot_inverse_maps(sweep: GainSweep) -> tuple[AnyArray, AnyArray]:
    """Return CoT⁻¹ A and B [m/J], [gains, frequencies]."""
    return sweep.outcome.cot_inverse, sweep.outcome.cot_inverse_total


def gain_map_tables(
    sweeps: Mapping[str, GainSweep], ridges: Mapping[str, Ridge]
) -> dict[str, pd.DataFrame]:
    """Return the data of the figure: the maps cell by cell, and `ridge`, with its line.

    Beside it, over all limit cycles: `resonance`, the best frequency of each gain, and `loss`, the
    share of CoT⁻¹ A that is lost beside each frequency at its best gain.
    """
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
            "omega_rad_per_s": ridge.omega,
            "best_sigma_rad_per_s_n": ridge.sigma,
            "censored": ridge.censored.astype(int),
            "cot_inverse_a_m_per_j": ridge.value,
            "fitted_sigma_rad_per_s_n": ridge.line(ridge.omega),
        }
        for name, ridge in ridges.items()
    }
    resonances, losses = {}, {}
    for name, sweep in sweeps.items():
        axes = sweep.sigma, sweep.omega, sweep.outcome.cot_inverse
        best, detuning = find_resonance(*axes), find_losses(*axes)
        resonances[name] = {
            "sigma_rad_per_s_n": best.sigma,
            "best_omega_rad_per_s": best.omega,
            "cot_inverse_a_m_per_j": best.value,
        }
        losses[name] = {
            "omega_rad_per_s": detuning.omega,
            "best_sigma_rad_per_s_n": detuning.sigma,
            "cot_inverse_a_lost": detuning.loss,
        }
    return {
        "": _joined(maps),
        "ridge": _joined(lines),
        "resonance": _joined(resonances),
        "loss": _joined(losses),
    }


def _joined(tables: Mapping[str, Any]) -> pd.DataFrame:
    """Join tables of the same columns below each other, each with its actuation."""
    frames = {name: pd.DataFrame(table) for name, table in tables.items()}
    return pd.concat(frames, names=["actuation"]).reset_index("actuation")


def draw_quantity(
    axes: Axes, x: np.ndarray, y: np.ndarray, value: AnyArray, regime: AnyArray, **options: Any
) -> QuadMesh:
    """Draw a quantity where there is a limit cycle, and elsewhere the regime; returns the mesh.

    Args:
        value: shape [rows, columns], NaN where undefined.
        how: limits and colours, as for matplotlib's `pcolormesh`.
    """
    draw_regimes(axes, x, y, regime)
    visible = np.ma.masked_where((regime <= UNSETTLED) | ~np.isfinite(value), value)
    return axes.pcolormesh(x, y, visible, rasterized=True, **{"cmap": quantities(), **options})
