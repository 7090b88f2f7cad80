"""Explain why quadruped G gallops, and where.

    python -m research.gaits.gallop everything
    python -m research.gaits.gallop modes   # which mode is light at which frequency; seconds
    python -m research.gaits.gallop map     # gaits over r and place of the mass; half a minute
    python -m research.gaits.gallop figure  # the figure of modes and map

Tables and the figure go to `docs/_static/gaits`. r is ω over the natural rate of pitching with all
feet down, ω / √(Σ K_z x_i² / I_yy), with x_i the hips' distance from the centre of mass.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D

from research.frame import main, write_rows
from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.figures.gaits.style import gait_colour
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.names import NO_GAIT, gait_of, nearest_pattern
from tegotae.parts.bodies import Walker
from tegotae.parts.fields import replace
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import Legged, lanes_of, random_phases
from tegotae.systems.tuned import front_family
from tegotae.systems.vanilla import legged_named

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "_static" / "gaits"
OMEGAS = np.arange(3.0, 8.01, 0.25)
"""Frequencies at which modes are measured [√(g / l0)]."""
LAGS = 64
"""Random lags at each."""
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


# Bodies


def released(
    legged: Legged, bodies: dict[str, np.ndarray], tuned: dict[str, np.ndarray], starts: int
) -> Any:
    """Return the coordination of bodies with different numbers, from the same random releases.

    Args:
        legged: the system.
        bodies: fields of the body, [bodies] or [limbs, bodies].
        tuned: frequency, gain and ellipse, [bodies].
        starts: releases of each.
    """
    kind = front_family(legged, "vanilla ellipse")
    lanes = {name: np.repeat(x, starts) for name, x in tuned.items()}
    changes = {name: np.repeat(x, starts, axis=-1) for name, x in bodies.items()}
    count = len(lanes["omega"])
    scenario = kind.scenario(legged, lanes, np.tile(random_phases(4, starts), count // starts))
    body = legged.body
    sag = 0.25 / np.asarray(changes.get("stiffness_z_n_per_m", body.stiffness_z_n_per_m))  # type: ignore[attr-defined]
    com = np.asarray(changes.get("com_z_m", body.com_z_m))  # type: ignore[attr-defined]
    scenario = scenario._replace(height_m=np.broadcast_to(1.0 + com - sag + lanes["press"], count))
    own_system = dataclasses.replace(legged.system, controller=kind.controller(legged))
    base = legged.timing
    timing = Timing(duration_s=150.0, tick_s=base.tick_s, frame_s=2.0 * base.frame_s)
    rollout = own_system.rollout(legged.summary(), timing)
    return lanes_of(rollout.run(kind.weights(lanes), with_changes(scenario, body, changes), body))


def own_numbers(legged: Legged, omega: np.ndarray) -> dict[str, np.ndarray]:
    """Return the system's gain and ellipse at frequencies."""
    return front_family(legged, "vanilla ellipse").numbers(legged, {"omega": omega})


R, COM_X = np.linspace(0.2, 0.8, 16), np.linspace(-0.3, 0.3, 13)


def mapped() -> None:
    """Write `gallop-map.csv`: gaits over r and com_x, r by ω or by the inertia of pitching."""
    legged, starts, rows = legged_named("quadruped-g"), 4, []
    body: Any = legged.body
    r, com = (x.ravel() for x in np.meshgrid(R, COM_X, indexing="ij"))
    arms = np.array(body.hips_x_m)[:, None] - com
    stiff = body.stiffness_z_n_per_m * (arms**2).sum(axis=0)
    by_omega = r * np.sqrt(stiff / body.inertia_y_kg_m2)
    omega = 7.2
    inertia = stiff * (r / omega) ** 2
    yaw = body.inertia_z_kg_m2 / body.inertia_y_kg_m2
    axes = {
        "omega": ({"com_x_m": com}, by_omega),
        "inertia": (
            {"com_x_m": com, "inertia_y_kg_m2": inertia, "inertia_z_kg_m2": yaw * inertia},
            np.full_like(r, omega),
        ),
    }
    for axis, (bodies, omegas) in axes.items():
        able = possible(legged, bodies)
        bodies = {name: x[..., able] for name, x in bodies.items()}
        results = released(legged, bodies, own_numbers(legged, omegas[able]), starts)
        gait = gait_of(results, legged.names).reshape(-1, starts)
        speed, cost = (
            np.asarray(x).reshape(-1, starts)
            for x in (results.speed_m_per_s, results.cost_of_transport)
        )
        for k, names in enumerate(gait):
            name, count = commonest(names)
            matches = names == name
            rows.append(
                {
                    "by": axis, "r": r[able][k], "com_x": com[able][k], "omega": omegas[able][k],
                    "gait": name, "starts": count,
                    "speed_m_per_s": speed[k][matches].mean(),
                    "cost_of_transport": cost[k][matches].mean(),
                }
            )  # fmt: skip
    write_rows(FOLDER / "gallop-map.csv", rows, digits=4)


def possible(legged: Legged, bodies: dict[str, np.ndarray]) -> np.ndarray:
    """Return the numbers of those bodies that are possible, at the system's tick."""
    able = []
    for k in range(next(iter(bodies.values())).shape[-1]):
        fields = {
            name: tuple(x[:, k].tolist()) if x.ndim > 1 else float(x[k])
            for name, x in bodies.items()
        }
        try:
            replace(legged.body, fields).check_tick(legged.timing.tick_s)
        except TegotaeError:
            continue
        able.append(k)
    return np.array(able, int)


# Figure


def drawn_figure() -> None:
    """Write `gallop.png` of the kept tables: the modes over ω, and the two maps."""
    with styled():
        figure = new_figure(PAGE_IN, 2.9)
        panel, *maps = figure.subplots(1, 3, width_ratios=(1.1, 1.0, 1.0))
        _modes(panel)
        names: list[str] = []
        table = read_csv(FOLDER / "gallop-map.csv")
        for axes, axis, title in zip(maps, ("omega", "inertia"), _TITLES, strict=True):
            names += _map(axes, table, axis)
            axes.set(xlabel="centre of mass, forward [l0]", title=title)
        maps[0].set_ylabel("ω over the rate of pitching, r")
        named_gaits = sorted(set(names), key=lambda name: (name in NO_GAIT, name))
        keys = [
            Line2D([], [], marker="s", ls="", color=gait_colour(n), label=n) for n in named_gaits
        ]
        figure.legend(handles=keys, loc="outside lower center", ncols=5)
        save_figure(figure, FOLDER / "gallop.png")


_TITLES = ("r varied by ω", "r varied by inertia, ω = 7.2")


def _modes(axes: Axes) -> None:
    table = read_csv(FOLDER / "gallop-modes.csv")
    omega = parse_numbers(table["omega"])
    for k, name in enumerate(MODES):
        axes.plot(omega, parse_numbers(table[f"kappa_{name}"]), color=COLOURS[k], label=name)
    axes.axhline(0.0, color="0.6", lw=0.6)
    low = -0.34
    for w, gait in zip(omega, table["gait"], strict=True):
        axes.bar(w, 0.04, 0.25, low, color=gait_colour(str(gait)), lw=0)
    axes.set(xlabel="frequency ω [√(g/l0)]", ylabel="κ [m g]", ylim=(low, 0.5))
    axes.legend(loc="upper left", ncols=2)
    axes.set_title("modes; below, the gait")


def _map(axes: Axes, table: dict[str, np.ndarray], axis: str) -> list[str]:
    rows = table["by"] == axis
    x, y = parse_numbers(table["com_x"][rows]), parse_numbers(table["r"][rows])
    gaits = [str(name) for name in table["gait"][rows]]
    share = parse_numbers(table["starts"][rows]) / 4.0
    colours = [to_rgba(gait_colour(gait), float(s)) for gait, s in zip(gaits, share, strict=True)]
    width, height = COM_X[1] - COM_X[0], R[1] - R[0]
    axes.bar(x, height, width, y - 0.5 * height, color=colours, lw=0)
    return gaits


def everything() -> None:
    """Measure the tables, and draw the figure."""
    for step in (modes, mapped, drawn_figure):
        step()


if __name__ == "__main__":
    main(everything, modes, map=mapped, figure=drawn_figure)
