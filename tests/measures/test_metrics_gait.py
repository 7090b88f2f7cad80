"""The metrics of recorded gaits whose answers are known."""

import math
import warnings

import jax
import numpy as np
import pytest

from refusals import refused
from synthetic import Hopping, seconds
from tegotae.measures.hopping import REGIMES, gait, measure
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.hopping.signals import smoothness

UNDEFINED_WITHOUT_CYCLE = (
    "limit_cycle_period",
    "t0_s",
    "t1_s",
    "w_peak",
    "a_peak",
    "delta_omega",
    "delta_w",
    "smoothness",
)


@pytest.fixture(autouse=True)
def _no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def sine(step_s: float = 0.004, omega: float = 6.0):
    """Height 1 + 0.1 sin ωt [m], with the force 2 (1 + cos ωt) [N]."""
    time_s = seconds(20.0, step_s)
    return time_s, 1 + 0.1 * np.sin(omega * time_s), 2.0 * (1 + np.cos(omega * time_s))


def regime(outcome) -> str:
    return REGIMES[outcome.regime]


@pytest.mark.parametrize("step_s", [0.002, 0.004, 0.01, 0.02])
def test_a_sine_at_any_resolution(step_s):
    """All in closed form: climbs 0.1 m above touchdown and 0.2 m in all per turn; the work is
    4 · 2 · 0.1 J (absolute), and the force changes by 2 ω sin ωt."""
    time_s, height, force = sine(step_s)
    result = measure(time_s, height, rest_length_m=1.0, omega=5.5, force_n=force, max_force_n=4.0)
    assert regime(result) == "limit cycle"
    assert result.limit_cycle_period == 1
    assert result.t0_s == pytest.approx(math.pi / 12, abs=1e-4)
    assert result.cot_inverse == pytest.approx(1 / 8, rel=0.01)
    assert result.cot_inverse_total == pytest.approx(1 / 4, rel=0.01)
    assert result.w_peak == pytest.approx(6.0, abs=0.002)
    assert result.a_peak == pytest.approx(1.0, abs=0.002)
    assert result.delta_omega == pytest.approx(-0.25, abs=0.003)
    assert result.delta_w == pytest.approx(0.5, abs=0.003)
    # Averaging over 20 ms shortens the force by sinc(ωΔ/2), and so does differencing.
    half_turn = 6.0 * 0.02 / 2
    rate = 2.0 * 6.0 / math.sqrt(2.0) * (math.sin(half_turn) / half_turn) ** 2
    assert result.smoothness == pytest.approx(rate / 4.0, rel=0.01)
    assert math.isnan(result.t1_s)


@pytest.mark.parametrize(
    ("work", "joule"),
    [("absolute", 0.8), ("positive", 0.4 + 0.1 * math.pi), ("net", 0.2 * math.pi)],
)
def test_the_three_definitions_of_work(work, joule):
    time_s, height, force = sine()
    result = measure(time_s, height, rest_length_m=1.0, force_n=force, work=work)
    assert result.cot_inverse == pytest.approx(0.1 / joule, rel=0.002)


@pytest.fixture(scope="module")
def dropped():
    """Settled at 1.2 m; the ground drops by 0.2 m at the 12th apex, and the transient that
    follows is -0.1 · 0.7^i."""
    transient = 1.2 - 0.1 * 0.7 ** np.arange(20)
    hopping = Hopping(np.concatenate([np.full(12, 1.2), transient]))
    drop_s = hopping.apex_s[11]
    time_s = seconds()
    over_ground = hopping.height_m(time_s)
    # The same flight, over a ground that moves away: it only lasts longer.
    fall_s = math.sqrt(2 * 0.4 / 9.81) - math.sqrt(2 * 0.2 / 9.81)
    later = time_s - fall_s
    height = np.where(
        time_s <= drop_s + math.sqrt(2 * 0.2 / 9.81), over_ground, hopping.height_m(later) - 0.2
    )
    falls = (time_s > drop_s) & (time_s < drop_s + math.sqrt(2 * 0.4 / 9.81))
    height[falls] = 1.2 - 0.5 * 9.81 * (time_s[falls] - drop_s) ** 2
    ground = np.where(time_s > drop_s, -0.2, 0.0)
    last = np.flatnonzero(hopping.apex_s + fall_s <= time_s[-1])[-1] - 12
    first = np.argmax(np.abs(transient - transient[last]) <= 0.005)
    assert 5 < first < last - 4
    return time_s, height, ground, drop_s, hopping.apex_s[12 + first] - hopping.touchdown_s[11]


def test_recovery_from_a_drop_of_the_ground(dropped):
    time_s, height, ground, drop_s, t1_s = dropped
    result = measure(time_s, height, rest_length_m=1.0, ground_m=ground, disturbed_at_s=drop_s)
    assert result.limit_cycle_period == 1
    assert result.t0_s < 1.5
    assert result.t1_s == pytest.approx(t1_s, abs=2e-3)


def test_without_naming_the_disturbance_there_is_no_limit_cycle(dropped):
    """Its apexes lie 0.2 m lower after it: the gait only settles late, and T1 is undefined."""
    time_s, height, ground, drop_s, _ = dropped
    result = measure(time_s, height, rest_length_m=1.0, ground_m=ground)
    assert result.t0_s > drop_s
    assert math.isnan(result.t1_s)


def test_no_cycle_before_the_disturbance_leaves_the_recovery_undefined():
    chaotic = [0.4]
    for _ in range(11):
        chaotic.append(3.9 * chaotic[-1] * (1 - chaotic[-1]))
    hopping = Hopping(np.concatenate([1.1 + 0.3 * np.array(chaotic), np.full(20, 1.2)]))
    time_s = seconds()
    result = measure(
        time_s,
        hopping.height_m(time_s),
        rest_length_m=1.0,
        disturbed_at_s=float(hopping.apex_s[11]),
    )
    assert regime(result) == "no limit cycle"
    assert math.isnan(result.t1_s)


def test_a_body_at_rest_hops_nowhere():
    time_s = seconds()
    result = measure(
        time_s,
        np.full_like(time_s, 0.8),
        rest_length_m=1.0,
        omega=5.0,
        force_n=np.ones_like(time_s),
        max_force_n=4.0,
    )
    assert regime(result) == "at rest"
    assert result.cot_inverse == result.cot_inverse_total == 0.0
    assert all(math.isnan(getattr(result, name)) for name in UNDEFINED_WITHOUT_CYCLE)


def test_a_body_that_hops_at_first_and_then_rests_is_at_rest():
    hopping = Hopping(np.full(10, 1.2))
    time_s = seconds()
    result = measure(time_s, hopping.height_m(time_s), rest_length_m=1.0)
    assert regime(result) == "at rest"
    assert math.isnan(result.t0_s)


def test_a_gait_that_never_settles_is_marked_and_has_no_efficiency():
    random = np.random.default_rng(0)
    hopping = Hopping(random.uniform(1.1, 1.5, 40))
    time_s = seconds()
    result = measure(
        time_s,
        hopping.height_m(time_s),
        rest_length_m=1.0,
        omega=5.0,
        force_n=np.ones_like(time_s),
        max_force_n=4.0,
    )
    assert regime(result) == "no limit cycle"
    undefined = (*UNDEFINED_WITHOUT_CYCLE, "cot_inverse", "cot_inverse_total")
    assert all(math.isnan(getattr(result, name)) for name in undefined)


def test_a_phase_that_slips_past_the_hops_is_no_limit_cycle():
    hopping = Hopping(np.full(40, 1.2))
    time_s = seconds()
    height = hopping.height_m(time_s)
    locked = hopping.phase_rad(time_s, np.full(40, 1.0))
    slipping = hopping.phase_rad(time_s, 0.2 * np.arange(40))
    assert measure(time_s, height, rest_length_m=1.0, phase_rad=locked).limit_cycle_period == 1
    wrapped = locked % (2 * math.pi)
    assert measure(time_s, height, rest_length_m=1.0, phase_rad=wrapped).limit_cycle_period == 1
    result = measure(time_s, height, rest_length_m=1.0, phase_rad=slipping)
    assert regime(result) == "no limit cycle"


def test_what_was_not_recorded_leaves_undefined_what_needs_it():
    time_s, height, _ = sine()
    bare = measure(time_s, height, rest_length_m=1.0)
    undefined = {name for name, value in bare.values.items() if math.isnan(value)}
    assert undefined == {
        "cot_inverse",
        "cot_inverse_total",
        "delta_omega",
        "delta_w",
        "smoothness",
        "t1_s",
        "optimum_share",
        "recovery_share",
        "feedback_share",
        "feedback_while_pushing",
        "phase_share",
    }


def test_work_that_is_negative_in_sum_has_no_efficiency():
    time_s, height, force = sine()
    result = measure(time_s, height, rest_length_m=1.0, force_n=-force, work="net")
    assert math.isnan(result.cot_inverse)


def test_hopping_without_work_has_an_efficiency_of_zero():
    time_s, height, _ = sine()
    result = measure(time_s, height, rest_length_m=1.0, force_n=np.zeros_like(time_s))
    assert result.cot_inverse == 0.0


@pytest.mark.precise
def test_many_recordings_at_once_give_what_each_gives_alone():
    time_s = seconds()
    random = np.random.default_rng(1)
    heights = [
        sine()[1],
        Hopping(np.resize([1.3, 1.2], 30)).height_m(time_s),
        Hopping(random.uniform(1.1, 1.5, 40)).height_m(time_s),
        np.full_like(time_s, 0.8),
    ]
    force = sine()[2]
    frames = [from_samples(time_s, y, rest_length_m=1.0, force_n=force) for y in heights]

    def measured(trajectory):
        single = jax.tree.map(lambda x: x if x.dtype == bool else x.astype("float32"), trajectory)
        return gait(single, omega=5.0, rest_length_m=1.0, max_force_n=4.0, frame_s=0.02)

    together = measured(jax.tree.map(lambda *x: np.concatenate(x, axis=1), *frames))
    for lane, alone in enumerate(map(measured, frames)):
        for name in alone.values:
            np.testing.assert_allclose(
                getattr(together, name)[lane], getattr(alone, name)[0], rtol=1e-5, err_msg=name
            )


def test_smoothness_knows_a_constant_force_from_one_that_switches():
    frames = np.arange(1, 501)[:, None] * 0.02
    constant = smoothness(2.0 * frames, 4.0, 0.02, 0.0)
    switching = np.cumsum(np.resize([4.0, 0.0], 500))[:, None] * 0.02
    assert constant[0] == pytest.approx(0.0, abs=0.01)
    assert float(smoothness(switching, 4.0, 0.02, 0.0)[0]) == pytest.approx(1 / 0.02, rel=1e-3)
    refused(r"frame_s is 0\.03", smoothness, frames, 4.0, 0.03, 0.0)


def test_an_apex_between_samples_is_found():
    hopping = Hopping(np.array([1.2, 1.3456, 1.2, 1.2]))
    time_s = seconds(2.0, 0.02)
    frames = from_samples(time_s, hopping.height_m(time_s), rest_length_m=1.0)
    apexes = np.isfinite(frames.apex_time_s)
    assert frames.apex_time_s[apexes][0] == pytest.approx(hopping.apex_s[1], abs=1e-6)
    assert frames.apex_height_m[apexes][0] == pytest.approx(1.3456, abs=1e-6)
    downs = frames.touchdown_time_s[np.isfinite(frames.touchdown_time_s)]
    inside = hopping.touchdown_s[hopping.touchdown_s < 2.0]
    np.testing.assert_allclose(downs, inside, atol=2e-3)


TIME, HEIGHT, FORCE = sine()


def with_(array: np.ndarray, index: int, value: float) -> np.ndarray:
    changed = array.copy()
    changed[index] = value
    return changed


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"height_m": with_(HEIGHT, 7, math.nan)}, "height_m is nan at sample 7"),
        ({"force_n": with_(FORCE, 9, math.inf)}, "force_n is inf at sample 9"),
        ({"time_s": with_(TIME, 5, math.nan)}, "time_s is nan at sample 5"),
        ({"time_s": with_(TIME, 5, 0.0)}, "do not increase: 0.016 s at sample 4, and 0 s"),
        ({"time_s": TIME[::-1]}, "do not increase"),
        ({"time_s": TIME**1.1}, "resample the recording to uniform times"),
        (
            {"time_s": 10 * TIME},
            "the samples are 0.04 s apart; the metrics need at least 50 samples a second",
        ),
        ({"time_s": TIME[:8], "height_m": HEIGHT[:8]}, "lasts 0.028 s; it must last at least"),
        ({"time_s": [0.0], "height_m": [1.0]}, "one row of at least 3 times"),
        ({"height_m": HEIGHT[:-1]}, r"height_m has shape \(5000,\)"),
        ({"height_m": "high"}, "height_m is no array of numbers"),
        ({"phase_rad": np.zeros(3)}, r"phase_rad has shape \(3,\)"),
        ({"rest_length_m": 0.0}, "rest_length_m is 0"),
        ({"omega": math.nan}, "omega is nan"),
        ({"omega": -3.0}, "omega is -3"),
        ({"max_force_n": -1.0}, "max_force_n is -1"),
        ({"work": "hard"}, "work is 'hard'; it must be one of absolute, positive, net"),
        (
            {"disturbed_at_s": 30.0},
            "disturbed_at_s lies 30 s after the first sample; it must lie inside",
        ),
        ({"disturbed_at_s": -1.0}, "disturbed_at_s lies -1 s after"),
    ],
)
def test_recordings_that_cannot_be_measured_are_refused_in_one_line(arguments, says):
    recording = {"time_s": TIME, "height_m": HEIGHT, "rest_length_m": 1.0, **arguments}
    refused(says, measure, **recording)
