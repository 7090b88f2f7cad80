"""The torso that walks: its mechanics against closed forms, its symmetries, and what it refuses."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import (
    Controller,
    Rollout,
    Scenario,
    TegotaeError,
    Timing,
    check,
)
from tegotae.parts.bodies import Walker
from tegotae.parts.bodies.walker.mechanics import angles, from_angles, rotation
from tegotae.parts.controller import Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    EllipticFoot,
    LearnedFoot,
    VanillaAction,
    VanillaReaction,
)
from tegotae.parts.terrains import Rough, Slope, SplitGrip, Steps, Sum
from tegotae.simulation.schedules import Ramp, Step

C = Walker()
FOOT = EllipticFoot(stride_m=0.2, lift_m=0.12, press_m=0.03, shift_rad=0.4)
SIGMA = [1.25]
TICK = Timing(duration_s=30.0, tick_s=0.0125, frame_s=0.1)
WALK = 2.1  # rad per time unit
# In another order the same legs: left and right changed, front and hind as they were.
MIRRORED = (1, 0, 3, 2)


def controller(foot=FOOT, limbs=4, **options) -> Controller:
    vanilla = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    return Controller(foot, PhaseOscillator(), vanilla, limbs=limbs, **options)


WALKS = Rollout(controller=controller(), timing=TICK)
STANDS = Rollout(
    controller=controller(EllipticFoot(stride_m=0.0, lift_m=0.0, press_m=0.0)), timing=TICK
)
PHASES = np.random.default_rng(3).uniform(0.0, 2.0 * math.pi, (4, 3))


def run(rollout=WALKS, body=C, sigma=SIGMA, dtype="float64", **scenario):
    settings = {"omega": WALK, "height_m": C.standing_height_m + 0.05} | scenario
    return rollout.run(sigma, Scenario(**settings), body, dtype=dtype)


# Mechanics


@pytest.mark.thorough
def test_it_keeps_the_contract_of_a_body():
    check(C)


def test_at_rest_it_stands_as_high_as_its_springs_bear_it():
    path = run(STANDS, phase_rad=PHASES[:, :1], changes={"stiffness_z_n_per_m": [9.0, 14.0]})
    expected = 1.0 - 0.39 - 1.0 / (4.0 * np.array([9.0, 14.0]))
    np.testing.assert_allclose(path.height_m[-1], expected, atol=1e-6)
    np.testing.assert_allclose(path.spring_force_n[-1], 0.25, atol=1e-5)


def test_it_heaves_at_the_frequency_of_its_springs():
    body = dataclasses.replace(C, damping_z_ns_per_m=0.0)
    height = run(STANDS, body, height_m=body.standing_height_m + 0.002).height_m[:, 0]
    above = height > body.standing_height_m
    crossings = np.flatnonzero(above[1:] != above[:-1])
    half_turns = len(crossings) - 1
    rate = math.pi * half_turns / (0.1 * (crossings[-1] - crossings[0]))
    assert rate == pytest.approx(math.sqrt(4.0 * 14.0), rel=0.01)


def test_on_its_feet_the_energy_is_what_its_actuators_did():
    # Feet that never leave the ground nor slide, and next to no damping.
    body = dataclasses.replace(C, friction=50.0, damping_z_ns_per_m=0.0, damping_xy_ns_per_m=1e-6)
    sways = Rollout(
        controller=controller(EllipticFoot(stride_m=0.03, lift_m=0.0, press_m=0.0)),
        timing=dataclasses.replace(TICK, tick_s=0.0025, duration_s=10.0),
    )
    path = run(sways, body, phase_rad=PHASES, height_m=body.standing_height_m)
    assert (path.stands == 1.0).all()
    work = path.energy_j - path.energy_j[0]
    worked = path.work_net_j - path.work_net_j[0]
    assert np.ptp(worked, axis=0).min() > 1e-3
    np.testing.assert_allclose(work, worked, atol=2e-5)


def test_moving_a_leg_costs_what_its_mass_and_the_damping_of_its_joints_take():
    # Feet that go to and fro far above the ground: in a cycle ½ m (Bω)² four times, and π d B² ω.
    stride_m, omega = 0.2, 2.0
    turn_s = 2.0 * math.pi / omega
    sways = Rollout(
        controller=controller(EllipticFoot(stride_m=stride_m, lift_m=0.0, press_m=0.0)),
        timing=Timing(duration_s=4.0 * turn_s, tick_s=turn_s / 512, frame_s=turn_s),
    )

    def spent(**price):
        path = run(sways, dataclasses.replace(C, **price), sigma=[0.0], omega=omega, height_m=500.0)
        legs = 4 * round(float(path.time_s[-1, 0] - path.time_s[1, 0]) / turn_s)
        return (path.work_absolute_j[-1, 0] - path.work_absolute_j[1, 0]) / legs

    assert spent() == pytest.approx(0.0)
    assert spent(leg_mass_x_kg=0.3) == pytest.approx(2.0 * 0.3 * (stride_m * omega) ** 2, rel=1e-3)
    damped = spent(joint_damping_x_ns_per_m=0.7)
    assert damped == pytest.approx(math.pi * 0.7 * stride_m**2 * omega, rel=1e-3)
    assert spent(leg_mass_z_kg=0.3, joint_damping_z_ns_per_m=0.7) == pytest.approx(0.0)


def test_the_price_of_a_leg_moves_nothing():
    price = {"leg_mass_x_kg": 0.1, "leg_mass_z_kg": 0.1, "joint_damping_x_ns_per_m": 0.3}
    free, priced = run(), run(body=dataclasses.replace(C, **price))
    np.testing.assert_array_equal(free.x_m, priced.x_m)
    assert (priced.work_absolute_j[-1] > free.work_absolute_j[-1]).all()


def test_in_flight_angular_momentum_is_kept():
    state = C.release(jnp.array([9.0]), jnp.array([0.0]), roll_rate_rad_per_s=1.0)
    state = state._replace(turn=jnp.array([[1.0], [0.7], [-0.4]]))
    inertia = jnp.array([0.10, 0.24, 0.29])[:, None]
    still = jnp.zeros((2, 4, 1))

    def momentum(state):
        return np.array(rotation(state.attitude).to_world(tuple(inertia * state.turn)))

    @jax.jit
    def later(state):
        return jax.lax.fori_loop(
            0, 300, lambda _, s: C.advance(s, _push(still), jnp.zeros(1), 0.005)[0], state
        )

    end = later(state)
    assert not np.allclose(end.turn, state.turn, atol=0.1)
    np.testing.assert_allclose(momentum(end), momentum(state), rtol=1e-3)


def _push(place):
    from tegotae.parts.bodies import Push

    return Push(place)


def test_angles_and_quaternions_agree():
    expected = np.array([[0.3, -0.2], [0.5, -0.9], [2.0, -3.0]])
    np.testing.assert_allclose(angles(from_angles(*jnp.asarray(expected))), expected, atol=1e-6)


# Symmetries


def test_a_walk_turned_by_any_yaw_is_the_same_walk():
    turned = 1.1
    path = run(phase_rad=PHASES[:, :1], initial_pose={"yaw_rad": [0.0, turned]})
    x, y = path.x_m, path.y_m
    np.testing.assert_allclose(path.phase_rad[:, :, 1], path.phase_rad[:, :, 0], atol=1e-6)
    ahead = x[:, 0] * math.cos(turned) - y[:, 0] * math.sin(turned)
    np.testing.assert_allclose(x[:, 1], ahead, atol=1e-6)


@pytest.mark.thorough
def test_mirrored_phases_make_a_mirrored_walk():
    path = run(phase_rad=np.stack([PHASES[:, 0], PHASES[MIRRORED, 0]], axis=1))
    np.testing.assert_allclose(path.y_m[:, 1], -path.y_m[:, 0], atol=1e-6)
    np.testing.assert_allclose(path.x_m[:, 1], path.x_m[:, 0], atol=1e-6)


@pytest.mark.thorough
def test_the_order_of_the_legs_does_not_matter():
    order = (2, 0, 3, 1)
    reordered = dataclasses.replace(
        C,
        hips_x_m=tuple(C.hips_x_m[i] for i in order),
        hips_y_m=tuple(C.hips_y_m[i] for i in order),
    )
    first, second = run(phase_rad=PHASES), run(body=reordered, phase_rad=PHASES[list(order)])
    np.testing.assert_allclose(second.phase_rad, first.phase_rad[:, list(order)], atol=1e-6)


@pytest.mark.thorough
def test_a_body_in_other_units_walks_the_same_walk():
    # l0 0.2 m, 1.5 kg: the time unit is 0.143 s.
    length, mass, gravity = 0.2, 1.5, 9.81
    time, force = math.sqrt(length / gravity), mass * gravity
    units = {
        "_n_per_m": force / length,
        "_ns_per_m": force * time / length,
        "_kg_m2": mass * length**2,
        "_m": length,
    }
    scaled = {
        f.name: getattr(C, f.name) * next(u for end, u in units.items() if f.name.endswith(end))
        for f in dataclasses.fields(C)
        if f.name.endswith(tuple(units)) and not f.name.startswith(("hips", "gravity"))
    }
    scaled |= {n: tuple(length * x for x in getattr(C, n)) for n in ("hips_x_m", "hips_y_m")}
    robot = dataclasses.replace(C, **scaled, mass_kg=mass, gravity_m_per_s2=gravity)
    foot = EllipticFoot(stride_m=0.04, lift_m=0.024, press_m=0.006, shift_rad=0.4)
    rollout = Rollout(
        controller=controller(foot),
        timing=Timing(duration_s=30 * time, tick_s=0.0125 * time, frame_s=0.1 * time),
    )
    first = run(phase_rad=PHASES)
    second = run(
        rollout,
        robot,
        sigma=[1.25 / force / time],
        omega=WALK / time,
        phase_rad=PHASES,
        height_m=length * (C.standing_height_m + 0.05),
    )
    np.testing.assert_allclose(second.x_m, length * first.x_m, atol=1e-6)


# What it meets


@pytest.mark.thorough
def test_lanes_do_not_know_of_each_other_even_if_one_falls():
    falls = np.array([0.0, 1.2, 0.0])  # released on its side
    path = run(phase_rad=PHASES, initial_pose={"roll_rad": falls})
    assert path.failed[-1].tolist() == [False, True, False]
    for lane in (0, 2):
        alone = run(phase_rad=PHASES[:, lane : lane + 1])
        np.testing.assert_allclose(path.x_m[:, lane], alone.x_m[:, 0], atol=1e-9)
    np.testing.assert_array_equal(path.x_m[-1, 1], path.x_m[-2, 1])


@pytest.mark.thorough
def test_what_happens_at_a_time_changes_nothing_before_it():
    # One thing a lane, and nothing in the last one.
    happens = {
        "friction": 0.1,
        "push_y_n": 0.2,
        "com_x_m": 0.1,
        "mass_kg": 1.2,
        "present": np.array([[1.0], [1.0], [0.0], [1.0]]),
    }
    lanes = len(happens) + 1
    times = np.where(np.eye(len(happens), lanes) > 0.0, 15.0, np.inf)
    changes = {
        name: Step(value, from_s=time)
        for (name, value), time in zip(happens.items(), times, strict=True)
    }
    path = run(phase_rad=np.repeat(PHASES[:, :1], lanes, axis=1), changes=changes)
    early = path.time_s[:, 0] <= 15.0
    baseline = path.x_m[:, -1:]
    np.testing.assert_array_equal(path.x_m[early], np.broadcast_to(baseline, path.x_m.shape)[early])
    assert (np.abs(path.x_m[-1, :-1] - baseline[-1]) > 1e-4).all()


def test_a_lost_leg_bears_nothing_and_four_minus_one_falls():
    presence = np.array([[1.0], [1.0], [0.0], [1.0]])
    path = run(phase_rad=PHASES[:, :1], changes={"present": Step(presence, from_s=15.0)})
    upright = (path.time_s[:, 0] > 15.0) & ~path.failed[:, 0]
    assert (path.spring_force_n[upright, 2] == 0.0).all()
    assert path.failed[-1, 0]


@pytest.mark.thorough
def test_a_load_that_is_shifted_moves_the_mass_and_not_the_torso():
    path = run(STANDS, changes={"com_x_m": Step([0.0, 0.1], from_s=15.0)})
    step = np.flatnonzero(path.time_s[:, 0] > 15.0)[0]
    assert path.x_m[step, 1] - path.x_m[step - 1, 1] == pytest.approx(0.1, abs=2e-3)
    # Before the middle the front legs bear more: half and half by the lever.
    front = path.spring_force_n[-1, :2, 1].sum()
    assert front == pytest.approx(0.5 * (0.85 + 0.1) / 0.85, abs=0.02)


@pytest.mark.thorough
def test_a_push_in_flight_gives_its_impulse():
    path = run(height_m=30.0, changes={"push_y_n": Step(0.2, from_s=1.0, until_s=3.0)})
    speed = np.diff(path.y_m[:, 0]) / 0.1
    assert speed[5] == pytest.approx(0.0, abs=1e-12)
    assert speed[40] == pytest.approx(0.4, abs=1e-3)


def test_a_wind_that_rises_drives_a_walker_in_flight_as_its_force_says():
    path = run(height_m=30.0, changes={"push_x_n": Ramp(0.2, from_s=1.0, until_s=3.0)})
    speed = np.diff(path.x_m[:, 0]) / 0.1
    assert speed[5] == pytest.approx(0.0, abs=1e-12)
    assert speed[40] - speed[30] == pytest.approx(0.2 * 1.0, abs=1e-3)
    assert speed[30] == pytest.approx(0.2 * (1.0 + 0.15), abs=2e-3)


def test_a_ground_that_drops_lets_it_down_by_as_much():
    path = run(STANDS, drop_m=0.2, drop_time_s=10.0)
    assert path.height_m[90, 0] - path.height_m[-1, 0] == pytest.approx(0.2, abs=1e-5)


def test_on_a_slope_it_stands_if_friction_bears_it_and_slides_if_not():
    body = dataclasses.replace(C, terrain=Slope(along=0.2))
    path = run(STANDS, body, changes={"friction": [0.3, 0.1]})
    held, slides = path.slid_m[-1].mean(axis=0) - path.slid_m[150].mean(axis=0)
    assert held < 0.05 < 1.0 < slides
    # Down a frictionless plane the acceleration would be g sin a; friction takes μ g cos a.
    angle = math.atan(0.2)
    speed = -(path.x_m[-1, 1] - path.x_m[-11, 1]) / math.cos(angle)
    earlier_speed = -(path.x_m[-51, 1] - path.x_m[-61, 1]) / math.cos(angle)
    gained = (speed - earlier_speed) / 5.0
    assert gained == pytest.approx(math.sin(angle) - 0.1 * math.cos(angle), rel=0.1)


def test_feet_slide_on_the_side_without_grip_alone():
    ground = Sum(first=Slope(along=0.1), second=SplitGrip(right=0.0))
    left, right = run(STANDS, dataclasses.replace(C, terrain=ground)).slid_m[40, :2, 0]
    assert left < 0.05 < right


@pytest.mark.thorough
def test_it_climbs_a_step_and_crosses_rough_ground():
    step = dataclasses.replace(C, terrain=Steps(rise_m=0.05, tread_m=100.0, start_m=1.0))
    path, flat = run(body=step, phase_rad=PHASES), run(phase_rad=PHASES)
    up = path.height_m[-100:].mean(axis=0) - flat.height_m[-100:].mean(axis=0)
    over = path.x_m[-101] > 2.5
    assert over.any()
    np.testing.assert_allclose(up[over], 0.05, atol=0.01)
    rough = dataclasses.replace(C, terrain=Rough(rms_m=0.02))
    on_rough = run(WALKS, rough, phase_rad=PHASES, changes={"terrain.place": [0.0, 1.0, 2.0]})
    assert not on_rough.failed[-1].any()


@pytest.mark.parametrize("terrain", [Slope(), Steps(), Rough(), SplitGrip()])
def test_ground_of_no_height_is_flat_everywhere(terrain):
    places = jnp.asarray(np.random.default_rng(0).uniform(-9.0, 9.0, (2, 50)))
    ground = jax.jit(lambda x, y: (terrain.height_m(x, y), terrain.slopes(x, y)))(*places)
    assert not any(np.any(values) for values in jax.tree.leaves(ground))


@pytest.mark.thorough
def test_a_walk_on_a_slope_of_no_height_is_that_on_flat_ground():
    path = run(body=dataclasses.replace(C, terrain=Slope()), phase_rad=PHASES)
    np.testing.assert_allclose(path.x_m, run(phase_rad=PHASES).x_m, atol=1e-9)


# Gaits


def test_without_feedback_the_legs_keep_the_lags_that_they_began_with():
    path = run(sigma=[0.0], phase_rad=PHASES)
    lag = np.angle(np.exp(1j * (path.phase_rad - path.phase_rad[:, :1])))
    np.testing.assert_allclose(lag, np.broadcast_to(lag[:1], lag.shape), atol=1e-6)


def test_with_it_all_starts_come_to_one_gait():
    slow = dataclasses.replace(WALKS, timing=dataclasses.replace(TICK, duration_s=80.0))
    path = run(slow, dtype="float32", phase_rad=PHASES)
    assert not path.failed[-1].any()
    lag = (path.phase_rad[-100:] - path.phase_rad[-100:, :1]) / (2.0 * math.pi)
    mean = np.angle(np.exp(2j * math.pi * lag).mean(axis=0)) / (2.0 * math.pi) % 1.0
    # Left and right half a cycle apart, hind legs about a third of it after the front ones.
    np.testing.assert_allclose(mean[1], 0.5, atol=0.06)
    np.testing.assert_allclose((mean[3] - mean[2]) % 1.0, 0.5, atol=0.06)


@pytest.mark.thorough
def test_it_walks_with_any_number_of_legs_and_a_learned_foot():
    six = Walker(hips_x_m=(0.85, 0.85, 0.0, 0.0, -0.85, -0.85), hips_y_m=(0.44, -0.44) * 3)
    unit = controller(LearnedFoot(("phase", "feedback"), hidden=4), limbs=6)
    weights = np.concatenate([SIGMA, np.random.default_rng(0).normal(size=unit.n_weights - 1)])
    path = Rollout(controller=unit, timing=TICK).run(
        weights, Scenario(omega=WALK, height_m=0.6, phase_rad=np.zeros((6, 1))), six
    )
    assert path.foot_x_m.shape == (TICK.n_frames, 6, 1)
    assert np.isfinite(path.x_m).all()


# Misuse


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"hips_x_m": (0.5, -0.5)}, "hips_x_m places 2 legs and hips_y_m 4; each leg needs both"),
        ({"hips_x_m": ()}, "hips_x_m places 0 legs"),
        ({"hips_x_m": 3.0}, "hips_x_m is 3.0; it must be numbers"),
        ({"hips_y_m": (0.1, 0.1, math.nan, 0.1)}, "an entry of hips_y_m is nan"),
        ({"present": (1.0, 0.5, 1.0, 1.0)}, "present is .* 1 or 0 for each of 4 legs"),
        ({"present": (0.0,) * 4}, "present is .*, and 1 for one"),
        ({"inertia_z_kg_m2": 0.5}, "none of them can be larger than the two others together"),
        ({"stiffness_z_n_per_m": 0.4}, "4 legs give way by 0.625 m under this weight"),
        ({"com_z_m": -1.0}, "com_z_m is -1, which is on the ground"),
        ({"terrain": "flat"}, "terrain is 'flat'; it must be a Terrain"),
    ],
)
def test_a_body_that_cannot_be_is_refused_in_one_line(fields, says):
    refused(says, dataclasses.replace, C, **fields)


def test_a_tick_too_long_for_its_springs_is_refused():
    refused(r"the control tick of 0.1 s is too long.* use at most", C.check_tick, 0.1)


def test_a_leg_that_is_pushed_and_one_that_is_placed_do_not_go_together():
    from tegotae import Hopper
    from tegotae.simulation.loop import check_senses
    from tegotae.systems.recipe import recipe

    with pytest.raises(TegotaeError, match="Sector commands force, and a Walker takes foot_x and"):
        check_senses(dataclasses.replace(recipe("V-sector-w8").controller(), limbs=4), C)
    with pytest.raises(TegotaeError, match="EllipticFoot commands foot_x and foot_z"):
        check_senses(controller(limbs=1), Hopper())
