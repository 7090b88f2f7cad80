"""The pictures of a controller's page: its curves over what it visits, and its rate over ω."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.explanation import Evaluated, Visits
from tegotae.analysis.surface import Surface
from tegotae.figures.cycles import draw_surface, phase_axis
from tegotae.figures.intervals import draw_intervals
from tegotae.figures.style import COLOURS, COLUMN_IN, PAGE_IN, literal_text, new_figure, styled
from tegotae.measures.statistics import Interval
from tegotae.parts.maths import TWO_PI

_DOTS = 3000
"""So many moments are drawn at most."""


@styled()
def explanation_figure(
    name: str,
    visited: Sequence[Visits],
    surface: Surface | None,
    evaluated: Mapping[str, Evaluated],
) -> Figure:
    """Draw A′ over phase with the density of visits, G R over load, the force, and the rate over ω.

    Args:
        name: of the controller.
        visited: what its gait visits, set of weights by set.
        surface: its force over phase and spring force; None leaves φ̇ in its place.
        evaluated: whole, cut and frozen.
    """
    figure = new_figure(PAGE_IN, 4.6)
    figure.suptitle(literal_text(name), fontsize=9)
    (action, reaction), (force, rate) = figure.subplots(2, 2)
    for i, v in enumerate(visited):
        some = slice(None, None, max(1, len(v.load) // _DOTS))
        order = np.argsort(v.phase_rad[some])
        dots = {"color": COLOURS[i % len(COLOURS)], "ms": 1.5, "ls": "", "marker": "."}
        action.plot(v.phase_rad[some][order], v.action[some][order], **dots)
        reaction.plot(v.load[some], (v.gain * v.reaction)[some], **dots)
        if surface is None:
            force.plot(v.phase_rad[some], v.rate_rad_per_s[some], **dots)
    action.set_ylabel("action A′")
    _density(action, visited)
    reaction.set_xlabel("load N [weights of the body]")
    reaction.set_ylabel("gain · reaction, G R [rad/s]")
    if np.isnan([v.action.max() for v in visited]).all():
        reaction.text(0.5, 0.5, "no feedback", ha="center", transform=reaction.transAxes)
    if surface is None:
        phase_axis(force)
        lowest = min(0.0, *(float(v.rate_rad_per_s.min()) for v in visited))
        force.set(ylabel="rate φ̇ [rad/s]", ylim=(lowest, None))
    else:
        _force(figure, force, surface, visited[0])
    _rates(rate, evaluated)
    return figure


@styled()
def forms_figure(
    forms: Sequence[tuple[str, int, Interval]], evaluated: Mapping[str, Evaluated], unit: str
) -> Figure:
    """Draw the scores of short forms, one row each; lines mark those of the controller.

    Args:
        forms: name, how many numbers, and score.
        evaluated: the controller, whole, cut and frozen.
        unit: of a score.
    """
    figure = new_figure(COLUMN_IN, 1.1 + 0.15 * len(forms))
    axes = figure.subplots()
    names = [f"{name} ({numbers})" for name, numbers, _ in forms]
    draw_intervals(axes, names, (score for *_, score in forms))
    for (name, result), style in zip(evaluated.items(), ("-", "--", ":"), strict=False):
        axes.axvline(result.mean.mean, color=COLOURS[2], lw=0.8, ls=style, label=name)
    axes.invert_yaxis()
    axes.set(xlim=(0.0, None), xlabel=f"score, mean CoT⁻¹ [{unit}]", ylabel="form (numbers)")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _density(axes: Axes, visited: Sequence[Visits]) -> None:
    """Draw the share of time in parts of a turn behind the curve, in flight and in stance."""
    phase_axis(axes)
    behind = axes.twinx()
    behind.set_zorder(-1)
    axes.patch.set_visible(False)
    phase = np.concatenate([v.phase_rad for v in visited])
    stance = np.concatenate([v.stance for v in visited])
    parts = [phase[~stance], phase[stance]]
    weights = [np.full(len(x), 1.0 / max(1, len(phase))) for x in parts]
    style = {"stacked": True, "color": ["#dddddd", "#999999"], "label": ["flight", "stance"]}
    behind.hist(parts, bins=60, range=(0.0, TWO_PI), weights=weights, **style)
    behind.set_ylabel("share of the time")
    behind.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)


def _force(figure: Figure, axes: Axes, surface: Surface, v: Visits) -> None:
    """Draw the surface of the force, with the gait on it."""
    mesh = draw_surface(axes, surface)
    figure.colorbar(mesh, ax=axes, label="actuator force $F_a$ [N]")
    if surface.phase_rad is not None:
        some = slice(None, None, max(1, len(v.load) // _DOTS))
        axes.plot(v.phase_rad[some], v.spring_force_n[some], ".", color=COLOURS[4], ms=1.5)


def _rates(axes: Axes, evaluated: Mapping[str, Evaluated]) -> None:
    """Draw hops or turns per second over the commanded frequency; the command as a thin line."""
    complete = evaluated["whole"]
    axes.set_ylabel("rate [rad/s]")
    if np.isnan(complete.omega).all():
        axes.set_xticks([])
        axes.plot(np.zeros_like(complete.rates), complete.rates, "o", color=COLOURS[0])
        return
    axes.plot(complete.omega, complete.omega, color="#dddddd", lw=4.0, label="command")
    for (name, result), marker in zip(evaluated.items(), "osx", strict=False):
        if np.isfinite(result.rates).any():
            axes.plot(result.omega, result.rates, marker=marker, ms=4, label=name)
    axes.set_xlabel("command ω [rad/s]")
    axes.legend()
