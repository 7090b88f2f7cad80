"""The hopper: exact motion in closed form, contacts inside the tick, energy, validation."""

import math
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp
from springs import Hertz, Proportional, Softening

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.parts.bodies import Contact, Push
from tegotae.parts.terms import Sector
from tegotae.simulation.integrators import push
from tegotae.systems.recipe import recipe

TICK_S = 0.001


@dataclass(frozen=True)
class Motion:
    """A body advanced tick by tick: arrays with an entry per tick, taken at its end."""

    time: np.ndarray
    height: np.ndarray
    velocity: np.ndarray
    contact: Contact


@partial(jax.jit, static_argnums=4)
def _advance(body, state, push, tick_s, ticks):
    def step(state, _):
        state, contact = body.advance(state, push, jnp.zeros_like(state.height), tick_s)
        return state, (state, contact)

    return jax.lax.scan(step, state, None, ticks)[1]


def advance(
    body: Hopper, height: float, velocity: float, duration: float, *, dtype="float64", force=0.0,
    rise=0.0, tick=TICK_S,
) -> Motion:  # fmt: skip
    with jax.enable_x64(dtype == "float64"):
        array = partial(jnp.asarray, dtype=dtype)
        body = jax.tree.map(array, body)
        state = body.release(array([height]), array([velocity]))
        push = Push(array([force]), array([rise]))
        ticks = round(duration / tick)
        state, contact = jax.tree.map(
            lambda x: np.asarray(x)[:, 0], _advance(body, state, push, array(tick), ticks)
        )
    return Motion(np.arange(1, ticks + 1) * tick, state.height, state.velocity, contact)


def stance(body: Hopper, x0: float, v0: float, force: float, t: np.ndarray):
    """Height over touchdown and velocity of m x'' = -k x - c x' + F - m g, in closed form."""
    m, k, c = body.mass_kg, body.stiffness_n_per_m, body.damping_ns_per_m
    offset = (force - m * body.gravity_m_per_s2) / k
    decay = 0.5 * c / m
    s = np.sqrt(complex(decay**2 - k / m))  # imaginary if underdamped
    cosh = np.cosh(s * t)
    sinh_s = np.sinh(s * t) / s if s else t
    a, b = x0 - offset, v0 + decay * (x0 - offset)
    x = offset + np.exp(-decay * t) * (a * cosh + b * sinh_s)
    v = np.exp(-decay * t) * (b * cosh + a * s**2 * sinh_s - decay * (a * cosh + b * sinh_s))
    return x.real, v.real


def apexes(motion: Motion, tick: float = TICK_S) -> tuple[np.ndarray, np.ndarray]:
    """Times and heights of the apexes."""
    indices = np.flatnonzero(~np.isnan(motion.contact.apex_share))
    return (indices + motion.contact.apex_share[indices]) * tick, motion.contact.apex_height_m[
        indices
    ]


# Closed forms.


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-12), ("float32", 2e-5)])
def test_flight_is_ballistic(dtype, tolerance):
    motion = advance(Hopper(), 1.5, 2.0, 0.5, dtype=dtype, force=3.0)
    t = motion.time
    np.testing.assert_allclose(motion.height, 1.5 + 2.0 * t - 0.5 * 9.81 * t**2, atol=tolerance)
    np.testing.assert_allclose(motion.velocity, 2.0 - 9.81 * t, atol=tolerance)
    assert not motion.contact.stance_share.any()
    assert not motion.contact.work_j.any()


def test_flight_damping_slows_the_fall_towards_its_terminal_velocity():
    body = Hopper(flight_damping_ns_per_m=0.05)
    motion = advance(body, 3.0, 1.0, 0.6)
    rate, t = 0.05 / 0.1, motion.time
    terminal = -9.81 / rate
    velocity = terminal + (1.0 - terminal) * np.exp(-rate * t)
    height = 3.0 + terminal * t + (1.0 - terminal) * (1.0 - np.exp(-rate * t)) / rate
    np.testing.assert_allclose(motion.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(motion.height, height, atol=1e-12)


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-11), ("float32", 1e-5)])
@pytest.mark.parametrize(
    "damping",
    [0.0, 0.2, 2.0 * math.sqrt(0.5), 2.0, 10.0],
    ids=["undamped", "underdamped", "critically-damped", "overdamped", "far-overdamped"],
)
def test_stance_is_a_damped_oscillator(damping, dtype, tolerance):
    body = Hopper(damping_ns_per_m=damping)
    motion = advance(body, 0.7, 0.1, 1.0, dtype=dtype, force=0.1)
    x, v = stance(body, -0.3, 0.1, 0.1, motion.time)
    assert x.max() < 0.0, "the case must stay in stance"
    np.testing.assert_allclose(motion.height, 1.0 + x, atol=tolerance)
    np.testing.assert_allclose(motion.velocity, v, atol=10 * tolerance)
    np.testing.assert_array_equal(motion.contact.stance_share, 1.0)


def test_a_force_that_rises_over_the_tick_is_advanced_exactly():
    body, force, rise = Hopper(), 1.0, 0.8
    motion = advance(body, 0.7, 0.1, TICK_S, force=force, rise=rise)

    def rate(t, state):
        x, v = state
        push = force + rise * (t / TICK_S - 0.5)
        return [v, (-5.0 * x - 0.2 * v + push) / 0.1 - 9.81]

    exact = solve_ivp(rate, (0, TICK_S), [-0.3, 0.1], method="DOP853", rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(motion.height[0], 1.0 + exact.y[0, -1], atol=1e-14)
    np.testing.assert_allclose(motion.velocity[0], exact.y[1, -1], atol=1e-12)


def test_a_sector_that_begins_inside_a_tick_displaces_the_body_as_it_does():
    """Force for the last 30 % of a tick: against a tick without it and a tick with it."""
    tick, sector = 0.01, Sector(start_rad=1.0, width_rad=1.0)
    without = advance(Hopper(), 0.8, 0.2, 0.7 * tick, tick=0.7 * tick)
    exact = advance(
        Hopper(), without.height[0], without.velocity[0], 0.3 * tick, force=4.0, tick=0.3 * tick
    )
    with jax.enable_x64(True):
        path = (jnp.asarray([x], "float64") for x in (0.93, 1.03, 5.0))
        displacement = push(sector, (), Hopper().max_force_n, jnp.zeros(1), *path)
        mean, rise = float(displacement.mean_n[0]), float(displacement.rise_n[0])
    assert mean == pytest.approx(0.3 * 4.0)
    moved = advance(Hopper(), 0.8, 0.2, tick, force=mean, rise=rise, tick=tick)
    without_rise = advance(Hopper(), 0.8, 0.2, tick, force=mean, tick=tick)
    error = abs(moved.height[0] - exact.height[0])
    assert error < 0.05 * abs(without_rise.height[0] - exact.height[0])
    assert moved.velocity[0] == pytest.approx(exact.velocity[0], abs=2e-4)


def test_touchdown_is_located_inside_the_tick():
    motion = advance(Hopper(), 1.2, 0.0, 0.3)
    fall = math.sqrt(2 * 0.2 / 9.81)
    (tick,) = np.flatnonzero(~np.isnan(motion.contact.touchdown_share))
    assert (tick + motion.contact.touchdown_share[tick]) * TICK_S == pytest.approx(fall, abs=1e-12)
    descended = motion.time > fall
    x, v = stance(Hopper(), 0.0, -9.81 * fall, 0.0, motion.time[descended] - fall)
    np.testing.assert_allclose(motion.height[descended], 1.0 + x, atol=1e-11)
    np.testing.assert_allclose(motion.velocity[descended], v, atol=1e-10)


def test_lift_off_is_located_inside_the_tick():
    motion = advance(Hopper(), 0.5, 0.0, 0.4, force=2.0)
    t = np.linspace(0.0, 0.4, 4_000_001)
    x, v = stance(Hopper(), -0.5, 0.0, 2.0, t)
    first = np.argmax(x > 0.0)
    descended = motion.time > t[first]
    flown = motion.time[descended] - t[first]
    expected = 1.0 + x[first] + v[first] * flown - 0.5 * 9.81 * flown**2
    np.testing.assert_allclose(motion.height[descended], expected, atol=1e-6)
    assert motion.contact.stance_share.sum() * TICK_S == pytest.approx(t[first], abs=2e-7)


def test_an_undamped_hopper_returns_to_its_release_for_ever():
    body = Hopper(damping_ns_per_m=0.0)
    motion = advance(body, 1.2, 0.0, 10.0)
    times, heights = apexes(motion)
    # Contact from x = 0, v = -v0 until x = 0 again: pi + 2 atan(g / (w v0)) of the oscillation.
    w, v0 = math.sqrt(50.0), math.sqrt(2 * 9.81 * 0.2)
    period = 2 * v0 / 9.81 + (math.pi + 2 * math.atan(9.81 / (w * v0))) / w
    np.testing.assert_allclose(heights, 1.2, atol=1e-9)
    np.testing.assert_allclose(times, period * np.arange(1, len(times) + 1), atol=1e-8)
    assert len(times) == int(10.0 / period)


def test_climbed_heights_add_up_to_the_hops():
    motion = advance(Hopper(damping_ns_per_m=0.0), 1.2, 0.0, 10.0)
    times, _ = apexes(motion)
    until = round(times[-1] / TICK_S) + 1
    hops = len(times)
    assert motion.contact.climb_flight_m[:until].sum() == pytest.approx(0.2 * hops, abs=1e-5)
    depth = motion.height.min()
    assert motion.contact.climb_m[:until].sum() == pytest.approx((1.2 - depth) * hops, abs=1e-4)


def test_the_release_itself_is_no_apex():
    for height in (1.2, 1.0):
        times, _ = apexes(advance(Hopper(), height, 0.0, 0.1))
        assert len(times) == 0


def test_a_throw_upwards_has_its_apex_where_mechanics_says():
    (time,), (height,) = apexes(advance(Hopper(), 1.2, 1.2345, 0.2))
    assert time == pytest.approx(1.2345 / 9.81, abs=1e-12)
    assert height == pytest.approx(1.2 + 1.2345**2 / (2 * 9.81), abs=1e-12)


def test_a_coarse_tick_moves_no_apex():
    _, fine = apexes(advance(Hopper(), 1.5, 0.0, 4.0))
    _, coarse = apexes(advance(Hopper(), 1.5, 0.0, 4.0, tick=0.01), 0.01)
    hops = fine > 1.01
    np.testing.assert_allclose(coarse[: hops.sum()], fine[hops], atol=1e-6)


# Energy and work.


def energy(body: Hopper, motion: Motion) -> np.ndarray:
    state = body.release(jnp.asarray(motion.height), jnp.asarray(motion.velocity))
    return np.asarray(body.energy(state, jnp.zeros_like(state.height)))


def test_energy_is_kinetic_plus_potential_plus_elastic():
    body = Hopper()
    state = body.release(jnp.array([1.2, 0.8, 0.6]), jnp.array([1.0, -2.0, 0.0]))
    expected = [
        0.05 * 1.0 + 0.981 * 1.2,
        0.05 * 4.0 + 0.981 * 0.8 + 2.5 * 0.1**2,
        0.981 * 0.6,
    ]
    ground = jnp.array([0.0, -0.1, -0.5])
    np.testing.assert_allclose(body.energy(state, ground), expected, rtol=1e-6)


def test_without_damping_the_energy_gained_is_the_work_done():
    body = Hopper(damping_ns_per_m=0.0)
    with jax.enable_x64(True):
        motion = advance(body, 0.9, 0.0, 3.0, force=1.5)
        gained = energy(body, motion) - (0.981 * 0.9 + 2.5 * 0.1**2)
    np.testing.assert_allclose(np.cumsum(motion.contact.work_j), gained, atol=1e-9)


def test_damping_takes_energy_and_never_gives_any():
    with jax.enable_x64(True):
        loss = -np.diff(energy(Hopper(), advance(Hopper(), 1.2, 0.0, 3.0)))
    assert loss.min() > -1e-10
    assert loss.sum() > 0.1


WITHOUT_ACTUATOR = Rollout(
    controller=recipe("V-reflex-w4").controller(), timing=Timing(duration_s=2.0, frame_s=0.01)
)
"""Rollout without actuation: with a gain of zero the reflex never pushes."""

hoppers = st.builds(
    Hopper,
    mass_kg=st.floats(0.02, 5.0),
    stiffness_n_per_m=st.floats(1.0, 500.0),
    damping_ns_per_m=st.floats(0.0, 2.0),
    rest_length_m=st.floats(0.3, 2.0),
    gravity_m_per_s2=st.floats(1.0, 20.0),
    max_force_n=st.floats(0.1, 20.0),
    flight_damping_ns_per_m=st.floats(0.0, 0.5),
)
releases = st.tuples(st.floats(0.4, 2.5), st.floats(-3.0, 3.0))


@given(body=hoppers, releases=st.lists(releases, min_size=8, max_size=8))
def test_energy_is_never_created_without_the_actuator(body, releases):
    share, velocity = np.array(releases).T
    out = WITHOUT_ACTUATOR.run(
        [[0.0]],
        Scenario(omega=5.0, height_m=share * body.rest_length_m, velocity_m_per_s=velocity),
        body,
        dtype="float64",
    )
    scale = np.abs(out.energy_j[0]) + body.weight_n * body.rest_length_m
    assert (np.diff(out.energy_j, axis=0) <= 1e-10 * scale).all()
    assert not out.work_absolute_j.any()
    assert not out.impulse_ns.any()


# Dry friction of the leg.

RUBBING = Hopper(damping_ns_per_m=0.0, leg_friction_n=0.2)
"""An oscillator in stance of which each half cycle is shorter by 2 f / k = 0.08 m."""
REST_M = 1.0 - RUBBING.weight_n / RUBBING.stiffness_n_per_m


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_dry_friction_shortens_each_half_cycle_by_the_same_length_and_then_holds(dtype):
    motion = advance(RUBBING, REST_M - 0.15, 0.0, 3.0, dtype=dtype)
    half_cycle_s = math.pi / RUBBING.natural_frequency_rad_per_s
    for time_s, height_m in ((half_cycle_s, 0.07), (2.0 * half_cycle_s, 0.01)):
        index = round(time_s / TICK_S)
        assert motion.height[index] == pytest.approx(REST_M + height_m, abs=2e-4)
    held = motion.height[motion.time > 2.1 * half_cycle_s]
    assert np.ptp(held) < 1e-6
    assert held[0] == pytest.approx(REST_M + 0.01, abs=2e-4)


def test_a_leg_that_its_friction_holds_stays_where_it_is():
    motion = advance(RUBBING, REST_M + 0.03, 0.0, 1.0)
    np.testing.assert_allclose(motion.height, REST_M + 0.03, atol=1e-12)
    moved = advance(RUBBING, REST_M - 0.03, 0.0, 1.0, force=0.06)
    assert moved.height[-1] > REST_M - 0.029, "the spring has 0.15 N, the actuator 0.06 N"


def test_dry_friction_takes_energy_from_every_hop_and_none_from_flight():
    motion = advance(RUBBING, 1.2, 0.0, 3.0)
    _, heights = apexes(motion)
    assert (np.diff([1.2, *heights]) < 0.0).all()
    falling = advance(RUBBING, 1.5, 2.0, 0.5)
    np.testing.assert_array_equal(falling.height, advance(Hopper(), 1.5, 2.0, 0.5).height)


# Springs of another law.


def solved(body: Hopper, height: float, force: float, times: np.ndarray) -> np.ndarray:
    """Heights by an independent solver, which stops at every touchdown and lift-off."""

    def moving(stance: bool):
        def rates(_, state):
            y, v = state
            depth = max(body.rest_length_m - y, 0.0)
            leg = float(body.spring(depth)) - body.damping_ns_per_m * v + force if stance else 0.0
            return [v, leg / body.mass_kg - body.gravity_m_per_s2]

        return rates

    def crossing(_, state):
        return state[0] - body.rest_length_m

    crossing.terminal = True
    start, state, stance, pieces = 0.0, [height, 0.0], False, []
    while start < times[-1]:
        crossing.direction = 1.0 if stance else -1.0
        piece = solve_ivp(
            moving(stance), (start, times[-1]), state, "DOP853", rtol=1e-10, atol=1e-12,
            events=crossing, dense_output=True,
        )  # fmt: skip
        pieces.append((piece.t[-1], piece.sol))
        start, state, stance = piece.t[-1], piece.y[:, -1], not stance
    ends = [end for end, _ in pieces]
    return np.array([pieces[np.searchsorted(ends, t)][1](t)[0] for t in times])


@pytest.mark.parametrize("force", [0.0, 1.5])
@pytest.mark.parametrize("kind", [Hertz, Softening])
def test_a_spring_of_another_law_moves_as_an_independent_solver_says(kind, force):
    body = kind(damping_ns_per_m=0.05)
    motion = advance(body, 1.2, 0.0, 2.0, force=force)
    assert np.isfinite(motion.contact.touchdown_share).sum() >= 2
    expected = solved(body, 1.2, force, motion.time)
    np.testing.assert_allclose(motion.height, expected, atol=1e-6)


def test_the_hoppers_law_written_once_more_moves_as_the_hopper():
    rewritten, original = (advance(x, 1.2, 0.0, 3.0, force=1.5) for x in (Proportional(), Hopper()))
    np.testing.assert_allclose(rewritten.height, original.height, atol=1e-9)
    for name, mine in rewritten.contact._asdict().items():
        theirs = getattr(original.contact, name)
        if theirs is not None:
            np.testing.assert_allclose(mine, theirs, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("kind", [Hertz, Softening])
def test_the_energy_of_another_spring_is_the_work_done_on_it(kind):
    body = kind(damping_ns_per_m=0.0)
    with jax.enable_x64(True):
        motion = advance(body, 1.1, 0.0, 3.0, force=1.5)
        gained = energy(body, motion) - 0.981 * 1.1
    np.testing.assert_allclose(np.cumsum(motion.contact.work_j), gained, atol=2e-5)


@pytest.mark.parametrize("kind", [Hertz, Softening, Proportional])
def test_the_depth_of_a_leg_is_that_at_which_its_spring_has_the_force(kind):
    body = kind()
    depth = np.linspace(0.0, 0.9, 7)
    np.testing.assert_allclose(body.depth(body.spring(depth)), depth, atol=1e-4)


def test_how_far_a_landing_presses_another_spring_is_where_it_turns():
    body = Hertz(max_force_n=2.0)
    lowest = advance(body, 1.3, 0.0, 0.6, force=2.0).height.min()
    assert body._landing_depth_m(1.3) == pytest.approx(1.0 - lowest, abs=1e-4)
    with pytest.raises(TegotaeError, match="breaks its leg"):
        Hertz(max_force_n=1.0, damping_ns_per_m=0.0).check_release(12.0)


@dataclass(frozen=True, kw_only=True)
class Preloaded(Hopper):
    """A spring that pushes before it is pressed."""

    def spring(self, depth):
        return 0.5 + self.stiffness_n_per_m * depth


@dataclass(frozen=True, kw_only=True)
class Buckling(Hopper):
    """A spring that pushes less where it is pressed more."""

    def spring(self, depth):
        return depth * (1.0 - depth)


@pytest.mark.parametrize("kind", [Preloaded, Buckling])
def test_a_spring_that_does_not_rise_from_zero_is_refused(kind):
    refused(r"spring gives .* must begin at 0 and increase", kind)


# What the body feels and predicts.


def test_the_hopper_feels_its_spring_its_velocity_and_its_height_over_ground():
    body = Hopper()
    state = body.release(jnp.array([1.2, 0.9, 0.9]), jnp.array([0.5, -1.0, 0.0]))
    felt = body.sense(state, jnp.array([0.0, 0.0, -0.2]))
    np.testing.assert_allclose(felt.values["spring_force"], [0.0, 0.5, 0.0], atol=1e-6)
    np.testing.assert_allclose(felt.values["velocity"], [0.5, -1.0, 0.0])
    np.testing.assert_allclose(felt.values["height"], [1.2, 0.9, 1.1], atol=1e-6)
    assert set(felt.values) == set(felt.scales) == set(Hopper.SENSES)
    assert felt.scales["spring_force"] == pytest.approx(0.981)
    assert float(felt.scales["velocity"]) == pytest.approx(math.sqrt(9.81))
    assert felt.scales["height"] == 1.0


def test_the_leg_has_failed_when_no_length_is_left():
    body = Hopper()
    state = body.release(jnp.array([0.1, 0.0, -0.1, -0.1]), jnp.zeros(4))
    failed = body.failed(state, jnp.array([0.0, 0.0, 0.0, -0.2]))
    np.testing.assert_array_equal(failed, [False, True, True, False])


def test_a_push_that_is_cut_by_lift_off_works_only_in_stance():
    motion = advance(Hopper(), 0.999, 2.0, TICK_S, force=4.0)
    share = motion.contact.stance_share[0]
    assert 0.4 < share < 0.6
    assert motion.contact.work_j[0] == pytest.approx(4.0 * 0.001, rel=1e-6)


@pytest.mark.parametrize("height", [0.8, 1.3])
def test_the_prediction_is_of_second_order(height):
    def error(tick: float) -> float:
        with jax.enable_x64(True):
            array = partial(jnp.asarray, dtype="float64")
            state = Hopper().release(array([height]), array([-0.7]))
            force, ground = array([1.0]), array([0.0])
            guess, begin, end = Hopper().predict(state, force, ground, array(tick))
            exact, _ = Hopper().advance(state, Push(force), ground, array(tick))
            assert (begin[0], end[0]) == ((0.0, 1.0) if height < 1.0 else (1.0, 1.0))
            return abs(float(guess.velocity[0] - exact.velocity[0]))

    assert error(1e-3) <= 1.05 * error(2e-3) / 4 + 1e-13


def test_the_prediction_knows_which_part_of_a_crossing_tick_is_stance():
    body, tick = Hopper(), jnp.asarray(TICK_S)
    state = body.release(jnp.array([0.999, 1.001]), jnp.array([2.0, -2.0]))
    _, begin, end = body.predict(state, jnp.zeros(2), jnp.zeros(2), tick)
    np.testing.assert_allclose(begin, [0.0, 0.5], atol=0.01)
    np.testing.assert_allclose(end, [0.5, 1.0], atol=0.01)


# Misuse.


@pytest.mark.parametrize(
    "body",
    [Hopper(stiffness_n_per_m=1e5), Hopper(damping_ns_per_m=40.0), Hertz(stiffness_n_per_m=1e5)],
    ids=["stiff", "heavily-damped", "stiff at its end"],
)
def test_a_tick_too_long_for_the_body_is_refused_with_one_that_is_short_enough(body):
    with pytest.raises(TegotaeError, match=r"tick of 0.001 s is too long.*use at most") as raised:
        body.check_tick(0.001)
    assert "\n" not in str(raised.value)
    body.check_tick(float(str(raised.value).split("at most ")[1].split(" s")[0]) * 0.99)


def test_another_mass_is_no_reason_to_compile_anew():
    advance(Hopper(), 1.2, 0.0, 0.01)
    programs = _advance._cache_size()
    advance(Hopper(mass_kg=0.2, damping_ns_per_m=0.0), 1.2, 0.0, 0.01)
    assert _advance._cache_size() == programs


@pytest.mark.parametrize(("dtype", "remainder"), [("float64", 1e-10), ("float32", 3e-7)])
@pytest.mark.parametrize("body", [Hopper(), Hopper(damping_ns_per_m=1.5)], ids=["paper", "damped"])
def test_the_advance_is_exact_at_the_longest_tick_allowed(body, dtype, remainder):
    """To what the series may leave out; in float32 to its rounding, too."""
    rate = max(body.natural_frequency_rad_per_s, body.damping_ns_per_m / body.mass_kg)
    tick_s = 0.0999 / rate
    body.check_tick(tick_s)
    motion = advance(body, 0.7, 1.0, tick_s, tick=tick_s, dtype=dtype)
    x, v = stance(body, -0.3, 1.0, 0.0, np.array([tick_s]))
    size = rate * 1.7 + 1.0  # of the motion about its rest, which is 1.7 m away
    assert abs(motion.height[0] - 1.0 - x[0]) < remainder * size / rate
    assert abs(motion.velocity[0] - v[0]) < remainder * size
