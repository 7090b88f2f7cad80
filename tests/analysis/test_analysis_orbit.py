"""A limit cycle looked at closely: its orbit, surface, phase response and multipliers."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from springs import Hertz

from oracle import fly, vanilla
from refusals import refused
from tegotae import Hopper, TegotaeError, Timing
from tegotae.analysis.maps import turn
from tegotae.analysis.orbit import NoLimitCycleError, Orbit, find_orbit, release_paths
from tegotae.analysis.phase_response import measure_phase_response
from tegotae.analysis.poincare import (
    Poincare,
    fixed_point,
    linearised,
    observed_factor,
    poincare_section,
    transient,
)
from tegotae.analysis.surface import actuation_surface, sees_velocity
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold, PredictorCorrector
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe

REFLEX = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0)
SECTOR = SavedController.from_weights(recipe("V-sector-w4").controller(), np.array([4.0]), 6.0)
CASES = {"reflex": REFLEX, "sector": SECTOR}


@cache
def orbit(name: str) -> Orbit:
    return find_orbit(CASES[name])


@cache
def section(name: str) -> Poincare:
    return poincare_section(CASES[name], orbit(name))


def oracle_apexes(name: str, omega: float, duration: float, **start):
    law = vanilla(float(CASES[name].weights[0]), name)
    return fly(law, omega=omega, duration=duration, **start)


# The orbit.


@pytest.mark.parametrize("name", CASES)
def test_the_orbit_is_one_turn_that_an_adaptive_solver_repeats(name):
    cycle = orbit(name)
    assert cycle.hops == 1
    flown = oracle_apexes(
        name,
        CASES[name].omega,
        3.5 * cycle.period_s,
        height=float(cycle.apex_height_m[0]),
        phase=float(cycle.apex_phase_rad[0]),
    )
    np.testing.assert_allclose(flown.apex_height, cycle.apex_height_m[0], atol=1e-3)
    np.testing.assert_allclose(flown.apex_time, cycle.period_s * np.arange(1, 4), atol=1e-3)


@pytest.mark.parametrize("name", CASES)
def test_the_samples_of_an_orbit_go_once_round(name):
    cycle = orbit(name)
    assert 0.0 <= cycle.time_s[0] <= 0.001
    assert cycle.period_s - cycle.time_s[-1] <= 0.001
    np.testing.assert_allclose(np.diff(cycle.time_s), 0.001, atol=1e-9)
    assert cycle.height_m.max() == pytest.approx(cycle.apex_height_m[0], abs=1e-4)
    assert cycle.height_m[0] == pytest.approx(cycle.height_m[-1], abs=1e-3)
    flies = cycle.height_m > 1.0
    assert (cycle.spring_force_n[flies] == 0.0).all()
    assert (cycle.spring_force_n[~flies] > 0.0).all()
    # One sample more, for a force is the mean over the tick that ends with the sample.
    assert (cycle.actuator_force_n[1:][flies[1:] & flies[:-1]] == 0.0).all()
    turns = turn(np.diff(cycle.phase_rad)).sum()
    assert turns == pytest.approx(2.0 * np.pi, abs=0.02)


def test_a_cycle_of_two_hops_has_two_apexes():
    cycle = find_orbit(
        SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([8.0]), 6.0)
    )
    assert cycle.hops == 2
    assert cycle.apex_height_m.shape == cycle.apex_phase_rad.shape == (2,)
    assert abs(np.diff(cycle.apex_height_m)[0]) > 0.1


@pytest.mark.parametrize(
    ("weights", "reason"), [([0.0], "at rest"), ([np.inf], "failed")], ids=("no gain", "infinite")
)
def test_a_gait_without_limit_cycle_is_an_error_that_says_what_it_does(weights, reason):
    saved = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array(weights), 8.0)
    with pytest.raises(
        NoLimitCycleError, match=f"has no limit cycle after 60 s: {reason}"
    ) as error:
        find_orbit(saved)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("release", [{"height_m": np.nan}, {"phase_rad": np.inf}])
def test_a_release_that_is_not_finite_is_refused(release):
    refused("must be finite", lambda: find_orbit(replace(REFLEX, release)))


# Whose system it is.

HELD = replace(
    REFLEX,
    {"integrator": Hold(), "timing": Timing(tick_s=0.004), "height_m": 1.1, "phase_rad": 0.5},
)


def test_every_figure_of_a_held_controller_keeps_its_period_and_its_hold():
    cycle = find_orbit(HELD)
    np.testing.assert_allclose(np.diff(cycle.time_s), 0.004, atol=1e-9)
    free = find_orbit(replace(HELD, {"integrator": PredictorCorrector()}), tick_s=0.004)
    assert cycle.period_s != free.period_s
    section = poincare_section(HELD, cycle, turns=3)
    assert section.distance[0] == pytest.approx(0.01)
    shift = measure_phase_response(HELD, cycle, np.array([0.0]), points=3, cycles=4).shift_rad
    np.testing.assert_allclose(shift, 0.0, atol=1e-9)
    assert release_paths(HELD, np.array([1.2]), duration_s=1.0).time_s[0, 0] == pytest.approx(0.008)


def test_a_gait_that_settles_nowhere_is_said_to_be_released_as_its_system_says():
    still = dataclasses.replace(HELD, weights=np.zeros(1))
    with pytest.raises(NoLimitCycleError, match=r"released from 1\.1 m at phase 0\.5 rad"):
        find_orbit(still, settle_s=20.0)


def test_a_period_of_which_20_ms_is_no_multiple_is_refused_with_those_that_go():
    with pytest.raises(TegotaeError, match=r"period is 0\.003 s; .* such as 0\.001, 0\.002"):
        find_orbit(replace(HELD, {"timing": Timing(tick_s=0.003, frame_s=0.021)}))


# The actuation surface.

FORCES = np.linspace(0.0, 2.0, 9)


@pytest.mark.parametrize(("body", "digits"), [(Hopper(), 1e-12), (Hertz(), 1e-3)])
def test_the_surface_of_a_reflex_in_closed_form(body, digits):
    """f = -σ cos φ F_k and F_a = -min(0, f), at most α, whatever the spring."""
    saved = SavedController.from_weights(REFLEX.controller, np.array([3.0]), 8.0, body)
    surface = actuation_surface(saved, FORCES, columns=17)
    feedback = -3.0 * np.cos(surface.phase_rad)[None] * FORCES[:, None]
    np.testing.assert_allclose(surface.feedback_rad_per_s, feedback, atol=digits)
    expected = np.clip(-np.minimum(feedback, 0.0), 0.0, 4.0)
    np.testing.assert_allclose(surface.actuator_force_n, expected, atol=digits)
    assert surface.actuator_force_n.max() == 4.0


def test_the_surface_of_a_sector_is_a_band_of_full_force():
    surface = actuation_surface(SECTOR, FORCES, columns=401)
    turns = surface.phase_rad / np.pi
    inside = (turns >= 1.75) & (turns < 1.85)
    assert (surface.actuator_force_n[:, inside] == 4.0).all()
    assert (surface.actuator_force_n[:, ~inside] == 0.0).all()


def test_along_the_limit_cycle_force_and_feedback_lie_on_the_surface():
    path = orbit("reflex")
    stance = path.spring_force_n > 0.05
    for index in np.flatnonzero(stance)[::40]:
        sigma, force = REFLEX.weights[0], path.spring_force_n[index]
        feedback = -sigma * np.cos(path.phase_rad[index]) * force
        assert path.feedback_rad_per_s[index] == pytest.approx(feedback, abs=0.01)
        assert path.actuator_force_n[index] == pytest.approx(max(0.0, -feedback), abs=0.02)


def test_only_controllers_that_sense_the_velocity_depend_on_the_slice():
    generator = np.random.default_rng(0)
    for name, sees in (("AR-rFv-reflex-w8", True), ("AR-rF-reflex-w8", False)):
        controller = recipe(name).controller()
        saved = SavedController.from_weights(
            controller, generator.normal(size=controller.n_weights), 8.0
        )
        assert sees_velocity(saved) is sees
        slices = [
            actuation_surface(saved, FORCES, columns=9, velocity_m_per_s=v).feedback_rad_per_s
            for v in (0.0, 2.0)
        ]
        assert np.array_equal(*slices) is not sees


def test_the_single_network_has_a_surface_over_velocity_instead_of_phase():
    controller = recipe("T-Fv").controller()
    weights = np.random.default_rng(1).normal(size=controller.n_weights)
    saved = SavedController.from_weights(controller, weights, None)
    surface = actuation_surface(saved, FORCES, columns=5, velocity_range_m_per_s=(-2.0, 2.0))
    assert surface.phase_rad is None
    assert surface.velocity_m_per_s.tolist() == [-2.0, -1.0, 0.0, 1.0, 2.0]
    assert (surface.feedback_rad_per_s == 0.0).all()
    neurons = weights.reshape(-1, 4)
    force, speed = 1.0 / Hopper().weight_n, -1.0 / 9.81**0.5
    expected = np.clip((neurons[:, 3] * np.tanh(neurons[:, :3] @ [force, speed, 1.0])).sum(), 0, 4)
    assert surface.actuator_force_n[4, 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("forces", "velocity", "message"),
    [
        ([-0.1, 1.0], 0.0, "from -0.1 to 1 N; those of this leg lie between 0 and 5 N"),
        ([0.0, 5.1], 0.0, "from 0 to 5.1 N"),
        ([0.0, np.nan], 0.0, "from nan to nan"),
        ([0.0, 1.0], np.nan, "velocity is nan; it must be finite"),
    ],
)
def test_a_surface_outside_of_what_the_leg_can_do_is_refused(forces, velocity, message):
    refused(message, actuation_surface, REFLEX, np.array(forces), velocity_m_per_s=velocity)


# The phase response.


@cache
def response():
    """The response to no push, a small one and its opposite, and a larger one."""
    responses = measure_phase_response(
        REFLEX, orbit("reflex"), np.array([0.0, 1e-4, -1e-4, 5e-3]), points=12, cycles=30
    )
    return [group.reset_index(drop=True) for _, group in responses.groupby("push_ns", sort=False)]


def test_opposite_small_pushes_shift_by_opposite_angles():
    none, up, down, _ = (group.shift_rad for group in response())
    assert (none == 0.0).all()
    assert np.abs(up).max() > 1e-5
    np.testing.assert_allclose(up, -down, atol=0.02 * np.abs(up).max())


def test_in_flight_the_response_to_a_small_push_is_linear_in_its_time():
    """A push Δv at t is one at t' and a lift by Δv (t' - t): linear in t, before the touchdown."""
    row = response()[1]
    rising = np.flatnonzero(np.cumsum(row.stance) == 0)
    assert len(rising) >= 3
    up = row.shift_rad.to_numpy()[rising]
    np.testing.assert_allclose(np.diff(up, 2), 0.0, atol=0.01 * np.abs(up).max())


@pytest.mark.parametrize("point", [1, 5, 9])
def test_the_shift_is_that_of_an_adaptive_solver(point):
    row, path = response()[3], orbit("reflex")
    index = int(
        np.argmin(np.abs(path.time_s - row.cycle_phase_rad[point] / 2 / np.pi * path.period_s))
    )
    push = row.push_ns[point]
    start = {"height": float(path.height_m[index]), "phase": float(path.phase_rad[index])}
    speed = float(path.velocity_m_per_s[index])
    last = [
        oracle_apexes("reflex", 8.0, 18.6, velocity=v, **start).apex_time[-1]
        for v in (speed, speed + push / Hopper().mass_kg)
    ]
    shift = turn(2.0 * np.pi * (last[0] - last[1]) / path.period_s)
    assert row.shift_rad[point] == pytest.approx(shift, abs=2e-4)


def test_a_gait_that_does_not_come_back_has_no_shift():
    huge = measure_phase_response(REFLEX, orbit("reflex"), np.array([5.0]), points=3, cycles=5)
    assert np.isnan(huge.shift_rad).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"push_ns": np.array([np.nan])}, "push is nan; it must be finite"),
        ({"points": 2}, "points is 2; it must be a whole number of at least 3"),
        ({"cycles": 0}, "cycles is 0; it must be a whole number of at least 3"),
    ],
)
def test_a_response_to_nothing_measurable_is_refused(change, message):
    settings = {"push_ns": np.array([0.001]), **change}
    refused(message, lambda: measure_phase_response(REFLEX, orbit("reflex"), **settings))


# Multipliers.


def test_a_linear_map_has_its_own_matrix_and_the_fixed_point_that_it_is_given():
    matrix, star = np.array([[0.5, -0.3], [0.2, 0.7]]), np.array([1.3, 2.0])

    def image(points):
        return star + (points - star) @ matrix.T

    point, slope, refined = fixed_point(image, np.array([1.32, 1.95]), 1e-3)
    assert refined
    np.testing.assert_allclose(point, star, atol=1e-8)
    np.testing.assert_allclose(slope, matrix, atol=1e-8)


def test_phases_either_side_of_zero_are_near_each_other():
    def image(points):
        return np.stack([points[:, 0], (points[:, 1] + 0.5) % (2.0 * np.pi)], axis=-1)

    centre, slope = linearised(image, np.array([1.2, 2.0 * np.pi - 0.5]), 1e-3)
    np.testing.assert_allclose(slope, np.eye(2), atol=1e-9)
    assert centre[1] == pytest.approx(0.0, abs=1e-9)


def test_a_map_without_images_keeps_its_start_and_says_so():
    start = np.array([1.2, 1.0])
    point, slope, refined = fixed_point(lambda points: np.full_like(points, np.nan), start, 1e-3)
    assert not refined
    assert point.tolist() == start.tolist()
    assert np.isnan(slope).all()


@pytest.mark.parametrize("factor", [0.2, 0.9, 0.5])
def test_the_observed_factor_of_an_exponential_decay_onto_a_floor(factor):
    distance = 0.01 * factor ** np.arange(40) + 1e-8
    assert observed_factor(distance) == pytest.approx(factor, rel=0.02)
    assert np.isnan(observed_factor(np.array([0.01, 1e-9, 1e-9, 1e-9])))  # over at once


@pytest.mark.parametrize("name", CASES)
def test_multipliers_are_those_of_an_adaptive_solver(name):
    section_map = section(name)

    def image(points):
        flights = [
            oracle_apexes(
                name, CASES[name].omega, 1.3 * section_map.period_s, height=y, phase=phase
            )
            for y, phase in points.tolist()
        ]
        return np.array([(f.apex_height[0], f.apex_phase[0] % (2.0 * np.pi)) for f in flights])

    centre, slope = linearised(image, section_map.fixed_point, 1e-4)
    np.testing.assert_allclose(centre, section_map.fixed_point, atol=1e-4)
    expected = np.sort(np.abs(np.linalg.eigvals(slope)))[::-1]
    np.testing.assert_allclose(np.abs(section_map.multipliers), expected, atol=0.01)


def test_a_nudge_dies_out_as_the_largest_multiplier_says():
    section_map = section("reflex")
    assert section_map.observed == pytest.approx(abs(section_map.multipliers[0]), rel=0.1)
    assert section_map.distance[0] == pytest.approx(0.01, rel=1e-6)
    assert section_map.decay_s == pytest.approx(
        section_map.period_s / -np.log(abs(section_map.multipliers[0]))
    )
    unstable = dataclasses.replace(section_map, multipliers=np.array([1.2 + 0j, 0.1]))
    assert unstable.decay_s == np.inf


def test_the_transient_ends_in_the_fixed_point():
    apexes = transient(REFLEX, duration_s=60.0)
    assert apexes.shape[1] == 2
    np.testing.assert_allclose(apexes[-1], section("reflex").fixed_point, atol=1e-3)
    assert abs(apexes[0, 0] - apexes[-1, 0]) > 0.01


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"step": 0.0}, "step is 0; it must be greater than 0"),
        ({"nudge": np.nan}, "nudge is nan; it must be finite"),
        ({"turns": 1}, "turns is 1"),
    ],
)
def test_a_section_that_cannot_be_taken_is_refused(change, message):
    refused(message, lambda: poincare_section(REFLEX, orbit("reflex"), **change))
