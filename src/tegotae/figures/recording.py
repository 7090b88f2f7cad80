"""A recorded gait at a glance: height and phase over time, portrait, apex section, spectrum."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tegotae.figures.cycles import phase_ticks
from tegotae.figures.rollout import phase_up
from tegotae.figures.style import COLOURS, PAGE_IN, Table, new_figure, styled
from tegotae.measures.hopping.gait import Measured
from tegotae.measures.hopping.signals import FORCE_PERIOD_S, Spectrum, spectrum
from tegotae.parts._shapes import AnyArray

_SHOWN = 0.01
"""The spectrum is drawn as far as it has this share of its highest peak."""


@styled()
def recording_figure(measured: Measured, *, rest_length_m: float, note: str = "") -> Figure:
    """Draw height and phase over time; below, the portrait (y, ẏ), the apexes, and the spectrum.

    The settled part is blue; a gait that does not settle has none. Without a phase the apexes are
    shown as a return map, each over the one before.

    Args:
        measured: what was measured (`tegotae.measures.hopping.measure`).
        rest_length_m: rest length of the leg l0 [m].
        note: a title.
    """
    frames, apexes = measured.frames, measured.hops
    time, height, ground = frames.time_s[:, 0], frames.height_m[:, 0], frames.ground_m[:, 0]
    with_phase = bool(np.any(frames.phase_rad))
    figure = new_figure(PAGE_IN, 4.6 if with_phase else 3.8)
    figure.suptitle(note, fontsize=8)
    rows: Any = [["height"] * 3, ["phase"] * 3, ["portrait", "section", "spectrum"]]
    heights = [1.2, 0.8, 1.5]
    if not with_phase:
        del rows[1], heights[1]
    axes = figure.subplot_mosaic(rows, height_ratios=heights)
    over_time, portrait = axes["height"], axes["portrait"]

    settled = np.where(_settled(measured, time), height, np.nan)
    over_time.fill_between(time, ground, ground.min() - 0.05, color="0.85", lw=0)
    over_time.plot(time, ground + rest_length_m, ":", color="0.4", lw=0.8)
    over_time.plot(time, height, color="0.6", lw=0.8)
    over_time.plot(time, settled, color=COLOURS[0], lw=0.8)
    over_time.plot(apexes.time_s, apexes.height_m, ".", color=COLOURS[2], ms=3)
    over_time.set_ylabel("height y [m]")
    last = over_time
    if with_phase:
        last = axes["phase"]
        last.plot(apexes.time_s, apexes.phase_rad, ".", color=COLOURS[2], ms=4)
        phase_up(last, "apex phase\nφ [rad]")
        over_time.sharex(last)
    last.set(xlabel="time [s]", xlim=(0.0, float(time[-1])))

    portrait.plot(height, frames.velocity_m_per_s[:, 0], color="0.75", lw=0.5)
    portrait.plot(settled, frames.velocity_m_per_s[:, 0], color=COLOURS[0])
    portrait.set(xlabel="height y [m]", ylabel="velocity ẏ [m/s]")
    _draw_section(axes["section"], measured, with_phase)
    _draw_spectrum(axes["spectrum"], measured)
    return figure


def recording_tables(measured: Measured) -> dict[str, Table]:
    """Return the data of the figure: `frames` of 20 ms, the `hops`, and the `spectrum`.

    None has the figure's own name, which may be that of the recording.
    """
    frames, table, power = measured.frames, measured.hops, _spectrum(measured)
    return {
        "frames": {
            name: getattr(frames, name)[:, 0]
            for name in ("time_s", "height_m", "velocity_m_per_s", "phase_rad")
        },
        "hops": {
            "apex_time_s": table.time_s,
            "apex_height_m": table.height_m,
            "apex_phase_rad": table.phase_rad,
        },
        "spectrum": {
            "angular_frequency_rad_per_s": np.asarray(power.angular_frequency),
            "power_share": _share(power),
        },
    }


def _settled(measured: Measured, time_s: AnyArray) -> np.ndarray:
    """Return a mask of the times that belong to the limit cycle; none where there is none."""
    start, efficiency = measured.t0_s, measured.efficiency
    if not np.isfinite(start) or efficiency is None:
        return np.zeros(len(time_s), bool)
    return np.asarray((time_s >= start) & (time_s <= efficiency.end_s + FORCE_PERIOD_S))


def _draw_section(axes: Axes, measured: Measured, with_phase: bool) -> None:
    table = measured.hops
    inside, height = _settled(measured, table.time_s), np.asarray(table.height_m)
    if with_phase:
        across, up = np.asarray(table.phase_rad), height
        axes.set_xlabel("apex phase φ [rad]")
    else:
        across, up, inside = height[:-1], height[1:], inside[1:]
        axes.set_xlabel("height of the apex before [m]")
    axes.set_ylabel("height of the apex y [m]")
    if not len(up):
        axes.text(0.5, 0.5, "no hops", transform=axes.transAxes, ha="center", color="0.4")
        return
    if with_phase:
        axes.plot(across, up, color="0.8", lw=0.5)
    axes.plot(across, up, ".", color="0.5", ms=4)
    axes.plot(across[inside], up[inside], ".", color=COLOURS[0], ms=5)
    # A cycle is a point: the axes show at least a centimetre, or noise would look like a gait.
    values = up if with_phase else np.append(up, across)
    middle = 0.5 * float(values.min() + values.max())
    room = max(0.55 * float(np.ptp(values)), 0.005)
    axes.set_ylim(middle - room, middle + room)
    if with_phase:
        phase_ticks(axes.xaxis)
        return
    # On the diagonal an apex is as high as the one before.
    axes.set(xlim=axes.get_ylim(), box_aspect=1.0)
    axes.axline((middle, middle), slope=1.0, color="0.6", lw=0.6, ls="--", label="as high")
    axes.legend()


def _draw_spectrum(axes: Axes, measured: Measured) -> None:
    spectrum = _spectrum(measured)
    frequency, share = np.asarray(spectrum.angular_frequency), _share(spectrum)
    reach = frequency[np.flatnonzero(share >= _SHOWN)[-1]] if share.any() else frequency[-1]
    axes.plot(frequency, share, color=COLOURS[0])
    if np.isfinite(measured.omega):
        axes.axvline(measured.omega, color=COLOURS[4], ls="--", lw=0.8, label="ω")
        axes.legend()
    axes.set_xlim(0.0, 1.3 * max(float(reach), float(np.nan_to_num(measured.omega))))
    axes.set(xlabel="angular frequency [rad/s]", ylabel="power over its peak")


def _spectrum(measured: Measured) -> Spectrum:
    """Return the spectrum of the height, over the settled part or, without one, the whole."""
    frames, start = measured.frames, np.nan_to_num(measured.t0_s)
    height = frames.height_m
    end = measured.efficiency.end_s if measured.efficiency and start else np.inf
    inside = int(np.sum(frames.time_s[:, 0] <= end + FORCE_PERIOD_S))
    return _transform(height[:inside], FORCE_PERIOD_S, np.floor(start / FORCE_PERIOD_S))


_transform = jax.jit(spectrum, static_argnums=1)


def _share(spectrum: Spectrum) -> np.ndarray:
    power = np.asarray(spectrum.power)[:, 0]
    return power / power.max() if power.max() > 0.0 else power
