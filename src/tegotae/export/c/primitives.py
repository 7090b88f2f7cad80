"""The one table from operations of a trace to C."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

ATOM, UNARY, PRODUCT, SUM, ORDER, EQUAL, BITS, CHOICE = 9, 8, 7, 6, 5, 4, 3, 1
"""How tightly C binds, from names and calls to `?:`."""


@dataclass(frozen=True)
class Scalar:
    """What an operation on scalars is in C.

    Args:
        text: the C, with {0}, {1} ... for what it acts on.
        binds: how tightly the text binds.
        inside: how tightly each operand must bind to stand without parentheses.
        fold: the same in NumPy, for what is known beforehand; None where that is not worth it.
        needs: a helper of `HELPERS` that the text calls.
        detail: what of the operation's parameters the text depends on.
    """

    text: str
    binds: int = ATOM
    inside: tuple[int, ...] = (0, 0, 0)
    fold: Callable[..., Any] | None = None
    needs: str | None = None
    detail: Callable[[Any], Any] = lambda parameters: None


def _infix(sign: str, binds: int, fold: Any, *, safe: bool = False) -> Scalar:
    """`a sign b`; the right operand binds more tightly, so that sums keep their order."""
    left = binds + 1 if safe else binds
    return Scalar(f"{{0}} {sign} {{1}}", binds, (left, binds + 1), fold)


def _function(name: str, operands: int = 1, needs: str | None = None, fold: Any = None) -> Scalar:
    places = ", ".join(f"{{{i}}}" for i in range(operands))
    return Scalar(f"{name}({places})", needs=needs, fold=fold)


CALLS = frozenset(
    ("jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "remote")
)
"""Operations that call a trace within."""

SCALAR: dict[str, Scalar] = {
    "add": _infix("+", SUM, np.add),
    "sub": _infix("-", SUM, np.subtract),
    "mul": _infix("*", PRODUCT, np.multiply),
    "div": _infix("/", PRODUCT, np.divide),
    "neg": Scalar("-{0}", UNARY, (ATOM,), np.negative),
    "max": _function("larger", 2, "larger", np.maximum),
    "min": _function("smaller", 2, "smaller", np.minimum),
    "clamp": Scalar("smaller(larger({1}, {0}), {2})", needs="smaller larger"),
    "abs": _function("fabsf", fold=np.abs),
    "sign": _function("sign_of", needs="sign_of"),
    "floor": _function("floorf", fold=np.floor),
    "ceil": _function("ceilf", fold=np.ceil),
    "round": _function("rintf", fold=np.rint),
    "sqrt": _function("sqrtf"),
    "rsqrt": Scalar("1.0f / sqrtf({0})", PRODUCT),
    "cbrt": _function("cbrtf"),
    "exp": _function("expf"),
    "exp2": _function("exp2f"),
    "expm1": _function("expm1f"),
    "log": _function("logf"),
    "log1p": _function("log1pf"),
    "logistic": Scalar("1.0f / (1.0f + expf(-{0}))", PRODUCT, (ATOM,)),
    "erf": _function("erff"),
    "sin": _function("sinf"),
    "cos": _function("cosf"),
    "tan": _function("tanf"),
    "asin": _function("asinf"),
    "acos": _function("acosf"),
    "atan": _function("atanf"),
    "sinh": _function("sinhf"),
    "cosh": _function("coshf"),
    "tanh": _function("tanhf"),
    "asinh": _function("asinhf"),
    "acosh": _function("acoshf"),
    "atanh": _function("atanhf"),
    "atan2": _function("atan2f", 2),
    "rem": _function("fmodf", 2),
    "pow": _function("powf", 2),
    "square": Scalar("{0} * {0}", PRODUCT, (ATOM,)),
    "integer_pow": Scalar("integer power", PRODUCT, (ATOM,), detail=lambda p: int(p["y"])),
    "is_finite": _function("is_finite", needs="is_finite"),
    "eq": _infix("==", EQUAL, np.equal, safe=True),
    "ne": _infix("!=", EQUAL, np.not_equal, safe=True),
    "lt": _infix("<", ORDER, np.less, safe=True),
    "le": _infix("<=", ORDER, np.less_equal, safe=True),
    "gt": _infix(">", ORDER, np.greater, safe=True),
    "ge": _infix(">=", ORDER, np.greater_equal, safe=True),
    "and": _infix("&", BITS, np.bitwise_and, safe=True),
    "or": _infix("|", BITS, np.bitwise_or, safe=True),
    "xor": _infix("^", BITS, np.bitwise_xor, safe=True),
    "not": Scalar("!{0}", UNARY, (ATOM,), np.logical_not),
    # The first of the cases is that of false.
    "select_n": Scalar(
        "{0} ? {2} : {1}",
        CHOICE,
        (ORDER, CHOICE + 1, CHOICE + 1),
        lambda c, no, yes: yes if c else no,
    ),
    "convert_element_type": Scalar("conversion", fold=lambda x: x),
    "copy": Scalar("{0}", UNARY, (UNARY,)),
}
"""Operations on floats by their names in a trace; those on whole numbers are of `WHOLE`."""

WHOLE: dict[str, Scalar] = {
    "add": _function("sum_of", 2, "sum_of"),
    "sub": _function("difference_of", 2, "difference_of"),
    "mul": _function("product_of", 2, "product_of"),
    "neg": Scalar("difference_of(0, {0})", needs="difference_of"),
    "max": Scalar("{0} > {1} ? {0} : {1}", CHOICE, (ATOM, ATOM)),
    "min": Scalar("{0} < {1} ? {0} : {1}", CHOICE, (ATOM, ATOM)),
    "not": Scalar("~{0}", UNARY, (ATOM,)),
    **{name: SCALAR[name] for name in ("and", "or", "xor", "select_n", "copy")},
    **{name: SCALAR[name] for name in ("eq", "ne", "lt", "le", "gt", "ge")},
}
"""Operations on int32_t, which wrap around as the traced ones do."""

HELPERS: dict[str, str] = {
    "larger": """\
/* The larger of two; not a number, if one of them is none. */
static float larger(float a, float b)
{
    return ((a > b) || (a != a)) ? a : b;
}
""",
    "smaller": """\
/* The smaller of two; not a number, if one of them is none. */
static float smaller(float a, float b)
{
    return ((a < b) || (a != a)) ? a : b;
}
""",
    "sign_of": """\
/* -1, 0 or 1. */
static float sign_of(float x)
{
    return (x > 0.0f) ? 1.0f : ((x < 0.0f) ? -1.0f : x);
}
""",
    "as_int32": """\
/* A whole number, cut off towards zero; the nearest there is beyond the range, 0 for no number. */
static int32_t as_int32(float x)
{
    int32_t whole = 0;
    if (x >= 2147483648.0f) {
        whole = INT32_MAX;
    } else if (x <= -2147483648.0f) {
        whole = INT32_MIN;
    } else if (x == x) {
        whole = (int32_t)x;
    } else {
        whole = 0;
    }
    return whole;
}
""",
    "sum_of": """\
/* The sum, modulo 2^32. */
static int32_t sum_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}
""",
    "difference_of": """\
/* The difference, modulo 2^32. */
static int32_t difference_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}
""",
    "product_of": """\
/* The product, modulo 2^32. */
static int32_t product_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a * (uint32_t)b);
}
""",
    "is_finite": """\
/* Whether it is a number, and not an infinite one. */
static bool is_finite(float x)
{
    return (x <= FLT_MAX) && (x >= -FLT_MAX);
}
""",
}
"""Small functions in C that texts of the table call."""
