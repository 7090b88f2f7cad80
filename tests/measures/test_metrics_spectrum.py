"""Peaks of the spectrum of height: where they are, how much of the power they hold."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tegotae.measures.hopping.signals import delta_w, peak, spectrum

STEP_S = 0.02
TIME_S = np.arange(1000)[:, None] * STEP_S


def signal(*parts: tuple[float, float]) -> np.ndarray:
    """1.2 m plus sines of (amplitude [m], angular frequency [rad/s])."""
    height = 1.2 + sum(a * np.sin(w * TIME_S + 0.3 * w) for a, w in parts)
    return height.astype("float32")


@given(st.floats(2.0, 40.0), st.floats(0.01, 0.5))
def test_a_sine_has_one_peak_that_holds_all(omega, amplitude):
    w_peak, a_peak = peak(spectrum(signal((amplitude, omega)), STEP_S))
    assert w_peak[0] == pytest.approx(omega, abs=0.005)
    assert a_peak[0] == pytest.approx(1.0, abs=0.005)


def test_two_frequencies_share_the_power():
    w_peak, a_peak = peak(spectrum(signal((0.1, 4.0), (0.06, 9.0)), STEP_S))
    assert w_peak[0] == pytest.approx(4.0, abs=0.005)
    assert a_peak[0] == pytest.approx((1.0 / (1.0 + 0.36)) ** 0.5, abs=0.003)


def test_delta_w_weighs_all_peaks_of_at_least_half_the_largest():
    strong = spectrum(signal((0.1, 4.0), (0.06, 9.0)), STEP_S)
    weak = spectrum(signal((0.1, 4.0), (0.04, 9.0)), STEP_S)
    a_strong, a_weak = (1 / 1.36) ** 0.5, (1 / 1.16) ** 0.5
    assert delta_w(strong, 5.0)[0] == pytest.approx(a_strong * (1 + 0.6 * 4), abs=0.02)
    assert delta_w(weak, 5.0)[0] == pytest.approx(a_weak, abs=0.01)


@pytest.mark.thorough
def test_every_lane_has_its_own_window_and_frequency():
    """A lane whose window starts late sees only what comes after, as if the signal were cut."""
    height = np.concatenate([signal((0.1, 9.0))[:700], signal((0.1, 4.0), (0.06, 8.0))[700:]])
    pair = np.concatenate([height, height], axis=1)
    together = spectrum(pair, STEP_S, np.array([0, 700]))
    w_peak, a_peak = peak(together)
    cut_w, cut_a = peak(spectrum(height[700:], STEP_S))
    assert w_peak[0] == pytest.approx(9.0, abs=0.1)
    assert w_peak[1] == pytest.approx(float(cut_w[0]), abs=0.002)
    assert a_peak[1] == pytest.approx(float(cut_a[0]), abs=0.002)
    alone = delta_w(spectrum(height[700:], STEP_S), 5.0)
    at_each = delta_w(together, np.array([9.0, 5.0], "float32"))
    assert at_each[1] == pytest.approx(float(alone[0]), abs=0.01)


@pytest.mark.parametrize("step_s", [0.005, 0.01, 0.04])
def test_the_peak_does_not_depend_on_the_sampling_period(step_s):
    time_s = np.arange(round(20 / step_s))[:, None] * step_s
    height = 1.2 + 0.1 * np.sin(5.0 * time_s) + 0.05 * np.sin(10.0 * time_s)
    w_peak, a_peak = peak(spectrum(height.astype("float32"), step_s))
    assert w_peak[0] == pytest.approx(5.0, abs=0.005)
    assert a_peak[0] == pytest.approx((1 / 1.25) ** 0.5, abs=0.003)


def test_a_body_at_rest_gives_numbers_without_warnings(recwarn):
    still = spectrum(np.full((1000, 1), 0.8, "float32"), STEP_S)
    w_peak, a_peak = peak(still)
    assert np.isfinite([w_peak[0], a_peak[0], delta_w(still, 5.0)[0]]).all()
    assert not recwarn.list
