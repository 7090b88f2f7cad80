"""Sensors that are late and noisy, before any body."""

import dataclasses

import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing, check
from tegotae.parts.bodies import Bar, Sensors
from tegotae.systems.recipe import recipe

REFLEX = recipe("V-reflex-w8").controller()
ROLLOUT = Rollout(controller=REFLEX, timing=Timing(duration_s=6.0))
LEG = Sensors(body=Hopper())


def run(body=LEG, rollout=ROLLOUT, **scenario):
    return rollout.run([2.0], Scenario(omega=8.0, **scenario), body)


@pytest.mark.thorough
def test_they_keep_the_contract_of_a_body():
    check(LEG)


def test_no_delay_and_no_noise_change_nothing_to_the_bit():
    bare, behind = run(Hopper()), run()
    for name, values in bare.channels.items():
        np.testing.assert_array_equal(getattr(behind, name), values, err_msg=name)


def test_what_they_tell_is_what_was_felt_so_long_ago():
    # Of a controller without gain the body does not depend on what is told.
    still = Rollout(controller=REFLEX, timing=Timing(duration_s=4.0, frame_s=0.001))
    reading = still.run(
        [0.0], Scenario(omega=8.0, changes={"delay_s": [0.0, 0.01, 0.0105]}), LEG, dtype="float64"
    ).spring_force_n
    np.testing.assert_allclose(reading[100:, 1], reading[90:-10, 0], atol=1e-12)
    between = 0.5 * (reading[90:-10, 0] + reading[89:-11, 0])
    np.testing.assert_allclose(reading[100:, 2], between, atol=1e-9)


def test_noise_is_white_normal_and_as_large_as_said():
    still = Rollout(controller=REFLEX, timing=Timing(duration_s=8.0, frame_s=0.001))
    reading = still.run(
        [0.0],
        Scenario(omega=8.0, changes={"noise": [0.0, 0.05, 0.05], "seed": [0.0, 0.0, 1.0]}),
        LEG,
    ).spring_force_n
    noise = (reading[:, 1:] - reading[:, :1]) / Hopper().weight_n
    np.testing.assert_allclose(noise.std(axis=0), 0.05, rtol=0.03)
    np.testing.assert_allclose(noise.mean(axis=0), 0.0, atol=0.002)
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.05
    assert abs(np.corrcoef(noise[:, 0], noise[:, 1])[0, 1]) < 0.05
    assert np.mean(np.abs(noise[:, 0]) < 0.05) == pytest.approx(0.683, abs=0.02)


@pytest.mark.thorough
def test_the_same_seed_makes_the_same_noise_whatever_the_lane():
    changes = {"noise": 0.05, "seed": [3.0, 1.0, 3.0]}
    height = run(changes=changes).height_m
    np.testing.assert_array_equal(height[:, 0], height[:, 2])
    assert not np.array_equal(height[:, 0], height[:, 1])
    np.testing.assert_array_equal(run(changes=changes).height_m, height)


@pytest.mark.thorough
def test_limbs_have_noise_of_their_own_and_the_body_behind_can_change():
    legs = dataclasses.replace(REFLEX, limbs=2)
    rollout = Rollout(controller=legs, timing=Timing(duration_s=2.0))
    behind = Sensors(body=Bar(inertia_ratio=0.6))
    bare = run(Bar(inertia_ratio=0.6), rollout)
    path = run(behind, rollout, changes={"noise": [0.0, 0.1]})
    np.testing.assert_array_equal(path.pitch_rad[:, 0], bare.pitch_rad[:, 0])
    assert np.abs(path.pitch_rad[-1, 1]) > 1e-6
    heavy = run(behind, rollout, changes={"body.mass_kg": [0.1, 0.12]})
    assert not np.allclose(heavy.height_m[:, 1], bare.height_m[:, 0])


@pytest.mark.thorough
def test_a_posture_is_the_one_of_the_body_behind():
    scenario = {"initial_pose": {"pitch_rad": 0.1}}
    legs = dataclasses.replace(REFLEX, limbs=2)
    rollout = Rollout(controller=legs, timing=Timing(duration_s=0.1))
    path = run(Sensors(body=Bar()), rollout, **scenario)
    np.testing.assert_array_equal(path.pitch_rad, run(Bar(), rollout, **scenario).pitch_rad)
    with pytest.raises(TegotaeError, match="Sensors has no initial_pose 'initial_pose'"):
        run(Sensors(body=Bar()), rollout, initial_pose={"initial_pose": 0.1})


def test_a_delay_beyond_what_is_kept_is_refused():
    refused("which is 50 control ticks; the sensors keep 16", run, changes={"delay_s": [0.0, 0.05]})
