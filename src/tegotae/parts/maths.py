"""Elementary functions that vectorise inside the rollout loop."""

from __future__ import annotations

import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jax import lax

from lanewise.nodes import stays_a_call

TWO_PI = 6.283185307179586

# Cody-Waite split of pi/2: n * _HALF_PI_HIGH is exact in float32 for |n| < 2^13.
_HALF_PI_HIGH = 1.5703125
_HALF_PI_LOW = 4.83826794896e-4


@stays_a_call
def sin_cos(angle: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Sine and cosine of an angle [rad], any shape.

    In float32 this is a Cody-Waite reduction to [-pi/4, pi/4] and a Taylor polynomial there
    (error below 2e-7 for |angle| < 1e4): XLA's own sine is a scalar library call on CPUs, which
    stops the whole rollout loop from vectorising. In float64 accuracy comes first.

    Example:
        >>> import jax.numpy as jnp
        >>> s, c = sin_cos(jnp.float32(0.5))
        >>> f"{s:.6f} {c:.6f}"
        '0.479426 0.877583'
    """
    if angle.dtype != jnp.float32:
        return jnp.sin(angle), jnp.cos(angle)
    quadrant = jnp.round(angle * (4.0 / TWO_PI))
    r = (angle - quadrant * _HALF_PI_HIGH) - quadrant * _HALF_PI_LOW
    r2 = r * r
    sine = r + r * r2 * (-1 / 6 + r2 * (1 / 120 + r2 * (-1 / 5040 + r2 * (1 / 362880))))
    cosine = 1.0 + r2 * (-1 / 2 + r2 * (1 / 24 + r2 * (-1 / 720 + r2 * (1 / 40320))))
    n = _last_bits(quadrant)
    swap = (n & 1) == 1
    sin_sign = jnp.where((n & 2) == 0, 1.0, -1.0).astype(angle.dtype)
    cos_sign = jnp.where(((n + 1) & 2) == 0, 1.0, -1.0).astype(angle.dtype)
    return sin_sign * jnp.where(swap, cosine, sine), cos_sign * jnp.where(swap, sine, cosine)


@stays_a_call
def wrap_phase(phase: jax.Array) -> jax.Array:
    """The phase [rad] modulo 2 pi, in [0, 2 pi)."""
    wrapped = phase - TWO_PI * jnp.floor(phase * (1.0 / TWO_PI))
    # Rounding can land on 2 pi itself; the interval is half open.
    return jnp.where(wrapped >= TWO_PI, 0.0, jnp.maximum(wrapped, 0.0)).astype(phase.dtype)


TANH_SCALE = 2.0 / math.log(2.0)
"""Factor z/x for which 1 - tanh x = 2 / (1 + 2ᶻ)."""
RATIOS_PER_DIVISION = 6
_TANH_END = 20.5
"""|z| beyond which tanh is constant: what is left to 1 is of the size of the error allowed."""
# 2ᶠ for f in [-½, ½], of least largest relative error, 2.6e-6.
_POWER_OF_TWO = (0.9999992614, 0.6931218146, 0.2402474483, 0.05591786111, 0.009570102712)


@stays_a_call
def one_plus_exp2(z: jax.Array) -> jax.Array:
    """1 + 2ᶻ in float32, of z kept within ±20.5.

    tanh x = 1 - 2 / (1 + 2ᶻ) with z = `TANH_SCALE` x is off by less than 1.5e-6. It is for sums
    over a common denominator (`sum_of_ratios`): XLA's own tanh costs a division each.

    Example:
        >>> import jax.numpy as jnp
        >>> f"{1.0 - 2.0 / one_plus_exp2(jnp.float32(TANH_SCALE * 0.5)):.5f}"
        '0.46212'
    """
    z = jnp.clip(z, -_TANH_END, _TANH_END)
    integer = jnp.round(z)
    fraction = z - integer
    power = jnp.full_like(z, _POWER_OF_TWO[-1])
    for coefficient in reversed(_POWER_OF_TWO[:-1]):
        power = power * fraction + coefficient
    # 2ⁿ by its bits; it is constant where the derivative is asked for, which `rest` has.
    scale = lax.bitcast_convert_type(_last_bits(integer, 127) << 23, jnp.float32)
    return 1.0 + power * scale


def _last_bits(integer: jax.Array, offset: int = 0) -> jax.Array:
    """The last bits of a whole number, and of some more: a float so large has no others."""
    return lax.bitcast_convert_type(integer + (1.5 * 2**23 + offset), jnp.int32)


@stays_a_call
def add_ratio(
    over: jax.Array, under: jax.Array, numerator: jax.Array, denominator: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Numerator and denominator of the sum of two ratios, without a division.

    Args:
        over: numerator of the one.
        under: its denominator.
        numerator: that of the other.
        denominator: its denominator.

    Example:
        >>> tuple(map(float, add_ratio(*map(jnp.float32, (1.0, 2.0, 1.0, 4.0)))))
        (6.0, 8.0)
    """
    return over * denominator + numerator * under, under * denominator


def sum_of_ratios(ratios: Sequence[tuple[jax.Array, jax.Array]]) -> jax.Array:
    """Sum of numerators over denominators, by one division for up to six.

    Denominators must lie between 1 and 1.5e6, for the product of six to be a float32.

    Example:
        >>> import jax.numpy as jnp
        >>> one, two, four = jnp.float32(1.0), jnp.float32(2.0), jnp.float32(4.0)
        >>> float(sum_of_ratios([(one, two), (one, four)]))
        0.75
    """
    total = jnp.zeros_like(ratios[0][0])
    for first in range(0, len(ratios), RATIOS_PER_DIVISION):
        (over, under), *tail = ratios[first : first + RATIOS_PER_DIVISION]
        for numerator, denominator in tail:
            over, under = add_ratio(over, under, numerator, denominator)
        total = total + over / under
    return total
