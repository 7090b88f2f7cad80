"""Measure the sensitivity of the metrics to the definition of a limit cycle: tolerances, period,
repeats, window.

    python -m research.experiments.limit_cycle_sensitivity

writes `limit_cycle_sensitivity.csv` and `.png`, in about two minutes.

The gaits are those of the paper's vanilla controllers, sector and reflex, at ω 3 ... 10 rad/s and
σ 1 ... 8 rad/(s N): 240, of which some are chaotic, some come to rest, and most settle with periods
of 1, 2 or more hops. Each setting is varied by itself, the others being the defaults.

Shares are of all gaits. A mean over those that settle would change with which do; so the means are
over the gaits that settle, and recover from the drop, under every value of the varied setting.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from research.frame import main, write_rows
from tegotae import Hopper, Scenario
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.evaluation import EvaluatedEpisodes, Protocol
from tegotae.measures.hopping import LimitCycle, gait
from tegotae.measures.hopping.gait import Gait
from tegotae.measures.hopping.metrics import LIMIT_CYCLE
from tegotae.systems.recipe import recipe

ACTUATIONS = ("sector", "reflex")
OMEGAS = np.arange(3.0, 11.0)
SIGMAS = np.linspace(1.0, 8.0, 15)
FRAME_S = 0.02

SWEEPS = {
    "height_tolerance_m": (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02),
    "phase_tolerance_rad": (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, math.inf),
    "max_period": (1, 2, 3, 4, 6, 8),
    "min_repeats": (2, 3, 4, 6, 8),
    "window_s": (10.0, 20.0, 40.0, 80.0),
}
"""The settings and their values; the window is the undisturbed time, and that after the drop."""

LABELS = {
    "height_tolerance_m": "height tolerance [m]",
    "phase_tolerance_rad": "phase tolerance [rad]",
    "max_period": "longest period [hops]",
    "min_repeats": "least repeats",
    "window_s": "window [s]",
}
DEFAULT = Protocol()
DEFAULTS = {
    **dataclasses.asdict(DEFAULT.limit_cycle),
    "window_s": DEFAULT.undisturbed_s,
}


def rollouts(window_s: float) -> list:
    """Return the episodes of both actuations: trajectory and time of the drop."""
    protocol = dataclasses.replace(DEFAULT, undisturbed_s=window_s, disturbed_s=window_s)
    sigma, omega = (x.ravel() for x in np.meshgrid(SIGMAS, OMEGAS))
    return [
        EvaluatedEpisodes(
            recipe(f"V-{name}-w8").controller(), sigma[:, None], Scenario(omega), Hopper(), protocol
        ).disturbed()
        for name in ACTUATIONS
    ]


def gaits(episodes: list, window_s: float, limit_cycle: LimitCycle) -> Gait:
    """Detect the gaits of all episodes, arrays of shape [actuations x lanes]."""
    omega = jnp.asarray(np.repeat(OMEGAS, len(SIGMAS)), "float32")
    results = [
        gait(
            trajectory,
            omega=omega,
            rest_length_m=1.0,
            max_force_n=4.0,
            frame_s=FRAME_S,
            undisturbed_s=window_s,
            disturbed_at_s=drop_time_s,
            limit_cycle=limit_cycle,
        )
        for trajectory, drop_time_s in episodes
    ]
    return jax.tree.map(lambda *parts: np.concatenate(parts), *results)


def sweep(setting: str, episodes: list) -> list[dict]:
    """Return a row per value of the setting."""
    results = []
    for value in SWEEPS[setting]:
        if setting == "window_s":
            results.append(gaits(rollouts(value), value, LimitCycle()))
        else:
            varied = dataclasses.replace(LimitCycle(), **{setting: value})
            results.append(gaits(episodes, DEFAULT.undisturbed_s, varied))
    always = np.all([np.isfinite(g.t1_s) for g in results], axis=0)
    rows = []
    for value, g in zip(SWEEPS[setting], results, strict=True):
        settled = g.regime == LIMIT_CYCLE
        rows.append(
            {
                "setting": setting,
                "value": value,
                "is_default": value == DEFAULTS[setting],
                "limit_cycle_share": settled.mean(),
                "recovery_share": np.isfinite(g.t1_s).mean(),
                **{
                    f"period_{k}_share": (g.limit_cycle_period == k).mean()
                    for k in range(1, max(SWEEPS["max_period"]) + 1)
                },
                "gaits_settled_always": int(always.sum()),
                **{
                    name: np.asarray(getattr(g, name))[always].mean()
                    for name in ("t0_s", "t1_s", "cot_inverse", "delta_omega", "delta_w")
                },
            }
        )
    return rows


def draw(rows: list[dict], path: Path) -> None:
    """Draw shares above, mean transients below, over each setting; the default is marked."""
    with styled():
        figure = new_figure(PAGE_IN, 3.6)
        axes = figure.subplots(3, len(SWEEPS), sharex="col", sharey="row")
        for column, setting in zip(axes.T, SWEEPS, strict=True):
            selection = [r for r in rows if r["setting"] == setting]
            positions = np.arange(len(selection))
            default = next(i for i, r in enumerate(selection) if r["is_default"])
            lines = (
                (("limit_cycle_share", "settles", "-o"), ("recovery_share", "recovers", "--s")),
                (("t0_s", "$T_0$", "-o"), ("t1_s", "$T_1$", "--s")),
                (("cot_inverse", "CoT⁻¹", "-o"),),
            )
            for axis, curves in zip(column, lines, strict=True):
                for name, label, style in curves:
                    axis.plot(
                        positions, [r[name] for r in selection], style, label=label, markersize=3
                    )
                axis.axvline(default, color="0.8", lw=4, zorder=0)
            column[-1].set_xlabel(LABELS[setting])
            column[-1].set_xticks(positions, [_short(r["value"]) for r in selection], rotation=45)
        labels = ("share of gaits", "transient [s]", "CoT⁻¹ [m/J]")
        for row, label in zip(axes, labels, strict=True):
            row[0].set_ylabel(label)
            # The axes of a row are shared; the largest of its values lies in any column.
            row[0].set_ylim(
                0.0, 1.15 * max(y for a in row for x in a.lines[:-1] for y in x.get_ydata())
            )
        for axis in axes[:2, 0]:
            axis.legend(loc="lower left")
        figure.align_ylabels(axes[:, 0])
        save_figure(figure, path)


def _short(value: float) -> str:
    return "∞" if value == math.inf else f"{value:g}"


def run() -> None:
    """Run the study, and write its table and figure."""
    episodes = rollouts(DEFAULT.undisturbed_s)
    rows = []
    for setting in SWEEPS:
        rows += sweep(setting, episodes)
        print(f"{setting} done")
    file = Path(__file__).with_suffix(".csv")
    write_rows(file, rows, digits=4)
    draw(rows, file.with_suffix(".png"))


if __name__ == "__main__":
    main(run)
