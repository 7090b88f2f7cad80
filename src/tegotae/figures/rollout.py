"""A rollout over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.style import COLOURS, PAGE_IN, literal, new_figure, styled
from tegotae.systems.simulation import Result
from tegotae.training.environments.replay import Replay

_SHOWN_S = 3.0
_BESIDE: Any = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "markerscale": 2.0}


def episode_figure(replay: Replay, *, note: str = "") -> Figure:
    """The last three seconds: the body's height where it is known, every load, every phase.

    Args:
        replay: an episode.
        note: a title.
    """
    episode, wiring = replay.episode, replay.experiment.wiring
    late = episode.time_s > episode.time_s[-1] - _SHOWN_S
    time = episode.time_s[late]
    heights = [] if wiring.height is None else [episode[wiring.height]]
    with styled():
        figure = new_figure(PAGE_IN, 1.3 * (2 + len(heights)))
        figure.suptitle(note, fontsize=8)
        panels = figure.subplots(2 + len(heights), 1, sharex=True)
        for height in heights:
            panels[0].plot(time, height[late])
            panels[0].set_ylabel("height [m]")
        for name, load in replay.loads.items():
            panels[-2].plot(time, load[late], label=literal(name))
        panels[-2].set_ylabel("load [N]")
        panels[-2].legend(**_BESIDE)
        for i, limb in enumerate(wiring.limbs):
            phase = np.mod(episode.phase_rad[late, i], 2.0 * math.pi)
            # Limbs in phase lie on each other: the later ones are smaller.
            size = 3.0 / (1.0 + i)
            panels[-1].plot(time, phase, ".", ms=size, label=literal(", ".join(limb.entries)))
        panels[-1].set(ylabel="phase φ [rad]", ylim=(0.0, 2.0 * math.pi), xlabel="time [s]")
        panels[-1].set_yticks([0.0, math.pi, 2.0 * math.pi], ["0", "π", "2π"])
        panels[-1].legend(**_BESIDE)
    return figure


def rollout_figure(result: Result) -> Figure:
    """Height, leg forces, phase and feedback of a simulation over time."""
    t = result.trajectory
    hopper = result.simulation.hopper
    with_oscillator = result.simulation.controller.oscillator is not None
    with styled():
        figure = new_figure(PAGE_IN, 4.6)
        height, spring, actuator, phase = figure.subplots(4, 1, sharex=True)
        height.fill_between(
            t.time_s, t.ground_m, min(0.0, float(t.ground_m.min())) - 0.05, color="0.85", lw=0
        )
        height.plot(t.time_s, t.ground_m + hopper.rest_length_m, ":", color="0.4", lw=0.8)
        height.plot(t.time_s, t.height_m, color=COLOURS[0])
        times, apexes, _ = result.apexes
        height.plot(times, apexes, ".", color=COLOURS[2], ms=3)
        height.set_ylabel("height y [m]")
        spring.plot(t.time_s, t.spring_force_n, color=COLOURS[0])
        spring.set_ylabel("spring $F_k$ [N]")
        actuator.fill_between(t.time_s, t.actuator_force_n, step="mid", color=COLOURS[1], lw=0)
        actuator.set_ylabel("actuator $F_a$ [N]")
        actuator.set_ylim(0.0, 1.05 * hopper.max_force_n)
        if with_oscillator:
            wrapped = np.where(
                np.abs(np.diff(t.phase_rad, append=np.nan)) > np.pi, np.nan, t.phase_rad
            )
            phase.plot(t.time_s, wrapped, color=COLOURS[0])
            phase.set_ylabel("phase φ [rad]")
            phase.set_ylim(0.0, 2.0 * np.pi)
            phase.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])
            feedback = phase.twinx()
            feedback.plot(t.time_s, t.feedback_rad_per_s, "--", color=COLOURS[1], lw=0.8)
            feedback.set_ylabel("feedback f [rad/s]", color="#9A6A00")
            feedback.spines["right"].set_visible(True)
        else:
            phase.plot(t.time_s, t.velocity_m_per_s, color=COLOURS[0])
            phase.set_ylabel("velocity ẏ [m/s]")
        phase.set_xlabel("time [s]")
        phase.set_xlim(0.0, t.time_s[-1])
        figure.align_ylabels([height, spring, actuator, phase])
    return figure
