"""The phase-response curve of a gait."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.phase_response import PhaseResponse
from tegotae.figures.style import COLOURS, COLUMN_IN, new_figure, styled

_LINES = ("-", "--", "-.", ":")


def phase_response_figure(response: PhaseResponse, note: str = "") -> Figure:
    """Shift of the rhythm over the phase of the cycle at which the push comes."""
    with styled():
        figure = new_figure(COLUMN_IN, 2.6)
        axes = figure.subplots()
        x = response.cycle_phase_rad / (2.0 * np.pi)
        axes.fill_between(
            x,
            0.0,
            1.0,
            where=response.stance.tolist(),
            transform=axes.get_xaxis_transform(),
            color="0.88",
            lw=0,
            step="post",
        )
        axes.axhline(0.0, color="0.5", lw=0.6)
        for number, (push, shift) in enumerate(
            zip(response.push_ns, response.shift_rad, strict=True)
        ):
            axes.plot(
                x,
                _unjumped(shift),
                ls=_LINES[number % len(_LINES)],
                color=COLOURS[(0, 4, 2, 5)[number % 4]],
                label=f"push of {1e3 * push:+.3g} mN s",
            )
        axes.set_xlim(0.0, 1.0)
        axes.set_xlabel("when the push comes, t / T since the apex")
        axes.set_ylabel("shift of the rhythm Δθ [rad]")
        axes.set_title(note)
        handles = [*axes.get_legend_handles_labels()[0], Patch(color="0.88", label="stance")]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def phase_response_table(response: PhaseResponse) -> dict[str, np.ndarray]:
    """What the figure shows, one row per push and point of the cycle."""
    pushes, points = response.shift_rad.shape
    return {
        "push_ns": np.repeat(response.push_ns, points),
        "cycle_phase_rad": np.tile(response.cycle_phase_rad, pushes),
        "oscillator_phase_rad": np.tile(response.oscillator_phase_rad, pushes),
        "stance": np.tile(response.stance, pushes),
        "shift_rad": response.shift_rad.ravel(),
    }


def _unjumped(shift_rad: np.ndarray) -> np.ndarray:
    """The curve with a gap where it wraps from π to -π."""
    jumps = np.abs(np.diff(shift_rad, prepend=shift_rad[:1])) > np.pi
    return np.where(jumps, np.nan, shift_rad)
