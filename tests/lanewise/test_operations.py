"""Operations and elementary functions as native code, against NumPy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from lanewise.functions import _FUNCTIONS
from lanewise.operations import OPERATIONS
from lowered import evaluated, samples

DTYPES = ("float32", "float64")
BASIC = {
    "add": (jnp.add, np.add),
    "sub": (jnp.subtract, np.subtract),
    "mul": (jnp.multiply, np.multiply),
    "div": (jnp.divide, np.divide),
    "max": (jnp.maximum, np.maximum),
    "min": (jnp.minimum, np.minimum),
    "eq": (jnp.equal, np.equal),
    "ne": (jnp.not_equal, np.not_equal),
    "lt": (jnp.less, np.less),
    "le": (jnp.less_equal, np.less_equal),
    "gt": (jnp.greater, np.greater),
    "ge": (jnp.greater_equal, np.greater_equal),
    "neg": (lambda x, y: -x, lambda x, y: -x),
    "abs": (lambda x, y: jnp.abs(x), lambda x, y: np.abs(x)),
    "floor": (lambda x, y: jnp.floor(x), lambda x, y: np.floor(x)),
    "ceil": (lambda x, y: jnp.ceil(x), lambda x, y: np.ceil(x)),
    "round": (lambda x, y: jnp.round(x), lambda x, y: np.rint(x)),
    "sqrt": (lambda x, y: jnp.sqrt(x), lambda x, y: np.sqrt(x)),
    "sign": (lambda x, y: jnp.sign(x), lambda x, y: np.sign(x)),
    "square": (lambda x, y: x * x, lambda x, y: x * x),
    "is_finite": (lambda x, y: jnp.isfinite(x), lambda x, y: np.isfinite(x)),
    "and": (lambda x, y: (x > 0) & (y > 0), lambda x, y: (x > 0) & (y > 0)),
    "or": (lambda x, y: (x > 0) | (y > 0), lambda x, y: (x > 0) | (y > 0)),
    "xor": (lambda x, y: (x > 0) ^ (y > 0), lambda x, y: (x > 0) ^ (y > 0)),
    "not": (lambda x, y: ~(x > 0), lambda x, y: ~(x > 0)),
    "select_n": (lambda x, y: jnp.where(x > y, x, y), lambda x, y: np.where(x > y, x, y)),
    "clamp": (lambda x, y: jnp.clip(x, -1.0, 2.0), lambda x, y: np.clip(x, -1.0, 2.0)),
}
"""Operations that are exact, in JAX and in NumPy."""


def pairs(dtype):
    x = samples(dtype)
    rng = np.random.default_rng(2)
    return np.concatenate([x, x, x]), np.concatenate([x, rng.permutation(x), rng.permutation(x)])


@pytest.mark.parametrize("dtype", DTYPES)
def test_basic_operations_are_those_of_numpy_to_the_bit(dtype):
    x, y = pairs(dtype)
    result = evaluated(lambda x, y: {k: f(x, y) for k, (f, _) in BASIC.items()}, x, y, dtype=dtype)
    with np.errstate(all="ignore"):
        for name, (_, function) in BASIC.items():
            expected = function(x, y)
            np.testing.assert_array_equal(result[name], expected, name)
            if name not in ("max", "min", "clamp", "sign"):  # of two zeros, either
                defined = ~np.isnan(expected) if expected.dtype.kind == "f" else slice(None)
                assert (np.signbit(result[name][defined]) == np.signbit(expected[defined])).all(), (
                    name
                )


WHOLE = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "neg": lambda a, b: -a,
    "abs": lambda a, b: abs(a),
    "max": lambda a, b: (jnp if isinstance(a, jax.Array) else np).maximum(a, b),
    "and": lambda a, b: a & b,
    "or": lambda a, b: a | b,
    "xor": lambda a, b: a ^ b,
    "not": lambda a, b: ~a,
    "left": lambda a, b: a << 3,
    "right": lambda a, b: a >> 2,
    "lt": lambda a, b: a < b,
    "ge": lambda a, b: a >= b,
}


def test_whole_numbers_wrap_around_as_those_of_numpy():
    rng = np.random.default_rng(0)
    a, b = (rng.integers(-(2**31), 2**31, 300).astype("int32") for _ in range(2))
    a[:3], b[:3] = (-(2**31), 2**31 - 1, 7), (-1, -1, 0)
    result = evaluated(lambda a, b: {k: f(a, b) for k, f in WHOLE.items()}, a, b)
    with np.errstate(all="ignore"):
        for name, function in WHOLE.items():
            np.testing.assert_array_equal(result[name], function(a, b), name)
    ratio = evaluated(jax.lax.div, a, b)
    np.testing.assert_array_equal(ratio, np.asarray(jax.lax.div(jnp.asarray(a), jnp.asarray(b))))
    remainder = evaluated(jax.lax.rem, a, b)
    np.testing.assert_array_equal(
        remainder, np.asarray(jax.lax.rem(jnp.asarray(a), jnp.asarray(b)))
    )


SHIFTS = {
    "left": jax.lax.shift_left,
    "logical": jax.lax.shift_right_logical,
    "arithmetic": jax.lax.shift_right_arithmetic,
}


@pytest.mark.parametrize("by", [None, 31, 32, 33, -1])
def test_a_shift_by_more_bits_than_there_are_is_that_of_xla(by):
    a = np.tile(np.array([-(2**31), -7, -1, 0, 1, 7, 2**31 - 1], "int32"), 9)
    b = np.repeat(np.array([0, 1, 30, 31, 32, 33, 64, -1, -(2**31)], "int32"), 7)

    def shifted(a, b):
        amount = b if by is None else jnp.full_like(b, by)
        return {name: shift(a, amount) for name, shift in SHIFTS.items()}

    result, expected = evaluated(shifted, a, b), shifted(jnp.asarray(a), jnp.asarray(b))
    for name in SHIFTS:
        np.testing.assert_array_equal(result[name], np.asarray(expected[name]), name)


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_float_becomes_whole_as_in_a_trace_whatever_it_is(dtype):
    x = samples(dtype)
    with jax.enable_x64(dtype == "float64"):
        expected = np.asarray(jnp.asarray(x).astype("int32"))
    result = evaluated(lambda x: x.astype("int32"), x, dtype=dtype)
    np.testing.assert_array_equal(result, expected)


UNARY = {
    "exp": (-110.0, 90.0),
    "exp2": (-150.0, 128.0),
    "expm1": (-40.0, 90.0),
    "log": (0.0, 1e30),
    "log1p": (-1.0, 1e30),
    "tanh": (-30.0, 30.0),
    "sinh": (-80.0, 80.0),
    "cosh": (-80.0, 80.0),
    "arcsinh": (-1e20, 1e20),
    "arccosh": (1.0, 1e20),
    "arctanh": (-1.0, 1.0),
    "sin": (-1e4, 1e4),
    "cos": (-1e4, 1e4),
    "tan": (-1e3, 1e3),
    "arcsin": (-1.0, 1.0),
    "arccos": (-1.0, 1.0),
    "arctan": (-1e6, 1e6),
    "cbrt": (-1e20, 1e20),
}
"""Elementary functions by NumPy's names, and where they are compared."""


@pytest.mark.parametrize("dtype", DTYPES)
def test_elementary_functions_are_right_within_a_few_units_in_the_last_place(dtype):
    rng = np.random.default_rng(0)
    scale = np.concatenate([np.geomspace(1e-8, 1, 200), rng.uniform(0, 1, 300)])
    exact = np.longdouble if dtype == "float64" else np.float64
    arguments = {
        name: np.concatenate([low * scale, high * scale, [low, high]]).astype(dtype)
        for name, (low, high) in UNARY.items()
    }
    for name in ("log", "arccosh"):
        arguments[name] = np.abs(arguments[name]) + (1 if name == "arccosh" else 0)

    def all_of_them(*columns):
        pairs = zip(UNARY, columns, strict=True)
        return {name: getattr(jnp, name)(column) for name, column in pairs}

    result = evaluated(all_of_them, *arguments.values(), dtype=dtype)
    with np.errstate(all="ignore"):
        for name, x in arguments.items():
            expected = getattr(np, name)(x.astype(exact))
            unit = np.spacing(np.abs(expected.astype(dtype)))
            finite = np.isfinite(expected.astype(dtype))
            units = np.abs(result[name].astype(exact) - expected)[finite] / unit[finite]
            tolerance = {"tan": 6, "arccosh": 6, "sinh": 5, "cosh": 5, "tanh": 6}.get(name, 4)
            worst = np.argmax(units)
            assert units[worst] <= tolerance, (name, x[finite][worst], units[worst])


@pytest.mark.parametrize("dtype", DTYPES)
def test_elementary_functions_end_where_those_of_numpy_do(dtype):
    x = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 1.0, -1.0, 2.0], dtype)
    result = evaluated(lambda x: {k: getattr(jnp, k)(x) for k in UNARY}, x, dtype=dtype)
    with np.errstate(all="ignore"):
        for name in UNARY:
            expected = getattr(np, name)(x)
            np.testing.assert_array_equal(np.isnan(result[name]), np.isnan(expected), name)
            np.testing.assert_allclose(result[name], expected, 1e-6, 1e-7, err_msg=name)


@pytest.mark.parametrize("dtype", DTYPES)
def test_functions_of_two_numbers_are_those_of_numpy(dtype):
    rng = np.random.default_rng(0)
    special = np.array([0.0, -0.0, 1.0, -1.0, 2.0, -3.0, 0.5, np.inf, -np.inf, np.nan])
    a, b = (grid.ravel() for grid in np.meshgrid(special, special))
    x = np.concatenate([a, np.abs(rng.normal(size=300))]).astype(dtype)
    y = np.concatenate([b, 3.0 * rng.normal(size=300)]).astype(dtype)

    def function(x, y):
        return {"atan2": jnp.arctan2(y, x), "pow": x**y, "rem": jnp.fmod(y, x)}

    result = evaluated(function, x, y, dtype=dtype)
    with np.errstate(all="ignore"):
        wide = (x.astype("float64"), y.astype("float64"))
        expected = {
            "atan2": np.arctan2(wide[1], wide[0]),
            "pow": np.power(*wide),
            "rem": np.fmod(wide[1], wide[0]),
        }
    tolerance = 4 * np.finfo(dtype).eps
    for name, values in expected.items():
        np.testing.assert_allclose(
            result[name], values.astype(dtype), tolerance, 1e-37, err_msg=name
        )


def test_powers_by_whole_numbers_are_products():
    x = samples("float32")
    result = evaluated(lambda x: [x**3, x**-2, x**0], x)
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(result[0], x * (x * x))
        np.testing.assert_array_equal(result[1], np.float32(1.0) / (x * x))
    assert (result[2] == 1.0).all()


def test_every_operation_of_the_table_is_native_code_or_made_of_what_is():
    missing = {
        name
        for name, operation in OPERATIONS.items()
        if operation.llvm is None and name not in _FUNCTIONS
    }
    assert missing == {"erf", "copy"}  # copies are moves


STEPS = {
    "add": lambda np_, a, b: a + b,
    "sub": lambda np_, a, b: a - b,
    "product": lambda np_, a, b: np_.maximum(a * b, b),  # no sum: it would take it along
    "div": lambda np_, a, b: a / b,
    "min": lambda np_, a, b: np_.minimum(a, b),
    "root": lambda np_, a, b: np_.sqrt(np_.abs(a)),
    "guarded": lambda np_, a, b: a / np_.where(b > 1.0, b, np_.asarray(1.0, a.dtype)),
    "choice": lambda np_, a, b: np_.where(a < b, np_.floor(a), b),
    "none": lambda np_, a, b: np_.where(np_.isnan(a), b, -a),
}


@settings(max_examples=12, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(STEPS)), st.integers(0, 99), st.integers(0, 99)),
        min_size=3,
        max_size=25,
    )
)
def test_any_graph_gives_what_numpy_gives_for_numbers_of_all_sorts(steps):
    def function(np_, x, y):
        nodes = [x, y, np_.asarray(0.75, x.dtype) + 0 * x]
        for name, a, b in steps:
            nodes.append(STEPS[name](np_, nodes[a % len(nodes)], nodes[b % len(nodes)]))
        return nodes[-3:]

    x, y = pairs("float32")
    result = evaluated(lambda x, y: function(jnp, x, y), x, y)
    with np.errstate(all="ignore"):
        expected = function(np, x, y)
    for got, expected_value in zip(result, expected, strict=True):
        np.testing.assert_array_equal(got, expected_value)
