"""The phase oscillator, its clamped form, and the elementary functions that carry a phase."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from refusals import refused
from tegotae.parts.maths import TWO_PI, sin_cos, wrap_phase
from tegotae.parts.oscillators import Clamped, PhaseOscillator, PhaseState, WaryOscillator

PHASES = np.linspace(-1e4, 1e4, 400_001)


def test_the_phase_rate_is_omega_plus_feedback_which_may_stop_and_reverse_it():
    oscillator = PhaseOscillator()
    omega, feedback = jnp.full(4, 5.0), jnp.array([0.0, 1.5, -5.0, -9.0])
    (rate,) = oscillator.rate(oscillator.start(jnp.zeros(4)), omega, feedback)
    np.testing.assert_array_equal(rate, [5.0, 6.5, 0.0, -4.0])


def test_a_floor_keeps_the_phase_from_falling_below_it_and_leaves_faster_rates_alone():
    oscillator = PhaseOscillator(slowest_rad_per_s=0.5)
    omega, feedback = jnp.array([5.0, 5.0, 5.0]), jnp.array([-9.0, -4.5, 1.0])
    (rate,) = oscillator.rate(oscillator.start(jnp.zeros(3)), omega, feedback)
    np.testing.assert_array_equal(rate, [0.5, 0.5, 6.0])


def test_a_clamped_phase_stays_where_it_is_whatever_the_feedback():
    oscillator = Clamped(PhaseOscillator())
    state = oscillator.start(jnp.array([1.0, 2.0]))
    (rate,) = oscillator.rate(state, jnp.array([5.0, 5.0]), jnp.array([3.0, -9.0]))
    np.testing.assert_array_equal(rate, 0.0)
    np.testing.assert_allclose(oscillator.phase(state), [1.0, 2.0])


def test_feedback_alarms_a_wary_oscillator_soon_and_it_calms_down_slowly():
    """Twice as much at twice the square of the frequency."""
    wary = WaryOscillator(fast_rad_per_s=5.0, rise_s=0.1, fall_s=2.0)
    omega, tick_s = 5.0 * jnp.sqrt(jnp.array([1.0, 2.0])), 0.001
    state, alarms = wary.start(jnp.zeros(2)), []
    for tick in range(1500):
        rate = wary.rate(state, omega, jnp.full(2, 3.0 if tick < 500 else 0.0))
        state = jax.tree.map(lambda x, dx: x + tick_s * dx, state, rate)
        alarms.append(np.array(wary.signals(state)["alarm"]))
    np.testing.assert_allclose(alarms[99], 3.0 * (1.0 - np.exp(-1.0)) * np.array([1, 2]), rtol=0.01)
    np.testing.assert_allclose(alarms[1499], alarms[499] * np.exp(-0.5), rtol=0.01)
    np.testing.assert_allclose(wary.phase(state), 1.5 * omega, rtol=1e-4)


def test_oscillators_with_rates_of_their_own_keep_them_in_other_units():
    assert PhaseOscillator(slowest_rad_per_s=1.0).in_units(0.5).slowest_rad_per_s == 2.0
    wary = WaryOscillator(fast_rad_per_s=4.0, rise_s=0.2, fall_s=8.0)
    oscillator = WaryOscillator(fast_rad_per_s=8.0, rise_s=0.1, fall_s=4.0)
    assert wary.in_units(0.5) == oscillator
    refused("a Clamped has rates of its own", lambda: Clamped(PhaseOscillator()).in_units(0.5))


def test_start_and_settle_bring_the_phase_into_one_turn():
    oscillator = PhaseOscillator()
    phase = oscillator.phase(oscillator.start(jnp.array([-0.5, 7.0, 100.0])))
    np.testing.assert_allclose(phase, np.mod([-0.5, 7.0, 100.0], 2 * np.pi), atol=1e-5)
    settled = oscillator.settle(PhaseState(jnp.array([-0.5, 7.0, 100.0])))
    np.testing.assert_array_equal(oscillator.phase(settled), phase)


@pytest.mark.parametrize(("dtype", "tolerance"), [("float32", 2e-7), ("float64", 1e-15)])
def test_sine_and_cosine_are_accurate(dtype, tolerance):
    with jax.enable_x64(dtype == "float64"):
        angle = PHASES.astype(dtype)
        sine, cosine = jax.jit(sin_cos)(jnp.asarray(angle))
    assert sine.dtype == cosine.dtype == dtype
    exact = angle.astype("float64")
    assert np.abs(np.asarray(sine, "float64") - np.sin(exact)).max() < tolerance
    assert np.abs(np.asarray(cosine, "float64") - np.cos(exact)).max() < tolerance


def test_sine_and_cosine_of_nan_and_infinity_are_nan_and_so_is_the_wrapped_phase_of_nan():
    sine, cosine = sin_cos(jnp.array([jnp.nan, jnp.inf, -jnp.inf]))
    assert np.isnan(sine).all()
    assert np.isnan(cosine).all()
    assert np.isnan(wrap_phase(jnp.array([jnp.nan]))).all()


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("angle", [0.0, TWO_PI, -TWO_PI, 2 * TWO_PI, -1e-9, -1e-30, 6.2831855])
def test_the_wrapped_phase_is_half_open_even_where_rounding_hurts(dtype, angle):
    with jax.enable_x64(dtype == "float64"):
        wrapped = wrap_phase(jnp.asarray([angle], dtype))
    assert wrapped.dtype == dtype
    assert 0.0 <= float(wrapped[0]) < TWO_PI


@given(st.floats(-1e3, 1e3, width=32))
def test_a_wrapped_phase_is_the_same_angle_in_one_turn(angle):
    wrapped = float(wrap_phase(jnp.float32(angle)))
    assert 0.0 <= wrapped < TWO_PI
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=2e-4)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=2e-4)
