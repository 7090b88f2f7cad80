"""Elementary functions: what their errors are, and that sums of ratios are sums of ratios."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from tegotae.parts.maths import sum_of_ratios, tanh_ratio


def test_the_ratio_is_tanh_within_its_stated_error():
    x = np.r_[np.linspace(-12.0, 12.0, 200_001), 1e-20, 1e30, -1e30, np.inf].astype("float32")
    numerator, denominator = tanh_ratio(jnp.asarray(x))
    ratio = np.asarray(numerator / denominator)
    assert np.abs(ratio - np.tanh(x.astype("float64"))).max() < 1.5e-6
    assert np.abs(ratio).max() <= 1.0
    np.testing.assert_array_equal(ratio[:200_001], -ratio[:200_001][::-1])
    assert 0.1 < denominator.min() < denominator.max() < 10.0


def test_what_is_no_number_stays_none():
    numerator, denominator = tanh_ratio(jnp.float32(jnp.nan))
    assert jnp.isnan(numerator / denominator)


@pytest.mark.parametrize("count", [1, 2, 16, 17, 40])
@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
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
