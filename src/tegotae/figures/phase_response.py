"""The phase-response curve of a gait."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.analysis.phase_response import PhaseResponse
from tegotae.figures.style import COLOURS, COLUMN_IN, new_figure, styled

NEGLIGIBLE_RAD = 0.01
"""A shift below this, 1/600 of a period, is negligible, and drawn as the flat line that it is."""

_LINES = ("-", "--", "-.", ":")


def phase_response_figure(response: PhaseResponse, note: str = "") -> Figure:
    """Shift of the rhythm over the phase of the cycle at which the push comes.

    The axis reaches at least to twice `NEGLIGIBLE_RAD`, so that a gait that does not respond does
    not look like one that does; the picture then says so.
    """
    largest = largest_shift_rad(response)
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
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, -2.0 * NEGLIGIBLE_RAD), max(high, 2.0 * NEGLIGIBLE_RAD))
        if largest < NEGLIGIBLE_RAD:
            axes.text(
                0.5, 0.95, _negligible(largest), transform=axes.transAxes, ha="center", va="top"
            )
        elif np.isnan(largest):
            words = "the gait never returns to its limit cycle"
            axes.text(0.5, 0.95, words, transform=axes.transAxes, ha="center", va="top")
        axes.set_xlim(0.0, 1.0)
        axes.set_xlabel("when the push comes, t / T since the apex")
        axes.set_ylabel("shift of the rhythm Δθ [rad]")
        axes.set_title(note)
        handles = [*axes.get_legend_handles_labels()[0], Patch(color="0.88", label="stance")]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def largest_shift_rad(response: PhaseResponse) -> float:
    """Largest shift by any push, in either direction [rad]; NaN if the gait never returns."""
    returned = np.isfinite(response.shift_rad)
    return float(np.abs(response.shift_rad[returned]).max()) if returned.any() else float("nan")


def _negligible(largest_rad: float) -> str:
    share = largest_rad / (2.0 * np.pi)
    return f"negligible response: at most {largest_rad:.1g} rad,\n{share:.1g} of a period"


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
