"""Work, spectra and smoothness of a recorded signal."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.simulation.recorder import Trajectory

WORK = ("absolute", "positive", "net")
"""Definitions of the actuator's work: ∫ |F_a ẏ| dt, ∫ max(0, F_a ẏ) dt, ∫ F_a ẏ dt."""


def check_work(definition: str, name: str = "work") -> None:
    """Raise `TegotaeError`, naming the setting, for a definition of work that is not in `WORK`."""
    if definition not in WORK:
        raise TegotaeError(f"{name} is {definition!r}; it must be one of {', '.join(WORK)}")


def work_total(trajectory: Trajectory, definition: str = "absolute") -> AnyArray:
    """Return the running total of the actuator's work [J], shape [frames, lanes].

    Args:
        trajectory: which has the channel `work_absolute_j`, or that of the definition.
        definition: one of `WORK`.

    Raises:
        TegotaeError: for a definition that is none of `WORK`.
    """
    check_work(definition)
    return getattr(trajectory, f"work_{definition}_j")


def cot_inverse(climb_m: Numeric, work_j: Numeric) -> jax.Array:
    """Return the inverse cost of transport, `CoT⁻¹ = Σ heights climbed / E` [m/J] (paper equation
    12).

    Zero where nothing was climbed or no work was done.

    Args:
        climb_m: climbed height [m], any shape: in flight (variant A) or in all (variant B).
        work_j: work over the same time [J], same shape.

    Example:
        >>> float(cot_inverse(1.5, 2.0)), float(cot_inverse(1.5, 0.0))
        (0.75, 0.0)
    """
    climb_m, work_j = jnp.asarray(climb_m), jnp.asarray(work_j)
    moves = (climb_m > 0.0) & (work_j > 1e-6)
    return jnp.where(moves, climb_m / jnp.where(moves, work_j, 1.0), 0.0)


REST_RANGE_M = 1e-3
"""A body whose height stays within this range [m] is at rest and has no spectrum."""

MAIN_LOBE_BINS = 2.0
"""Half width of the Hann window's main lobe."""


class Spectrum(NamedTuple):
    """One-sided power spectrum of a windowed signal."""

    angular_frequency: jax.Array
    """Angular frequencies [rad/s], shape [bins]."""
    power: jax.Array
    """|Y|² of the Hann-windowed, mean-free signal, shape [bins, lanes]."""
    resolution: jax.Array
    """2π / window length [rad/s]: one bin of the signal without zero padding; [1] or
    [lanes]."""


def spectrum(height_m: AnyArray, sample_s: float, first: Numeric = 0) -> Spectrum:
    """Return the power spectrum of a height [m] sampled every `sample_s` [s]: shape [samples,
    lanes].

    The mean is removed, a Hann window applied, and the signal padded with zeros to at least four
    times its length, so that the peak can be interpolated.

    Args:
        height_m: the signal, shape [samples, lanes].
        sample_s: sampling period [s].
        first: the sample at which the window starts, one or [lanes]: each lane may have its own,
            such as where its limit cycle begins.
    """
    height_m = jnp.asarray(height_m)
    dtype, samples = height_m.dtype, len(height_m)
    first = jnp.asarray(first, dtype).reshape(1, -1)
    length = samples - first
    sample = jnp.arange(samples, dtype=dtype)[:, None] - first
    inside = jnp.where(sample >= 0.0, 1.0, 0.0).astype(dtype)
    window = inside * (0.5 - 0.5 * jnp.cos(2.0 * np.pi * sample / length))
    mean = jnp.sum(inside * height_m, axis=0, keepdims=True) / length
    padded = 1 << int(np.ceil(np.log2(4 * samples)))
    transform = jnp.fft.rfft(window * (height_m - mean), padded, axis=0)
    frequencies = np.arange(padded // 2 + 1) * (2.0 * np.pi / (padded * sample_s))
    return Spectrum(
        jnp.asarray(frequencies, dtype),
        jnp.real(transform) ** 2 + jnp.imag(transform) ** 2,
        2.0 * np.pi / (length[0] * sample_s),
    )


def peak(spectrum: Spectrum) -> tuple[jax.Array, jax.Array]:
    """Return the frequency w_peak [rad/s] of the highest peak, and A_peak.

    The peak is refined by a parabola through the logarithm of three bins. A_peak is the square
    root of the share of the power inside the peak's main lobe: 1 for a pure sinusoid.
    Both have shape [lanes].
    """
    power = spectrum.power
    interior = power[1:-1]
    bin_number = jnp.arange(1, 1 + len(interior), dtype=jnp.int32)[:, None]
    # The first of the highest, as argmax finds it, in two reductions that XLA makes vector code of.
    # Either may compute the power anew, with another last digit: so "highest" leaves room for it.
    threshold = (1.0 - 4.0 * jnp.finfo(power.dtype).eps) * interior.max(axis=0, keepdims=True)
    highest = jnp.where(interior >= threshold, bin_number, len(interior)).min(axis=0)

    def neighbour(offset: int) -> jax.Array:
        return jnp.take_along_axis(power, highest[None] + offset, axis=0)[0]

    shift = _parabola_shift(neighbour(-1), neighbour(0), neighbour(1))
    w_peak = (highest.astype(power.dtype) + shift) * spectrum.angular_frequency[1]
    distance = jnp.abs(spectrum.angular_frequency[:, None] - w_peak[None])
    in_lobe = distance <= MAIN_LOBE_BINS * spectrum.resolution[None]
    total = jnp.sum(power, axis=0)
    share = jnp.sum(jnp.where(in_lobe, power, 0.0), axis=0) / jnp.where(total > 0.0, total, 1.0)
    return w_peak, jnp.sqrt(share)


def _parabola_shift(lower: jax.Array, centre: jax.Array, upper: jax.Array) -> jax.Array:
    """Return the peak of a parabola through the logarithm of three powers, in bins from the centre,
    -½ ... ½."""
    lower, centre, upper = (jnp.log(power + 1e-30) for power in (lower, centre, upper))
    curvature = lower - 2.0 * centre + upper
    bends = curvature < 0.0
    shift = 0.5 * (lower - upper) / jnp.where(bends, curvature, -1.0)
    return jnp.clip(jnp.where(bends, shift, 0.0), -0.5, 0.5)


def delta_omega(omega: Numeric, w_peak: Numeric, a_peak: Numeric) -> Numeric:
    """Return `ΔΩ = -(ω - w_peak)² - (1 - A_peak)²` (paper equation 13), zero at best.

    Args:
        omega: prescribed frequency ω [rad/s].
        w_peak: frequency of the highest peak [rad/s].
        a_peak: square root of the power share of that peak.

    Example:
        >>> delta_omega(5.0, 4.5, 1.0)
        -0.25
    """
    return -((omega - w_peak) ** 2) - (1.0 - a_peak) ** 2


def rest_delta_omega(omega: Numeric) -> Numeric:
    """Return ΔΩ of a body at rest, which has no peak: w_peak = 0 and A_peak = 0, so `-ω² - 1`."""
    return delta_omega(omega, 0.0, 0.0)


def delta_w(spectrum: Spectrum, omega: Numeric) -> jax.Array:
    """Return `Δw = Σ_p |w_p - ω| A_p` over the peaks p with `A_p >= ½ A_max` [rad/s] (paper
    equation 14).

    Every local maximum of the spectrum |Y| is a peak. The highest has the amplitude A_peak
    (`peak`), and the others in proportion to their height, `A_p = A_peak |Y_p| / |Y_peak|`.

    Args:
        spectrum: the spectrum, [bins, lanes].
        omega: prescribed frequency ω [rad/s], one or [lanes].

    Returns:
        Δw [rad/s], shape [lanes].

    Example:
        >>> time_s = np.arange(2000)[:, None] * 0.02
        >>> height_m = 1.2 + 0.1 * np.sin(4.0 * time_s) + 0.08 * np.sin(7.0 * time_s)
        >>> f"{float(delta_w(spectrum(height_m, 0.02), 5.0)[0]):.1f} rad/s"  # (1 + 2 · 0.8) · 0.78
        '2.0 rad/s'
    """
    power = spectrum.power
    lower, centre, upper = power[:-2], power[1:-1], power[2:]
    highest = jnp.max(centre, axis=0, keepdims=True)
    relative = jnp.sqrt(centre / jnp.where(highest > 0.0, highest, 1.0))
    is_peak = (centre > lower) & (centre >= upper) & (relative >= 0.5)
    shift = _parabola_shift(lower, centre, upper) * spectrum.angular_frequency[1]
    frequency = spectrum.angular_frequency[1:-1, None] + shift
    away = jnp.abs(frequency - jnp.asarray(omega, power.dtype).reshape(1, -1))
    distance = jnp.where(is_peak, away * relative, 0.0)
    return peak(spectrum)[1] * jnp.sum(distance, axis=0)


FORCE_PERIOD_S = 0.02
"""The actuator force is averaged over this time [s] before its rate of change is taken."""


def require_measurable(tick_s: float) -> None:
    """Raise `TegotaeError` for a control period by which hops cannot be measured.

    Records are of whole control periods, and the mean force of each 20 ms is one of its metrics.
    """
    if not _divides(tick_s):
        raise TegotaeError(
            f"the control period is {tick_s:g} s; hops are measured with those of which "
            f"{FORCE_PERIOD_S:g} s is a whole multiple, such as 0.001, 0.002, 0.0025, 0.004, "
            "0.005, 0.01 and 0.02"
        )


def _divides(period_s: float) -> bool:
    ratio = FORCE_PERIOD_S / period_s
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= 1e-6


def smoothness(
    impulse_ns: AnyArray, max_force_n: Numeric, frame_s: float, start_s: Numeric
) -> jax.Array:
    """Return root-mean-square rate of change of the actuator force over its largest value [1/s].

        smoothness = rms( (F̄_{j+1} - F̄_j) / Δt ) / α,    Δt = 20 ms,

    where F̄_j is the mean force over the j-th 20 ms. The mean makes a force that jumps measurable,
    and the result independent of how finely the force was recorded. The smaller, the smoother.

    Args:
        impulse_ns: running total of ∫ F_a dt [N s] at the end of each frame, [frames, lanes].
        max_force_n: largest force α [N].
        frame_s: recording period [s], of which 20 ms is a whole multiple.
        start_s: only later changes count [s]; a number or [lanes].

    Raises:
        TegotaeError: for a recording period of which 20 ms is no multiple.

    Example:
        >>> import numpy as np
        >>> force = 4.0 * np.arange(50)[:, None] / 50  # 0 to 4 N within a second
        >>> f"{float(smoothness(np.cumsum(0.02 * force, axis=0), 4.0, 0.02, 0.0)[0]):.3f}"
        '1.000'
    """
    if not _divides(frame_s):
        raise TegotaeError(
            f"frame_s is {frame_s:g}; the smoothness of actuation needs a recording period "
            f"of which {FORCE_PERIOD_S:g} s is a whole multiple"
        )
    every = round(FORCE_PERIOD_S / frame_s)
    total = jnp.asarray(impulse_ns)[every - 1 :: every]
    rate = jnp.diff(total, 2, axis=0) / FORCE_PERIOD_S**2
    # The j-th change is that from the (j+1)-th mean force to the next.
    begins = FORCE_PERIOD_S * jnp.arange(1, len(rate) + 1, dtype=rate.dtype)
    counts = begins[:, None] >= jnp.asarray(start_s, rate.dtype).reshape(1, -1)
    number = jnp.sum(counts, axis=0).astype(rate.dtype)
    mean_square = jnp.sum(jnp.where(counts, rate**2, 0.0), axis=0) / number
    return jnp.sqrt(mean_square) / max_force_n
