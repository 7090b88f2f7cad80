"""Weak and late actuators, blows and ground that moves: against closed forms, and zero is none."""

import dataclasses

import numpy as np
import pytest

from refusals import refused
from tegotae import Experiment, Hopper, Rollout, Scenario, System, TegotaeError, Timing, check
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.bodies import (
    Actuators,
    Bar,
    Blows,
    Pushes,
    Sensors,
    Walker,
)
from tegotae.simulation.schedules import Ramp, Staircase, Step
from tegotae.systems.recipe import recipe

REFLEX = recipe("V-reflex-w8").controller()
EVERYTHING = Sensors(body=Actuators(body=Blows(body=Hopper())), most_ticks=2)
ROLLOUT = Rollout(controller=REFLEX, timing=Timing(duration_s=6.0, tick_s=0.002))


def run(body=EVERYTHING, rollout=ROLLOUT, sigma=2.0, **scenario):
    return rollout.run([sigma], Scenario(omega=8.0, **scenario), body)


def disturbed(sigma=2.0, **levels):
    """Three lanes with everything around the body: one compiled program for all tests."""
    fields = {"strength": 1.0, "lag_s": 0.0, "impulse_ns": 0.0, "at_s": 0.0} | levels
    where = {
        "strength": "body.",
        "lag_s": "body.",
        "impulse_ns": "body.body.",
        "at_s": "body.body.",
    }
    changes = {where[name] + name: np.broadcast_to(x, 3) for name, x in fields.items()}
    return run(sigma=sigma, changes=changes)


@pytest.mark.parametrize(
    "body", [Actuators(body=Hopper()), Blows(body=Hopper()), Pushes(body=Hopper())]
)
def test_they_keep_the_contract_of_a_body(body):
    check(body)


def test_nothing_wrong_changes_nothing_to_the_bit():
    bare, within = run(Hopper()), disturbed()
    for name, values in bare.channels.items():
        np.testing.assert_array_equal(getattr(within, name)[:, :1], values, err_msg=name)


def test_a_share_of_the_strength_is_a_share_of_the_force():
    # A sector commands α or nothing, so that half of the strength is half of α.
    sector = Rollout(
        controller=recipe("V-sector-w8").controller(), timing=Timing(duration_s=6.0, tick_s=0.002)
    )
    body = Actuators(body=Hopper())
    changes = {"strength": [1.0, 0.5], "body.max_force_n": [2.0, 4.0]}
    weak, strong = np.moveaxis(run(body, sector, changes=changes).height_m, 1, 0)
    np.testing.assert_allclose(strong, weak, atol=2e-4)


def test_a_lagging_actuator_follows_a_jump_of_the_command_as_a_first_order_filter_does():
    lag_s, tick_s = 0.05, 0.002
    body = Actuators(body=Hopper(), lag_s=lag_s)
    reached, mean = np.zeros(1, "float32"), []
    for _ in range(50):
        of_tick, reached = body._follow(reached, np.ones(1, "float32"), tick_s)
        mean.append(float(of_tick[0]))
    time = tick_s * np.arange(51)
    exact = 1.0 - np.exp(-time / lag_s)
    assert float(reached[0]) == pytest.approx(exact[-1], abs=1e-5)
    integral = time + lag_s * np.exp(-time / lag_s)
    np.testing.assert_allclose(mean, np.diff(integral) / tick_s, atol=1e-4)


@pytest.mark.parametrize("lag_s", [1e3, 1e9])
def test_an_actuator_that_lags_for_ages_stays_where_it_is(lag_s):
    body = Actuators(body=Hopper(), lag_s=lag_s)
    mean, end = body._follow(np.zeros(1, "float32"), np.full(1, 4.0, "float32"), 0.002)
    np.testing.assert_allclose(end, 4.0 * 0.002 / lag_s, rtol=1e-4)
    np.testing.assert_allclose(mean, 0.0, atol=1e-5)


def test_ever_less_lag_comes_ever_nearer_to_none():
    path = disturbed(lag_s=[0.0, 0.001, 0.01]).height_m[:100]
    gap = np.abs(path - path[:, :1]).max(axis=0)
    assert 0.0 < gap[1] < 0.02
    assert gap[1] < 0.2 * gap[2]


def test_a_blow_in_flight_changes_the_apex_by_what_energy_says():
    body, impulse = Hopper(), 0.1
    # Released from 1.2 m with no velocity, and struck at once: up, or down.
    path = disturbed(sigma=0.0, impulse_ns=[0.0, impulse, -impulse])
    speed = impulse / body.mass_kg
    assert path.velocity_m_per_s[0] - path.velocity_m_per_s[0, 0] == pytest.approx(
        np.array([0.0, speed, -speed]), abs=1e-4
    )
    apex = np.nanmax(path.apex_height_m[:10, 1])
    assert apex == pytest.approx(1.2 + 0.5 * speed**2 / body.gravity_m_per_s2, abs=1e-4)


def test_a_wind_that_rises_carries_a_hopper_in_flight_as_its_force_says():
    body = Pushes(body=Hopper())
    wind = Ramp([0.0, body.weight_n], from_s=0.0, until_s=1.0)
    path = run(body, height_m=9.0, changes={"push_z_n": wind})
    flies = path.time_s[:, 0] <= 1.2
    still, carried = path.velocity_m_per_s[flies].T
    time = path.time_s[flies, 0]
    gravity = body.body.gravity_m_per_s2
    gained = gravity * np.where(time < 1.0, 0.5 * time**2, time - 0.5)
    np.testing.assert_allclose(still, -gravity * time, atol=1e-3)
    np.testing.assert_allclose(carried - still, gained, atol=0.02)
    np.testing.assert_array_equal(path.height_m[:, 0], run(Hopper(), height_m=9.0).height_m[:, 0])


def test_a_ground_that_drops_is_a_step_of_it_and_stairs_are_drops_one_after_the_other():
    drop = run(Hopper(), drop_m=0.1, drop_time_s=2.0)
    step = run(Hopper(), changes={"ground_m": Step(-0.1, from_s=2.0)})
    for name in ("height_m", "ground_m", "work_absolute_j"):
        np.testing.assert_array_equal(getattr(drop, name), getattr(step, name))
    stairs = run(Hopper(), changes={"ground_m": Staircase(step=-0.1, dwell_s=2.0, levels=3)})
    assert sorted(set(np.round(10.0 * stairs.ground_m[:, 0]).tolist())) == [-2.0, -1.0, 0.0]
    undisturbed = stairs.time_s[:, 0] < 2.0
    np.testing.assert_array_equal(stairs.height_m[undisturbed], drop.height_m[undisturbed])


def test_a_ground_that_lies_lower_throughout_is_refused():
    refused("a release from higher up", lambda: run(Hopper(), changes={"ground_m": -0.1}))


@pytest.mark.thorough
def test_several_legs_have_actuators_each_and_are_struck_as_one():
    legs = dataclasses.replace(REFLEX, limbs=2)
    rollout = Rollout(controller=legs, timing=Timing(duration_s=0.2, tick_s=0.002))
    body = Actuators(body=Blows(body=Bar(inertia_ratio=0.6)))
    path = run(body, rollout, changes={"body.impulse_ns": [0.0, 0.2], "body.at_s": 0.1})
    undisturbed = path.time_s[:, 0] <= 0.1
    np.testing.assert_array_equal(
        path.velocity_m_per_s[undisturbed, 0], path.velocity_m_per_s[undisturbed, 1]
    )
    # A bar of two legs weighs 0.2 kg.
    assert np.diff(path.velocity_m_per_s[~undisturbed][0]) == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(path.pitch_rad, 0.0, atol=1e-6)


def test_they_are_written_down_and_read_again():
    body = Actuators(body=Blows(body=Hopper(), impulse_ns=0.1, at_s=3.0), strength=0.9, lag_s=0.02)
    late = Sensors(body=body, delay_s=0.005, noise=0.01, most_ticks=8)
    experiment = Experiment(
        name="weak", system=System(controller=REFLEX, omega=8.0, body=late, timing=EPISODE)
    )
    assert Experiment.from_document(experiment.document) == experiment


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Actuators(body=Walker(), strength=0.5), "takes places of its feet, not forces"),
        (lambda: Blows(body=3), "body is 3; it must be a Body"),
    ],
)
def test_what_cannot_be_is_refused(make, says):
    refused(says, make)


def test_actuators_too_weak_to_lift_the_weight_are_refused_before_work():
    with pytest.raises(TegotaeError, match=r"strength is 0.2.*it cannot hop"):
        Actuators(body=Hopper(), strength=0.2).check_release(1.2)
