"""The fitness of an episode: CoT⁻¹ + ΔΩ, what it does at rest, on failure, and between equals."""

import math
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.hopping import hop_height_m
from tegotae.measures.hopping.signals import (
    cot_inverse,
    delta_omega,
    peak,
    rest_delta_omega,
    spectrum,
    work_total,
)
from tegotae.measures.objectives.fitness import EPISODE, HERTZ, SETTLE_S, Fitness
from tegotae.measures.objectives.objective import FAILED_FITNESS, Objective
from tegotae.simulation.recorder import COMMON, Trajectory
from tegotae.systems.recipe import recipe

TIMING = Timing(duration_s=20.0)
FITNESS = Fitness(settle_s=4.0)
TIME = TIMING.frame_s * np.arange(1, TIMING.n_frames + 1)


def trajectory(height: np.ndarray, **totals) -> Trajectory:
    """A trajectory [frames, lanes] of the given heights and their apexes, and of given totals."""
    lanes = height.shape[1]
    zero = np.zeros((len(TIME), lanes), "float32")
    entries = {channel.name: zero for channel in COMMON}
    entries |= {"time_s": TIME[:, None] + zero, "failed": zero > 0.0, "height_m": height + zero}
    rises = np.diff(height, axis=0) > 0.0
    at_apex = np.pad(rises[:-1] & ~rises[1:], ((1, 1), (0, 0)))
    entries["apex_height_m"] = np.where(at_apex, height, np.nan).astype("float32")
    for name, value in totals.items():
        value = np.asarray(value)
        shape = (-1, 1) if value.ndim == 1 else value.shape
        entries[name] = np.broadcast_to(value.reshape(shape), zero.shape).astype(
            bool if name == "failed" else "float32"
        )
    return Trajectory(**jax.tree.map(jnp.asarray, entries))


def judge(recorded: Trajectory, omega=5.0, fitness: Fitness = FITNESS) -> dict[str, np.ndarray]:
    lanes = recorded.height_m.shape[1]
    scenario = jax.tree.map(
        lambda x: jnp.asarray(np.broadcast_to(x, (lanes,)), "float32"), Scenario(np.asarray(omega))
    )
    body = jax.tree.map(jnp.float32, Hopper())
    return jax.tree.map(np.asarray, _judged(fitness, recorded, scenario, body))


@partial(jax.jit, static_argnums=0)
def _judged(fitness, recorded, scenario, body):
    return fitness(recorded, scenario, body, TIMING)


def sinusoid(*omegas: float, amplitude: float = 0.3) -> np.ndarray:
    return 1.2 + amplitude * np.sin(np.outer(TIME, omegas))


# The spectrum.


def test_neither_offset_nor_size_of_the_motion_matter_to_the_spectrum():
    for scale, offset in ((1.0, 0.0), (0.01, 1.0), (3.0, -7.0)):
        height = offset + scale * sinusoid(6.0)
        w_peak, a_peak = peak(spectrum(jnp.asarray(height, "float32"), 0.02))
        assert w_peak[0] == pytest.approx(6.0, abs=2e-3)
        assert a_peak[0] == pytest.approx(1.0, abs=2e-3)


def test_delta_omega_punishes_a_wrong_frequency_and_an_impure_motion():
    assert delta_omega(5.0, 5.0, 1.0) == 0.0
    assert delta_omega(5.0, 3.0, 1.0) == -4.0
    assert delta_omega(5.0, 5.0, 0.5) == -0.25
    assert rest_delta_omega(5.0) == -26.0


# CoT.


def test_cot_is_zero_without_climb_or_without_work():
    np.testing.assert_array_equal(
        cot_inverse(np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])), 0
    )


def test_the_settled_part_alone_counts():
    climb = np.where(TIME <= 4.02, 50.0 * TIME, 50.0 * 4.02 + 0.6 * (TIME - 4.02))
    work = np.where(TIME <= 4.02, 1.0 * TIME, 4.02 + 0.3 * (TIME - 4.02))
    out = judge(trajectory(sinusoid(5.0), climb_flight_m=climb, work_absolute_j=work))
    assert out["cot_inverse"][0] == pytest.approx(2.0, rel=1e-3)


def hopping(period_s: float, climbs_m: tuple[float, ...], first_s: float) -> Trajectory:
    """Hops of one period, each climbing and costing in its own way, from a first apex on.

    Each hop's work is done in its stance, half way between apexes, and its climb in the tenth of
    the period before its apex; both cost alike, 2 J and a bit, so that CoT⁻¹ tells the climbs.
    """
    n = int((TIME[-1] - first_s) / period_s) + 2
    apex_s = first_s + period_s * np.arange(-1, n)
    climbs = np.resize(climbs_m, len(apex_s))

    def total(amounts: np.ndarray, from_share: float, to_share: float) -> np.ndarray:
        share = (TIME[:, None] - apex_s) / period_s + 1.0  # of each hop, which ends at its apex
        return (amounts * np.clip((share - from_share) / (to_share - from_share), 0, 1)).sum(axis=1)

    height = 1.2 + 0.2 * np.cos(2.0 * np.pi * (TIME - first_s) / period_s)
    return trajectory(
        height[:, None],
        climb_flight_m=total(climbs, 0.85, 0.95),
        work_absolute_j=total(np.full(len(climbs), 2.0), 0.4, 0.6),
    )


@pytest.mark.parametrize("period_s", [0.5, 0.785, 1.57, 2.3])
def test_where_the_window_cuts_a_hop_is_no_matter(period_s):
    for cut in np.linspace(0.0, period_s, 23):
        out = judge(hopping(period_s, (1.5,), first_s=0.1 + cut))
        assert out["cot_inverse"][0] == pytest.approx(0.75, rel=1e-4)


@pytest.mark.parametrize("climbs_m", [(1.0, 3.0), (1.0, 2.0, 4.0, 1.0)])
def test_hops_that_alternate_are_paid_alike(climbs_m):
    period_s = 1.7  # nine or ten hops in the window, of which eight or ten count
    for cut in np.linspace(0.0, len(climbs_m) * period_s, 23):
        out = judge(hopping(period_s, climbs_m, first_s=0.1 + cut))
        tolerance = 0.0 if len(climbs_m) == 2 else 0.25
        assert out["cot_inverse"][0] == pytest.approx(np.mean(climbs_m) / 2.0, abs=tolerance + 1e-4)


def test_less_than_a_whole_hop_is_worth_nothing():
    out = judge(hopping(17.0, (1.5,), first_s=10.0))
    assert out["cot_inverse"][0] == 0.0


def test_a_gait_that_has_died_out_by_the_last_quarter_is_none():
    for last_s, alive in ((14.95, False), (15.35, True)):
        recorded = hopping(0.4, (1.5,), first_s=0.1)
        hops = jnp.where(recorded.time_s <= last_s, recorded.apex_height_m, jnp.nan)
        cot = judge(Trajectory(**{**recorded.channels, "apex_height_m": hops}))["cot_inverse"][0]
        assert cot == pytest.approx(0.75 if alive else 0.0, rel=1e-4)


@pytest.mark.parametrize("energy", ["absolute", "positive", "net"])
def test_the_definition_of_energy_is_a_choice(energy):
    work = {
        f"work_{name}_j": TIME * x
        for name, x in zip(("absolute", "positive", "net"), (4, 3, 2), strict=True)
    }
    recorded = trajectory(sinusoid(5.0), climb_flight_m=12.0 * TIME, **work)
    out = judge(recorded, fitness=Fitness(work=energy))
    expected = {"absolute": 3.0, "positive": 4.0, "net": 6.0}[energy]
    assert out["cot_inverse"][0] == pytest.approx(expected, rel=1e-4)
    np.testing.assert_array_equal(
        work_total(recorded, energy), getattr(recorded, f"work_{energy}_j")
    )


def test_bounces_that_do_not_clear_the_rest_length_by_a_hundredth_are_no_hops():
    assert hop_height_m(1.0) == pytest.approx(1.01)
    assert hop_height_m(2.0, -0.2) == pytest.approx(1.82)
    totals = {"climb_flight_m": TIME, "work_absolute_j": TIME}
    low = trajectory(0.9 + 0.1 * np.sin(5.0 * TIME)[:, None], **totals)
    high = trajectory(0.9 + 0.12 * np.sin(5.0 * TIME)[:, None], **totals)
    assert judge(low)["cot_inverse"][0] == 0.0
    assert judge(high)["cot_inverse"][0] == pytest.approx(1.0, rel=1e-4)


def test_a_hop_is_measured_from_the_ground_where_it_is():
    height = 0.9 + 0.05 * np.sin(5.0 * TIME)[:, None]
    totals = {"climb_flight_m": TIME, "work_absolute_j": TIME}
    lowered = trajectory(height, ground_m=np.full(len(TIME), -0.2), **totals)
    assert judge(lowered)["cot_inverse"][0] == pytest.approx(1.0, rel=1e-4)
    assert judge(trajectory(height, **totals))["cot_inverse"][0] == 0.0


# Fitness.


def test_the_fitness_is_the_sum_of_both():
    recorded = trajectory(sinusoid(4.5), climb_flight_m=3.0 * TIME, work_absolute_j=2.0 * TIME)
    out = judge(recorded, omega=5.0)
    assert out["delta_omega"][0] == pytest.approx(-0.25, abs=3e-3)
    assert out["fitness"][0] == pytest.approx(1.5 - 0.25, abs=5e-3)


def test_the_frequency_can_be_left_out():
    recorded = trajectory(sinusoid(4.0), climb_flight_m=3.0 * TIME, work_absolute_j=2.0 * TIME)
    out = judge(recorded, omega=8.0, fitness=Fitness(follow_omega=False))
    assert out["fitness"][0] == pytest.approx(1.5, abs=2e-3)
    assert out["delta_omega"][0] == 0.0


@pytest.mark.parametrize("weight", [0.0, HERTZ, 0.5, 1.0])
def test_what_the_frequency_counts_for_is_a_choice(weight):
    recorded = trajectory(sinusoid(4.5), climb_flight_m=3.0 * TIME, work_absolute_j=2.0 * TIME)
    plain, weighted = (
        judge(recorded, fitness=f) for f in (Fitness(), Fitness(frequency_weight=weight))
    )
    gap = plain["fitness"][0] - plain["cot_inverse"][0]
    assert weighted["fitness"][0] == pytest.approx(1.5 + weight * gap, abs=2e-3)
    assert Fitness(frequency_weight=weight).program == Fitness().program, "it compiles nothing anew"


def test_a_weight_that_punishes_to_follow_is_refused():
    refused("frequency_weight is -1", Fitness, frequency_weight=-1.0)


def test_a_body_at_rest_gets_the_gap_of_no_motion():
    # Below a range of a millimetre there is no spectrum to speak of, only rounding.
    height = np.stack([np.full_like(TIME, 0.8), 0.8 + 4e-4 * np.sin(5.0 * TIME)], axis=1)
    out = judge(trajectory(height), omega=5.0)
    np.testing.assert_allclose(out["delta_omega"], -26.0)
    np.testing.assert_allclose(out["fitness"], -26.0, atol=1e-3)


def test_motion_in_tune_is_better_than_rest_and_rest_better_than_far_out_of_tune():
    height = np.concatenate([sinusoid(5.0, 11.0), np.full((len(TIME), 1), 0.8)], axis=1)
    in_tune, out_of_tune, at_rest = judge(trajectory(height), omega=5.0)["fitness"]
    assert in_tune > at_rest > out_of_tune


@pytest.mark.thorough
def test_between_equals_the_one_that_climbs_more_is_better_by_little():
    climbed = np.outer(np.linspace(0.0, 1.0, len(TIME)), [0.0, 0.02, 0.2, 5.0])
    out = judge(trajectory(np.full((len(TIME), 4), 0.8), climb_m=climbed))
    assert (np.diff(out["fitness"]) > 0.0).all()
    assert np.ptp(out["fitness"]) < 1e-3


def test_a_failure_is_worse_than_anything_that_does_not_fail():
    # As bad as it gets without failing: full noise at the highest frequency that is recorded.
    noise = 1.2 + 10.0 * np.cos(np.pi * np.arange(len(TIME)))[:, None]
    worst = judge(trajectory(noise), omega=0.1)["fitness"][0]
    best_failure = trajectory(
        sinusoid(5.0),
        climb_flight_m=100.0 * TIME,
        work_absolute_j=TIME,
        climb_m=100.0 * TIME,
        failed=np.arange(len(TIME)) == len(TIME) - 1,
    )
    out = judge(best_failure)
    assert out["failed"][0]
    assert out["cot_inverse"][0] == 0.0
    assert FAILED_FITNESS <= out["fitness"][0] <= FAILED_FITNESS + 1.0 < worst


def test_to_fail_later_is_better():
    failed = np.stack([failed_at_s < TIME for failed_at_s in (2.0, 10.0, 19.0)], axis=1)
    out = judge(trajectory(sinusoid(5.0, 5.0, 5.0), failed=failed))
    assert (np.diff(out["fitness"]) > 0.1).all()


def test_a_failed_lane_is_no_matter_to_the_others():
    height = sinusoid(5.0, 4.0)
    spoiled = np.concatenate([height, np.full((len(TIME), 1), np.nan)], axis=1)
    failed = np.zeros((len(TIME), 3), bool)
    failed[:, 2] = True
    out = judge(trajectory(spoiled, failed=failed))
    np.testing.assert_array_equal(out["fitness"][:2], judge(trajectory(height))["fitness"])
    assert out["fitness"][2] == FAILED_FITNESS
    assert all(np.isfinite(out[name][2]) for name in ("fitness", "cot_inverse"))


def test_on_the_device_it_is_what_it_is_on_the_recorded_trajectory():
    timing = Timing(duration_s=8.0)
    controller = recipe("V-reflex-w8").controller()
    sigma = np.array([[0.0], [2.0], [5.0]])
    lanes = scenario = Scenario(omega=8.0, height_m=np.array([1.0 - 0.981 / 5.0, 1.2, 12.0]))
    on_device = Rollout(controller=controller, timing=timing, summary=FITNESS).run(sigma, scenario)
    recorded = Rollout(controller=controller, timing=timing).run(sigma, scenario)
    lanes = jax.tree.map(lambda x: jnp.asarray(np.broadcast_to(x, (3,)), "float32"), lanes)
    body = jax.tree.map(jnp.float32, Hopper())
    afterwards = FITNESS(jax.tree.map(jnp.asarray, recorded), lanes, body, timing)
    assert set(on_device) == {"fitness", "cot_inverse", "delta_omega", "failed"}
    for name, value in on_device.items():
        np.testing.assert_allclose(value, afterwards[name], rtol=1e-4, atol=1e-4, err_msg=name)
    at_rest, hopping, failed = on_device["fitness"]
    assert on_device["cot_inverse"][1] > 0.1
    assert at_rest == pytest.approx(-65.0, abs=1e-2)
    assert hopping > at_rest > failed


def test_training_pays_within_two_percent_of_what_a_long_window_of_the_same_gait_makes():
    controller, sigma = recipe("V-reflex-w4").controller(), np.linspace(1.0, 9.0, 40)[:, None]
    omega = np.linspace(3.0, 9.0, 40)
    paid = Rollout(controller=controller, timing=EPISODE, summary=Fitness())
    rollout = Rollout(controller=controller, timing=Timing(duration_s=60.0), summary=GaitSummary())
    trained = paid.run(sigma, Scenario(omega))["cot_inverse"]
    long = rollout.run(sigma, Scenario(omega))
    settled = np.isfinite(long.limit_cycle_period) & (long.t0_s < SETTLE_S)
    settled &= long.limit_cycle_period <= 2
    assert settled.sum() >= 15
    np.testing.assert_allclose(trained[settled], long.cot_inverse[settled], rtol=0.02)


# Misuse.


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_settling_time_out_of_range_is_refused(value):
    refused(r"^settle_s is .*; it must be", Fitness, settle_s=value)


def test_an_unknown_energy_is_refused_with_those_that_are_known():
    message = r"^\w+ is 'gross'; it must be one of absolute, positive, net$"
    refused(message, Fitness, work="gross")
    refused(message, lambda: work_total(trajectory(sinusoid(5.0)), "gross"))


def test_an_episode_that_leaves_nothing_to_judge_is_refused():
    Fitness(settle_s=4.0).check(Timing(duration_s=5.0))
    with pytest.raises(TegotaeError, match=r"^an episode of 4.5 s leaves less than 1 s") as raised:
        Fitness(settle_s=4.0).check(Timing(duration_s=4.5))
    assert "\n" not in str(raised.value)


# An objective of one's own.


@dataclass(frozen=True)
class _Highest(Objective):
    """The greatest height [m]."""

    needs = ("height_m",)

    def outcome(self, trajectory, scenario, body, timing):
        return trajectory.height_m.max(axis=0)


@dataclass(frozen=True)
class _Priced(_Highest):
    """A height at a price that is data."""

    price: float = 1.0

    @property
    def program(self) -> "_Priced":
        return _Priced()

    @property
    def data(self) -> np.float32:
        return np.float32(self.price)

    def score(self, outcome, data):
        return {"fitness": data * outcome, "height_m": outcome}


def test_an_outcome_alone_is_a_fitness_and_a_failure_is_below_all_others():
    falls = np.stack([np.zeros(len(TIME)), TIME > 10.0], axis=1) > 0.5
    out = judge(trajectory(sinusoid(5.0, 5.0), failed=falls), fitness=_Highest())
    assert out["fitness"][0] == pytest.approx(1.5, abs=1e-3)
    assert FAILED_FITNESS < out["fitness"][1] < FAILED_FITNESS + 1.0
    assert np.isnan(out["cot_inverse"]).all()
    assert list(out["failed"]) == [False, True]


def test_a_score_reads_its_settings_as_data_of_one_program():
    out = judge(trajectory(sinusoid(5.0)), fitness=_Priced(price=2.0))
    assert out["fitness"][0] == pytest.approx(2.0 * out["height_m"][0])
    assert _Priced(price=2.0).program == _Priced(price=3.0).program


def test_a_fitness_that_is_not_one_number_per_lane_is_refused():
    @dataclass(frozen=True)
    class Whole(_Highest):
        def outcome(self, trajectory, scenario, body, timing):
            return trajectory.height_m

    with pytest.raises(TegotaeError, match=r"Whole.outcome returned .* one number per lane"):
        judge(trajectory(sinusoid(5.0)), fitness=Whole())
