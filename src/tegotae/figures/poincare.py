"""The Poincaré section at the apex: how a gait settles, and how fast disturbances decay."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from tegotae.analysis.poincare import NUMERICAL, Poincare
from tegotae.figures.data import Table
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.figures.surface import phase_ticks

_SEEN = ("apex_height_m", "apex_phase_rad")
"""The shown part of a point of the section; an oscillator may have more state than its phase."""


def poincare_figure(found: Poincare, transient: np.ndarray, note: str = "") -> Figure:
    """Apexes after the release; decay of a nudge; multipliers in the complex plane.

    Args:
        found: the fixed point and its multipliers.
        transient: apexes from a release on, height [m] and phase [rad], shape [hops, 1 or 2].
        note: a title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.4)
        section, decay, plane = figure.subplots(1, 3)
        figure.suptitle(note, fontsize=8)
        _draw_section(section, found, transient)
        _draw_decay(decay, found)
        _draw_multipliers(plane, found)
    return figure


def poincare_tables(found: Poincare, transient: np.ndarray) -> dict[str, Table]:
    """What the figure shows: `decay` of the nudge, apexes of the `transient`, `multipliers`."""
    names = _SEEN[: len(found.fixed_point)]
    turns = np.arange(len(found.distance))
    return {
        "": {
            "turn": turns,
            **dict(zip(names, found.nudged.T, strict=False)),
            "distance": found.distance,
            "predicted_distance": predicted(found),
        },
        "transient": {
            "hop": np.arange(len(transient)),
            **dict(zip(names, transient.T, strict=True)),
        },
        "multipliers": {
            "real": np.real(found.multipliers),
            "imaginary": np.imag(found.multipliers),
            "modulus": np.abs(found.multipliers),
            "observed_factor": found.observed,
            "refined": found.refined,
            "period_hops": found.hops,
            "period_s": found.period_s,
            "decay_time_s": found.decay_s,
        },
    }


def predicted(found: Poincare) -> np.ndarray:
    """The nudge's distance from the fixed point if the return map were linear, shape [turns]."""
    point = found.nudged[0] - found.fixed_point
    distances = []
    for _ in found.distance:
        distances.append(np.linalg.norm(point))
        point = found.jacobian @ point
    return np.array(distances)


def _draw_section(axes: Axes, found: Poincare, transient: np.ndarray) -> None:
    if len(found.fixed_point) > 1:
        axes.plot(transient[:, 1], transient[:, 0], color="0.75", lw=0.5)
        axes.plot(transient[:, 1], transient[:, 0], ".", color=COLOURS[0], ms=4)
        axes.plot(*transient[0, ::-1], "s", color=COLOURS[2], ms=4, label="first apex")
        axes.plot(
            *found.fixed_point[1::-1], "x", color=COLOURS[4], ms=7, mew=1.4, label=_star(found)
        )
        axes.set_xlabel("phase at the apex φ [rad]")
        phase_ticks(axes.xaxis)
    else:
        axes.plot(transient[:-1, 0], transient[1:, 0], ".", color=COLOURS[0], ms=4)
        axes.plot(transient[0, 0], transient[1, 0], "s", color=COLOURS[2], ms=4, label="first apex")
        if found.hops == 1:
            star = found.fixed_point[0]
            axes.plot(star, star, "x", color=COLOURS[4], ms=7, mew=1.4, label=_star(found))
        axes.axline((transient[0, 0], transient[0, 0]), slope=1.0, color="0.6", lw=0.6)
        axes.set_xlabel("height of the apex before [m]")
    axes.set_ylabel("height of the apex y [m]")
    axes.legend(handletextpad=0.2)


def _star(found: Poincare) -> str:
    return "x*" if found.refined else "x*, not refined"


def _draw_decay(axes: Axes, found: Poincare) -> None:
    turns = np.arange(len(found.distance))
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.semilogy(turns, predicted(found), color="black", lw=0.9, label="linear map")
    axes.semilogy(turns, found.distance, "o", color=COLOURS[0], ms=3, mfc="none", label="simulated")
    shown = np.flatnonzero(found.distance > NUMERICAL)
    axes.set_ylim(NUMERICAL, 3.0 * np.nanmax(found.distance))
    axes.set_xlim(-0.5, shown[-1] + 1.5)
    unit = "hops" if found.hops == 1 else f"turns of {found.hops} hops"
    axes.set_xlabel(unit)
    axes.set_ylabel("distance from x* [m, rad]")
    axes.legend()


def _draw_multipliers(axes: Axes, found: Poincare) -> None:
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color="0.5", lw=0.8))
    axes.axhline(0.0, color="0.85", lw=0.5, zorder=0)
    axes.axvline(0.0, color="0.85", lw=0.5, zorder=0)
    axes.plot(np.real(found.multipliers), np.imag(found.multipliers), "o", color=COLOURS[4], ms=4)
    reach = 1.15 * max(1.0, float(np.abs(found.multipliers).max()))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="Re λ", ylabel="Im λ")
    axes.set_aspect("equal")
    axes.set_title(f"|λ₁| = {abs(found.multipliers[0]):.3f}")
