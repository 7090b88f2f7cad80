"""Recordings from elsewhere, a robot or another simulator: arrays in, a trajectory out."""

from __future__ import annotations

from typing import NotRequired, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.simulation.rollout import Trajectory

_UNIFORM = 0.01  # largest deviation of a time step from the mean one, as a share of it
_MOST = 1e9  # largest value in SI units that a recording may hold
_RESTART = 3.0  # a fall of so many times the largest rise, and the steps beside it, is a restart


class Samples(TypedDict):
    """The samples of a recording, as `from_samples` takes them: [samples] each."""

    time_s: ArrayLike
    height_m: ArrayLike
    ground_m: NotRequired[ArrayLike]
    phase_rad: NotRequired[ArrayLike | None]
    force_n: NotRequired[ArrayLike | None]
    work_j: NotRequired[ArrayLike | None]
    climb_flight_m: NotRequired[ArrayLike | None]
    climb_m: NotRequired[ArrayLike | None]


def from_samples(
    time_s: ArrayLike,
    height_m: ArrayLike,
    *,
    rest_length_m: float,
    ground_m: ArrayLike = 0.0,
    phase_rad: ArrayLike | None = None,
    force_n: ArrayLike | None = None,
    work_j: ArrayLike | None = None,
    climb_flight_m: ArrayLike | None = None,
    climb_m: ArrayLike | None = None,
    prominence_m: float = 0.0,
    frame_s: float = 0.02,
) -> Trajectory:
    """A recording of one gait as frames, in the form in which `Engine` records its own.

    Touchdowns lie where the height crosses `l0 + h`, between two samples by linear interpolation.
    Every flight has one apex: its highest sample, refined by a parabola through three, which is
    exact in ballistic flight. The actuator's work is what `work_j` says, or else
    `E = Σ F̄ Δy`, with the mean force between two samples. Running totals of climbs likewise go
    before what follows from the heights: they were counted between the samples, too.

    Args:
        time_s: sampling times, uniform and increasing [s], shape [samples].
        height_m: height of the centre of mass y [m], [samples].
        rest_length_m: height over ground at which the foot leaves it, l0 [m].
        ground_m: height of the ground h [m], a number or [samples].
        phase_rad: oscillator phase φ, wrapped or not [rad], [samples]; None without an oscillator.
        force_n: actuator force F_a [N], [samples]; None if not recorded.
        work_j: running total of the work [J], [samples], by whatever definition it was counted; it
            stands for all. None if not recorded. Without it and the force, work is NaN.
        climb_flight_m: running total of the heights climbed in flight [m], [samples].
        climb_m: running total of all heights climbed [m], [samples].
        prominence_m: how far an apex must stand out from the lowest heights on either side, up to
            the next that is higher [m], not to be taken for noise.
        frame_s: period of the frames [s], not below that of the samples.

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
    require_finite("rest_length_m", rest_length_m, above=0.0, most=_MOST)
    require_finite("frame_s", frame_s, above=0.0)
    time = _checked_time(time_s)
    samples, step = len(time), (time[-1] - time[0]) / (len(time) - 1)
    time = np.arange(samples) * step
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
    height = _checked("height_m", height_m, samples)
    _check_spikes(height, rest_length_m)
    ground = _checked("ground_m", np.broadcast_to(ground_m, np.shape(ground_m) or samples), samples)
    has_phase, has_force = phase_rad is not None, force_n is not None
    phase = np.unwrap(_checked("phase_rad", phase_rad, samples)) if has_phase else np.zeros(samples)
    force = _checked("force_n", force_n, samples) if has_force else np.full(samples, np.nan)

    climb = np.diff(height)
    mean_force = 0.5 * (force[1:] + force[:-1])
    if work_j is None:
        work = mean_force * climb
        absolute, positive = np.abs(work), np.maximum(work, 0.0)
    else:
        work = absolute = positive = _steps_of_total("work_j", work_j, samples)
    over_touchdown = np.maximum(height, rest_length_m + ground)
    # A ground that moves during a step is where it is after it.
    before = np.maximum(height[:-1], rest_length_m + ground[1:])
    climb_flight = np.maximum(over_touchdown[1:] - before, 0.0)
    if climb_flight_m is not None:
        climb_flight = _steps_of_total("climb_flight_m", climb_flight_m, samples)
    all_climbs = np.maximum(climb, 0.0)
    if climb_m is not None:
        all_climbs = _steps_of_total("climb_m", climb_m, samples)

    ends = np.arange(1, frames + 1) * frame_s

    def at_ends(signal: np.ndarray) -> np.ndarray:
        return np.interp(ends, time, signal)[:, None]

    def running(steps: np.ndarray) -> np.ndarray:
        return at_ends(np.concatenate([[0.0], np.cumsum(steps)]))

    def events(at: np.ndarray, value: np.ndarray) -> np.ndarray:
        column = np.full((frames, 1), np.nan)
        frame = np.ceil(at / frame_s - 1e-9).astype(int) - 1
        inside = (frame >= 0) & (frame < frames)
        column[frame[inside], 0] = value[inside]
        return column

    apex_time, apex_height = _apexes(height, height - rest_length_m - ground, step, prominence_m)
    touchdown = _touchdowns(height - rest_length_m - ground, step)
    nothing = np.full((frames, 1), np.nan)
    return Trajectory(
        time_s=ends[:, None],
        height_m=at_ends(height),
        velocity_m_per_s=at_ends(np.gradient(height, step)),
        phase_rad=at_ends(phase) % (2.0 * np.pi),
        spring_force_n=nothing,
        feedback_rad_per_s=nothing,
        actuator_force_n=at_ends(force),
        ground_m=at_ends(ground),
        energy_j=nothing,
        impulse_ns=running(mean_force * step),
        work_absolute_j=running(absolute),
        work_positive_j=running(positive),
        work_net_j=running(work),
        climb_flight_m=running(climb_flight),
        climb_m=running(all_climbs),
        apex_time_s=events(apex_time, apex_time),
        apex_height_m=events(apex_time, apex_height),
        apex_phase_rad=events(apex_time, np.interp(apex_time, time, phase)),
        touchdown_time_s=events(touchdown, touchdown),
        failed=np.zeros((frames, 1), bool),
    )


def _checked(name: str, values: ArrayLike | None, samples: int) -> np.ndarray:
    """The values as float64 [samples], all finite."""
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
    if abs(array[where]) > _MOST:
        raise TegotaeError(
            f"{name} is {array[where]:g} at sample {where}; no recording holds more than {_MOST:g}"
        )
    return array


def _check_spikes(height: np.ndarray, rest_length_m: float) -> None:
    """Raise `TegotaeError` for a sample that lies off both its neighbours by over a rest length."""
    before, after = height[1:-1] - height[:-2], height[1:-1] - height[2:]
    off = np.where(before * after > 0.0, np.minimum(np.abs(before), np.abs(after)), 0.0)
    where = int(np.argmax(off))
    if off[where] > rest_length_m:
        raise TegotaeError(
            f"height_m is {height[where + 1]:g} at sample {where + 1} and {height[where]:g} before "
            f"it, and goes back: further than the rest length of {rest_length_m:g} m in one "
            "sample; correct the sample, or check units and rest length"
        )


def _steps_of_total(name: str, values: ArrayLike | None, samples: int) -> np.ndarray:
    """What a running total gains from sample to sample, [samples - 1].

    Net work may fall, but not in one sample and by more than it ever rises in one: such a fall is
    a counter that starts again, or overflows.
    """
    total = _checked(name, values, samples)
    steps = np.diff(total)
    beside = np.abs(np.concatenate([[0.0], steps, [0.0]]))
    usual = np.maximum(np.maximum(beside[:-2], beside[2:]), steps.max(initial=0.0))
    restarts = (-steps > _RESTART * usual) & (steps.max(initial=0.0) > 0.0)
    if restarts.any():
        where = int(np.argmax(restarts))
        raise TegotaeError(
            f"{name} falls from {total[where]:g} to {total[where + 1]:g} at sample {where + 1}: a "
            "running total does not start again; add up its parts, or cut the recording there"
        )
    return steps


def _checked_time(time_s: ArrayLike) -> np.ndarray:
    """Increasing, uniform times [s]."""
    samples = np.shape(time_s)
    if len(samples) != 1 or samples[0] < 3:
        raise TegotaeError(f"time_s has shape {samples}; it must be one row of at least 3 times")
    time = _checked("time_s", time_s, samples[0])
    steps = np.diff(time)
    if not (steps > 0.0).all():
        where = int(np.argmin(steps > 0.0))
        raise TegotaeError(
            f"time_s goes from {time[where]:g} to {time[where + 1]:g} at sample {where + 1}; "
            "it must increase"
        )
    mean = steps.mean()
    uneven = np.abs(steps - mean)
    where = int(np.argmax(uneven))
    if uneven[where] > _UNIFORM * mean:
        raise TegotaeError(
            f"time_s has a step of {steps[where]:g} s at sample {where + 1}, the mean being "
            f"{mean:g} s; resample the recording to uniform times (--resample HZ)"
        )
    return time


def _apexes(
    height: np.ndarray, clearance: np.ndarray, step: float, prominence_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and heights [m] of the highest point of every flight that rises and falls."""
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
    left, top, right = height[highest - 1], height[highest], height[highest + 1]
    curvature = left - 2.0 * top + right
    shift = np.where(
        curvature < 0.0, 0.5 * (left - right) / np.where(curvature < 0.0, curvature, -1.0), 0.0
    )
    return (highest + shift) * step, top - 0.25 * (left - right) * shift


def _touchdowns(clearance: np.ndarray, step: float) -> np.ndarray:
    """Times [s] at which the clearance over touchdown turns negative."""
    last = np.flatnonzero((clearance[:-1] >= 0.0) & (clearance[1:] < 0.0))
    return (last + clearance[last] / (clearance[last] - clearance[last + 1])) * step
