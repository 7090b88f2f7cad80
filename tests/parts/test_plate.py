"""The plate: what hopper legs under a body that pitches, rolls and may twist promise."""

import dataclasses
import math

import jax.numpy as jnp
import numpy as np
import pytest

import upright_oracle
from refusals import refused
from tegotae import Controller, Rollout, Scenario, Timing, check
from tegotae.parts.bodies import (
    Bar,
    Body,
    Hopper,
    Plate,
    Push,
)
from tegotae.parts.terms import Signals
from tegotae.simulation.recorder import needing
from tegotae.systems.recipe import recipe

ONE = recipe("V-sector-w8").controller()
SHORT = Timing(duration_s=4.0)
PHASES = np.array([[0.0, 1.0], [2.0, 4.0], [1.0, 5.5], [3.5, 2.5]])
"""Phases of the legs left fore, right fore, left hind, right hind; two lanes."""
NEAR = PHASES * 0.2
"""Near enough to each other for flights of the whole body."""
TILTED = {"pitch_rad": 0.05, "roll_rad": 0.08}
SPINNING = {"pitch_rate_rad_per_s": 0.5, "roll_rate_rad_per_s": -0.5}
SLIGHTLY = {"pitch_rad": 0.02, "roll_rad": -0.03}
LIMP = Plate(pitch_inertia_ratio=0.6, roll_inertia_ratio=1.6, twist_inertia_ratio=0.8)


COMMON = ("height_m", "phase_rad", "energy_j", "climb_flight_m", "apex_time_s", "apex_height_m")


@dataclasses.dataclass(frozen=True)
class Recorded:
    """These channels, and no others, which would be compiled, too."""

    needs: tuple[str, ...]

    def __call__(self, trajectory, scenario, body, timing):
        return trajectory


def legs(limbs: int, unit: Controller = ONE) -> Controller:
    return dataclasses.replace(unit, limbs=limbs)


def run(body: Body, phases=PHASES, *, unit: Controller = ONE, gain: float = 1.0, **scenario):
    angles = tuple(channel.name for channel in body.channels if channel.name.endswith("_rad"))
    rollout = Rollout(
        controller=legs(body.limbs, unit), timing=SHORT, summary=Recorded((*COMMON, *angles))
    )
    weights = np.broadcast_to(gain, (2, unit.n_weights))
    if isinstance(body, Plate):  # the same names in every run: one program for all
        scenario["initial_pose"] = dict.fromkeys((*TILTED, *SPINNING), 0.0) | scenario.get(
            "initial_pose", {}
        )
        phases = np.broadcast_to(phases, (body.limbs, 2))
    return rollout.run(weights, Scenario(8.0, phase_rad=phases, **scenario), body, dtype="float64")


@pytest.mark.thorough
def test_the_plate_keeps_the_contract_of_a_body():
    check(dataclasses.replace(LIMP, twist_stiffness_nm_per_rad=0.5))


# Where the legs do not feel each other


@pytest.mark.thorough
def test_at_ratios_of_one_each_leg_of_a_limp_plate_is_a_hopper():
    plate = Plate(twist_inertia_ratio=1.0)
    path = run(plate)
    for leg, (x, z) in enumerate(zip(plate.hips_x_m, plate.hips_z_m, strict=True)):
        alone = run(Hopper(), PHASES[leg])
        hip = path.height_m + x * path.pitch_rad + z * path.roll_rad + x * z / 0.5 * path.twist_rad
        np.testing.assert_allclose(hip, alone.height_m, atol=1e-10)
        np.testing.assert_allclose(path.phase_rad[:, leg], alone.phase_rad, atol=1e-8)


def test_at_ratios_of_one_each_leg_of_a_rigid_tripod_is_a_hopper():
    tripod = Plate(hips_x_m=(0.6, -0.3, -0.3), hips_z_m=(0.0, 0.4, -0.4))
    path = run(tripod, PHASES[:3])
    for leg in range(3):
        alone = run(Hopper(), PHASES[leg])
        np.testing.assert_allclose(path.phase_rad[:, leg], alone.phase_rad, atol=1e-8)


@pytest.mark.parametrize("pairs", [(0, 0, 1, 1), (0, 1, 0, 1)], ids=["fore, hind", "left, right"])
def test_a_rigid_plate_at_ratios_of_one_is_hoppers_as_long_as_nothing_would_twist_it(pairs):
    path = run(Plate(), PHASES[list(pairs)])
    for leg, pair in enumerate(pairs):
        alone = run(Hopper(), PHASES[pair])
        np.testing.assert_allclose(path.phase_rad[:, leg], alone.phase_rad, atol=1e-8)


def test_diagonal_legs_of_a_rigid_plate_feel_each_other_at_any_ratios():
    diagonal = PHASES[[0, 1, 1, 0]]
    light, heavy = (
        run(Plate(pitch_inertia_ratio=j, roll_inertia_ratio=j), diagonal) for j in (0.6, 1.6)
    )
    np.testing.assert_allclose(light.phase_rad, heavy.phase_rad, atol=1e-8)
    np.testing.assert_allclose(light.roll_rad, 0.0, atol=1e-12)
    alone = run(Hopper(), diagonal[0])
    assert np.abs(light.height_m - alone.height_m).max(axis=0).min() > 0.05


@pytest.mark.thorough
def test_legs_that_are_all_alike_are_one_hopper_at_any_ratios():
    path, alone = run(LIMP, PHASES[0]), run(Hopper(), PHASES[0])
    np.testing.assert_allclose(path.height_m, alone.height_m, atol=1e-11)
    np.testing.assert_allclose(path.climb_flight_m, alone.climb_flight_m, atol=1e-11)
    for angle in (path.pitch_rad, path.roll_rad, path.twist_rad):
        np.testing.assert_allclose(angle, 0.0, atol=1e-12)


def test_a_plate_whose_pairs_are_alike_is_a_bar_with_half_the_legs():
    bar = Bar(inertia_ratio=0.6)
    along = run(
        Plate(pitch_inertia_ratio=0.6), PHASES[[1, 1, 0, 0]], initial_pose={"pitch_rad": 0.05}
    )
    across = run(
        Plate(roll_inertia_ratio=0.6, hips_z_m=(0.5, -0.5, 0.5, -0.5)),
        PHASES[[1, 0, 1, 0]],
        initial_pose={"roll_rad": 0.05},
    )
    path = run(bar, PHASES[:2], initial_pose={"pitch_rad": 0.05})
    for plate, angle in ((along, along.pitch_rad), (across, across.roll_rad)):
        np.testing.assert_allclose(plate.height_m, path.height_m, atol=1e-11)
        np.testing.assert_allclose(angle, path.pitch_rad, atol=1e-11)


# Against an adaptive solver


@pytest.mark.parametrize(
    ("ratios", "stiffness", "reflex"),
    [
        pytest.param((0.6, 1.6), 0.0, False, id="rigid", marks=pytest.mark.thorough),
        pytest.param((0.8, 0.9, 1.2), 0.5, True, id="sprung, reflex"),
        pytest.param((1.6, 0.7, 1.2), 0.0, False, id="limp", marks=pytest.mark.thorough),
    ],
)
def test_apexes_and_phases_are_those_of_an_adaptive_solver(ratios, stiffness, reflex):
    flown = upright_oracle.fly(
        upright_oracle.plate(0.5, 0.3, ratios, stiffness),
        sigma=2.0,
        omega=8.0,
        phases=tuple(NEAR[:, 0]),
        duration=SHORT.duration_s,
        turned=tuple(SLIGHTLY.values()),
        reflex=reflex,
    )
    pitch, roll, *twist = ratios
    plate = Plate(
        pitch_inertia_ratio=pitch,
        roll_inertia_ratio=roll,
        twist_inertia_ratio=twist[0] if twist else None,
        twist_stiffness_nm_per_rad=stiffness,
    )
    unit = recipe("V-reflex-w8").controller() if reflex else ONE
    path = run(plate, NEAR, unit=unit, gain=2.0, initial_pose=SLIGHTLY)
    mask = np.isfinite(path.apex_time_s[:, 0])
    assert mask.sum() == len(flown.apex_time) >= 1
    np.testing.assert_allclose(path.apex_height_m[mask, 0], flown.apex_height, atol=1e-3)
    np.testing.assert_allclose(path.apex_time_s[mask, 0], flown.apex_time, atol=2e-3)
    difference = path.phase_rad[-1, :, 0] - flown.phase
    np.testing.assert_allclose(np.cos(difference), 1.0, atol=1e-4)
    assert path.height_m[-1, 0] == pytest.approx(flown.place[0], abs=1e-3)
    assert path.roll_rad[-1, 0] == pytest.approx(flown.place[2], abs=5e-3)


def test_without_damping_and_force_the_plate_keeps_its_energy():
    plate = dataclasses.replace(LIMP, damping_ns_per_m=0.0, twist_stiffness_nm_per_rad=0.5)
    path = run(
        plate,
        np.zeros(2),
        unit=recipe("V-reflex-w8").controller(),
        gain=0.0,
        initial_pose=TILTED | SPINNING,
    )
    assert np.ptp(path.energy_j) < 1e-9 * path.energy_j[0, 0]
    assert np.ptp(path.twist_rad) > 1e-3


# Symmetry


def test_a_plate_whose_legs_are_named_in_another_order_moves_the_same():
    order = [2, 0, 3, 1]
    renamed = dataclasses.replace(
        LIMP,
        hips_x_m=tuple(LIMP.hips_x_m[leg] for leg in order),
        hips_z_m=tuple(LIMP.hips_z_m[leg] for leg in order),
    )
    path, reordered = (
        run(LIMP, initial_pose=TILTED),
        run(renamed, PHASES[order], initial_pose=TILTED),
    )
    np.testing.assert_allclose(path.height_m, reordered.height_m, atol=1e-12)
    np.testing.assert_allclose(path.phase_rad[:, order], reordered.phase_rad, atol=1e-10)


@pytest.mark.parametrize(
    ("order", "flipped"),
    [([1, 0, 3, 2], "roll_rad"), ([2, 3, 0, 1], "pitch_rad")],
    ids=["left and right", "fore and hind"],
)
def test_a_mirrored_start_gives_the_mirrored_gait(order, flipped):
    path = run(LIMP, initial_pose=TILTED)
    mirrored = run(LIMP, PHASES[order], initial_pose=TILTED | {flipped: -TILTED[flipped]})
    np.testing.assert_allclose(path.phase_rad[:, order], mirrored.phase_rad, atol=1e-10)
    np.testing.assert_allclose(path.twist_rad, -mirrored.twist_rad, atol=1e-12)
    for angle in ("pitch_rad", "roll_rad"):
        sign = -1.0 if angle == flipped else 1.0
        np.testing.assert_allclose(
            getattr(path, angle), sign * getattr(mirrored, angle), atol=1e-12
        )


# What legs do that feel their own load alone


@needing("phase_rad")
def last_phases(trajectory, scenario, body, timing):
    return trajectory.phase_rad[-1]


def lags(plate: Plate, gain: float = 1.0, lanes: int = 4) -> np.ndarray:
    """Return the lags of the legs behind left fore after 90 s [rad], [legs, lanes]."""
    start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (4, lanes))
    timing = Timing(duration_s=90.0, frame_s=0.1, tick_s=0.002)
    rollout = Rollout(controller=legs(4), timing=timing, summary=last_phases)
    phase = rollout.run([gain], Scenario(8.0, phase_rad=start), plate)
    return phase[:1] - phase


@pytest.mark.parametrize(
    ("pitch", "roll", "gait"),
    [(0.6, 1.6, (0, 0, 1, 1)), (1.6, 0.6, (0, 1, 0, 1)), (1.6, 1.6, (0, 0, 0, 0))],
    ids=["light in pitch: bound", "light in roll: pace", "heavy: pronk"],
)
def test_the_gait_is_the_lightest_mode_of_the_body(pitch, roll, gait):
    gait_lags = lags(Plate(pitch_inertia_ratio=pitch, roll_inertia_ratio=roll))
    expected = np.pi * np.array(gait, float)[:, None]
    np.testing.assert_allclose(np.cos(gait_lags - expected), 1.0, atol=0.05)


def test_legs_that_do_not_listen_keep_their_lags():
    plate = Plate(pitch_inertia_ratio=0.6, roll_inertia_ratio=1.6)
    start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (4, 4))
    difference = lags(plate, gain=0.0) - (start[:1] - start)
    np.testing.assert_allclose(np.cos(difference), 1.0, atol=1e-4)


# Lanes with bodies of their own


@pytest.mark.thorough
def test_every_lane_may_have_a_body_of_its_own():
    across = np.array([[0.3, 0.4], [-0.3, -0.4], [0.3, 0.4], [-0.3, -0.4]])
    varied = {
        "pitch_inertia_ratio": [0.6, 1.6],
        "twist_stiffness_nm_per_rad": [0.0, 0.3],
        "mass_kg": [0.1, 0.11],
        "stiffness_n_per_m": [5.0, 6.0],
        "rest_length_m": [1.0, 0.9],
    }
    path = run(LIMP, initial_pose=TILTED, changes=varied | {"hips_z_m": across})
    for lane in (0, 1):
        fields = {name: values[lane] for name, values in varied.items()}
        body = dataclasses.replace(LIMP, hips_z_m=tuple(across[:, lane]), **fields)
        alone = run(body, initial_pose=TILTED)
        np.testing.assert_allclose(path.height_m[:, lane], alone.height_m[:, lane], atol=1e-9)
        np.testing.assert_allclose(path.energy_j[:, lane], alone.energy_j[:, lane], atol=1e-9)
        np.testing.assert_allclose(path.phase_rad[..., lane], alone.phase_rad[..., lane], atol=1e-7)


def test_a_network_sees_what_is_sensed_over_the_scale_of_its_lane():
    sensed = Signals({"force": jnp.ones((4, 2))}, {"force": jnp.array([1.0, 2.0])})
    np.testing.assert_array_equal(sensed.dimensionless("force"), np.tile([1.0, 0.5], (4, 1)))


# What cannot be


def test_a_leg_that_is_lost_bears_nothing_and_the_others_bear_as_they_did():
    intact, lame = Plate(), Plate(present=(1, 1, 0, 1))
    state = intact.release(jnp.array([0.8]), jnp.array([0.0]))  # all legs pressed by 0.2 m
    ground = jnp.zeros(1)
    felt, felt_lame = (body.sense(state, ground).values["spring_force"] for body in (intact, lame))
    np.testing.assert_allclose(felt[:, 0], 1.0, rtol=1e-5)
    np.testing.assert_allclose(felt_lame[:, 0], [1.0, 1.0, 0.0, 1.0], rtol=1e-5)
    push = Push(jnp.full((4, 1), 2.0))
    tick = jnp.float32(0.001)
    moved, contact = lame.advance(state, push, ground, tick)
    assert contact.stance_share[:, 0].tolist() == [1.0, 1.0, 0.0, 1.0]
    # 3 (1 N + 2 N) - 4 m g on 4 m, and the left hind leg's share of the moments is missing.
    assert float(moved.rate[0, 0]) == pytest.approx(0.001 * (9.0 / 0.4 - 9.81), rel=1e-2)
    assert float(moved.rate[1, 0]) > 0.0 > float(moved.rate[2, 0])
    lame_energy, intact_energy = (
        float(body.energy(state, ground)[0]) for body in (lame, Plate(present=(1, 1, 1, 1)))
    )
    assert intact_energy == float(intact.energy(state, ground)[0])
    assert intact_energy - lame_energy == pytest.approx(0.5 * 5.0 * 0.2**2, rel=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Plate(hips_x_m=0.5), "hips_x_m is 0.5; it must be numbers"),
        (
            lambda: Plate(hips_z_m=("a", 0, 0, 0)),
            "hips_z_m is 'a'; it must be a number",
        ),
        (
            lambda: Plate(hips_z_m=(math.nan, 0, 0, 0)),
            "hips_z_m is nan; it must be finite",
        ),
        (
            lambda: Plate(hips_x_m=(0.5, -0.5)),
            "hips_x_m names 2 hips and hips_z_m 4; every leg needs a place",
        ),
        (lambda: Plate(hips_x_m=(0.5, -0.5), hips_z_m=(0.3, -0.3)), "name three to eight places"),
        (
            lambda: Plate(hips_x_m=(0.1,) * 5 + (-0.1,) * 5, hips_z_m=(0.1, -0.1) * 5),
            "name three to eight places",
        ),
        (lambda: Plate(hips_x_m=(0.5, 0.5, -0.5, -0.4)), "hips_x_m .*whose mean is 0.025"),
        (lambda: Plate(hips_z_m=(0.3, 0.3, 0.3, -0.3)), "hips_z_m .*for the plate to rest level"),
        (lambda: Plate(hips_z_m=(0.0, 0.0, 0.0, 0.0)), "are in one line"),
        (lambda: Plate(hips_z_m=(0.3, 0.3, -0.3, -0.3)), "are in one line"),
        (
            lambda: Plate(twist_stiffness_nm_per_rad=1.0),
            "this plate does not twist; give it a twist_inertia_ratio",
        ),
        (
            lambda: Plate(
                hips_x_m=(0.6, 0.4, -0.6, -0.4),
                hips_z_m=(0.3, -0.3, -0.3, 0.3),
                twist_inertia_ratio=1.0,
            ),
            "have a mean x z of 0.03; it must be 0, for a spine to rest untwisted",
        ),
        (lambda: Plate(present=(1, 1, 1)), "present is .*; it must be 1 or 0 for each of 4 legs"),
        (lambda: Plate(present=(1, 1, 1, 0.5)), "present is .*; it must be 1 or 0"),
        (lambda: Bar(present=(0, 0)), "present is .*, and 1 for one"),
        (
            lambda: run(Plate(roll_inertia_ratio=1e-6)),
            "the control tick of 0.001 s is too long for this plate",
        ),
        (
            lambda: run(Plate(twist_inertia_ratio=1.0, twist_stiffness_nm_per_rad=1e6)),
            "the control tick of 0.001 s is too long for this plate",
        ),
        (
            lambda: run(Plate(), initial_pose={"yaw_rad": 0.1}),
            "Plate has no initial_pose 'yaw_rad'; it takes pitch_rad, .*roll_rate_rad_per_s",
        ),
        (
            lambda: run(Plate(), initial_pose={"twist_rad": 0.1}),
            "the release is twisted, and this plate does not twist",
        ),
        (
            lambda: Plate(max_force_n=0.5).check_release(1.2),
            "as a leg of this plate, this hopper cannot hop",
        ),
    ],
)
def test_what_cannot_be_is_said_in_one_line(make, message):
    refused(message, make)
