"""The evaluation of controllers: five frequencies, a drop of the ground, a clamped phase."""

import dataclasses
import math

import numpy as np
import pytest

from oracle import fly, vanilla
from refusals import refused
from tegotae.measures.evaluation import Evaluation, Protocol, evaluate
from tegotae.measures.hopping import LimitCycle
from tegotae.measures.hopping.hopping import Hops, find_limit_cycle
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.systems.controller_file import load
from tegotae.systems.recipe import recipe

SHORT = Protocol(undisturbed_s=15.0, disturbed_s=10.0)
SIGMAS = np.array([[1.0], [2.0], [3.0]])


@pytest.fixture(scope="module")
def reflex() -> Evaluation:
    return evaluate(recipe("V-reflex-w8").controller(), SIGMAS, 8.0, protocol=SHORT)


def settles(flown, start_s: float, end_s: float) -> float:
    """Return the time at which the oracle's apexes settle [s]."""
    column = np.full((3, len(flown.apex_time)), np.nan)
    column[:] = flown.apex_time, flown.apex_height, flown.apex_phase % (2 * math.pi)
    frame = np.arange(column.shape[1], dtype=np.int32)[:, None]
    table = Hops(*(c[:, None].astype("float32") for c in column), frame, frame[-1] + 1)
    return float(find_limit_cycle(table, LimitCycle(), start_s, end_s).time_s[0])


def test_transients_agree_with_an_adaptive_solver(reflex):
    """σ = 2 at ω = 8: T0, the apex at which the ground drops, and T1, each to a few ms."""
    law = vanilla(2.0, "reflex")
    calm = fly(law, omega=8.0, duration=16.0, rtol=1e-9)
    drop_s = calm.apex_time[calm.apex_time >= 15.0][0]
    dropped = fly(law, omega=8.0, duration=25.0, drop=0.2, drop_time=drop_s, rtol=1e-9)
    touchdown_s = dropped.touchdown_time[dropped.touchdown_time > drop_s][0]
    t0_s = settles(calm, -math.inf, 15.0)
    t1_s = settles(dropped, touchdown_s, 25.0) - touchdown_s
    assert reflex.episodes["t0_s"][1, 2] == pytest.approx(t0_s, abs=0.005)
    assert reflex.episodes["t1_s"][1, 2] == pytest.approx(t1_s, abs=0.005)


def test_five_episodes_around_the_training_frequency(reflex):
    assert np.array_equal(reflex.omega, [6.0, 7.0, 8.0, 9.0, 10.0])
    assert set(reflex.episodes) == set(HOPPING.names())
    assert all(values.shape == (3, 5) for values in reflex.episodes.values())


def test_a_run_does_not_depend_on_the_runs_it_is_evaluated_with(reflex):
    extra = evaluate(recipe("V-reflex-w8").controller(), [[2.0], [7.0], [0.5]], 8.0, protocol=SHORT)
    for name in HOPPING.names():
        np.testing.assert_allclose(
            extra.episodes[name][0], reflex.episodes[name][1], rtol=1e-4, atol=1e-5, err_msg=name
        )


def test_a_metric_of_a_run_is_the_mean_over_the_episodes_that_define_it(reflex):
    t0_s = reflex.episodes["t0_s"]
    on_cycle = reflex.episodes["limit_cycle_share"]
    assert np.array_equal(np.isfinite(t0_s), on_cycle == 1.0)
    assert 0 < on_cycle.sum() < on_cycle.size  # some do not settle: they stay out, counted
    runs = reflex.runs()
    for run in range(3):
        defined = t0_s[run][np.isfinite(t0_s[run])]
        assert runs["t0_s"][run] == pytest.approx(defined.mean() if len(defined) else np.nan)
        assert runs["limit_cycle_share"][run] == on_cycle[run].mean()


def test_a_controller_that_needs_its_oscillator_hops_at_no_clamped_phase(reflex):
    """The vanilla reflex pushes with F_k alone when its phase stands still: it cannot hop on."""
    assert np.all(reflex.episodes["cpgu"] == 1.0)


def test_without_an_oscillator_there_is_one_episode():
    model = recipe("T-Fv")
    still = np.zeros((2, model.controller().n_weights))
    result = evaluate(model.controller(), still, model.omega_t, protocol=SHORT)
    assert np.isnan(result.omega).all()
    assert result.episodes["t0_s"].shape == (2, 1)
    assert np.all(result.episodes["cot_inverse"] == 0.0)  # no force: comes to rest
    assert np.all(result.episodes["limit_cycle_share"] == 0.0)
    for name in ("cpgu", "delta_w", "t0_s", "t1_s", "recovery_share"):
        assert np.isnan(result.episodes[name]).all(), name


def test_without_a_drop_there_is_nothing_to_recover_from(reflex):
    calm = dataclasses.replace(SHORT, drop_m=0.0)
    result = evaluate(recipe("V-reflex-w8").controller(), SIGMAS, 8.0, protocol=calm)
    assert np.isnan(result.episodes["t1_s"]).all()
    assert np.isnan(result.episodes["recovery_share"]).all()
    np.testing.assert_allclose(result.episodes["t0_s"], reflex.episodes["t0_s"], rtol=1e-5)


@pytest.mark.parametrize(
    ("weights", "omega_t", "says"),
    [
        ([[1.0, 2.0]], 8.0, r"weights have shape \(1, 2\)"),
        (np.zeros((0, 1)), 8.0, "weights must be finite, of one run or more; those of 0 of 0"),
        ([[1.0], [math.nan]], 8.0, "those of 1 of 2 runs are not"),
        ("heavy", 8.0, "weights is 'heavy'; it must be a number"),
        ([[1.0]], None, "needs omega_t"),
        ([[1.0]], math.nan, "omega_t is nan"),
        ([[1.0]], 2.0, "omega_t is 2 and its lowest offset -2"),
    ],
)
def test_what_cannot_be_evaluated_is_refused_before_it_is_rolled_out(weights, omega_t, says):
    refused(says, lambda: evaluate(recipe("V-reflex-w8").controller(), weights, omega_t))


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("offsets", ()),
        ("offsets", (math.nan,)),
        ("undisturbed_s", 0.5),
        ("disturbed_s", math.inf),
        ("drop_m", -0.2),
        ("clamped_phases", 0),
        ("work", "heavy"),
    ],
)
def test_protocols_that_mean_nothing_are_refused(setting, value):
    refused(setting.removesuffix("s"), Protocol, **{setting: value})


def test_an_episode_is_resolved_if_half_the_tick_leaves_it_as_it_is():
    saved = load("zoo:ARGT-rF-gF-tphi-w4/2")

    def evaluated(tick_s):
        protocol = Protocol(tick_s=tick_s)
        return evaluate(saved.controller, saved.weights, 4.0, None, protocol, ["cot_inverse"])

    two, one, half = map(evaluated, (0.002, 0.001, 0.0005))
    assert two.resolved(one).tolist() == [[False, False, False, False, True]]
    assert one.resolved(half).all()
