"""A recording against what bodies and sensors do: holes, leaps, frozen and held samples."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.recording import SURE, check_increasing, noise_std

MOST_PERIODS = 5
"""Longest time without a sample, in sampling periods."""
_MOST = 1e9  # larger values are refused where they are measured
_GRAVITY_M_PER_S2 = 9.81
_FASTER = 2.0  # than a fall through all of the recorded heights: legs push, and gravities differ
_FROZEN = 8  # samples of one value
_STARTS_M_PER_S2 = 200.0  # of a body that stood still: twenty times gravity
_MOST_WEIGHTS = 50.0
_HELD = 0.3  # share of the values that are repeated
_QUANTA = 3.0  # a step of more is none of the sensor's resolution
_LEAST = 20
_TO_HELD = 30


def check_plausible(samples: pd.DataFrame) -> None:
    """Raise `TegotaeError` for a recording that no body and sensor make.

    It is one with holes of more than `MOST_PERIODS` sampling periods, with times that do not
    increase, with a height that lies below the ground, stands still and leaps, or moves faster than
    twice a fall through its range R, `2 √(2 g R)`, or with a height or load that was held at a
    lower rate than the log's. Empty cells (NaN) are left out.

    Args:
        samples: `time_s`, `height_m` and what else is recorded, a row a sample.

    Example:
        >>> time_s = np.arange(400) * 0.01
        >>> height_m = 1.0 + 0.1 * np.sin(6.0 * time_s)
        >>> check_plausible(pd.DataFrame({"time_s": time_s, "height_m": height_m}))
    """
    time_s = samples["time_s"].to_numpy(float)
    if np.isfinite(time_s).all():
        check_increasing(time_s)
    if "ground_m" not in samples:
        _check_upwards(samples["height_m"].to_numpy(float))
    for name, cells in samples.items():
        column = cells.to_numpy(float)
        rows = np.flatnonzero(np.isfinite(column))
        if name == "time_s" or len(rows) < 3 or np.abs(column[rows]).max() > _MOST:
            continue
        _check_holes(str(name), time_s[rows], rows)
        if name in ("height_m", "spring_force_n"):
            _check_held(str(name), column[rows], time_s[rows])
        if name == "height_m":
            _check_frozen(column[rows], time_s[rows], rows)
            _check_leaps(column[rows], time_s[rows], rows)


def doubts(samples: pd.DataFrame) -> list[str]:
    """Return a line on every odd but possible property of a recording.

    Args:
        samples: as of `check_plausible`.

    Example:
        >>> rows, random = np.arange(4000), np.random.default_rng(0)
        >>> held = np.repeat(random.uniform(0.0, 1.0, 200), 20)
        >>> doubts(pd.DataFrame({"time_s": rows * 0.005, "command_share": held}))
        ['command_share changes at every 20th sample only: it is taken to be held in between']
    """
    if "command_share" not in samples:
        return []
    changes = np.flatnonzero(np.diff(samples["command_share"].dropna()))
    every = int(np.gcd.reduce(np.diff(changes))) if len(changes) >= _TO_HELD else 1
    if every < 2:
        return []
    return [
        f"command_share changes at every {every}th sample only: it is taken to be held in between"
    ]


def check_over_ground(samples: pd.DataFrame, rest_length_m: float) -> list[str]:
    """Return a line on a body that moves without flight, for a leg of known length.

    Args:
        samples: as of `check_plausible`.
        rest_length_m: height over ground at which the foot leaves it, l0 [m].

    Raises:
        TegotaeError: for a body below the ground, or one that stands still in the air.
    """
    time, height = (samples[name].to_numpy(float) for name in ("time_s", "height_m"))
    over = height - np.asarray(samples.get("ground_m", 0.0))
    _check_upwards(over)
    starts, lengths = _runs(height)
    fall_m = _GRAVITY_M_PER_S2 * (time[starts + lengths - 1] - time[starts]) ** 2 / 8.0
    hangs = (lengths >= _FROZEN) & (over[starts] > rest_length_m) & (fall_m > 0.1 * rest_length_m)
    if hangs.any():
        start = starts[int(np.argmax(hangs))]
        end = start + lengths[int(np.argmax(hangs))] - 1
        raise TegotaeError(
            f"height_m stays at {height[start]:.4g} from sample {start} to {end} "
            f"({time[start]:.4g} to {time[end]:.4g} s), above the rest length of "
            f"{rest_length_m:g} m: nothing hangs in the air; cut the recording to what was measured"
        )
    moves = np.quantile(over, 0.99) - np.quantile(over, 0.01)
    if over.max() > rest_length_m or moves < 0.1 * rest_length_m:
        return []
    return [
        f"the height moves by {moves:.3g} m and never exceeds the rest length of "
        f"{rest_length_m:g} m: no flight; look at rest length, unit and zero of the height, and "
        "whether it points downwards (--columns height=-COLUMN[UNIT])"
    ]


def check_forces(
    force_n: np.ndarray, *, weight_n: float | None = None, max_force_n: float | None = None
) -> list[str]:
    """Return a line on forces that nothing can be compared with.

    Args:
        force_n: of the actuator [N], [samples].
        weight_n: of the body [N], if it is known.
        max_force_n: of the actuator [N], if it is known.

    Raises:
        TegotaeError: for forces that are in another unit.
    """
    largest_n = float(np.nanmax(np.abs(force_n)))
    units = [
        (weight_n, _MOST_WEIGHTS, "the weight"),
        (max_force_n, 2.0, "the actuator's largest force"),
    ]
    for newton, times, unit in units:
        if newton is not None and math.isfinite(newton) and largest_n > times * newton:
            raise TegotaeError(
                f"force_n reaches {largest_n:.4g} N, {largest_n / newton:.3g} times {unit} of "
                f"{newton:.4g} N; look at its unit, such as --columns force=COLUMN[gf]"
            )
    if weight_n is not None or max_force_n is not None:
        return []
    return [f"the force reaches {largest_n:.3g} N; --mass-kg or --max-force-n checks its unit"]


def _check_upwards(over_ground_m: np.ndarray) -> None:
    median = float(np.nanmedian(over_ground_m))
    if median < 0.0:
        raise TegotaeError(
            f"the height over ground is {median:.4g} m in the median: it points downwards, or has "
            "another zero; --columns height=-COLUMN[UNIT] turns it round"
        )


def _check_holes(name: str, time_s: np.ndarray, rows: np.ndarray) -> None:
    steps = np.diff(time_s)
    median_s = float(np.median(steps))
    index = int(np.argmax(steps))
    if steps[index] > (MOST_PERIODS + 0.5) * median_s:
        raise TegotaeError(
            f"{name} has no sample for {steps[index]:.4g} s after sample {rows[index]} "
            f"({time_s[index]:.4g} s), and one every {median_s:.4g} s elsewhere; cut the recording "
            f"there, since no more than {MOST_PERIODS} periods are bridged"
        )


def _check_leaps(height: np.ndarray, time_s: np.ndarray, rows: np.ndarray) -> None:
    fastest = _FASTER * math.sqrt(2.0 * _GRAVITY_M_PER_S2 * np.ptp(height))
    noise = 2.0 * SURE * noise_std(height)
    steps, period = np.diff(height), np.diff(time_s)
    over = np.abs(steps) - fastest * period - noise
    index = int(np.argmax(over > 0.0))
    if over[index] > 0.0:
        raise TegotaeError(
            f"height_m goes from {height[index]:.3g} to {height[index + 1]:.4g} at sample "
            f"{rows[index + 1]} ({time_s[index + 1]:.4g} s) within {period[index]:.4g} s, and no "
            f"body that moves by {np.ptp(height):.3g} m is faster than {fastest:.3g} m/s; correct "
            "the samples, or cut them off"
        )


def _runs(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first samples of the runs of one value, and the length of each."""
    edges = np.flatnonzero(np.concatenate([[True], np.diff(values) != 0.0, [True]]))
    return edges[:-1], np.diff(edges)


def _check_frozen(height: np.ndarray, time_s: np.ndarray, rows: np.ndarray) -> None:
    starts, lengths = _runs(height)
    leaps = np.abs(np.diff(height[starts]))
    beside = np.maximum(np.append(leaps, 0.0), np.append(0.0, leaps))
    threshold = 0.5 * _STARTS_M_PER_S2 * float(np.median(np.diff(time_s))) ** 2
    frozen = (lengths >= _FROZEN) & (beside > threshold)
    if frozen.any():
        run = int(np.argmax(frozen))
        start, end = starts[run], starts[run] + lengths[run] - 1
        raise TegotaeError(
            f"height_m stays at {height[start]:.4g} from sample {rows[start]} to {rows[end]} "
            f"({time_s[start]:.4g} to {time_s[end]:.4g} s) and leaps by {beside[run]:.3g} m "
            "beside it: the sensor was frozen; cut the recording there"
        )


def _check_held(name: str, column: np.ndarray, time_s: np.ndarray) -> None:
    """Raise `TegotaeError` for a sensor slower than the log, whose last value is repeated."""
    starts, lengths = _runs(column)
    if len(starts) < _LEAST:
        return
    steps = np.abs(np.diff(column[starts]))
    if np.mean(lengths > 1) > _HELD and np.median(steps) > _QUANTA * steps.min():
        rate = 1.0 / float(np.median(np.diff(time_s)))
        raise TegotaeError(
            f"{name} repeats its last value for {lengths.max()} samples and less: a sensor of "
            f"about {rate / lengths.mean():.3g} Hz in a log of {rate:.3g} Hz; record it at the "
            "log's rate, or leave the cells without a new value empty and set --resample HZ"
        )
