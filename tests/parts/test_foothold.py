"""A leg that is placed and stands: Raibert's placement, the swing to it, the stance at a speed."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tegotae.parts.oscillators import FootholdOscillator, raibert_placement
from tegotae.parts.scaled import ScaledOscillator
from tegotae.parts.terms import PlacedFoot, Signals
from tegotae.parts.units import Units

CLOCK = FootholdOscillator(settle_s=0.02, most_m_per_s2=1e3)
TICK_S = 1e-3
OMEGA = 10.0


def walked(clock, *, velocity, commanded, weights=(0.1, 0.2, 0.0, 0.0), seconds=4.0, omega=OMEGA):
    """States of a leg at all ticks, whose body has a velocity and a command, x and y each."""
    sensed = dict(zip(clock.READS, map(jnp.asarray, (*velocity, *commanded)), strict=True))
    weights = tuple(jnp.float32(x) for x in weights)

    def tick(state, _):
        rate = clock.rate(state, omega, 0.0, weights, signals=Signals(sensed))
        state = clock.settle(jax.tree.map(lambda x, dx: x + TICK_S * dx, state, rate))
        return state, state

    _, states = jax.lax.scan(tick, clock.start(jnp.float32(0.0)), None, round(seconds / TICK_S))
    return jax.tree.map(np.asarray, states)


def test_a_body_at_its_commanded_speed_passes_as_far_behind_a_foot_as_it_came_before_it():
    assert raibert_placement(0.8, 0.8, 0.25, 0.3) == pytest.approx(0.1)
    half_m = 0.5 * 0.8 * np.pi / OMEGA
    states = walked(CLOCK, velocity=(0.8, -0.8), commanded=(0.8, -0.8))
    late = slice(2000, None)
    for place in (states.foothold_x[late], -states.foothold_y[late]):
        assert place.max() == pytest.approx(half_m, rel=0.03)
        assert place.min() == pytest.approx(-half_m, rel=0.03)


def test_a_standing_foot_moves_the_body_at_the_commanded_speed_whatever_its_own_speed():
    states = walked(CLOCK, velocity=(0.1, 0.0), commanded=(0.5, -0.3))
    stands = (np.sin(states.phase[:-1]) < 0.0) & (np.sin(states.phase[1:]) < 0.0)
    stands[:1000] = False
    for place, speed in ((states.foothold_x, 0.5), (states.foothold_y, -0.3)):
        assert np.diff(place)[stands] / TICK_S == pytest.approx(-speed, abs=1e-3)


def test_a_foot_swings_by_half_a_cosine_to_its_place_and_touches_down_there():
    states = walked(CLOCK, velocity=(1.0, 0.2), commanded=(0.6, 0.0), seconds=np.pi / OMEGA)
    stance_s = np.pi / OMEGA
    for place, goal in (
        (states.foothold_x, raibert_placement(1.0, 0.6, stance_s, 0.1)),
        (states.foothold_y, raibert_placement(0.2, 0.0, stance_s, 0.2)),
    ):
        early = states.phase < 2.0
        expected = float(goal) * 0.5 * (1.0 - np.cos(states.phase))
        assert place[early] == pytest.approx(expected[early], abs=0.03 * float(goal))
        assert place[-1] == pytest.approx(float(goal), rel=0.02)


def test_a_leg_that_lags_behind_pushes_the_more_up_to_a_bound():
    clock = dataclasses.replace(CLOCK, most_lag_m=0.2)
    states = walked(clock, velocity=(0.4, 0.0), commanded=(0.5, 0.0), weights=(0.1, 0.2, 2.0, 0.0))
    assert states.lag_x[1499] - states.lag_x[499] == pytest.approx(0.1, rel=0.01)
    assert states.lag_x[-1] == pytest.approx(0.2)
    stands = np.flatnonzero(np.sin(states.phase[3000:-1]) < -0.5) + 3000
    assert np.diff(states.foothold_x)[stands] / TICK_S == pytest.approx(-0.9, abs=1e-3)
    assert states.lag_y == pytest.approx(0.0, abs=1e-6)


def test_a_command_is_approached_no_faster_than_the_leg_may():
    clock = dataclasses.replace(CLOCK, most_m_per_s2=0.5)
    states = walked(clock, velocity=(0.0, 0.0), commanded=(1.0, -0.2))
    assert states.pace_x[[499, 999]] == pytest.approx([0.25, 0.5], rel=1e-3)
    assert states.pace_x[-1] == pytest.approx(1.0, rel=1e-3)
    assert states.pace_y[999] == pytest.approx(-0.2, rel=1e-3)


def test_a_calibrated_leg_paces_faster_and_does_not_count_that_as_lag():
    weights = (0.1, 0.2, 2.0, 0.25)
    states = walked(CLOCK, velocity=(0.4, 0.0), commanded=(0.4, 0.0), weights=weights)
    assert states.pace_x[-1] == pytest.approx(0.5, rel=1e-3)
    assert abs(states.lag_x[-1]) < 0.01


def test_a_placed_foot_is_lifted_in_swing_presses_in_stance_and_levels_its_corner_of_the_torso():
    foot = PlacedFoot()
    tilt = dict(zip(foot.TILT, jnp.array([0.1, 0.2, -0.3, 0.4]), strict=True))
    sensed = {"foothold_x": jnp.array(0.05), "foothold_y": jnp.array(-0.02), **tilt}
    weights = jnp.array([0.08, 0.01, 0.02, 1.0, 0.5, 0.2, 0.1, 0.06])
    for sine, lift in ((0.5, 0.04), (-0.5, -0.03)):
        ahead, up, left = foot(weights, Signals({**sensed, "sin_phase": jnp.array(sine)}))
        assert (ahead, left) == (pytest.approx(0.06), pytest.approx(-0.02))
        assert up == pytest.approx(0.02 + lift + 0.1 + 0.1 - 0.06 + 0.04)


def test_a_leg_in_si_does_the_same_in_proportion():
    units = Units(length_m=0.5, time_s=0.25)
    weights = (0.1, 0.2, 1.0, 0.0)
    reference = walked(CLOCK, velocity=(0.5, 0.1), commanded=(0.6, 0.0), weights=weights)
    ticks = 400

    clock, speed = ScaledOscillator(CLOCK, units), units.value_of("odometry_x")
    sensed = dict(zip(CLOCK.READS, speed * jnp.array([0.5, 0.1, 0.6, 0.0]), strict=True))
    weights = tuple(map(jnp.float32, weights))
    state = clock.start(jnp.float32(0.0))
    for _ in range(ticks):
        rate = clock.rate(state, OMEGA / 0.25, 0.0, weights, signals=Signals(sensed))
        state = clock.settle(jax.tree.map(lambda x, dx: x + 0.25 * TICK_S * dx, state, rate))
    expected = [x[ticks - 1] for x in reference]
    assert [float(x) for x in state] == pytest.approx(expected, rel=1e-3, abs=1e-5)
