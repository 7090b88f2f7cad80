"""Elementary functions out of basic operations, so that their bits depend on no maths library.

Each is written once, in JAX, for float32 and float64, and becomes part of a graph where a trace
calls the function. Series are Taylor's, as long as the number's digits need; reductions are those
of Cody and Waite. Results are within a few units in the last place (`tests/lanewise`); sine and
cosine lose digits beyond 10⁶ (float32) and 10⁹ (float64).

Reference: W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from lanewise.nodes import Traced


class _Format(NamedTuple):
    """Layout of a float type, and the lengths of its series."""

    whole: type[np.signedinteger]
    """The type of whole numbers with as many bits."""
    fraction: int
    """Bits of the fraction."""
    bias: int
    exp_range: tuple[float, float]
    """Beyond it the exponential is zero or infinite."""
    exp_terms: int
    log_terms: int
    angle_terms: int
    atan_terms: int
    ln2: tuple[float, float]
    """ln 2 in two parts, of which the first has few digits."""
    half_pi: tuple[float, float, float]
    """π/2 in three parts, of which the first two have few digits."""


_FORMATS = {
    "float32": _Format(
        *(np.int32, 23, 127, (-104.0, 89.0)),
        *(8, 5, 5, 10),
        (0.693359375, -2.12194440054690583e-4),
        (1.5703125, 4.837512969970703125e-4, 7.54978995489188e-8),
    ),
    "float64": _Format(
        *(np.int64, 52, 1023, (-746.0, 710.0)),
        *(14, 12, 9, 22),
        (6.93147180369123816490e-01, 1.90821492927058770002e-10),
        (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21),
    ),
}
_TAN_EIGHTH = math.tan(math.pi / 8)


def _format(x: jax.Array) -> _Format:
    return _FORMATS[x.dtype.name]


def _polynomial(coefficients: Sequence[float], x: jax.Array) -> jax.Array:
    """Σ cₙ xⁿ, by Horner's rule."""
    value = jnp.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        value = value * x + coefficient
    return value


def _bits(x: jax.Array) -> jax.Array:
    return lax.bitcast_convert_type(x, _format(x).whole)


def _power_of_two(n: jax.Array, like: jax.Array) -> jax.Array:
    """2ⁿ of a normal number."""
    f = _format(like)
    return lax.bitcast_convert_type((n + f.bias) << f.fraction, like.dtype)


def _scaled(x: jax.Array, n: jax.Array) -> jax.Array:
    """x 2ⁿ, in two steps, since 2ⁿ alone may be no normal number."""
    half = n >> 1
    return x * _power_of_two(half, x) * _power_of_two(n - half, x)


def _nearest(x: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The nearest whole number of a moderate one, as a float and as a whole number."""
    shift = jnp.full_like(x, 1.5 * 2.0 ** _format(x).fraction)
    shifted = x + shift
    return shifted - shift, _bits(shifted) - _bits(shift)


def _signed(magnitude: jax.Array, x: jax.Array) -> jax.Array:
    """A positive number with the sign of x."""
    lowest = np.iinfo(_format(x).whole).min
    return lax.bitcast_convert_type(_bits(magnitude) | (_bits(x) & lowest), x.dtype)


def _exp_reduced(x: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """n, r and exp(r) - 1, with x = n ln 2 + r."""
    f = _format(x)
    n, integer = _nearest(x * math.log2(math.e))
    r = (x - n * f.ln2[0]) - n * f.ln2[1]
    return integer, r, _exp_less_one(r)


def _exp_less_one(r: jax.Array) -> jax.Array:
    terms = [1.0 / math.factorial(n) for n in range(2, _format(r).exp_terms)]
    return r + r * r * _polynomial(terms, r)


def exp(x: jax.Array) -> jax.Array:
    """e to the power of x."""
    integer, _, less_one = _exp_reduced(_within(x, *_format(x).exp_range))
    return _scaled(1.0 + less_one, integer)


def exp2(x: jax.Array) -> jax.Array:
    """Two to the power of x."""
    f = _format(x)
    x = _within(x, -f.bias - f.fraction - 2.0, f.bias + 2.0)
    n, integer = _nearest(x)
    return _scaled(1.0 + _exp_less_one((x - n) * math.log(2.0)), integer)


def expm1(x: jax.Array) -> jax.Array:
    """e to the power of x, less one."""
    integer, _, less_one = _exp_reduced(_within(x, -40.0, _format(x).exp_range[1]))
    half = _power_of_two(integer - 1, x)
    result = 2.0 * (less_one * half + (half - 0.5))
    return jnp.where(x == 0.0, x, jnp.where(integer == 0, less_one, result))


def _log_parts(x: jax.Array) -> tuple[jax.Array, jax.Array]:
    """k and f with x = 2ᵏ (1 + f), f near zero; of a positive number."""
    fmt = _format(x)
    tiny = x < 2.0 ** (1 - fmt.bias)
    bits = _bits(jnp.where(tiny, x * 2.0 ** (fmt.fraction + 2), x))
    root = int(np.asarray(math.sqrt(0.5), x.dtype).view(fmt.whole))
    bits_of_one = fmt.bias << fmt.fraction
    bits = bits + (bits_of_one - root)
    exponent = (bits >> fmt.fraction) - fmt.bias
    mantissa = lax.bitcast_convert_type((bits & ((1 << fmt.fraction) - 1)) + root, x.dtype)
    exponent = exponent - jnp.where(tiny, fmt.whole(fmt.fraction + 2), fmt.whole(0))
    return exponent.astype(x.dtype), mantissa - 1.0


def _log_tail(s: jax.Array) -> jax.Array:
    """log((1 + s) / (1 - s)) / s - 2."""
    z = s * s
    return z * _polynomial([2.0 / (2 * n + 3) for n in range(_format(s).log_terms)], z)


def log(x: jax.Array) -> jax.Array:
    """The natural logarithm."""
    high, low = _format(x).ln2
    k, f = _log_parts(x)
    s = f / (2.0 + f)
    half = 0.5 * f * f
    value = k * high - ((half - (s * (half + _log_tail(s)) + k * low)) - f)
    value = jnp.where(x == jnp.inf, x, jnp.where(x == 0.0, -jnp.inf, value))
    return jnp.where(x >= 0.0, value, jnp.nan)


def log1p(x: jax.Array) -> jax.Array:
    """The natural logarithm of one more than x."""
    u = 1.0 + x
    correction = jnp.where(x > 1.0, 1.0 - (u - x), x - (u - 1.0)) / u
    value = log(u)
    value = jnp.where((u > 0.0) & (u < jnp.inf), value + correction, value)
    return jnp.where(x == 0.0, x, value)


def tanh(x: jax.Array) -> jax.Array:
    """The hyperbolic tangent."""
    raised = expm1(2.0 * _within(x, -20.0, 20.0))
    return raised / (raised + 2.0)


def logistic(x: jax.Array) -> jax.Array:
    """1 / (1 + e⁻ˣ)."""
    return 1.0 / (1.0 + exp(-x))


def sinh(x: jax.Array) -> jax.Array:
    """The hyperbolic sine."""
    size = jnp.abs(x)
    raised = expm1(lax.min(size, jnp.full_like(x, 30.0)))
    half = exp(0.5 * size)
    large = (0.5 * half) * half
    return _signed(jnp.where(size > 30.0, large, 0.5 * (raised + raised / (raised + 1.0))), x)


def cosh(x: jax.Array) -> jax.Array:
    """The hyperbolic cosine."""
    half = exp(0.5 * jnp.abs(x))
    return (0.5 * half) * half + 0.5 / (half * half)


def asinh(x: jax.Array) -> jax.Array:
    """The inverse of the hyperbolic sine."""
    size = jnp.abs(x)
    limit = jnp.full_like(x, 2.0**28)
    small = lax.min(size, limit)
    value = log1p(small + small * small / (1.0 + jnp.sqrt(small * small + 1.0)))
    return _signed(jnp.where(size > limit, log(size) + math.log(2.0), value), x)


def acosh(x: jax.Array) -> jax.Array:
    """The inverse of the hyperbolic cosine."""
    over = lax.min(x, jnp.full_like(x, 2.0**28)) - 1.0
    value = log1p(over + jnp.sqrt(2.0 * over + over * over))
    return jnp.where(x > 2.0**28, log(x) + math.log(2.0), value)


def atanh(x: jax.Array) -> jax.Array:
    """The inverse of the hyperbolic tangent."""
    size = jnp.abs(x)
    return _signed(0.5 * log1p(2.0 * size / (1.0 - size)), x)


def _sin_cos(x: jax.Array) -> tuple[jax.Array, jax.Array]:
    f = _format(x)
    n, quadrant = _nearest(x * (2.0 / math.pi))
    r = ((x - n * f.half_pi[0]) - n * f.half_pi[1]) - n * f.half_pi[2]
    r = _within(r, -0.8, 0.8)  # beyond is only what has lost all digits
    z = r * r
    signs = [(-1.0) ** n for n in range(f.angle_terms + 1)]
    of_sine = [signs[n] / math.factorial(2 * n + 1) for n in range(1, f.angle_terms)]
    of_cosine = [signs[n] / math.factorial(2 * n) for n in range(1, f.angle_terms + 1)]
    sine = r + r * z * _polynomial(of_sine, z)
    cosine = 1.0 + z * _polynomial(of_cosine, z)
    swap = (quadrant & 1) == 1
    first, second = jnp.where(swap, cosine, sine), jnp.where(swap, sine, cosine)
    return (
        jnp.where((quadrant & 2) == 0, first, -first),
        jnp.where(((quadrant + 1) & 2) == 0, second, -second),
    )


def sin(x: jax.Array) -> jax.Array:
    """The sine of an angle [rad]."""
    return jnp.where(x == 0.0, x, _sin_cos(x)[0])


def cos(x: jax.Array) -> jax.Array:
    """The cosine of an angle [rad]."""
    return _sin_cos(x)[1]


def tan(x: jax.Array) -> jax.Array:
    """The tangent of an angle [rad]."""
    sine, cosine = _sin_cos(x)
    return jnp.where(x == 0.0, x, sine / cosine)


def atan2(y: jax.Array, x: jax.Array) -> jax.Array:
    """The angle [rad] of the point (x, y)."""
    width, height = jnp.abs(x), jnp.abs(y)
    smaller, larger = lax.min(width, height), lax.max(width, height)
    diagonal = smaller == larger
    far = (smaller > _TAN_EIGHTH * larger) | (diagonal & (larger > 0.0))
    ratio = jnp.where(far, smaller - larger, smaller) / jnp.where(far, smaller + larger, larger)
    t = jnp.where(diagonal, 0.0, ratio)
    z = t * t
    terms = [(-1.0) ** n / (2 * n + 1) for n in range(1, _format(x).atan_terms)]
    angle = jnp.where(far, math.pi / 4, 0.0) + (t + t * z * _polynomial(terms, z))
    angle = jnp.where(height > width, math.pi / 2 - angle, angle)
    angle = jnp.where(_bits(x) < 0, math.pi - angle, angle)
    none = jnp.isnan(x) | jnp.isnan(y)
    return jnp.where(none, jnp.nan, _signed(angle.astype(x.dtype), y))


def atan(x: jax.Array) -> jax.Array:
    """The angle [rad] of a tangent."""
    return atan2(x, jnp.ones_like(x))


def asin(x: jax.Array) -> jax.Array:
    """The angle [rad] of a sine."""
    return atan2(x, jnp.sqrt((1.0 - x) * (1.0 + x)))


def acos(x: jax.Array) -> jax.Array:
    """The angle [rad] of a cosine."""
    return atan2(jnp.sqrt((1.0 - x) * (1.0 + x)), x)


def cbrt(x: jax.Array) -> jax.Array:
    """The cubic root."""
    size = jnp.abs(x)
    root = exp(log(size) * (1.0 / 3.0))
    better = root - (root - size / (root * root)) * (1.0 / 3.0)
    plain = (size > 0.0) & (size < jnp.inf)
    return _signed(jnp.where(plain, better, root), x)


def _log_in_two(x: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The logarithm of a positive, finite number as a sum of two, of which the second is small."""
    high, low = _format(x).ln2
    k, f = _log_parts(x)
    under = 2.0 + f
    s = f / under
    s_low = ((f - s * under) - s * (f - (under - 2.0))) / under
    a, b = k * high, 2.0 * s
    total = a + b
    back = total - a
    remainder = (a - (total - back)) + (b - back)
    return total, remainder + (k * low + (2.0 * s_low + s * _log_tail(s)))


def _power(x: jax.Array, y: jax.Array) -> jax.Array:
    """x to the power of y, both positive... as exp(y log x), its argument in two parts."""
    first, second = _log_in_two(x)
    # Of products of halves with few digits nothing is lost.
    y_high, log_high = _high(y), _high(first)
    large = y_high * log_high
    small = y_high * (first - log_high) + ((y - y_high) * first + y * second)
    lowest, highest = _format(x).exp_range
    bounded = _within(large + small, lowest, highest)
    beyond = bounded != large + small
    large, small = jnp.where(beyond, bounded, large), jnp.where(beyond, 0.0, small)
    high, low = _format(x).ln2
    n, integer = _nearest(large * math.log2(math.e))
    r = (large - n * high) + (small - n * low)
    return _scaled(1.0 + _exp_less_one(r), integer)


def _high(x: jax.Array) -> jax.Array:
    """x with half of its digits."""
    cut = (1 << (_format(x).fraction // 2 + 1)) - 1
    return lax.bitcast_convert_type(_bits(x) & ~cut, x.dtype)


def power(x: jax.Array, y: jax.Array) -> jax.Array:
    """x to the power of y."""
    if not jnp.issubdtype(y.dtype, jnp.floating):
        y = y.astype(x.dtype)
    if x.dtype == jnp.float32:
        return power(x.astype(jnp.float64), y.astype(jnp.float64)).astype(jnp.float32)
    size = jnp.abs(x)
    plain = (size > 0.0) & (size < jnp.inf) & (jnp.abs(y) < jnp.inf)
    ones = jnp.ones_like(x)
    regular = _power(jnp.where(plain, size, ones), jnp.where(plain, y, ones))
    limit = exp(y * log(size))
    value = jnp.where(plain, regular, limit)
    is_integer = jnp.floor(y) == y
    odd = is_integer & (jnp.floor(0.5 * y) * 2.0 != y) & (jnp.abs(y) < jnp.inf)
    value = jnp.where(odd & (_bits(x) < 0), -value, value)
    value = jnp.where((x < 0.0) & (x > -jnp.inf) & ~is_integer, jnp.nan, value)
    one_always = (y == 0.0) | (x == 1.0) | ((x == -1.0) & (jnp.abs(y) == jnp.inf))
    return jnp.where(one_always, 1.0, value)


def integer_power(x: jax.Array, y: int) -> jax.Array:
    """x to the power of a known whole number, by repeated squaring."""
    value, square, remaining = None, x, abs(y)
    while remaining:
        if remaining & 1:
            value = square if value is None else value * square
        remaining >>= 1
        square = square * square if remaining else square
    if value is None:
        return jnp.ones_like(x)
    return value if y > 0 else 1.0 / value


def remainder(x: jax.Array, y: jax.Array) -> jax.Array:
    """Return the remainder of a division, with the sign of x; exact for quotients that the type
    counts."""
    if not jnp.issubdtype(x.dtype, jnp.floating):
        difference = x - lax.div(x, y) * y
        return jnp.where(y == 0, x, difference)
    quotient = x / y
    cut = _signed(jnp.floor(jnp.abs(quotient)), quotient)
    difference = x - cut * y
    size, step = _signed_as(difference, x), jnp.abs(y)
    size = jnp.where(size < 0.0, size + step, jnp.where(size >= step, size - step, size))
    finite = jnp.abs(x) < jnp.inf
    return jnp.where((step == jnp.inf) & finite, x, _signed(jnp.abs(size), x) + (x - x))


def _signed_as(value: jax.Array, x: jax.Array) -> jax.Array:
    """The value in the direction of x."""
    return jnp.where(x < 0.0, -value, value)


def rounded_away(x: jax.Array) -> jax.Array:
    """The nearest whole number; of two, the larger one in magnitude."""
    size = jnp.abs(x)
    below = jnp.floor(size)
    return _signed(below + jnp.where(size - below >= 0.5, 1.0, 0.0).astype(x.dtype), x)


def sign(x: jax.Array) -> jax.Array:
    """-1, 0 or 1."""
    ones = jnp.ones_like(x)
    return jnp.where(x > 0, ones, jnp.where(x < 0, -ones, x))


def _within(x: jax.Array, low: float, high: float) -> jax.Array:
    """x, or the bound that it is beyond; not a number stays none."""
    return lax.min(lax.max(x, jnp.full_like(x, low)), jnp.full_like(x, high))


_NAMED = (
    *(exp, exp2, expm1, log, log1p, tanh, logistic, sinh, cosh, asinh, acosh, atanh),
    *(sin, cos, tan, atan2, atan, asin, acos, cbrt, sign),
)
_FUNCTIONS: dict[str, Callable[..., jax.Array]] = {
    **{function.__name__: function for function in _NAMED},
    "pow": power,
    "integer_pow": integer_power,
    "rem": remainder,
    "round": rounded_away,
    "rsqrt": lambda x: 1.0 / jnp.sqrt(x),
    "square": lambda x: x * x,
    "clamp": lambda low, x, high: lax.min(lax.max(x, low), high),
    "is_finite": lambda x: jnp.abs(x) < jnp.inf,
}
"""Functions by the operation of a trace."""


def function(equation: Traced) -> Traced | None:
    """The trace of the function that an operation is, for one entry; None if it is a basic one."""
    name, parameters = equation.primitive.name, equation.params
    if name not in _FUNCTIONS:
        return None
    if name == "round" and parameters["rounding_method"] == lax.RoundingMethod.TO_NEAREST_EVEN:
        return None
    details = {"y": int(parameters["y"])} if name == "integer_pow" else {}
    dtypes = tuple(str(atom.aval.dtype) for atom in equation.invars)
    return _trace(name, dtypes, tuple(details.items()))


@functools.cache
def _trace(name: str, dtypes: tuple[str, ...], details: tuple[tuple[str, int], ...]) -> Traced:
    function = functools.partial(_FUNCTIONS[name], **dict(details))
    with jax.enable_x64(True):
        return jax.make_jaxpr(function)(*(jax.ShapeDtypeStruct((), dtype) for dtype in dtypes))
