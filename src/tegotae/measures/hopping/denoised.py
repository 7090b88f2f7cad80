"""A recording with noise in it, as the metrics can take it, and what they can then not measure."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tegotae.measures.hopping.limit_cycle import LimitCycle
from tegotae.measures.hopping.noise import (
    FLOOR,
    SURE,
    Cleaned,
    cleaned,
    noise_std,
    work_under_noise,
)
from tegotae.measures.hopping.recording import Samples

_FOR_WORK = 1.5  # of the cutoff of least error
_ROUND = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)


@dataclass(frozen=True, kw_only=True)
class Denoised:
    """A recording after its low-pass."""

    columns: Samples
    """Arrays by the names of `from_samples`, [samples] each."""
    prominence_m: float
    """How far an apex must rise from the heights around it not to be noise [m]."""
    limit_cycle: LimitCycle
    """What counts as settled, as far as noise lets it be seen."""
    notes: tuple[str, ...]
    """What was done, a sentence each."""


def denoised(
    columns: Samples,
    *,
    rest_length_m: float,
    limit_cycle: LimitCycle,
    work: str,
    lowpass_hz: float | None = None,
) -> Denoised:
    """The recording after a zero-phase low-pass of height and phase, if they hold noise.

    The height's cutoff is the one given, or that of least expected error (`cleaned`), and one
    and a half times that for the work. The force is not filtered, so that it keeps its jumps. Noise
    averages out in the work (`work_under_noise`).

    Args:
        columns: by the names of `from_samples`, checked: `time_s`, `height_m` and the others.
        rest_length_m: rest length of the leg l0 [m].
        limit_cycle: what counts as settled without noise. Apexes differ by noise, too: tolerances
            are widened to four deviations of the difference of two.
        work: definition of work.
        lowpass_hz: cutoff for the height [Hz]; infinite to filter nothing; None to choose it.

    Raises:
        TegotaeError: for a cutoff that cannot be used.

    Example:
        >>> time_s = np.arange(2000) * 0.01
        >>> noise = 0.02 * np.random.default_rng(0).standard_normal(2000)
        >>> columns = {"time_s": time_s, "height_m": 1 + 0.3 * np.sin(6.0 * time_s) + noise}
        >>> found = denoised(columns, rest_length_m=1.0, limit_cycle=LimitCycle(), work="absolute")
        >>> f"{found.limit_cycle.height_tolerance_m:g} m"
        '0.03 m'
    """
    time, height = (np.asarray(columns[name], float) for name in ("time_s", "height_m"))
    step_s = float(time[-1] - time[0]) / (len(time) - 1)
    of_height = cleaned(height, step_s, floor=FLOOR * rest_length_m, cutoff_hz=lowpass_hz)
    found: Samples = {**columns, "height_m": of_height.samples}
    notes = list(_on_height(of_height))
    apex_s = of_height.rate_left / _curvature(of_height.samples, step_s)
    apex_rad = 0.0
    if (recorded := columns.get("phase_rad")) is not None:
        phase = np.unwrap(np.asarray(recorded, float))
        trend = np.linspace(phase[0], phase[-1], len(phase))
        of_phase = cleaned(phase - trend, step_s, floor=FLOOR * 2.0 * math.pi)
        if of_phase.noise:
            found["phase_rad"] = of_phase.samples + trend
            notes.append(f"the phase holds noise of {of_phase.noise:.2g} rad, and is low-passed")
        turning = abs(float(phase[-1] - phase[0])) / float(time[-1] - time[0])
        apex_rad = math.hypot(of_phase.left, turning * apex_s)
    if (recorded := columns.get("force_n")) is not None and columns.get("work_j") is None:
        force = np.asarray(recorded, float)
        noise_n = noise_std(force)
        in_force = noise_n > FLOOR * float(np.abs(force).max())
        if in_force:
            notes.append(
                f"the force holds noise of about {noise_n:.2g} N: it averages out in the work, and "
                "is in the smoothness"
            )
        if of_height.noise or in_force:
            rougher = of_height if lowpass_hz is not None else _rougher(height, of_height, step_s)
            direction = np.sign(np.diff(of_height.samples))
            found["work_j"] = work_under_noise(force, rougher.samples, direction, step_s, work)
    widened = wider(limit_cycle, of_height.left, apex_rad)
    notes.extend(_on_tolerance(limit_cycle, widened))
    return Denoised(
        columns=found,
        prominence_m=SURE * of_height.left,
        limit_cycle=widened,
        notes=tuple(notes),
    )


def wider(limit_cycle: LimitCycle, height_m: float, phase_rad: float) -> LimitCycle:
    """A limit cycle's tolerances, not below four deviations of the difference of two apexes.

    Args:
        limit_cycle: what counts as settled without noise.
        height_m: standard deviation of the height of an apex [m].
        phase_rad: that of the phase there [rad].

    Example:
        >>> wider(LimitCycle(), 0.01, 0.001).height_tolerance_m
        0.07
    """
    height, phase = (_rounded_up(SURE * math.sqrt(2.0) * x) for x in (height_m, phase_rad))
    return replace(
        limit_cycle,
        height_tolerance_m=max(limit_cycle.height_tolerance_m, height),
        phase_tolerance_rad=max(limit_cycle.phase_tolerance_rad, phase),
    )


def _rounded_up(value: float) -> float:
    """The next round number: every tolerance is compiled for itself."""
    if value <= 0.0:
        return 0.0
    decade = 10.0 ** math.floor(math.log10(value))
    rounded = next((r for r in _ROUND if r * decade >= value), 10.0)
    return float(f"{rounded * decade:.2g}")


def _rougher(height: np.ndarray, of: Cleaned, step_s: float) -> Cleaned:
    """The height at a higher cutoff: work is a sum, in which noise averages out and bias stays."""
    if math.isinf(of.cutoff_hz):
        return of
    cutoff_hz = min(_FOR_WORK * of.cutoff_hz, 0.45 / step_s)
    return cleaned(height, step_s, floor=0.0, cutoff_hz=cutoff_hz)


def _curvature(height: np.ndarray, step_s: float) -> float:
    """Typical magnitude of the acceleration in the upper half [m/s²]."""
    bends = np.abs(np.diff(height, 2)) / step_s**2
    return float(np.median(bends[height[1:-1] >= np.median(height)])) or 1.0


def _on_height(of: Cleaned) -> tuple[str, ...]:
    found = f"the height holds noise of about {_short(1e3 * of.noise)} mm (standard deviation)"
    if math.isinf(of.cutoff_hz):
        return (found + ", and is not filtered",) if of.noise else ()
    passed = f"low-passed at {of.cutoff_hz:.3g} Hz"
    if not of.noise:
        return (f"the height is {passed}",)
    return (f"{found}: {passed}, which leaves about {_short(1e3 * of.left)} mm",)


def _short(value: float) -> str:
    """Two digits of a number, never as a power of ten."""
    return f"{float(f'{value:.2g}'):g}"


def _on_tolerance(before: LimitCycle, after: LimitCycle) -> tuple[str, ...]:
    parts = []
    if after.height_tolerance_m > before.height_tolerance_m:
        parts.append(f"{1e3 * after.height_tolerance_m:g} mm")
    if after.phase_tolerance_rad > before.phase_tolerance_rad:
        parts.append(f"{after.phase_tolerance_rad:g} rad")
    if not parts:
        return ()
    return (f"hops that differ by less than {' or '.join(parts)} count as alike: noise hides it",)
