"""The vanilla baseline of an environment over gain and frequency."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from tegotae.figures.data import long_table
from tegotae.figures.maps import quantities
from tegotae.figures.style import new_figure, styled
from tegotae.training.environments.baseline import VanillaSweep


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
