"""Recordings from elsewhere, a robot or another simulator: arrays in, a trajectory out.

Samples are checked once (`checked_samples`), freed of noise (`denoised`), and become frames
(`frames_of`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite, unknown
from tegotae.measures.hopping.hopping import LimitCycle
from tegotae.simulation.recorder import Trajectory

Samples = Mapping[str, np.ndarray]
"""Columns of a recording by the names of `from_samples`, [samples] each."""

_UNIFORM = 0.01  # largest deviation of a time step from the mean one, as a share of it
_MOST = 1e9  # largest value in SI units that a recording may hold
_RESTART = 3.0  # a fall of so many times the largest rise, and the steps beside it, is a restart
TOTALS = ("work_j", "climb_flight_m", "climb_m")
"""Running totals, each of which stands in place of what would follow from the samples."""
COLUMNS = ("time_s", "height_m", "ground_m", "phase_rad", "force_n", *TOTALS)
"""Columns of a recording."""


def from_samples(
    time_s: ArrayLike,
    height_m: ArrayLike,
    *,
    rest_length_m: float,
    frame_s: float = 0.02,
    **signals: ArrayLike | None,
) -> Trajectory:
    """Return a recording of one gait as frames, in the form in which `Rollout` records its own.

    Touchdowns lie where the height crosses `l0 + h`, between two samples by linear interpolation.
    Every flight has one apex: its highest sample, refined by a parabola through three, which is
    exact in ballistic flight. The actuator's work is what `work_j` says, or else
    `E = Σ F̄ Δy`, with the mean force between two samples. Running totals of climbs likewise go
    before what follows from the heights: they were counted between the samples, too.

    Args:
        time_s: sampling times, uniform and increasing [s], shape [samples].
        height_m: height of the centre of mass y [m], [samples].
        rest_length_m: height over ground at which the foot leaves it, l0 [m].
        frame_s: period of the frames [s], not below that of the samples.
        more: columns [samples], None if not recorded: `ground_m`, height of the ground h [m], also
            a number; `phase_rad`, oscillator phase φ, wrapped or not [rad]; `force_n`, actuator
            force F_a [N]; `work_j`, running total of the work [J] by whatever definition it was
            counted, which stands for all; `climb_flight_m`, running total of the heights climbed in
            flight [m]; `climb_m`, that of all heights climbed [m]. Without work and force, work is
            NaN.

    Returns:
        The trajectory, from the first sample on, of shape [frames, 1] in float64; NaN in what the
        samples do not show.

    Raises:
        TegotaeError: for arrays that differ in length, hold values that are not finite or beyond
            1e9, or too few samples; for times that decrease or are not uniform, frames shorter
            than their period, a height that leaves both its neighbours by more than the rest
            length, or a running total that starts again.

    Example:
        >>> time_s = np.arange(2000) * 0.005
        >>> frames = from_samples(time_s, 1 + 0.1 * np.sin(6 * time_s), rest_length_m=1.0)
        >>> f"{np.nanmax(frames.apex_height_m):.4f} m"
        '1.1000 m'
    """
    columns = {"time_s": time_s, "height_m": height_m, **signals}
    return frames_of(checked_samples(columns, rest_length_m), rest_length_m, frame_s)


def checked_samples(columns: Mapping[str, ArrayLike | None], rest_length_m: float) -> Samples:
    """Return the recorded columns as float64 [samples], the ground's included.

    Raises:
        TegotaeError: for samples that `from_samples` refuses.
    """
    if extra := [name for name in columns if name not in COLUMNS]:
        raise unknown("column of a recording", extra[0], COLUMNS)
    require_finite("rest_length_m", rest_length_m, above=0.0, most=_MOST)
    time = _checked_time(columns["time_s"])
    filled = {"ground_m": 0.0, **{name: x for name, x in columns.items() if x is not None}}
    if not np.shape(filled["ground_m"]):
        filled["ground_m"] = np.broadcast_to(filled["ground_m"], len(time))
    samples = {
        name: time if name == "time_s" else _checked(name, column, len(time))
        for name, column in filled.items()
    }
    _check_spikes(samples["height_m"], rest_length_m)
    for name in TOTALS:
        if name in samples:
            _check_total(name, samples[name])
    return samples


def _checked(name: str, values: Any, samples: int, limit: float = _MOST) -> np.ndarray:
    """Return the values as float64 [samples], after a check that all are finite."""
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} is no array of numbers") from None
    if array.shape != (samples,):
        raise TegotaeError(
            f"{name} has shape {array.shape}; it must have one entry per time, ({samples},)"
        )
    sound = np.isfinite(array)
    if not sound.all():
        where = int(np.argmin(sound))
        raise TegotaeError(
            f"{name} is {array[where]} at sample {where}; every sample must be finite "
            "(cut the recording, or fill the gap)"
        )
    where = int(np.argmax(np.abs(array)))
    if abs(array[where]) > limit:
        raise TegotaeError(
            f"{name} is {array[where]:g} at sample {where}; no recording holds more than {limit:g}"
        )
    return array


def _checked_time(time_s: Any) -> np.ndarray:
    """Return uniform, increasing times [s]; time stamps of a clock may be large."""
    samples = np.shape(time_s)
    if len(samples) != 1 or samples[0] < 3:
        raise TegotaeError(f"time_s has shape {samples}; it must be one row of at least 3 times")
    time = _checked("time_s", time_s, samples[0], limit=math.inf)
    check_increasing(time)
    steps = np.diff(time)
    mean = steps.mean()
    uneven = np.abs(steps - mean)
    where = int(np.argmax(uneven))
    if uneven[where] > _UNIFORM * mean:
        raise TegotaeError(
            f"time_s has a step of {steps[where]:g} s at sample {where + 1}, the mean being "
            f"{mean:g} s; resample the recording to uniform times (--resample HZ)"
        )
    return time


def check_increasing(time_s: np.ndarray) -> None:
    """Raise `TegotaeError` for times [s] that do not increase."""
    increase = np.diff(time_s) > 0.0
    if not increase.all():
        row = int(np.argmin(increase))
        raise TegotaeError(
            f"the times do not increase: {time_s[row]:.6g} s at sample {row}, and "
            f"{time_s[row + 1]:.6g} s after it; sort the recording, or, at a fixed rate, delete "
            "the column of times and set --rate HZ"
        )


def _check_spikes(height: np.ndarray, rest_length_m: float) -> None:
    """Raise `TegotaeError` for a sample that lies off both its neighbours by over a rest length."""
    rise, fall = height[1:-1] - height[:-2], height[1:-1] - height[2:]
    off = np.where(rise * fall > 0.0, np.minimum(np.abs(rise), np.abs(fall)), 0.0)
    where = int(np.argmax(off))
    if off[where] > rest_length_m:
        raise TegotaeError(
            f"height_m is {height[where + 1]:g} at sample {where + 1} and {height[where]:g} before "
            f"it, and goes back: further than the rest length of {rest_length_m:g} m in one "
            "sample; correct the sample, or check units and rest length"
        )


def _check_total(name: str, total: np.ndarray) -> None:
    """Raise `TegotaeError` for a running total that starts again.

    Net work may fall, but not in one sample and by more than it ever rises in one: such a fall is
    a counter that starts again, or overflows.
    """
    steps = np.diff(total)
    beside = np.abs(np.concatenate([[0.0], steps, [0.0]]))
    largest = steps.max(initial=0.0)
    restarts = -steps > _RESTART * np.maximum(np.maximum(beside[:-2], beside[2:]), largest)
    if restarts.any() and largest > 0.0:
        where = int(np.argmax(restarts))
        raise TegotaeError(
            f"{name} falls from {total[where]:g} to {total[where + 1]:g} at sample {where + 1}: a "
            "running total does not start again; add up its parts, or cut the recording there"
        )


def step_of(samples: Samples) -> float:
    """Return the sampling period [s]."""
    time = samples["time_s"]
    return (time[-1] - time[0]) / (len(time) - 1)


def frames_of(
    samples: Samples, rest_length_m: float, frame_s: float, prominence_m: float = 0.0
) -> Trajectory:
    """Return the frames of checked samples, as `from_samples` makes them.

    Args:
        samples: from `checked_samples`.
        rest_length_m: rest length of the leg l0 [m].
        frame_s: period of the frames [s].
        prominence_m: how far an apex must stand out from the lowest heights on either side, up to
            the next that is higher [m], not to be taken for noise.

    Raises:
        TegotaeError: for frames shorter than the period of the samples, or fewer than three.
    """
    require_finite("frame_s", frame_s, above=0.0)
    height, ground, step = samples["height_m"], samples["ground_m"], step_of(samples)
    time, undefined = np.arange(len(height)) * step, np.full(len(height), np.nan)
    frames = int(np.floor(time[-1] / frame_s + 1e-6))
    if frame_s < step * (1.0 - _UNIFORM):
        raise TegotaeError(
            f"frame_s is {frame_s:g}, below the sampling period of {step:g} s; it must be at least "
            "that"
        )
    if frames < 3:
        raise TegotaeError(
            f"the recording lasts {time[-1]:g} s; it must last at least three frames "
            f"({3 * frame_s:g} s)"
        )
    phase = np.unwrap(samples["phase_rad"]) if "phase_rad" in samples else np.zeros(len(height))
    force, climb = samples.get("force_n", undefined), np.diff(height)
    mean_force = 0.5 * (force[1:] + force[:-1])
    over_touchdown = np.maximum(height, rest_length_m + ground)
    # A ground that moves during a step is where it is after it.
    previous = np.maximum(height[:-1], rest_length_m + ground[1:])
    gains = {
        "work_j": mean_force * climb,
        "climb_flight_m": np.maximum(over_touchdown[1:] - previous, 0.0),
        "climb_m": np.maximum(climb, 0.0),
    } | {name: np.diff(samples[name]) for name in TOTALS if name in samples}
    work = absolute = positive = gains["work_j"]
    if "work_j" not in samples:
        absolute, positive = np.abs(work), np.maximum(work, 0.0)

    ends = np.arange(1, frames + 1) * frame_s

    def at_ends(signal: np.ndarray) -> np.ndarray:
        return np.interp(ends, time, signal)[:, None]

    def running(steps: np.ndarray) -> np.ndarray:
        return at_ends(np.concatenate([[0.0], np.cumsum(steps)]))

    def events(index: np.ndarray, value: np.ndarray) -> np.ndarray:
        column = np.full((frames, 1), np.nan)
        frame = np.ceil(index / frame_s - 1e-9).astype(int) - 1
        inside = (frame >= 0) & (frame < frames)
        column[frame[inside], 0] = value[inside]
        return column

    clearance = height - rest_length_m - ground
    apex_time, apex_height = _apexes(height, clearance, step, prominence_m)
    touchdown = _touchdowns(clearance, step)
    unknown = np.full((frames, 1), np.nan)
    return Trajectory(
        time_s=ends[:, None],
        height_m=at_ends(height),
        velocity_m_per_s=at_ends(np.gradient(height, step)),
        phase_rad=at_ends(phase) % (2.0 * np.pi),
        spring_force_n=unknown,
        feedback_rad_per_s=unknown,
        actuator_force_n=at_ends(force),
        ground_m=at_ends(ground),
        energy_j=unknown,
        impulse_ns=running(mean_force * step),
        work_absolute_j=running(absolute),
        work_positive_j=running(positive),
        work_net_j=running(work),
        climb_flight_m=running(gains["climb_flight_m"]),
        climb_m=running(gains["climb_m"]),
        apex_time_s=events(apex_time, apex_time),
        apex_height_m=events(apex_time, apex_height),
        apex_phase_rad=events(apex_time, np.interp(apex_time, time, phase)),
        touchdown_time_s=events(touchdown, touchdown),
        failed=np.zeros((frames, 1), bool),
    )


def _apexes(
    height: np.ndarray, clearance: np.ndarray, step: float, prominence_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the times [s] and heights [m] of the highest point of every flight that rises and
    falls.
    """
    flies = np.concatenate([[False], clearance >= 0.0, [False]])
    starts, ends = np.flatnonzero(~flies[:-1] & flies[1:]), np.flatnonzero(flies[:-1] & ~flies[1:])
    highest = np.array(
        [start + np.argmax(height[start:end]) for start, end in zip(starts, ends, strict=True)], int
    )
    highest = highest[(highest > 0) & (highest < len(height) - 1)]
    if prominence_m > 0.0 and len(highest):
        # What comes after the end is not known: an apex there has to rise from the left alone.
        ended = np.append(height, height.min())
        from scipy.signal import peak_prominences  # slow to import

        highest = highest[peak_prominences(ended, highest)[0] >= prominence_m]
    earlier, top, later = height[highest - 1], height[highest], height[highest + 1]
    curvature = earlier - 2.0 * top + later
    shift = np.where(
        curvature < 0.0, 0.5 * (earlier - later) / np.where(curvature < 0.0, curvature, -1.0), 0.0
    )
    return (highest + shift) * step, top - 0.25 * (earlier - later) * shift


def _touchdowns(clearance: np.ndarray, step: float) -> np.ndarray:
    """Return the times [s] at which the clearance over touchdown turns negative."""
    last = np.flatnonzero((clearance[:-1] >= 0.0) & (clearance[1:] < 0.0))
    return (last + clearance[last] / (clearance[last] - clearance[last + 1])) * step


_FLOOR = 2e-4
"""Noise of a smaller share of the rest length, or of the largest force, counts as none."""

SURE = 4.0
"""Beyond so many standard deviations something is no noise."""

_LEAST_SAMPLES = 50
_ORDERS = range(3, 9)  # of the differences in which smooth signals vanish and noise does not
_BUTTERWORTH = 4
_CUTOFFS = 48
_BINS = 2048
_FOR_WORK = 1.5  # of the cutoff of least error
_ROUND = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)


def noise_std(samples: np.ndarray) -> float:
    """Return the standard deviation of white noise in samples of a signal that is smooth between
    most of them.

    The k-th differences of white noise of deviation σ deviate by `σ √C(2k, k)`, those of a smooth
    signal vanish as k grows. The least estimate of k = 3 ... 8 is taken, each from the median of
    their magnitudes, so that single jumps do not count.

    Args:
        samples: at uniform times, shape [samples].

    Returns:
        σ, in the unit of the samples; 0 for fewer than 50 samples.

    Example:
        >>> wave = np.sin(0.05 * np.arange(2000))
        >>> noise = 0.1 * np.random.default_rng(0).standard_normal(2000)
        >>> f"{noise_std(wave):.3f} {noise_std(wave + noise):.3f}"
        '0.000 0.096'
    """
    if len(samples) < _LEAST_SAMPLES:
        return 0.0
    return min(
        1.4826 * float(np.median(np.abs(np.diff(samples, k)))) / math.sqrt(math.comb(2 * k, k))
        for k in _ORDERS
    )


class Cleaned(NamedTuple):
    """Samples after a low-pass, and the noise that is left in them."""

    samples: np.ndarray
    """[samples]."""
    noise: float
    """Standard deviation of their noise before."""
    left: float
    """Standard deviation of what is left of it."""
    rate_left: float
    """The same of their rate of change [1/s]."""
    cutoff_hz: float
    """Cutoff of the low-pass [Hz]; infinite if there was none."""


def cleaned(
    samples: np.ndarray, step_s: float, *, floor: float, cutoff_hz: float | None = None
) -> Cleaned:
    """Return the samples after the low-pass of least error, as far as they hold noise.

    It is a Butterworth filter of fourth order, run forward and backward: no phase is shifted. At
    the cutoff one pass halves the power; together they halve the amplitude. Of all cutoffs that is
    taken which has the least expected square error, by Stein's estimate,

        mean (y - ŷ)² + 2 σ² mean G,

    with the noise σ of `noise_std`, and the gain G of forward and backward pass over the
    frequencies. Too low a cutoff shows in the first term, too high a one in the second.

    Args:
        samples: at uniform times, shape [samples].
        step_s: sampling period [s].
        floor: noise of a smaller standard deviation counts as none.
        cutoff_hz: the cutoff [Hz], whether there is noise or not; infinite to filter nothing.

    Raises:
        TegotaeError: for a cutoff that is not below half of the sampling rate, or too few samples
            for it.

    Source:
        C. M. Stein, Estimation of the mean of a multivariate normal distribution, Ann. Statist. 9
        (1981).

    Example:
        >>> wave = np.sin(0.05 * np.arange(2000))
        >>> noisy = wave + 0.1 * np.random.default_rng(0).standard_normal(2000)
        >>> clean = cleaned(noisy, 0.01, floor=1e-4)
        >>> f"{np.std(noisy - wave):.3f} {np.std(clean.samples - wave):.3f}"
        '0.100 0.024'
    """
    noise = noise_std(samples)
    noise = noise if noise > floor else 0.0
    if cutoff_hz is None and noise == 0.0:
        return Cleaned(samples, 0.0, 0.0, 0.0, math.inf)
    if cutoff_hz == math.inf:
        return Cleaned(samples, noise, noise, noise * math.pi / step_s / math.sqrt(3.0), math.inf)
    if cutoff_hz is None:
        cutoffs = np.geomspace(2.0 / (len(samples) * step_s), 0.45 / step_s, _CUTOFFS).tolist()
    else:
        _check_cutoff(cutoff_hz, step_s, len(samples))
        cutoffs = [cutoff_hz]

    def risk(passed: tuple[float, np.ndarray, np.ndarray, np.ndarray]) -> float:
        _, smooth, _, gain = passed
        return float(np.mean((samples - smooth) ** 2)) + 2.0 * noise**2 * float(np.mean(gain))

    best = min(((cutoff, *_low_passed(samples, step_s, cutoff)) for cutoff in cutoffs), key=risk)
    chosen_hz, smooth, frequency, gain = best
    residual, rate_left = (math.sqrt(np.mean(by**2)) for by in (gain, gain * frequency))
    return Cleaned(smooth, noise, noise * residual, noise * rate_left, chosen_hz)


def _check_cutoff(cutoff_hz: float, step_s: float, samples: int) -> None:
    """Raise `TegotaeError` for a cutoff that samples cannot be filtered at."""
    if samples < _LEAST_SAMPLES:
        raise TegotaeError(
            f"lowpass takes at least {_LEAST_SAMPLES} samples; the recording has {samples}"
        )
    require_finite("lowpass", cutoff_hz, above=0.0)
    if not cutoff_hz < 0.5 / step_s:
        raise TegotaeError(
            f"lowpass is {cutoff_hz:g} Hz; it must be below half of the sampling rate, "
            f"{0.5 / step_s:g} Hz (inf to filter nothing)"
        )


def _low_passed(
    samples: np.ndarray, step_s: float, cutoff_hz: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the samples without higher frequencies; the angular frequencies [rad/s], and the gain
    at each.
    """
    from scipy.signal import butter, sosfiltfilt, sosfreqz  # slow to import

    sections = butter(_BUTTERWORTH, cutoff_hz, fs=1.0 / step_s, output="sos")
    # Mirrored at its ends: turned about them, too, it would hang on two noisy samples.
    padding = min(len(samples) - 1, round(2.0 / (cutoff_hz * step_s)))
    smooth = sosfiltfilt(sections, samples, padtype="even", padlen=padding)
    frequency, response = sosfreqz(sections, _BINS, fs=2.0 * np.pi / step_s)
    return np.asarray(smooth), np.asarray(frequency), np.abs(response) ** 2


def work_under_noise(
    force_n: np.ndarray, height_m: np.ndarray, direction: np.ndarray, step_s: float, definition: str
) -> np.ndarray:
    """Return the running total of the work, in which noise averages out [J], [samples].

    |F̄ Δy| of noise is work. So the signs that a definition wants are separated from the sizes:
    that of the velocity from a smoother height, that of the force from its own low-pass, where a
    force within four deviations of what that leaves keeps the sign that it had before. Given its
    signs, `Σ ± F̄ Δy` is linear in force and height, and noise of theirs has no mean.

    Args:
        force_n: actuator force [N], [samples].
        height_m: the height [m], [samples].
        direction: the sign of the velocity between samples, [samples - 1].
        step_s: sampling period [s].
        definition: of the work, one of "absolute", "positive", "net".

    Example:
        >>> times = np.arange(400) * 0.01
        >>> height, push = 1.0 + 0.1 * np.sin(6.0 * times), np.full(400, 2.0)
        >>> up = np.sign(np.diff(height))
        >>> f"{work_under_noise(push, height, up, 0.01, 'absolute')[-1]:.2f} J"
        '3.01 J'
    """
    steps = 0.5 * (force_n[1:] + force_n[:-1]) * np.diff(height_m)
    if definition != "net":
        smooth = cleaned(force_n, step_s, floor=_FLOOR * float(np.abs(force_n).max()))
        between = 0.5 * (smooth.samples[1:] + smooth.samples[:-1])
        sign = _last_known_sign(between, SURE * smooth.left) * direction
        steps = sign * steps if definition == "absolute" else np.where(sign > 0.0, steps, 0.0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _last_known_sign(values: np.ndarray, threshold: float) -> np.ndarray:
    """Sign of the values, where they are within `least` that of the last beyond it."""
    if threshold == 0.0:
        return np.sign(values)
    significant = np.abs(values) > threshold
    if not significant.any():
        return np.full(len(values), np.sign(values.mean()))
    last = np.maximum.accumulate(np.where(significant, np.arange(len(values)), -1))
    return np.sign(values[np.where(last < 0, int(np.argmax(significant)), last)])


class Denoised(NamedTuple):
    """A recording after its low-pass."""

    samples: Samples
    """Arrays by name, [samples] each."""
    prominence_m: float
    """Least prominence of an apex above the noise [m]."""
    limit_cycle: LimitCycle
    """Criteria of a settled limit cycle, widened by the noise."""
    notes: tuple[str, ...]
    """Processing steps, a sentence each."""


def denoised(
    samples: Samples,
    *,
    rest_length_m: float,
    limit_cycle: LimitCycle,
    work: str,
    lowpass_hz: float | None = None,
) -> Denoised:
    """Filter height and phase by a zero-phase low-pass if they hold noise.

    The height's cutoff is the one given, or that of least expected error (`cleaned`), and one
    and a half times that for the work. The force is not filtered, so that it keeps its jumps. Noise
    averages out in the work (`work_under_noise`).

    Args:
        samples: from `checked_samples`.
        rest_length_m: rest length of the leg l0 [m].
        limit_cycle: what counts as settled without noise. Apexes differ by noise, too: tolerances
            are widened to four deviations of the difference of two, rounded up, since every
            tolerance is compiled for itself.
        work: definition of work.
        lowpass_hz: cutoff for the height [Hz]; infinite to filter nothing; None to choose it.

    Raises:
        TegotaeError: for a cutoff that cannot be used.

    Example:
        >>> time_s = np.arange(2000) * 0.01
        >>> noise = 0.02 * np.random.default_rng(0).standard_normal(2000)
        >>> samples = {"time_s": time_s, "height_m": 1 + 0.3 * np.sin(6.0 * time_s) + noise}
        >>> clean = denoised(samples, rest_length_m=1.0, limit_cycle=LimitCycle(), work="absolute")
        >>> f"{clean.limit_cycle.height_tolerance_m:g} m"
        '0.03 m'
    """
    time, height, step_s = samples["time_s"], samples["height_m"], step_of(samples)
    of_height = cleaned(height, step_s, floor=_FLOOR * rest_length_m, cutoff_hz=lowpass_hz)
    smooth = {**samples, "height_m": of_height.samples}
    notes = [*_on_height(of_height)]
    apex_s = of_height.rate_left / _curvature(of_height.samples, step_s)
    apex_rad = 0.0
    if "phase_rad" in samples:
        phase = np.unwrap(samples["phase_rad"])
        trend = np.linspace(phase[0], phase[-1], len(phase))
        of_phase = cleaned(phase - trend, step_s, floor=_FLOOR * 2.0 * math.pi)
        if of_phase.noise:
            smooth["phase_rad"] = of_phase.samples + trend
            notes.append(f"the phase holds noise of {of_phase.noise:.2g} rad, and is low-passed")
        turning = abs(float(phase[-1] - phase[0])) / float(time[-1] - time[0])
        apex_rad = math.hypot(of_phase.left, turning * apex_s)
    if "force_n" in samples and "work_j" not in samples:
        force = samples["force_n"]
        noise_n = noise_std(force)
        in_force = noise_n > _FLOOR * float(np.abs(force).max())
        if in_force:
            notes.append(
                f"the force holds noise of about {noise_n:.2g} N: it averages out in the work, and "
                "is in the smoothness"
            )
        if of_height.noise or in_force:
            rougher = of_height.samples
            if lowpass_hz is None and of_height.noise:  # bias does not average out, and noise does
                cutoff_hz = min(_FOR_WORK * of_height.cutoff_hz, 0.45 / step_s)
                rougher = cleaned(height, step_s, floor=0.0, cutoff_hz=cutoff_hz).samples
            direction = np.sign(np.diff(of_height.samples))
            smooth["work_j"] = work_under_noise(force, rougher, direction, step_s, work)
    tolerances = {"height_tolerance_m": of_height.left, "phase_tolerance_rad": apex_rad}
    wider = {name: _rounded_up(SURE * math.sqrt(2.0) * x) for name, x in tolerances.items()}
    wider = {name: x for name, x in wider.items() if x > getattr(limit_cycle, name)}
    if wider:
        units = {"height_tolerance_m": (1e3, "mm"), "phase_tolerance_rad": (1.0, "rad")}
        hidden = " or ".join(
            f"{units[name][0] * x:g} {units[name][1]}" for name, x in wider.items()
        )
        notes.append(f"hops that differ by less than {hidden} count as alike: noise hides it")
    return Denoised(smooth, SURE * of_height.left, replace(limit_cycle, **wider), tuple(notes))


def _rounded_up(value: float) -> float:
    """Return the next larger round number."""
    if value <= 0.0:
        return 0.0
    decade = 10.0 ** math.floor(math.log10(value))
    rounded = next((r for r in _ROUND if r * decade >= value), 10.0)
    return float(f"{rounded * decade:.2g}")


def _curvature(height: np.ndarray, step_s: float) -> float:
    """Return the typical magnitude of the acceleration in the upper half [m/s²]."""
    bends = np.abs(np.diff(height, 2)) / step_s**2
    return float(np.median(bends[height[1:-1] >= np.median(height)])) or 1.0


def _on_height(signal: Cleaned) -> tuple[str, ...]:
    remark = f"the height holds noise of about {_short(1e3 * signal.noise)} mm (standard deviation)"
    if math.isinf(signal.cutoff_hz):
        return (remark + ", and is not filtered",) if signal.noise else ()
    passed = f"low-passed at {signal.cutoff_hz:.3g} Hz"
    if not signal.noise:
        return (f"the height is {passed}",)
    return (f"{remark}: {passed}, which leaves about {_short(1e3 * signal.left)} mm",)


def _short(value: float) -> str:
    """Return a number in two digits, never as a power of ten."""
    return f"{float(f'{value:.2g}'):g}"
