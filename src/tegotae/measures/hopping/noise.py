"""Noise of a recording: its level, and what is left without it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.hopping.hopping import LimitCycle
from tegotae.measures.hopping.recording import Samples

FLOOR = 2e-4
"""Noise of a smaller share of the rest length, or of the largest force, counts as none."""

SURE = 4.0
"""Beyond so many standard deviations something is no noise."""

_LEAST_SAMPLES = 50
_ORDERS = range(3, 9)  # of the differences in which smooth signals vanish and noise does not
_BUTTERWORTH = 4
_CUTOFFS = 48
_BINS = 2048


def noise_std(samples: np.ndarray) -> float:
    """Standard deviation of white noise in samples of a signal that is smooth between most of them.

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


@dataclass(frozen=True)
class LowPass:
    """A Butterworth filter of fourth order, run forward and backward: no phase is shifted.

    Args:
        cutoff_hz: where a pass halves the power [Hz]; together they halve the amplitude.
        step_s: sampling period [s].

    Raises:
        TegotaeError: for a cutoff that is not between zero and half of the sampling rate.

    Example:
        >>> times = np.arange(500) * 0.01
        >>> slow, fast = np.sin(6.0 * times), np.sin(200.0 * times)
        >>> f"{np.abs(LowPass(8.0, 0.01)(slow + fast) - slow)[50:-50].max():.3f}"
        '0.000'
    """

    cutoff_hz: float
    step_s: float

    def __post_init__(self) -> None:
        require_finite("lowpass", self.cutoff_hz, above=0.0)
        if not self.cutoff_hz < 0.5 / self.step_s:
            raise TegotaeError(
                f"lowpass is {self.cutoff_hz:g} Hz; it must be below half of the sampling rate, "
                f"{0.5 / self.step_s:g} Hz (inf to filter nothing)"
            )

    def __call__(self, samples: np.ndarray) -> np.ndarray:
        """The samples without what is faster, [samples]."""
        reach = round(2.0 / (self.cutoff_hz * self.step_s))
        # Mirrored at its ends: turned about them, too, it would hang on two noisy samples.
        padding = min(len(samples) - 1, reach)
        from scipy.signal import sosfiltfilt  # slow to import

        return sosfiltfilt(self._sections, samples, padtype="even", padlen=padding)

    @property
    def _sections(self) -> np.ndarray:
        from scipy.signal import butter

        return np.asarray(butter(_BUTTERWORTH, self.cutoff_hz, fs=1.0 / self.step_s, output="sos"))

    def gain(self) -> tuple[np.ndarray, np.ndarray]:
        """Angular frequencies up to half of the sampling rate [rad/s], and the amplitude's gain."""
        from scipy.signal import sosfreqz

        frequency, response = sosfreqz(self._sections, _BINS, fs=2.0 * np.pi / self.step_s)
        return np.asarray(frequency), np.abs(np.asarray(response)) ** 2


@dataclass(frozen=True)
class Cleaned:
    """Samples after a low-pass, and what noise is left in them."""

    samples: np.ndarray
    """[samples]."""
    noise: float
    """Standard deviation of the noise that was found."""
    left: float
    """Standard deviation of what is left of it."""
    rate_left: float
    """The same of their rate of change [1/s]."""
    cutoff_hz: float
    """Cutoff of the low-pass [Hz]; infinite if there was none."""


def cleaned(
    samples: np.ndarray, step_s: float, *, floor: float, cutoff_hz: float | None = None
) -> Cleaned:
    """Samples after the low-pass that leaves the least error, as far as they hold noise.

    Of all cutoffs that is taken which has the least expected square error, by Stein's estimate,

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
    if cutoff_hz is not None and math.isinf(cutoff_hz) and cutoff_hz > 0.0:
        return Cleaned(samples, noise, noise, noise * math.pi / step_s / math.sqrt(3.0), math.inf)
    if cutoff_hz is not None and len(samples) < _LEAST_SAMPLES:
        raise TegotaeError(
            f"lowpass takes at least {_LEAST_SAMPLES} samples; the recording has {len(samples)}"
        )
    chosen = _best(samples, step_s, noise) if cutoff_hz is None else LowPass(cutoff_hz, step_s)
    frequency, gain = chosen.gain()
    return Cleaned(
        chosen(samples),
        noise,
        noise * math.sqrt(np.mean(gain**2)),
        noise * math.sqrt(np.mean((gain * frequency) ** 2)),
        chosen.cutoff_hz,
    )


def _best(samples: np.ndarray, step_s: float, noise: float) -> LowPass:
    """The low-pass of least expected error."""

    def risk(of: LowPass) -> float:
        error = float(np.mean((samples - of(samples)) ** 2))
        return error + 2.0 * noise**2 * float(np.mean(of.gain()[1]))

    cutoffs = np.geomspace(2.0 / (len(samples) * step_s), 0.45 / step_s, _CUTOFFS)
    return min((LowPass(float(cutoff), step_s) for cutoff in cutoffs), key=risk)


def work_under_noise(
    force_n: np.ndarray, height_m: np.ndarray, direction: np.ndarray, step_s: float, definition: str
) -> np.ndarray:
    """Running total of the work, in which noise averages out [J], [samples].

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
        smooth = cleaned(force_n, step_s, floor=FLOOR * float(np.abs(force_n).max()))
        between = 0.5 * (smooth.samples[1:] + smooth.samples[:-1])
        sign = _last_known_sign(between, SURE * smooth.left) * direction
        steps = sign * steps if definition == "absolute" else np.where(sign > 0.0, steps, 0.0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _last_known_sign(values: np.ndarray, least: float) -> np.ndarray:
    """Sign of the values, where they are within `least` that of the last beyond it."""
    if least == 0.0:
        return np.sign(values)
    known = np.abs(values) > least
    if not known.any():
        return np.full(len(values), np.sign(values.mean()))
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.sign(values[np.where(last < 0, int(np.argmax(known)), last)])


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
