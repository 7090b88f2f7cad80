"""An episode on an environment over time: height, loads of the limbs, phases."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tegotae.figures.style import PAGE_IN, literal, new_figure, styled
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
