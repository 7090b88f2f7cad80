"""One rollout for people: what its summary says, and what is refused before it begins."""

import dataclasses
import json
import math

import jax
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, System, Timing
from tegotae.analysis.simulation import EFFICIENCY, Result, simulate
from tegotae.measures.hopping import gait
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.fields import replace
from tegotae.systems.recipe import recipe
from tegotae.systems.vanilla import preset

TIMING = Timing(duration_s=4.0, tick_s=0.002, frame_s=0.01)
PAPER = preset("paper")
ENERGIES = ("absolute", "positive", "net")


def simulation(
    weights: float = PAPER.sigma, actuation: str = "sector", timing: Timing = TIMING, **changed
) -> Result:
    """The paper's hopper for four seconds: fields of its system or release are otherwise, or what
    `simulate` takes."""
    of_rollout = {"drop_m", "drop_time_s", "work", "measure_from_s", "dtype"} & changed.keys()
    rollout = {name: changed.pop(name) for name in of_rollout}
    system = System(controller=PAPER.controller(actuation), omega=PAPER.omega_rad_per_s)
    return simulate(replace(system, changed), np.atleast_1d(weights), timing, **rollout)


def test_the_summary_is_json_and_lists_the_apexes_of_the_trajectory():
    result = simulation()
    summary = json.loads(json.dumps(result.summary(), allow_nan=False))
    t = result.trajectory
    has_apex = np.isfinite(t.apex_time_s)
    assert has_apex.sum() >= 2
    np.testing.assert_array_equal(summary["apex_time_s"], t.apex_time_s[has_apex])
    np.testing.assert_array_equal(summary["apex_height_m"], t.apex_height_m[has_apex])
    assert (np.diff(summary["apex_time_s"]) > 0.0).all()
    assert max(summary["apex_height_m"]) == pytest.approx(t.height_m[has_apex].max(), abs=2e-3)
    assert (summary["failed"], summary["failed_time_s"]) == (False, None)


@pytest.fixture(scope="module")
def settled() -> Result:
    """A gait that has settled long before its end."""
    return simulation(timing=Timing(duration_s=16.0, tick_s=0.002, frame_s=0.01))


def measured(result: Result, from_s: float) -> dict:
    """The summary of a result whose hops count from some time on."""
    return dataclasses.replace(result, measure_from_s=from_s).summary()


def test_a_settled_gait_has_one_cot_wherever_its_window_begins(settled):
    measures = [measured(settled, from_s) for from_s in np.arange(8.0, 9.2, 0.1)]
    for name in ("cot_inverse_flight", "cot_inverse_total"):
        values = [row[name] for row in measures]
        assert max(values) / min(values) - 1.0 < 2e-3
    assert {row["hops"] % 2 for row in measures} == {0}


def test_cot_is_that_of_training_and_of_evaluation(settled):
    t = jax.tree.map(lambda x: x[:, None], settled.trajectory)
    settled_run = settled
    result = measured(settled, 8.0)["cot_inverse_flight"]
    judged = Fitness(settle_s=8.0)(
        t, settled_run.system.scenario(), settled_run.body, settled_run.timing
    )
    assert result == pytest.approx(float(judged["cot_inverse"][0]), rel=1e-5)
    evaluated = gait(
        t,
        omega=settled_run.system.omega,
        rest_length_m=settled_run.body.rest_length_m,
        max_force_n=settled_run.body.max_force_n,
        frame_s=settled_run.timing.frame_s,
    )
    assert result == pytest.approx(float(evaluated.cot_inverse[0]), rel=5e-3)


def test_work_and_climbs_are_those_between_two_apexes():
    result = simulation(measure_from_s=1.0)
    summary, t = result.summary(), result.trajectory
    apexes = np.flatnonzero(t.apex_time_s >= 1.0)
    assert summary["hops"] == len(apexes) - 1 == 2
    assert summary["window_s"] == [t.apex_time_s[apexes[0]], t.apex_time_s[apexes[-1]]]
    work = t.work_absolute_j[apexes[-1]] - t.work_absolute_j[apexes[0]]
    flight = t.climb_flight_m[apexes[-1]] - t.climb_flight_m[apexes[0]]
    total = t.climb_m[apexes[-1]] - t.climb_m[apexes[0]]
    assert summary["work_j"] == pytest.approx(work)
    assert summary["cot_inverse_flight"] == pytest.approx(flight / work)
    assert summary["cot_inverse_total"] == pytest.approx(total / work)
    assert total > flight > 0.0


def test_hops_count_from_half_of_the_duration_unless_asked_for():
    start, end = simulation().summary()["window_s"]
    assert 2.0 < start < end < 4.0


def test_without_a_whole_hop_there_is_no_cot_but_a_reason(settled):
    last_s = settled.apexes[0][-1]
    for from_s, reason in (
        (last_s - 0.05, f"one hop from {last_s - 0.05:g} s on; it takes a whole one"),
        (last_s + 0.05, f"no hop from {last_s + 0.05:g} s on"),
    ):
        summary = measured(settled, float(from_s))
        assert summary["reason"].startswith(reason)
        assert {summary[name] for name in EFFICIENCY} == {None}
        assert summary["hops"] == 0


def test_a_body_that_cannot_lift_its_weight_is_told_so():
    result = simulation(body=Hopper(max_force_n=0.5), measure_from_s=3.9)
    assert (
        result.summary()["reason"]
        == "no hop from 3.9 s on; it pushes with 0.5 N and weighs 0.981 N"
    )


def test_the_definition_of_work_is_a_choice_and_is_named():
    summaries = {energy: simulation(work=energy).summary() for energy in ENERGIES}
    assert all(summaries[energy]["work"] == energy for energy in ENERGIES)
    absolute, positive, net = (summaries[energy]["work_j"] for energy in ENERGIES)
    assert absolute >= positive >= net
    assert absolute > 0.0
    assert absolute - positive == pytest.approx(positive - net, abs=1e-5)


def test_a_gait_that_dies_out_has_no_cot_but_a_reason():
    summary = simulation(0.0, "reflex", measure_from_s=0.0).summary()
    assert summary["reason"].startswith("no hop ")
    assert summary["cot_inverse_flight"] is None


def test_a_failed_rollout_says_when_and_has_no_cot():
    # Too soft a spring: the leg is at its end before it turns the body.
    summary = simulation(body=Hopper(stiffness_n_per_m=0.5)).summary()
    assert summary["failed"]
    assert 0.0 < summary["failed_time_s"] < 1.0
    assert summary["cot_inverse_flight"] is None
    assert summary["cot_inverse_total"] is None
    assert summary["reason"] == "the rollout failed"
    json.dumps(summary, allow_nan=False)


def test_the_ground_drops_when_and_as_far_as_asked():
    dropped, even = simulation(drop_m=0.2, drop_time_s=2.5), simulation()
    t = dropped.trajectory
    np.testing.assert_allclose(t.ground_m, np.where(t.time_s > 2.5001, -0.2, 0.0), atol=1e-7)
    previous = dropped.trajectory.time_s <= 2.5
    np.testing.assert_array_equal(t.height_m[previous], even.trajectory.height_m[previous])
    assert t.height_m[-1] != even.trajectory.height_m[-1]


def test_a_phase_counts_only_modulo_a_turn_however_large():
    once = simulation(phase_rad=1.0)
    turned = simulation(phase_rad=1.0 + 2.0 * math.pi * 100_000)
    np.testing.assert_allclose(
        turned.trajectory.height_m, once.trajectory.height_m, rtol=0.0, atol=1e-5
    )


REFUSED = {
    "an infinite drop": ({"drop_m": math.inf}, "drop_m is inf"),
    "a drop beyond all bounds": ({"drop_m": 1e39}, r"drop_m is 1e\+39; it must be at most 1000"),
    "a mass beyond float32": (
        {"body": Hopper(mass_kg=1e300)},
        r"mass_kg is 1e\+300; it must be at",
    ),
    "a weight beyond float32": ({"weights": 1e39}, r"weight 0 is 1e\+39; it must be at most 3.4"),
    "a weight too many": ({"weights": np.zeros(2)}, r"this controller needs \[lanes, 1\]"),
    "a window after the end": ({"measure_from_s": 4.0}, "window begins at 4 s, .* ends at 4 s"),
    "a window before the release": ({"measure_from_s": -1.0}, "measure_from_s is -1"),
    "a tick too long": (
        {"timing": Timing(duration_s=4.0, tick_s=0.05, frame_s=0.05)},
        r"control tick of 0\.05 s is too long .* at most 0\.014",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_simulated_is_refused_at_once(name):
    changed, message = REFUSED[name]
    refused(message, simulation, **changed)


def test_a_number_too_large_for_single_precision_may_fit_into_double():
    assert simulation(weights=1e39, dtype="float64").trajectory.height_m.dtype == np.float64


def test_a_simulation_is_a_lane_of_the_engine():
    controller = recipe("V-reflex-w8").controller()
    alone = simulation(2.0, controller=controller)
    lanes = Rollout(controller=controller, timing=TIMING).run(
        np.array([[2.0], [3.0]]), Scenario(omega=PAPER.omega_rad_per_s)
    )
    np.testing.assert_allclose(alone.trajectory.height_m, lanes.height_m[:, 0], atol=1e-5)
