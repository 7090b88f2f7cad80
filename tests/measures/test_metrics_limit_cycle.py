"""Limit cycles are found on the Poincaré section at the apex, and only where there are any."""

import math

import numpy as np
import pytest

from refusals import refused
from tegotae.measures.hopping import LimitCycle
from tegotae.measures.hopping.hopping import Hops, find_limit_cycle, hops
from tegotae.simulation.recorder import COMMON, Trajectory

ROWS = 60
HOP_S = 0.5


def table(*lanes: tuple) -> Hops:
    """A table of hops every 0.5 s: a lane is its heights [m], or (heights, phases [rad])."""
    height, phase, time = (np.full((ROWS, len(lanes)), np.nan) for _ in range(3))
    for lane, entry in enumerate(lanes):
        heights, phases = entry if isinstance(entry, tuple) else (entry, np.zeros(len(entry)))
        height[: len(heights), lane] = heights
        phase[: len(heights), lane] = phases
        time[: len(heights), lane] = HOP_S * np.arange(1, len(heights) + 1)
    frame = np.tile(np.arange(ROWS, dtype=np.int32)[:, None], (1, len(lanes)))
    count = np.isfinite(time).sum(axis=0).astype(np.int32)
    return Hops(*(np.asarray(x, "float32") for x in (time, height, phase)), frame, count)


def find(recorded: Hops, settings: LimitCycle | None = None, start_s=-math.inf, end_s=None):
    end_s = np.nanmax(recorded.time_s, axis=0) if end_s is None else end_s
    return find_limit_cycle(recorded, settings or LimitCycle(), start_s, end_s)


def test_the_smallest_period_counts():
    cycles = [np.resize(np.arange(k) * 0.1 + 1.1, 40) for k in range(1, 5)]
    assert np.array_equal(find(table(*cycles)).period, [1, 2, 3, 4])


def test_a_period_above_the_longest_is_no_limit_cycle():
    five = np.resize(np.arange(5) * 0.1 + 1.1, 40)
    assert np.isnan(find(table(five)).period[0])
    assert find(table(five), LimitCycle(max_period=5)).period[0] == 5


def test_the_end_of_a_decaying_transient_is_found_to_the_hop():
    """y_i = 1.2 + 0.2 · 0.8^i is within 5 mm of its last value from a known hop on."""
    heights = 1.2 + 0.2 * 0.8 ** np.arange(40)
    first = np.argmax(np.abs(heights - heights[-1]) <= 0.005)
    result = find(table(heights))
    assert result.period[0] == 1
    assert result.time_s[0] == pytest.approx(HOP_S * (first + 1))


def test_a_transient_into_period_two_is_timed_by_the_hop_from_which_both_branches_hold():
    heights = np.resize([1.3, 1.2], 40) + 0.1 * 0.7 ** np.arange(40)
    reference = np.resize(heights[-2:], 40)
    first = np.argmax(np.abs(heights - reference) <= 0.005)
    result = find(table(heights))
    assert result.period[0] == 2
    assert result.time_s[0] == pytest.approx(HOP_S * (first + 1))


def test_gaits_that_never_settle_have_no_limit_cycle():
    chaos = [0.4]
    for _ in range(49):
        chaos.append(3.9 * chaos[-1] * (1 - chaos[-1]))
    drift = 1.2 + 0.002 * np.arange(40)  # 2 mm a hop: each hop close to the one before
    torus = 1.3 + 0.1 * np.sin(1.0 * np.arange(50))
    result = find(table(1.1 + np.array(chaos), drift, torus))
    assert np.isnan(result.period).all()
    assert np.isnan(result.time_s).all()
    assert not result.found.any()


def test_the_phase_must_repeat_too():
    steady = np.full(40, 1.2)
    drifting = (0.3 * np.arange(40)) % (2 * np.pi)
    alternating = np.resize([1.0, 2.0], 40)
    around_zero = np.resize([0.01, 2 * np.pi - 0.01], 40)
    hops_made = table((steady, drifting), (steady, alternating), (steady, around_zero))
    assert np.array_equal(find(hops_made).period, [np.nan, 2, 1], equal_nan=True)
    body_alone = LimitCycle(phase_tolerance_rad=math.inf)
    assert np.array_equal(find(hops_made, body_alone).period, [1, 1, 1])


def test_a_body_that_stops_hopping_is_on_no_limit_cycle():
    hops_made = table(np.full(40, 1.2))
    last_s = 40 * HOP_S
    assert find(hops_made, end_s=last_s + 0.9 * HOP_S).period[0] == 1
    assert np.isnan(find(hops_made, end_s=last_s + 2.0 * HOP_S).period[0])


def test_enough_repeats_are_needed():
    transient = np.concatenate([np.linspace(2.0, 1.3, 20), np.full(5, 1.2)])
    assert find(table(transient), LimitCycle(min_repeats=4)).period[0] == 1
    assert np.isnan(find(table(transient), LimitCycle(min_repeats=5)).period[0])


def test_only_hops_inside_the_window_count():
    """Settled at 1.2 m, disturbed at 10 s, settled again at 1.4 m from 12.5 s on."""
    heights = np.concatenate([np.full(20, 1.2), np.linspace(1.3, 1.37, 4), np.full(16, 1.4)])
    hops_made = table(heights)
    assert find(hops_made, end_s=10.0).time_s[0] == pytest.approx(0.5)
    assert find(hops_made, start_s=10.2).time_s[0] == pytest.approx(12.5)
    assert find(hops_made, start_s=15.2).time_s[0] == pytest.approx(15.5)
    assert np.isnan(find(hops_made, end_s=12.4).period[0])


def test_the_last_whole_cycles_are_marked():
    heights = np.concatenate([[2.0, 1.9, 1.8], np.resize([1.1, 1.2, 1.3], 20)])
    result = find(table(heights))
    assert result.period[0] == 3
    steps = int(result.to_hop[0] - result.from_hop[0])
    assert result.to_hop[0] == 22
    assert steps == 18  # 20 settled hops span 19 intervals: six whole cycles of three


def test_hops_are_only_flights_that_clear_the_ground_by_one_percent():
    """A bounce of 5 mm is skipped, and over a ground that lies 0.2 m lower a hop counts anew."""
    frames, nan = 6, np.nan
    lane = np.array([nan, 1.2, 1.005, nan, 1.0, 1.5])
    ground = np.array([0.0, 0.0, 0.0, 0.0, -0.2, -0.2])
    columns = {channel.name: np.zeros((frames, 1), "float32") for channel in COMMON}
    columns["apex_height_m"] = lane[:, None].astype("float32")
    columns["apex_time_s"] = np.arange(frames, dtype="float32")[:, None]
    columns["apex_phase_rad"] = np.full((frames, 1), 7.0, "float32")
    columns["ground_m"] = ground[:, None].astype("float32")
    result = hops(Trajectory(**columns), 1.0)
    assert result.n_hops[0] == 3
    np.testing.assert_allclose(result.height_m[:3, 0], [1.2, 1.0, 1.5])
    np.testing.assert_allclose(result.time_s[:3, 0], [1, 4, 5])
    np.testing.assert_allclose(result.phase_rad[:3, 0], 7.0 - 2 * np.pi, rtol=1e-5)
    assert np.array_equal(result.frame[:3, 0], [1, 4, 5])
    assert np.isnan(result.time_s[3:]).all()


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("height_tolerance_m", 0.0),
        ("height_tolerance_m", math.nan),
        ("phase_tolerance_rad", -1.0),
        ("phase_tolerance_rad", math.nan),
        ("max_period", 0),
        ("min_repeats", 0),
        ("min_repeats", 1.5),
    ],
)
def test_settings_that_mean_nothing_are_refused(setting, value):
    refused(setting, LimitCycle, **{setting: value})
