"""Elementary functions: what their errors are, and that sums of ratios are sums of ratios."""

import jax.numpy as jnp
import numpy as np
import pytest

from tegotae.parts.maths import TANH_SCALE, one_plus_exp2, sum_of_ratios


def tanh(x: np.ndarray) -> np.ndarray:
    z = jnp.float32(TANH_SCALE) * jnp.asarray(x, "float32")
    return np.asarray(1.0 - 2.0 / one_plus_exp2(z))


def test_one_plus_a_power_of_two_gives_tanh_within_its_stated_error():
    x = np.r_[np.linspace(-12.0, 12.0, 200_001), 1e-20, 1e30, -1e30, np.inf].astype("float32")
    assert np.abs(tanh(x) - np.tanh(x.astype("float64"))).max() < 1.5e-6
    assert np.abs(tanh(x)).max() <= 1.0


def test_what_is_no_number_stays_none():
    assert np.isnan(tanh(np.float32(np.nan)))


@pytest.mark.parametrize("count", [1, 2, 6, 7, 40])
@pytest.mark.parametrize("size", [1.2, 1e3, 1.5e6])
def test_a_sum_of_ratios_is_exact_up_to_rounding(count, size):
    rng = np.random.default_rng(count)
    over = rng.normal(size=(count, 5)).astype("float32")
    under = (size * rng.uniform(0.9, 1.0, size=(count, 5))).astype("float32")
    got = sum_of_ratios(
        [(jnp.asarray(a), jnp.asarray(b)) for a, b in zip(over, under, strict=True)]
    )
    exact = (over.astype("float64") / under).sum(axis=0)
    scale = np.abs(over.astype("float64") / under).sum(axis=0)
    assert (np.abs(got - exact) / scale).max() < 3e-6
