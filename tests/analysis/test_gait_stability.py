"""Stability of gaits: return maps with known multipliers, and those of bodies that move."""

import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Timing
from tegotae.analysis.gaits.map import Axis
from tegotae.analysis.gaits.stability import crossings, fit_return_map, stability
from tegotae.api import gaits
from tegotae.measures.gaits.lags import TURN, lag_difference, lags_at_sections
from tegotae.parts.fields import replace
from tegotae.systems.resolve import legged_system as system

BAR = replace(system("bar-light"), {"timing": Timing(duration_s=30.0)})
RATIOS = (-1.0, 0.9, 0.95, 1.05, 1.1)


@pytest.fixture(scope="module")
def bars():
    """Bars on either side of j = 1, and one that cannot be."""
    return stability(BAR, Axis("inertia_ratio", RATIOS))


def path(jacobian, kicks, cycles=6, shift=0.0):
    """Deviations that a linear map makes of kicks, [cycles, legs, kicks]."""
    deviations = [np.asarray(kicks, float)]
    for _ in range(cycles):
        deviations.append(np.asarray(jacobian) @ deviations[-1])
    return np.array(deviations) + shift


# Made-up maps


@pytest.mark.parametrize(
    ("jacobian", "multipliers"),
    [
        (np.diag([0.5, 0.9]), [0.9, 0.5]),
        ([[1.2, 0.3], [0.0, 0.4]], [1.2, 0.4]),
        ([[0.0, -0.8], [0.8, 0.0]], [0.8j, -0.8j]),
        (np.eye(2), [1.0, 1.0]),
    ],
)
def test_the_multipliers_of_a_known_map_are_found(jacobian, multipliers):
    fit = fit_return_map(path(jacobian, 0.01 * np.eye(2)))
    np.testing.assert_allclose(fit.jacobian, jacobian, atol=1e-10)
    assert fit.largest == pytest.approx(abs(multipliers[0]))
    for value in multipliers:
        assert np.abs(fit.multipliers - value).min() < 1e-9
    assert fit.residual < 1e-9


def test_what_a_linear_map_does_not_explain_is_told():
    noise = np.random.default_rng(0).normal(size=(7, 2, 50))
    clean = path(0.9 * np.eye(2), 0.01 * np.random.default_rng(1).normal(size=(2, 50)))
    assert fit_return_map(clean + 0.002 * noise).residual > 0.1
    assert fit_return_map(clean).residual < 1e-9
    too_few = fit_return_map(path(np.eye(2), [[0.01], [0.0]]))
    assert np.isnan([too_few.largest, too_few.residual]).all()


def test_deviations_that_have_left_the_neighbourhood_do_not_count_even_if_they_return():
    deviations = path(1.5 * np.eye(1), [[0.01]], cycles=12)
    deviations[8:] = 0.001
    assert fit_return_map(deviations).largest == pytest.approx(1.5)


def test_a_multiplier_crosses_one_between_its_neighbours_and_not_over_a_gap():
    ((loss_at, loses), (gain_at, gains)) = crossings([1, 2, 3, 4, 5], [1.2, 0.8, 0.9, 1.3, np.nan])
    assert (loss_at, loses) == (pytest.approx(1.5), False)
    assert (gain_at, gains) == (pytest.approx(3.25), True)
    assert crossings([1, 2, 3], [0.9, np.nan, 1.1]) == []


# Sections


def test_lags_at_sections_are_exact_for_even_paces_and_undefined_beyond_the_end():
    frame = jnp.arange(400.0)[:, None, None]
    turns = 0.3 + 0.0123 * frame - jnp.array([[[0.0], [0.25], [0.9]]])
    lag = np.asarray(lags_at_sections(TURN * turns % TURN, 8, 0))[..., 0]
    assert np.abs(lag_difference(lag[:5], np.array([[0.0, 0.25, 0.9]]))).max() < 1e-5
    assert np.isnan(lag[5:]).all()


def test_between_frames_a_sway_is_followed():
    frame = np.arange(400) * 0.01
    first = frame + 0.05 * np.sin(2 * np.pi * frame)
    second = frame - 0.3 + 0.05 * np.cos(2 * np.pi * frame)
    phase = 2 * np.pi * np.stack([first, second], axis=1)[..., None] % (2 * np.pi)
    lag = np.asarray(lags_at_sections(jnp.asarray(phase), 3))[:, 1, 0]
    np.testing.assert_allclose(lag, 0.25, atol=2e-6)  # where the sine is 0, the cosine is 1


# Bodies


def test_the_bar_exchanges_its_gaits_where_its_legs_do_not_feel_each_other(bars):
    crossing = bars.crossings.set_index(["gait", "loses"])["at"]
    assert 0.95 < crossing["in phase", False] < 1.05
    assert 0.95 < crossing["antiphase", True] < 1.05


def test_multipliers_say_which_gait_is_left_to_itself_and_which_is_not(bars):
    assert list(bars.jacobians) == ["in phase", "antiphase"]
    in_phase, antiphase = (bars.frame[bars.frame.gait == gait] for gait in bars.jacobians)
    assert (in_phase.largest[1:3] > 1.02).all()
    assert (in_phase.largest[3:] < 0.98).all()
    assert (antiphase.largest[1:3] < 0.98).all()
    assert (in_phase.unexplained[1:] < 0.05).all()


def test_a_body_that_cannot_be_has_no_return_map(bars):
    nobody = bars.frame[bars.frame.inertia_ratio == -1.0]
    assert nobody.largest.isna().all()
    assert not nobody.stays.any()


def test_without_feedback_every_multiplier_is_one():
    row = stability(BAR, Axis("sigma", (0.0, 0.01)), ["antiphase"]).frame.iloc[0]
    assert row.multiplier_1_real == pytest.approx(1.0, abs=1e-6)
    assert row.unexplained < 1e-6


# Misuse


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"over": Axis("inertia", (1.0, 2.0))}, "no parameter of this system is called 'inertia'"),
        ({"cycles": 0}, "cycles is 0; it must be a whole number of at least 1"),
        ({"kick": 0.0}, "kick is 0; it must be greater than 0"),
        ({"pairs": 0}, "pairs is 0; it must be a whole number of at least 1"),
        ({"gaits": ["trot"]}, "no gait of 2 legs is called 'trot'"),
        ({"over": Axis("inertia_ratio", (-2.0, -1.0))}, "no value of inertia_ratio has a body"),
    ],
)
def test_what_has_no_return_map_is_told_in_one_line(options, line):
    refused(line, lambda: stability(BAR, **{"over": Axis("inertia_ratio", (0.9, 1.1)), **options}))


def test_the_answer_has_crossings_matrices_and_a_picture():
    over = ("inertia_ratio", 0.9, 1.1)
    answer = gaits.stability("bar-light", over=over, count=5, duration_s=30.0)
    assert "in phase gains its stability at inertia_ratio 1" in answer.notes
    document = answer.to_dict()
    assert [row["gait"] for row in document["rows"]] == answer.table.gait.tolist()
    assert len(document["jacobians"]["antiphase"]) == 5
    answer.plot().draw_without_rendering()
