"""Phase portraits: the body's plane, and that of what a controller feels."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.analysis.portrait import Paths
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.figures.surface import phase_axis

_LATE = 0.75
"""From this share of the time on a path is drawn as where the gait has come to."""


def portrait_figure(paths: Paths, *, rest_length_m: float, note: str = "") -> Figure:
    """Velocity over height, and spring force over phase, or over velocity without an oscillator.

    Thin lines lead from the releases, the squares; the last quarter of the time is thick. A cross
    is where a leg has no length left.

    Args:
        paths: the rollouts.
        rest_length_m: rest length of the leg l0 [m], above which it flies.
        note: a title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.9)
        body, felt = figure.subplots(1, 2)
        figure.suptitle(note, fontsize=8)
        body.axvline(rest_length_m, color="0.4", ls=":", lw=0.8)
        _draw(body, paths.height_m, paths.velocity_m_per_s, paths.failed, _labels(paths))
        body.set(xlabel="height y [m]", ylabel="velocity ẏ [m/s]")
        figure.legend(title="released from", loc="outside right center", title_fontsize=7)
        if paths.phase_rad is None:
            _draw(felt, paths.velocity_m_per_s, paths.spring_force_n, paths.failed)
            felt.set_xlabel("velocity ẏ [m/s]")
        else:
            phase = _broken(paths.phase_rad % (2.0 * np.pi))
            _draw(felt, phase, paths.spring_force_n, paths.failed)
            phase_axis(felt)
        felt.set_ylabel("spring force $F_k$ [N]")
        felt.set_ylim(bottom=0.0)
    return figure


def portrait_table(paths: Paths) -> dict[str, np.ndarray]:
    """What the figure shows, a row a frame and release."""
    frames, releases = paths.height_m.shape
    phase = {} if paths.phase_rad is None else {"phase_rad": paths.phase_rad.T.ravel()}
    return {
        "release_height_m": np.repeat(paths.height_m[0], frames),
        "time_s": np.tile(paths.time_s, releases),
        "height_m": paths.height_m.T.ravel(),
        "velocity_m_per_s": paths.velocity_m_per_s.T.ravel(),
        **phase,
        "spring_force_n": paths.spring_force_n.T.ravel(),
        "actuator_force_n": paths.actuator_force_n.T.ravel(),
    }


def _labels(paths: Paths) -> list[str]:
    return [f"{height:.3g} m" for height in paths.height_m[0]]


def _draw(
    axes: Axes, x: np.ndarray, y: np.ndarray, failed: np.ndarray, labels: list[str] | None = None
) -> None:
    late = round(_LATE * len(x))
    for i, (across, up) in enumerate(zip(x.T, y.T, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(across[: late + 1], up[: late + 1], color=colour, lw=0.4, alpha=0.6)
        axes.plot(across[late:], up[late:], color=colour, lw=1.3, label=labels and labels[i])
        axes.plot(across[0], up[0], "s", color=colour, ms=4)
        if failed[i]:
            axes.plot(across[-1], up[-1], "x", color=colour, ms=6, clip_on=False)


def _broken(phase_rad: np.ndarray) -> np.ndarray:
    """Phases [frames, releases] with a gap where they wrap."""
    jumps = np.abs(np.diff(phase_rad, axis=0, prepend=phase_rad[:1])) > np.pi
    return np.where(jumps, np.nan, phase_rad)
