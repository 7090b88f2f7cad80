"""Measures of the use of feedback and of phase, on recordings made by hand."""

import numpy as np
import pytest

from synthetic import Hopping, seconds
from tegotae.measures.hopping import gait, metrics
from tegotae.measures.hopping.recording import from_samples
from tegotae.simulation.recorder import Trajectory

METRICS = (metrics.feedback_share, metrics.feedback_while_pushing, metrics.phase_share)
ALPHA = 4.0


def feedback_metrics(force_n, feedback=0.0, has_oscillator: bool = True) -> dict[str, float]:
    """The metrics of a gait of one hop, whose force is a function of F_k and of compression.

    F_k grows with compression, up to some 10 N.
    """
    hopping, time_s = Hopping(np.full(40, 1.2)), seconds(30.0)
    path = from_samples(time_s, hopping.height_m(time_s), rest_length_m=1.0, frame_s=0.02)
    felt = 25.0 * np.maximum(1.0 - path.height_m, 0.0)
    force = np.where(felt > 0.0, force_n(felt, path.velocity_m_per_s < 0.0), 0.0)
    made_up = {
        "spring_force_n": felt,
        "actuator_force_n": force,
        "feedback_rad_per_s": np.where(felt > 0.0, feedback, 0.0),
    }
    path = Trajectory(**{**path.channels, **made_up})
    values = gait(
        path,
        omega=6.0,
        rest_length_m=1.0,
        max_force_n=ALPHA,
        frame_s=0.02,
        has_oscillator=has_oscillator,
        metrics=METRICS,
    )
    return {metric.name: float(np.asarray(getattr(values, metric.name))[0]) for metric in METRICS}


def in_stance() -> float:
    """Share of the time that the leg stands."""
    time_s = np.arange(1, 1501) * 0.02
    return float(np.mean(Hopping(np.full(40, 1.2)).height_m(time_s) < 1.0))


@pytest.mark.parametrize(
    "law", [lambda felt, _: 0.3 * felt, lambda felt, _: 4.0 * np.tanh(0.5 * felt)]
)
def test_a_force_that_follows_the_spring_alone_leaves_nothing_to_the_phase(law):
    assert feedback_metrics(law)["phase_share"] < 0.02


def test_a_push_in_compression_alone_is_the_phases():
    assert feedback_metrics(lambda felt, down: np.where(down, 4.0, 0.0))["phase_share"] > 0.95


def test_a_force_that_has_both_is_shared_by_their_variances():
    spring = feedback_metrics(lambda felt, _: 0.3 * felt)
    assert spring["phase_share"] < 0.02
    share = feedback_metrics(lambda felt, down: 0.3 * felt + np.where(down, 1.0, -1.0))[
        "phase_share"
    ]
    hopping, time_s = Hopping(np.full(40, 1.2)), np.arange(1, 1501) * 0.02
    compression = 1.0 - hopping.height_m(time_s)
    variance = np.var(7.5 * compression[compression > 0.0])
    assert share == pytest.approx(1.0 / (1.0 + variance), abs=0.02)


def test_a_constant_force_has_no_variance_to_explain():
    assert np.isnan(feedback_metrics(lambda felt, _: 2.0 + 0.0 * felt)["phase_share"])


def test_feedback_that_is_off_makes_nothing_of_the_phases_advance():
    assert feedback_metrics(lambda felt, _: 0.3 * felt)["feedback_share"] == 0.0


@pytest.mark.parametrize("feedback", [-2.0, 2.0])
def test_the_share_of_feedback_is_that_of_its_size(feedback):
    mean = 2.0 * in_stance()
    share = feedback_metrics(lambda felt, _: 0.3 * felt, feedback)["feedback_share"]
    assert share == pytest.approx(mean / (6.0 + mean), rel=0.02)


def test_the_feedback_counts_while_the_actuator_pushes():
    slowed = feedback_metrics(lambda felt, down: np.where(down, 1.0, 0.0), -2.0)
    assert slowed["feedback_while_pushing"] == pytest.approx(-2.0)
    assert np.isnan(feedback_metrics(lambda felt, _: 0.0 * felt, -2.0)["feedback_while_pushing"])


def test_without_an_oscillator_there_is_nothing_to_feed_back():
    assert np.isnan(
        [*feedback_metrics(lambda felt, _: 0.3 * felt, -2.0, has_oscillator=False).values()]
    ).all()
