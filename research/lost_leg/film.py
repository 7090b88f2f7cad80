"""Frames of a quadruped around the loss of a leg."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tegotae.analysis.gaits.releases import GaitRun, simulate_gaits
from tegotae.figures.gaits.animation import LegPositions, pose
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure
from tegotae.parts.fields import replace
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Step
from tegotae.simulation.summaries import whole_trajectory
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import Legged, random_phases

LOST_S = 20.0
"""Time of the loss of the leg."""
TIMING = Timing(duration_s=45.0, tick_s=0.008, frame_s=0.04)
"""Timing of the shown rollouts."""
SEED = 7
"""Seed of the phases at release; no training or evaluation has it."""
SHOWN_S = (-0.5, 0.5, 1.0, 1.5, 2.5, 4.0)
"""Times after the loss of the frames in a row."""


def loses(legged: Legged, leg: str) -> GaitRun:
    """Simulate one release of a walker that loses a leg."""
    presence = [float(name != leg) for name in legged.names]
    phase = random_phases(len(presence), 1, SEED)
    changes = {"present": Step(np.array(presence)[:, None], from_s=LOST_S)}
    scenario = with_changes(legged.scenario(phase), legged.body, changes)
    trajectory = legged.run(whole_trajectory, scenario, TIMING)
    intact = replace(legged, {"timing": dataclasses.replace(TIMING, duration_s=LOST_S)})
    return dataclasses.replace(
        simulate_gaits(intact, phase[:, 0].tolist()),
        legged=replace(legged, {"timing": TIMING}),
        trajectory=jax.tree.map(lambda x: np.asarray(x)[..., 0], trajectory),
    )


def frame_at(run: GaitRun, after_s: float) -> int:
    """Return the recorded frame at a time after the loss."""
    return round((LOST_S + after_s) / run.timing.frame_s) - 1


def draw_frames(runs: dict[str, dict[str, GaitRun]]) -> Figure:
    """Draw one row of frames, seen from the side, for each walker and the leg that it loses."""
    rows = [(name, leg, run) for name, legs in runs.items() for leg, run in legs.items()]
    figure = new_figure(PAGE_IN, 1.1 * len(rows) + 0.5)
    panels = figure.subplots(len(rows), len(SHOWN_S), squeeze=False)
    for axes, (name, leg, run) in zip(panels, rows, strict=True):
        shape = pose(run.legged.body, run.trajectory).along_torso()
        fell = run.trajectory.failed
        for panel, delay_s in zip(axes, SHOWN_S, strict=True):
            frame, late = frame_at(run, delay_s), f"{delay_s:+.1f}"
            if fell[frame]:
                frame, late = int(np.argmax(fell)), "fallen"
            draw_pose(panel, shape, frame, run.legged.names.index(leg) if delay_s > 0.0 else None)
            panel.set_title(late, fontsize=7, pad=2)
        axes[0].set_ylabel(f"{name},\n{leg} lost", fontsize=7)
    legged = rows[0][2].legged
    keys: list[dict[str, Any]] = [
        *({"color": COLOURS[i], "label": leg} for i, leg in enumerate(legged.names)),
        {"color": "0.4", "ls": ":", "label": "lost"},
        {"color": "0.4", "ls": "", "marker": "o", "ms": 3, "label": "stands"},
        {"color": "0.4", "ls": "", "marker": "o", "ms": 3, "mfc": "none", "label": "swings"},
    ]
    figure.legend(
        handles=[Line2D([], [], **key) for key in keys],
        title=f"above each frame: time after the loss [{legged.units[1]}]",
        loc="outside lower center",
        ncols=len(keys),
    )
    return figure


def draw_pose(axes: Axes, shape: LegPositions, frame: int, missing: int | None) -> None:
    """Draw the body from its right side at a frame; a lost leg is dotted."""
    hips, feet = shape.hips_m[frame], shape.feet_m[frame]
    order = [0, 1, 3, 2]
    axes.axhspan(-1.0, 0.0, color="0.88", lw=0)
    axes.fill(hips[order, 0], hips[order, 2], color="0.75", ec="k", lw=0.8)
    for leg in range(len(hips)):
        line = ":" if leg == missing else "-"
        axes.plot(
            *zip(hips[leg, ::2], feet[leg, ::2], strict=True), line, color=COLOURS[leg], lw=1.2
        )
        full = "full" if shape.stands[frame, leg] and leg != missing else "none"
        axes.plot(*feet[leg, ::2], "o", color=COLOURS[leg], ms=3, fillstyle=full)
    middle = hips[:, 0].mean()
    axes.set(xlim=(middle - 1.6, middle + 1.6), ylim=(-0.2, 1.8), xticks=[], yticks=[])
    axes.set_aspect("equal")
