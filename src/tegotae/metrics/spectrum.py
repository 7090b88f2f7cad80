"""The spectrum of the body's height, and how it sits with the prescribed frequency."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

REST_RANGE_M = 1e-3
"""A body whose height stays within this range [m] is at rest and has no spectrum."""

_MAIN_LOBE_BINS = 2.0  # half width of the Hann window's main lobe


class Spectrum(NamedTuple):
    """One-sided power spectrum of a windowed signal."""

    angular_frequency: Any
    """Angular frequencies [rad/s], shape [bins]."""
    power: Any
    """|Y|² of the Hann-windowed, mean-free signal, shape [bins, lanes]."""
    resolution: float
    """2π / window length [rad/s]: one bin of the signal without zero padding."""


def spectrum(height_m: Any, sample_s: float) -> Spectrum:
    """Power spectrum of a height [m] sampled every `sample_s` [s]: shape [samples, lanes].

    The mean is removed, a Hann window applied, and the signal padded with zeros to at least four
    times its length, so that the peak can be interpolated.
    """
    height_m = jnp.asarray(height_m)
    samples = height_m.shape[0]
    window = jnp.asarray(np.hanning(samples + 1)[:-1], height_m.dtype)
    window = window.reshape(-1, *[1] * (height_m.ndim - 1))
    signal = window * (height_m - height_m.mean(axis=0))
    padded = 1 << int(np.ceil(np.log2(4 * samples)))
    transform = jnp.fft.rfft(signal, padded, axis=0)
    frequencies = np.arange(padded // 2 + 1) * (2.0 * np.pi / (padded * sample_s))
    return Spectrum(
        jnp.asarray(frequencies, height_m.dtype),
        jnp.real(transform) ** 2 + jnp.imag(transform) ** 2,
        2.0 * np.pi / (samples * sample_s),
    )


def peak(of: Spectrum) -> tuple[Any, Any]:
    """Frequency w_peak [rad/s] of the highest peak, and A_peak.

    The peak is refined by a parabola through the logarithm of three bins. A_peak is the square
    root of the share of the power inside the peak's main lobe: 1 for a pure sinusoid.
    Both have shape [lanes].
    """
    power = of.power
    highest = jnp.argmax(power[1:-1], axis=0) + 1

    def log_power(at: Any) -> Any:
        return jnp.log(jnp.take_along_axis(power, at[None], axis=0)[0] + 1e-30)

    left, centre, right = log_power(highest - 1), log_power(highest), log_power(highest + 1)
    curvature = left - 2.0 * centre + right
    shift = jnp.where(curvature < 0.0, 0.5 * (left - right) / jnp.where(curvature < 0, curvature, -1.0), 0.0)
    step = of.angular_frequency[1]
    w_peak = (highest.astype(power.dtype) + jnp.clip(shift, -0.5, 0.5)) * step
    frequency = of.angular_frequency.reshape(-1, *[1] * (power.ndim - 1))
    in_lobe = jnp.abs(frequency - w_peak) <= _MAIN_LOBE_BINS * of.resolution
    total = jnp.sum(power, axis=0)
    share = jnp.sum(jnp.where(in_lobe, power, 0.0), axis=0) / jnp.where(total > 0.0, total, 1.0)
    return w_peak, jnp.sqrt(share)


def delta_omega(omega: Any, w_peak: Any, a_peak: Any) -> Any:
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


def rest_delta_omega(omega: Any) -> Any:
    """ΔΩ of a body at rest, which has no peak: w_peak = 0 and A_peak = 0, so `-ω² - 1`."""
    return delta_omega(omega, 0.0, 0.0)
