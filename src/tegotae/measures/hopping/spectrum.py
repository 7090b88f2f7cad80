"""The spectrum of the body's height, and how it sits with the prescribed frequency."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.parts._shapes import AnyArray, Numeric

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
    """Power spectrum of a height [m] sampled every `sample_s` [s]: shape [samples, lanes].

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


def peak(of: Spectrum) -> tuple[jax.Array, jax.Array]:
    """Frequency w_peak [rad/s] of the highest peak, and A_peak.

    The peak is refined by a parabola through the logarithm of three bins. A_peak is the square
    root of the share of the power inside the peak's main lobe: 1 for a pure sinusoid.
    Both have shape [lanes].
    """
    power = of.power
    inner = power[1:-1]
    bin_number = jnp.arange(1, 1 + len(inner), dtype=jnp.int32)[:, None]
    # The first of the highest, as argmax finds it, in two reductions that XLA makes vector code of.
    highest = jnp.where(inner == inner.max(axis=0, keepdims=True), bin_number, len(inner)).min(
        axis=0
    )

    def neighbour(offset: int) -> jax.Array:
        return jnp.take_along_axis(power, highest[None] + offset, axis=0)[0]

    shift = _parabola_shift(neighbour(-1), neighbour(0), neighbour(1))
    w_peak = (highest.astype(power.dtype) + shift) * of.angular_frequency[1]
    distance = jnp.abs(of.angular_frequency[:, None] - w_peak[None])
    in_lobe = distance <= MAIN_LOBE_BINS * of.resolution[None]
    total = jnp.sum(power, axis=0)
    share = jnp.sum(jnp.where(in_lobe, power, 0.0), axis=0) / jnp.where(total > 0.0, total, 1.0)
    return w_peak, jnp.sqrt(share)


def _parabola_shift(left: jax.Array, centre: jax.Array, right: jax.Array) -> jax.Array:
    """Where between -½ and ½ bin a parabola through the logarithm of three powers peaks."""
    left, centre, right = (jnp.log(power + 1e-30) for power in (left, centre, right))
    curvature = left - 2.0 * centre + right
    bends = curvature < 0.0
    shift = 0.5 * (left - right) / jnp.where(bends, curvature, -1.0)
    return jnp.clip(jnp.where(bends, shift, 0.0), -0.5, 0.5)


def delta_omega(omega: Numeric, w_peak: Numeric, a_peak: Numeric) -> Numeric:
    """`ΔΩ = -(ω - w_peak)² - (1 - A_peak)²` (paper equation 13), zero at best.

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
    """ΔΩ of a body at rest, which has no peak: w_peak = 0 and A_peak = 0, so `-ω² - 1`."""
    return delta_omega(omega, 0.0, 0.0)


def delta_w(of: Spectrum, omega: Numeric) -> jax.Array:
    """`Δw = Σ_p |w_p - ω| A_p` over the peaks p with `A_p >= ½ A_max` [rad/s] (paper equation 14).

    Every local maximum of the spectrum |Y| is a peak. The highest has the amplitude A_peak
    (`peak`), and the others in proportion to their height, `A_p = A_peak |Y_p| / |Y_peak|`.

    Args:
        of: the spectrum, [bins, lanes].
        omega: prescribed frequency ω [rad/s], one or [lanes].

    Returns:
        Δw [rad/s], shape [lanes].

    Example:
        >>> time_s = np.arange(2000)[:, None] * 0.02
        >>> height_m = 1.2 + 0.1 * np.sin(4.0 * time_s) + 0.08 * np.sin(7.0 * time_s)
        >>> f"{float(delta_w(spectrum(height_m, 0.02), 5.0)[0]):.1f} rad/s"  # (1 + 2 · 0.8) · 0.78
        '2.0 rad/s'
    """
    power = of.power
    left, centre, right = power[:-2], power[1:-1], power[2:]
    highest = jnp.max(centre, axis=0, keepdims=True)
    relative = jnp.sqrt(centre / jnp.where(highest > 0.0, highest, 1.0))
    is_peak = (centre > left) & (centre >= right) & (relative >= 0.5)
    shift = _parabola_shift(left, centre, right) * of.angular_frequency[1]
    frequency = of.angular_frequency[1:-1, None] + shift
    away = jnp.abs(frequency - jnp.asarray(omega, power.dtype).reshape(1, -1))
    distance = jnp.where(is_peak, away * relative, 0.0)
    return peak(of)[1] * jnp.sum(distance, axis=0)
