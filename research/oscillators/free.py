"""The oscillators free and on a hopper, and ways for feedback to enter them.

    python -m research.oscillators.free

writes `free.png`, `entrained.png` and `entry.csv` to `research/oscillators`, in some minutes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure

from research.frame import main
from tegotae import Rollout, Scenario, Timing
from tegotae._support.files import output_folder
from tegotae._support.tables import write_csv
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.metrics import FAILED, LIMIT_CYCLE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import (
    AdaptiveHopf,
    Hopf,
    Learned,
    Matsuoka,
    VanDerPol,
)
from tegotae.parts.terms import (
    ConstantGain,
    Sector,
    UnitAction,
    VanillaAction,
    VanillaReaction,
)

DOCS = Path(__file__).resolve().parents[2] / "docs"

SHOWN = {
    "Hopf": Hopf(),
    "adaptive Hopf": AdaptiveHopf(),
    "van der Pol, μ = 1": VanDerPol(),
    "Matsuoka": Matsuoka(),
}
OMEGA = 8.0
SIGMAS = (1.0, 2.0, 4.0, 8.0)
STARTS = (0.0, 1.5, 3.0, 4.5)
ENTRIES = {
    "turn": (False, 1.0, 0.0),
    "input f": (False, 0.0, 1.0),
    "input -f": (False, 0.0, -1.0),
    "input f/5": (False, 0.0, 0.2),
    "input -f/5": (False, 0.0, -0.2),
    "input load": (True, 0.0, 1.0),
    "input -load": (True, 0.0, -1.0),
    "input load/5": (True, 0.0, 0.2),
    "input -load/5": (True, 0.0, -0.2),
}
"""Variants of an entry: True if the action is 1, so that f = σ F_k; the factor by which f turns the
state; the factor by which f is an input."""


@dataclass(frozen=True)
class Pictures:
    """Draw, and compare."""

    out: Path = DOCS.parent / "research" / "oscillators"
    """Folder of figures and table."""

    def run(self) -> None:
        """Run the whole study."""
        output_folder(self.out)
        save_figure(draw_free(), self.out / "free.png")
        rows: list[dict[str, Any]] = []
        paths = {}
        for name, oscillator in SHOWN.items():
            for with_load in (False, True):
                entries = {k: v[1:] for k, v in ENTRIES.items() if v[0] == with_load}
                path, gait = driven(oscillator, entries, with_load)
                rows += compared(name, entries, gait)
                if not with_load:
                    paths[name] = path, int(np.argmax(gait.regime == LIMIT_CYCLE))
            print(name, flush=True)
        columns = {key: [row[key] for row in rows] for key in rows[0]}
        write_csv(self.out / "entry.csv", columns, digits=3)
        save_figure(draw_entrained(paths), self.out / "entrained.png")


def free(oscillator: Any, duration_s: float = 12.0, step_s: float = 0.002) -> np.ndarray:
    """Return the phase and radius of an oscillator by itself, [2, steps]: improved Euler steps."""

    @jax.jit
    def run() -> Any:
        omega, none = jnp.full(1, OMEGA), jnp.zeros(1)

        def step(state: Any, _: Any) -> Any:
            first = oscillator.rate(state, omega, none)
            ahead = jax.tree.map(lambda x, dx: x + step_s * dx, state, first)
            second = oscillator.rate(ahead, omega, none)
            state = jax.tree.map(lambda x, a, b: x + 0.5 * step_s * (a + b), state, first, second)
            return state, (state.phase, state.radius)

        start = oscillator.start(jnp.zeros(1))._replace(radius=jnp.full(1, 0.2))
        return jax.lax.scan(step, start, None, length=round(duration_s / step_s))[1]

    return np.array(run())[:, :, 0]


def driven(oscillator: Any, entries: dict[str, tuple[float, float]], with_load: bool) -> Any:
    """Simulate a hopper with a sector: trajectory and gait, one lane per entry, σ and start."""
    action = UnitAction() if with_load else VanillaAction()
    learned = Learned(oscillator)
    law = Tegotae(action, VanillaReaction(), ConstantGain())
    controller = Controller(Sector(), learned, law)
    lanes = [
        (sigma, turn, push, start)
        for turn, push in entries.values()
        for sigma in SIGMAS
        for start in STARTS
    ]
    weights = np.zeros((len(lanes), controller.n_weights))
    offset = controller.layout["oscillator"].start
    names = learned.names
    sigma, turn, push, start = np.array(lanes).T
    weights[:, 0] = sigma
    weights[:, offset + names.index("turn")] = turn - 1.0
    weights[:, offset + names.index("push")] = push
    rollout = Rollout(
        controller=controller, timing=Timing(duration_s=60.0), summary=trajectory_and_gait
    )
    return rollout.run(weights, Scenario(omega=OMEGA, phase_rad=start))


def trajectory_and_gait(trajectory, scenario, body, timing):
    """Return the trajectory for the pictures and the gait for the comparison."""
    channels = {
        name: trajectory.channels[name] for name in ("time_s", "height_m", "phase_rad", "radius")
    }
    return channels, GaitSummary()(trajectory, scenario, body, timing)


def compared(name: str, entries: dict[str, Any], gait: Any) -> list[dict[str, Any]]:
    """Return one row per entry: the share of lanes that settle, and the speed and efficiency of
    their hopping.
    """
    rows = []
    settled = (gait.regime == LIMIT_CYCLE).reshape(len(entries), -1)
    failed = (gait.regime == FAILED).reshape(len(entries), -1)
    for row, entry in enumerate(entries):
        inside = settled[row]

        def mean(values: np.ndarray, row: int = row, inside: np.ndarray = inside) -> float:
            settled_values = values.reshape(len(entries), -1)[row][inside]
            return (
                float(np.nanmean(settled_values))
                if np.isfinite(settled_values).any()
                else float("nan")
            )

        rows.append(
            {
                "oscillator": name,
                "entry": entry,
                "settled_share": float(inside.mean()),
                "failed_share": float(failed[row].mean()),
                "hop_rate_rad_per_s": mean(gait.hop_rate),
                "cot_inverse_m_per_j": mean(gait.cot_inverse),
            }
        )
    return rows


def draw_free() -> Figure:
    """Draw the way from a small radius to the limit cycle in the plane, and the sine of the
    phase."""
    with styled():
        figure = new_figure(PAGE_IN, 3.6)
        planes, waves = figure.subplots(2, len(SHOWN), height_ratios=(1.6, 1.0))
        for plane, wave, (name, oscillator) in zip(planes, waves, SHOWN.items(), strict=True):
            phase, radius = free(oscillator)
            late = slice(len(phase) * 3 // 4, None)
            x, y = radius * np.cos(phase), radius * np.sin(phase)
            plane.plot(x, y, color="0.7", lw=0.6)
            plane.plot(x[late], y[late], color=COLOURS[0], lw=1.4)
            plane.set_title(name, loc="left")
            plane.set_aspect("equal")
            plane.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), xlabel="r cos φ")
            turns = 0.002 * np.arange(len(phase)) * OMEGA / (2.0 * np.pi)
            window = turns > turns[-1] - 2.0
            time_turns = turns[window] - turns[window][0]
            wave.plot(time_turns, np.sin(phase[window]), color=COLOURS[0], label="sin φ")
            wave.plot(time_turns, radius[window], color=COLOURS[1], label="r")
            wave.set(xlabel="ω t / 2π", ylim=(-1.6, 1.6))
        planes[0].set_ylabel("r sin φ")
        figure.legend(*waves[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def draw_entrained(paths: dict[str, Any]) -> Figure:
    """Draw the last hops with feedback that turns the state, at the least σ that settles."""
    with styled():
        figure = new_figure(PAGE_IN, 3.0)
        heights, waves = figure.subplots(2, len(paths), sharex=True, sharey="row")
        for height, wave, (name, (path, lane)) in zip(heights, waves, paths.items(), strict=True):
            window = path["time_s"][:, lane] > 57.5
            time = path["time_s"][window, lane] - 57.5
            height.plot(time, path["height_m"][window, lane], color=COLOURS[0])
            height.axhline(1.0, color="0.6", lw=0.5)
            height.set_title(f"{name}, σ = {SIGMAS[lane // len(STARTS)]:g}", loc="left")
            wave.plot(
                time, np.sin(path["phase_rad"][window, lane]), color=COLOURS[0], label="sin φ"
            )
            wave.plot(time, path["radius"][window, lane], color=COLOURS[1], label="r")
            wave.set_xlabel("time [s]")
        heights[0].set_ylabel("height [m]")
        figure.legend(*waves[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


if __name__ == "__main__":
    main(Pictures)
