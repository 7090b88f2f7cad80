"""A rollout over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.simulation import Result
from tegotae.figures.cycles import broken
from tegotae.figures.style import COLOURS, PAGE_IN, literal_text, new_figure, styled

if TYPE_CHECKING:  # of Gymnasium, which is an extra
    from tegotae.training.environments.replay import Replay

_SHOWN_S = 3.0
_BESIDE: Any = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "markerscale": 2.0}


def phase_up(axes: Axes, label: str = "phase φ [rad]") -> None:
    """Set a vertical axis of phase, from 0 to 2π."""
    axes.set(ylabel=label, ylim=(0.0, 2.0 * np.pi))
    axes.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])


@styled()
def episode_figure(replay: Replay, *, note: str = "") -> Figure:
    """Draw the last three seconds: the body's height where it is known, every load, every phase.

    Args:
        replay: an episode.
        note: a title.
    """
    episode, wiring = replay.episode, replay.experiment.wiring
    late = episode.time_s > episode.time_s[-1] - _SHOWN_S
    time = episode.time_s[late]
    heights = [] if wiring.height is None else [episode[wiring.height]]
    figure = new_figure(PAGE_IN, 1.3 * (2 + len(heights)))
    figure.suptitle(note, fontsize=8)
    *panels, loads, phases = figure.subplots(2 + len(heights), 1, sharex=True)
    for panel, height in zip(panels, heights, strict=True):
        panel.plot(time, height[late])
        panel.set_ylabel("height [m]")
    for name, load in replay.episode.loads.items():
        loads.plot(time, load[late], label=literal_text(name))
    loads.set_ylabel("load [N]")
    loads.legend(**_BESIDE)
    for i, limb in enumerate(wiring.limbs):
        phase, name = episode.phase_rad[late, i] % (2.0 * np.pi), ", ".join(limb.entries)
        # Limbs in phase lie on each other: the later ones are smaller.
        phases.plot(time, phase, ".", ms=3.0 / (1.0 + i), label=literal_text(name))
    phase_up(phases)
    phases.set_xlabel("time [s]")
    phases.legend(**_BESIDE)
    return figure


@styled()
def rollout_figure(result: Result) -> Figure:
    """Draw height, leg forces, phase and feedback of a simulation over time."""
    t, hopper = result.trajectory, result.body
    figure = new_figure(PAGE_IN, 4.6)
    height, spring, actuator, phase = figure.subplots(4, 1, sharex=True)
    below = min(0.0, float(t.ground_m.min())) - 0.05
    height.fill_between(t.time_s, t.ground_m, below, color="0.85", lw=0)
    height.plot(t.time_s, t.ground_m + hopper.rest_length_m, ":", color="0.4", lw=0.8)
    height.plot(t.time_s, t.height_m, color=COLOURS[0])
    times, apexes, _ = result.apexes
    height.plot(times, apexes, ".", color=COLOURS[2], ms=3)
    height.set_ylabel("height y [m]")
    spring.plot(t.time_s, t.spring_force_n, color=COLOURS[0])
    spring.set_ylabel("spring $F_k$ [N]")
    actuator.fill_between(t.time_s, t.actuator_force_n, step="mid", color=COLOURS[1], lw=0)
    actuator.set(ylabel="actuator $F_a$ [N]", ylim=(0.0, 1.05 * hopper.max_force_n))
    if result.system.controller.oscillator is None:
        phase.plot(t.time_s, t.velocity_m_per_s, color=COLOURS[0])
        phase.set_ylabel("velocity ẏ [m/s]")
    else:
        phase.plot(t.time_s, broken(t.phase_rad), color=COLOURS[0])
        phase_up(phase)
        feedback = phase.twinx()
        feedback.plot(t.time_s, t.feedback_rad_per_s, "--", color=COLOURS[1], lw=0.8)
        feedback.set_ylabel("feedback f [rad/s]", color="#9A6A00")
        feedback.spines["right"].set_visible(True)
    phase.set(xlabel="time [s]", xlim=(0.0, t.time_s[-1]))
    figure.align_ylabels([height, spring, actuator, phase])
    return figure
