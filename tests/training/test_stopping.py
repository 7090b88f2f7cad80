"""The end of a training: on made-up curves that rise, stay, jump late, or are noisy."""

import math

import numpy as np
import pytest

from refusals import refused
from tegotae.training.evolution import CAP, PLATEAU, RUNNING, Stopping

RULE = Stopping(generations=1000, least=40, share=0.5, tolerance=0.01)


def end_of(curve: np.ndarray, rule: Stopping = RULE) -> tuple[int, str]:
    """After how many generations a run ends, and why."""
    for generation in range(1, len(curve) + 1):
        reason = rule.reason(curve[:generation])
        if reason != RUNNING:
            return generation, reason
    return len(curve), RUNNING


RISES = np.minimum(np.arange(2000), 100.0)
DOUBLING = np.log2(np.maximum(np.arange(2000), 1.0))  # gains one with each doubling


def jumps_at(generation: int) -> np.ndarray:
    return np.where(np.arange(2000) >= generation, RISES + 5.0, RISES)


@pytest.mark.parametrize(
    ("curve", "end", "reason"),
    [
        pytest.param(np.linspace(0.0, 30.0, 2000), 1000, CAP, id="rises to the end"),
        pytest.param(np.full(2000, -17.0), 40, PLATEAU, id="flat: as soon as it may"),
        pytest.param(RISES, 202, PLATEAU, id="the asked share of it brought nothing"),
        pytest.param(0.009 * DOUBLING, 40, PLATEAU, id="gains below the tolerance are none"),
        pytest.param(0.011 * DOUBLING, 1000, CAP, id="slow gains above it are some"),
        pytest.param(jumps_at(190), 382, PLATEAU, id="a late jump is waited for"),
        pytest.param(jumps_at(210), 202, PLATEAU, id="one that came too late is missed"),
    ],
)
def test_a_training_ends_when_a_share_of_it_as_long_as_asked_for_gained_nothing(curve, end, reason):
    assert end_of(curve) == (end, reason)
    failed = np.where(np.arange(2000) % 7 == 6, -1e6, curve)  # on the way, which does no harm
    assert end_of(failed)[1] == reason


def test_noise_below_the_best_seen_neither_ends_nor_prolongs_a_training():
    draw = np.random.default_rng(0)
    smooth = np.minimum(np.arange(2000), 100.0)
    noisy = smooth - np.abs(draw.normal(size=2000)) * (np.arange(2000) % 2)
    assert abs(end_of(noisy)[0] - end_of(smooth)[0]) <= 4


def test_each_run_is_judged_alone_and_stays_ended():
    rises = np.linspace(0.0, 30.0, 60)
    ended = np.full(60, -17.0)
    ended[40:] = np.nan
    assert RULE.reasons(np.stack([rises, ended], axis=1)) == [RUNNING, PLATEAU]


def test_a_number_of_generations_can_be_asked_for():
    assert end_of(np.zeros(50), Stopping.after(7)) == (7, CAP)


def test_before_the_first_generation_nothing_has_ended():
    assert RULE.reasons(np.empty((0, 3))) == [RUNNING] * 3


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"generations": 0}, "generations is 0; it must be a whole number of at least 1"),
        ({"least": 0}, "least is 0; it must be a whole number of at least 1"),
        ({"share": 0.0}, "share is 0; it must be greater"),
        ({"share": 1.0}, "share is 1; it must be less than 1"),
        ({"tolerance": -0.1}, "tolerance is -0.1; it must be"),
        ({"tolerance": math.nan}, "tolerance is nan; it must be"),
    ],
)
def test_a_rule_that_is_none_is_refused(changed, message):
    refused(f"^{message}", Stopping, **changed)
