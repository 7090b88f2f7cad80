"""Explain why quadruped G gallops, and where.

    python -m research.gaits.gallop run     # which mode is light at which frequency; seconds
    python -m research.gaits.gallop figure  # the figure of the kept table

The table and the figure go to `docs/_static/gaits`. r is ω over the natural rate of pitching with
all feet down, ω / √(Σ K_z x_i² / I_yy), with x_i the hips' distance from the centre of mass.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pandas as pd

from research.frame import main, write_rows
from tegotae.figures.gaits.style import gait_colour
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.names import gait_of, nearest_pattern
from tegotae.parts.bodies import Walker
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.systems.legged import Legged, lanes_of, random_phases
from tegotae.systems.vanilla import legged_named

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "_static" / "gaits"
OMEGAS = np.arange(3.0, 8.01, 0.25)
"""Frequencies at which modes are measured [√(g / l0)]."""
LAGS = 64
"""Random lags at each."""
LOWEST = -0.34
"""Lower end of the figure's axis."""
MODES = {
    "heave": (1, 1, 1, 1), "pitch": (1, 1, -1, -1), "roll": (1, -1, 1, -1), "twist": (1, -1, -1, 1),
}  # fmt: skip
"""Signs of the modes at left fore, right fore, left hind, right hind."""


def pitch_rate(body: Walker) -> float:
    """Return the natural rate of pitching with all feet down, √(Σ K_z x_i² / I_yy) [√(g / l0)]."""
    arms = np.array(body.hips_x_m) - body.com_x_m
    return float(np.sqrt(body.stiffness_z_n_per_m * (arms**2).sum() / body.inertia_y_kg_m2))


# Modes


@needing("spring_force_n", "phase_rad", "time_s", "failed")
def harmonics(trajectory: Any, scenario: Any, body: Any, timing: Timing) -> Any:
    """Return ⟨N cos φ⟩ and ⟨N sin φ⟩ of every leg over the last whole strides, and its last
    phase.
    """
    t = trajectory
    stride = 2.0 * jnp.pi / scenario.omega
    span = jnp.floor(0.5 * timing.duration_s / stride) * stride
    count = (t.time_s[-1] - t.time_s < span).astype(t.time_s.dtype)[:, None]

    def mean(x: Any) -> Any:
        return (count * x).sum(axis=0) / count.sum(axis=0)

    load, phase = t.spring_force_n, t.phase_rad
    return mean(load * jnp.cos(phase)), mean(load * jnp.sin(phase)), phase[-1], t.failed[-1]


def coupling(legged: Legged) -> list[dict[str, Any]]:
    """Compute the coupling of a body's legs through their steps, by mode, at every frequency.

    Legs turn at ω without feedback, at random lags. To first order in σ the phases then obey

        φ̇_i = ω - σ ⟨N_i cos φ_i⟩ = ω - ½ σ Re Σ_j G_ij exp(i (φ_j - φ_i)),

    with G fitted to the loads. Its imaginary part on the pattern of a mode, κ = uᵀ Im G u, draws
    the legs towards this pattern if it is positive, and away from it if it is negative.
    """
    still = dataclasses.replace(legged, weights=(0.0,))
    phase = np.tile(random_phases(4, LAGS), len(OMEGAS))
    scenario = still.scenario(phase)._replace(omega=np.repeat(OMEGAS, LAGS))
    tick = legged.timing.tick_s
    timing = Timing(duration_s=60.0, tick_s=tick, frame_s=5.0 * tick)
    cosine, sine, last, fell = still.rollout(harmonics, timing).run((0.0,), scenario, legged.body)
    rows = []
    for k, omega in enumerate(OMEGAS):
        lanes = np.arange(k * LAGS, (k + 1) * LAGS)
        lanes = lanes[~fell[lanes].astype(bool)]
        matrix, explained = fitted((cosine - 1j * sine)[:, lanes], last[:, lanes])
        rows.append(
            {
                "omega": omega,
                "r": omega / pitch_rate(legged.body),  # type: ignore[arg-type]
                **{
                    f"kappa_{name}": 0.25 * np.real(np.array(u) @ matrix.imag @ np.array(u))
                    for name, u in MODES.items()
                },
                "explained": explained,
                "averaged_gait": averaged(matrix, legged),
            }
        )
    return rows


def fitted(loads: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit G of ⟨N_i exp(-i φ_i)⟩ = ½ Σ_j G_ij exp(i (φ_j - φ_i)); return it and the share that it
    explains.
    """
    matrix, residual, total = np.zeros((4, 4), complex), 0.0, 0.0
    for i in range(4):
        phasors = np.exp(1j * (phase - phase[i])).T
        row, *_ = np.linalg.lstsq(phasors, loads[i], rcond=None)
        matrix[i] = 2.0 * row
        residual += np.abs(loads[i] - phasors @ row).var()
        total += np.abs(loads[i] - loads[i].mean()).var()
    return matrix, 1.0 - residual / total


def averaged(matrix: np.ndarray, legged: Legged) -> str:
    """Return the gait in which most of 64 random starts of the averaged equations end."""
    phase = random_phases(4, 64, 1)
    for _ in range(5000):
        phasors = np.exp(1j * (phase[None] - phase[:, None]))
        phase = phase - 0.05 * np.real((matrix[:, :, None] * phasors).sum(axis=1))
    lag = (phase[legged.reference] - phase) / (2.0 * np.pi) % 1.0
    names, counts = np.unique(nearest_pattern(lag, legged.names), return_counts=True)
    return str(names[counts.argmax()])


def emerged(legged: Legged) -> list[dict[str, Any]]:
    """Return the gait of 12 random starts with feedback at every frequency."""
    starts = 12
    phase = np.tile(random_phases(4, starts), len(OMEGAS))
    scenario = legged.scenario(phase)._replace(omega=np.repeat(OMEGAS, starts))
    results = lanes_of(legged.run(legged.summary(), scenario))
    gait = gait_of(results, legged.names).reshape(len(OMEGAS), starts)
    rows = []
    for k, names in enumerate(gait):
        name, count = commonest(names)
        lanes = np.arange(k * starts, (k + 1) * starts)[names == name]
        rows.append(
            {
                "gait": name,
                "starts": count,
                **{
                    column: np.mean(np.asarray(getattr(results, column))[..., lanes])
                    for column in _OF_GAIT
                },
            }
        )
    return rows


_OF_GAIT = ("speed_m_per_s", "cost_of_transport", "duty_factor", "flight_share", "lock_time_s")


def commonest(names: np.ndarray) -> tuple[str, int]:
    """Return the most common name, and how often it occurs."""
    gaits, counts = np.unique(names, return_counts=True)
    return str(gaits[counts.argmax()]), int(counts.max())


def modes() -> None:
    """Write `gallop-modes.csv`."""
    legged = legged_named("quadruped-g")
    rows = [a | b for a, b in zip(coupling(legged), emerged(legged), strict=True)]
    write_rows(FOLDER / "gallop-modes.csv", rows, digits=4)


def draw() -> None:
    """Write `gallop.png` of the kept table: the modes over ω, and the gaits that emerge."""
    table = pd.read_csv(FOLDER / "gallop-modes.csv")
    with styled():
        figure = new_figure(0.6 * PAGE_IN, 2.6)
        axes = figure.subplots()
        for k, name in enumerate(MODES):
            axes.plot(table.omega, table[f"kappa_{name}"], color=COLOURS[k], label=name)
        axes.axhline(0.0, color="0.6", lw=0.6)
        for gait, rows in table.groupby("gait"):
            axes.bar(rows.omega, 0.04, 0.25, LOWEST, color=gait_colour(gait), lw=0, label=gait)
        axes.set(xlabel="frequency ω [√(g/l0)]", ylabel="κ [m g]", ylim=(LOWEST, 0.5))
        axes.set_title("modes; below, the gait")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")
        save_figure(figure, FOLDER / "gallop.png")


def run() -> None:
    """Measure the modes, and draw them."""
    modes()
    draw()


if __name__ == "__main__":
    main(run, modes, figure=draw)
