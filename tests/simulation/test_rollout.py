"""Batched rollouts: shapes, events, ground drops, contained failures, reproducibility."""

import math
import os
import subprocess
import sys
from functools import cache

import jax
import numpy as np
import pytest

from refusals import refused
from tegotae import Rollout, Scenario, Timing
from tegotae.simulation.integrators import Hold
from tegotae.simulation.recorder import Trajectory
from tegotae.systems.recipe import recipe

SHORT = Timing(duration_s=3.0)
VANILLA = Rollout(controller=recipe("V-both-w4").controller(), timing=SHORT)
ART = Rollout(controller=recipe("ART").controller(), timing=SHORT)
LANES = 8


def art_weights(lanes: int = LANES, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(lanes, ART.controller.n_weights))


@cache
def art_rollout() -> Trajectory:
    return ART.run(art_weights(), Scenario(omega=6.0))


def lanes_of(trajectory: Trajectory, lanes) -> Trajectory:
    return jax.tree.map(lambda entry: entry[:, lanes], trajectory)


def assert_identical(first: Trajectory, second: Trajectory) -> None:
    assert first.channels.keys() == second.channels.keys()
    for name, a in first.channels.items():
        np.testing.assert_array_equal(a, second.channels[name], err_msg=name)


# What is recorded.


def test_a_trajectory_has_a_row_per_frame_and_a_column_per_lane():
    out = art_rollout()
    for name, entry in out.channels.items():
        assert entry.shape == (150, LANES), name
        assert isinstance(entry, np.ndarray), name
        assert entry.dtype == ("bool" if name == "failed" else "float32"), name
    np.testing.assert_allclose(out.time_s[:, 0], 0.02 * np.arange(1, 151), rtol=1e-6)


def test_double_precision_is_double_all_through():
    out = VANILLA.run([[2.0]], Scenario(omega=5.0), dtype="float64")
    for name, entry in out.channels.items():
        assert entry.dtype == ("bool" if name == "failed" else "float64"), name


def test_every_lane_has_its_own_weights_frequency_and_release():
    scenario = Scenario(
        omega=[4.0, 5.0, 6.0, 5.0],
        height_m=[1.2, 1.3, 1.2, 1.3],
        velocity_m_per_s=[0.0, 0.5, 0.0, 0.5],
        phase_rad=[0.0, 1.0, 2.0, 1.0],
    )
    weights = np.array([[1.0], [2.0], [3.0], [2.0]])
    together = VANILLA.run(weights, scenario)
    assert len(set(together.height_m[-1])) == 3
    for lane in range(4):
        varied = Scenario(
            *(entry[lane] for entry in (scenario.omega, scenario.height_m)),
            velocity_m_per_s=scenario.velocity_m_per_s[lane],
            phase_rad=scenario.phase_rad[lane],
        )
        alone = VANILLA.run(weights[lane], varied)
        np.testing.assert_allclose(together.height_m[:, lane], alone.height_m[:, 0], atol=1e-5)


def test_one_weight_vector_serves_all_lanes():
    once = VANILLA.run([2.0], Scenario(omega=[4.0, 6.0]))
    runs = VANILLA.run([[2.0], [2.0]], Scenario(omega=[4.0, 6.0]))
    assert_identical(once, runs)


def test_a_coarser_recording_shows_the_same_rollout():
    fine = VANILLA.run([[2.0]], Scenario(omega=5.0))
    timing = Timing(duration_s=3.0, frame_s=0.1)
    coarse = Rollout(controller=VANILLA.controller, timing=timing).run([[2.0]], Scenario(omega=5.0))
    assert coarse.height_m.shape == (30, 1)
    for name in ("time_s", "height_m", "phase_rad", "work_absolute_j", "climb_m", "energy_j"):
        np.testing.assert_allclose(
            getattr(coarse, name), getattr(fine, name)[4::5], atol=1e-5, err_msg=name
        )


def test_the_phase_advances_at_omega_without_feedback():
    omega = np.array([4.0, 5.5, 8.0])
    out = VANILLA.run([[0.0]], Scenario(omega=omega, phase_rad=1.0), dtype="float64")
    expected = np.mod(1.0 + omega * out.time_s, 2 * np.pi)
    np.testing.assert_allclose(out.phase_rad, expected, atol=1e-10)
    assert not out.feedback_rad_per_s.any()


def test_in_single_precision_the_phase_drifts_by_less_than_1e_4_rad_per_second():
    rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=60.0))
    out = rollout.run([[0.0]], Scenario(omega=8.0))
    drift = out.phase_rad - np.mod(8.0 * out.time_s.astype("float64"), 2 * np.pi)
    assert np.abs(np.angle(np.exp(1j * drift))).max() < 60.0 * 1e-4


def test_totals_are_those_of_the_recorded_force_and_height():
    timing = Timing(duration_s=3.0, frame_s=0.001)
    rollout = Rollout(controller=VANILLA.controller, timing=timing)
    out = rollout.run([[2.753]], Scenario(omega=5.0), dtype="float64")
    force, height = out.actuator_force_n[:, 0], np.r_[1.2, out.height_m[:, 0]]
    assert force.max() > 3.0
    assert out.impulse_ns[-1, 0] == pytest.approx(force.sum() * 0.001, rel=1e-9)
    # Lift-off and touchdown lie inside a tick, hence the tolerance.
    powers = force * np.diff(height)
    assert out.work_net_j[-1, 0] == pytest.approx(powers.sum(), abs=5e-3)
    assert out.work_absolute_j[-1, 0] == pytest.approx(np.abs(powers).sum(), abs=5e-3)
    assert out.work_positive_j[-1, 0] == pytest.approx(powers.clip(0).sum(), abs=5e-3)
    assert out.climb_m[-1, 0] == pytest.approx(np.diff(height).clip(0).sum(), abs=1e-4)
    flight = np.minimum(height[1:], height[:-1]) >= 1.0
    climbed = np.where(flight, np.diff(height).clip(0), 0.0).sum()
    assert out.climb_flight_m[-1, 0] == pytest.approx(climbed, abs=5e-3 * out.climb_m[-1, 0])


def test_the_work_definitions_fit_together():
    out = art_rollout()
    np.testing.assert_allclose(
        out.work_absolute_j, 2 * out.work_positive_j - out.work_net_j, rtol=1e-4, atol=1e-5
    )
    assert (np.diff(out.work_absolute_j, axis=0) >= 0).all()
    assert (out.climb_flight_m <= out.climb_m).all()


def test_no_force_is_recorded_in_flight():
    out = art_rollout()
    high = (out.height_m > 1.02) & (np.roll(out.height_m, 1, axis=0) > 1.02)
    assert high.any()
    assert not out.actuator_force_n[high].any()
    assert not out.spring_force_n[high].any()


def test_a_summary_sees_the_blocks_of_lanes_and_only_its_result_is_kept():
    rollout = Rollout(controller=VANILLA.controller, timing=SHORT, summary=highest)
    lanes = 1100  # more than one block on each of two devices
    sigma = np.linspace(0.5, 8.0, lanes)[:, None]
    out = rollout.run(sigma, Scenario(omega=5.0))
    assert set(out) == {"height_m", "omega"}
    assert out["height_m"].shape == (lanes,)
    some = [0, 511, 512, 1099]
    few = VANILLA.run(sigma[some], Scenario(omega=5.0))
    np.testing.assert_allclose(out["height_m"][some], few.height_m.max(axis=0), atol=1e-5)
    np.testing.assert_array_equal(out["omega"], 5.0)


def highest(trajectory, scenario, body, timing):
    """A summary: the greatest recorded height."""
    return {"height_m": trajectory.height_m.max(axis=0), "omega": scenario.omega}


def test_a_held_controller_agrees_at_short_ticks():
    timing = Timing(duration_s=1.0, tick_s=0.0001)
    controller = recipe("V-reflex-w8").controller()
    held = Rollout(controller=controller, timing=timing, integrator=Hold())
    exact = Rollout(controller=controller, timing=timing)
    first, second = (
        rollout.run([[2.0]], Scenario(omega=6.0), dtype="float64") for rollout in (held, exact)
    )
    np.testing.assert_allclose(first.height_m, second.height_m, atol=2e-3)


# The ground drops.


def test_after_a_drop_in_flight_touchdown_is_later_and_lower():
    out = VANILLA.run([[0.0]], Scenario(omega=5.0, drop_m=[0.0, 0.2], drop_time_s=0.1))
    first = np.nanmin(out.touchdown_time_s, axis=0)
    np.testing.assert_allclose(first, np.sqrt(2 * np.array([0.2, 0.4]) / 9.81), atol=1e-5)
    frames = np.round(first / 0.02).astype(int)
    assert out.height_m[frames[1], 1] < 0.85 < out.height_m[frames[0], 0]
    np.testing.assert_array_equal(out.ground_m[:5], 0.0)
    np.testing.assert_allclose(out.ground_m[5:, 1], -0.2, rtol=1e-6)
    np.testing.assert_array_equal(out.ground_m[:, 0], 0.0)


@pytest.mark.parametrize(("drop_time_s", "tick"), [(0.005, 5), (0.0052, 6), (0.0, 0)])
def test_the_ground_drops_at_the_first_tick_not_earlier_than_told(drop_time_s, tick):
    timing = Timing(duration_s=0.01, frame_s=0.001)
    rollout = Rollout(controller=VANILLA.controller, timing=timing)
    out = rollout.run([[0.0]], Scenario(omega=5.0, drop_m=0.2, drop_time_s=drop_time_s))
    np.testing.assert_array_equal(out.ground_m[:, 0] < 0.0, np.arange(10) >= tick)


def test_a_drop_in_stance_lets_go_of_the_leg():
    scenario = Scenario(omega=5.0, height_m=0.85, drop_m=0.5, drop_time_s=0.1)
    out = VANILLA.run([[0.0]], scenario, dtype="float64")
    assert out.spring_force_n[4, 0] > 0.0
    assert out.spring_force_n[5, 0] == 0.0
    np.testing.assert_allclose(np.diff(out.velocity_m_per_s[5:10, 0]), -9.81 * 0.02, atol=1e-9)


def test_drops_can_differ_from_lane_to_lane():
    times = np.array([0.5, 1.0, math.inf])
    out = VANILLA.run([[1.0]], Scenario(omega=5.0, drop_m=0.1, drop_time_s=times))
    dropped = out.time_s > times + 1e-4
    np.testing.assert_allclose(out.ground_m, np.where(dropped, -0.1, 0.0), rtol=1e-6)


# Lanes are independent.


def with_lane(lane: int, **change) -> Scenario:
    """All lanes alike but for one."""
    scenario = jax.tree.map(lambda x: np.full(LANES, x), Scenario(omega=6.0))
    for name, value in change.items():
        getattr(scenario, name)[lane] = value
    return scenario


@pytest.mark.parametrize("spoiled", [0, 3, LANES - 1])
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_spoiled_weights_change_no_other_lane(spoiled, value):
    weights = art_weights()
    weights[spoiled] = value
    out = ART.run(weights, Scenario(omega=6.0))
    neighbours = np.arange(LANES) != spoiled
    assert_identical(lanes_of(out, neighbours), lanes_of(art_rollout(), neighbours))
    if not np.isfinite(value):
        assert out.failed[-1, spoiled]


@pytest.mark.parametrize(
    "change",
    [
        {"height_m": 12.0},
        {"velocity_m_per_s": -30.0},
        {"height_m": math.nan},
        {"velocity_m_per_s": math.inf},
        {"omega": math.nan},
        {"phase_rad": math.nan},
    ],
    ids=lambda change: "-".join(f"{k}-{v}" for k, v in change.items()),
)
def test_a_failing_lane_is_marked_stands_still_and_changes_no_other(change):
    out = ART.run(art_weights(), with_lane(4, **change))
    neighbours = np.arange(LANES) != 4
    assert_identical(lanes_of(out, neighbours), lanes_of(art_rollout(), neighbours))
    failed = out.failed[:, 4]
    assert failed[-1]
    since = np.argmax(failed)
    assert failed[since:].all()
    for name in ("height_m", "work_absolute_j", "climb_m", "phase_rad"):
        values = getattr(out, name)[since:, 4]
        np.testing.assert_array_equal(values, np.full_like(values, values[0]), err_msg=name)


# Reproducibility.


ON_SO_MANY_CORES = """
import sys
import numpy as np
from tegotae import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import PGPE
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import System
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run
from tegotae.measures.objectives.fitness import Fitness
from tegotae.training.evolution import Stopping
art = recipe("ART").controller()
weights = np.random.default_rng(0).normal(size=(150, art.n_weights))
out = Rollout(controller=art, timing=Timing(duration_s=3.0)).run(weights, Scenario(omega=6.0))
experiment = Experiment(
    name="art",
    system=System(
        controller=art, omega=6.0, timing=Timing(duration_s=4.0, tick_s=0.002)
    ),
    objective=Fitness(settle_s=1.0),
)
run = Run(
    experiment=experiment,
    seeds=(0, 1),
    learner=Evolution(algorithm=PGPE(population=40), stopping=Stopping.after(4)),
)
curves = [c for _, c in run.learner.evolve(run.experiment, run.seeds)]
np.savez(
    sys.argv[1],
    **out.channels,
    curves=np.array(curves),
)
"""


@pytest.mark.thorough
def test_results_are_bit_identical_on_any_number_of_cores(tmp_path):
    """150 lanes, in blocks of which one is not full; and a training of two seeds."""
    results = {}
    for cores in (1, 2, 3):
        path = tmp_path / f"{cores}.npz"
        subprocess.run(
            [sys.executable, "-c", ON_SO_MANY_CORES, str(path)],
            check=True,
            env={**os.environ, "TEGOTAE_CORES": str(cores), "JAX_PLATFORMS": "cpu"},
        )
        results[cores] = dict(np.load(path))
    assert results[1]["height_m"].shape == (150, 150)
    for name, entry in results[1].items():
        for cores in (2, 3):
            np.testing.assert_array_equal(results[cores][name], entry, err_msg=name)


def test_a_lane_does_not_depend_on_how_many_go_with_it():
    weights = art_weights(200)
    together = ART.run(weights, Scenario(omega=6.0))
    for lanes in (slice(0, 1), slice(70, 71), slice(199, 200), slice(3, 90)):
        single = ART.run(weights[lanes], Scenario(omega=6.0))
        assert_identical(lanes_of(together, lanes), single)


# Misuse.

PERIODS = ("duration_s", "tick_s", "frame_s")
MULTIPLE = r"^frame_s is .*whole multiple of tick_s"
LONG_TICK = Timing(tick_s=0.05, frame_s=0.05)


def timed(**periods):
    return lambda: Timing(**periods)


def run(weights, rollout=VANILLA, omega=5.0, **options):
    return lambda: rollout.run(weights, Scenario(omega=omega), **options)


@pytest.mark.parametrize(
    ("misuse", "says"),
    [
        *(
            (timed(**{name: value}), f"^{name} is .*; it must be")
            for name in PERIODS
            for value in (0.0, -0.001, math.nan, math.inf, -math.inf, "long")
        ),
        *(
            (timed(tick_s=tick_s, frame_s=frame_s), MULTIPLE)
            for tick_s, frame_s in [(0.003, 0.02), (0.02, 0.01), (0.0007, 0.001)]
        ),
        (timed(duration_s=0.005), r"^duration_s is 0.005; .*at least one frame"),
        *(
            (run(np.zeros(shape), ART), r"^weights have shape .* needs \[lanes, 96\]")
            for shape in [(), (3,), (4, 3), (96, 4), (2, 4, 96)]
        ),
        (run(np.ones((3, 1)), omega=np.full(4, 5.0)), r"^weights for 3 lanes do not go with"),
        *(
            (run([[1.0]], dtype=dtype), f"^dtype is '{dtype}'; it must be")
            for dtype in ("float16", "int32", "double")
        ),
        (
            run([[1.0]], Rollout(controller=VANILLA.controller, timing=LONG_TICK)),
            r"tick of 0.05 s is too long",
        ),
    ],
)
def test_what_cannot_be_rolled_out_is_refused_in_one_line(misuse, says):
    refused(says, misuse)
