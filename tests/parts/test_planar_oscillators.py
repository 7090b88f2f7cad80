"""Hopf, van der Pol and Matsuoka oscillators: what the literature says of them, by themselves."""

import math
from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing, check
from tegotae.parts.oscillators import (
    OSCILLATORS,
    PLANAR,
    AdaptiveHopf,
    Hopf,
    Learned,
    Matsuoka,
    PhaseOscillator,
    VanDerPol,
    oscillator_named,
)
from tegotae.parts.oscillators.planar import period_ratio
from tegotae.systems.recipe import recipe

STEP_S = 0.005
OMEGA = 6.0


def silence(t, phase):
    return jnp.zeros_like(phase)


@partial(jax.jit, static_argnames=("oscillator", "steps", "feedback"))
def _followed(oscillator, omega, weights, steps, feedback):
    arguments = (weights,) if weights else ()

    def rate(state, t):
        return oscillator.rate(state, omega, feedback(t, state[0]), *arguments)

    def step(state, t):
        def ahead(rates, by):
            return jax.tree.map(lambda x, dx: x + by * dx, state, rates)

        k1 = rate(state, t)
        k2 = rate(ahead(k1, STEP_S / 2), t + STEP_S / 2)
        k3 = rate(ahead(k2, STEP_S / 2), t + STEP_S / 2)
        k4 = rate(ahead(k3, STEP_S), t + STEP_S)
        mean = jax.tree.map(lambda a, b, c, d: (a + 2 * b + 2 * c + d) / 6, k1, k2, k3, k4)
        state = ahead(mean, STEP_S)
        return state, state

    start = oscillator.start(jnp.full_like(omega, 0.3))
    return jax.lax.scan(step, start, STEP_S * jnp.arange(steps, dtype=omega.dtype))[1]


def followed(oscillator, omega=(OMEGA,), *, weights=(), duration_s=40.0, feedback=silence):
    """The state of an oscillator by itself after each step, arrays [steps, lanes], float64."""
    with jax.enable_x64(True):
        lanes = np.broadcast_shapes(np.shape(omega), *(np.shape(w) for w in weights))
        frequencies = jnp.broadcast_to(jnp.asarray(omega, float), lanes)
        rows = tuple(jnp.broadcast_to(jnp.asarray(w, float), lanes) for w in weights)
        steps = round(duration_s / STEP_S)
        return jax.tree.map(np.asarray, _followed(oscillator, frequencies, rows, steps, feedback))


def frequency(phase):
    """Mean frequency over the whole turns in the second half [rad/s], lane by lane."""
    result = []
    for lane in phase[len(phase) // 2 :].T:
        turns = np.floor((lane[-1] - lane[0]) / (2 * np.pi))
        last = np.interp(lane[0] + 2 * np.pi * turns, lane, np.arange(len(lane)))
        result.append(2 * np.pi * turns / (last * STEP_S))
    return np.array(result)


@pytest.mark.parametrize("name", [name for name in OSCILLATORS if name.startswith("learned")])
def test_every_oscillator_keeps_the_contract(name):
    check(OSCILLATORS[name])


@pytest.mark.parametrize("name", [name for name in OSCILLATORS if not name.startswith("learned")])
def test_left_alone_it_runs_at_the_prescribed_frequency(name):
    result = frequency(followed(oscillator_named(name), (3.0, 8.0))[0])
    np.testing.assert_allclose(result, (3.0, 8.0), rtol=0.01)


# Hopf


def test_a_hopf_oscillator_comes_to_the_radius_of_the_root_of_mu():
    hopf = Hopf(mu=4.0, recovery_per_s=1.0)
    np.testing.assert_allclose(followed(hopf, duration_s=8.0).radius[-1], 2.0, rtol=1e-6)


def test_a_hopf_oscillator_drives_a_hopper_as_the_phase_oscillator_does():
    timing = Timing(duration_s=10.0)
    plain, hopf = (
        Rollout(controller=recipe(name).controller(), timing=timing).run(
            [[2.0], [4.0]], Scenario(omega=8.0)
        )
        for name in ("V-sector-w8", "V-sector-w8+hopf")
    )
    for name, recorded in plain.channels.items():
        np.testing.assert_allclose(recorded, hopf.channels[name], atol=1e-4, err_msg=name)
    np.testing.assert_allclose(hopf.radius, 1.0, rtol=1e-6)


@pytest.mark.parametrize("oscillator", [PhaseOscillator(), Hopf()], ids=str)
def test_a_sinusoid_that_turns_it_locks_it_within_adlers_range(oscillator):
    driving, strength = 6.0, 0.5

    def feedback(t, phase):
        return strength * jnp.sin(driving * t - phase)

    detuning = np.array([-0.6, -0.45, 0.0, 0.45, 0.6])
    phase = followed(oscillator, driving + detuning, duration_s=120.0, feedback=feedback)[0]
    late = len(phase) // 2
    mean = (phase[-1] - phase[late]) / ((len(phase) - late - 1) * STEP_S) - driving
    np.testing.assert_allclose(mean[1:4], 0.0, atol=1e-6)
    beat = math.sqrt(0.6**2 - strength**2)
    np.testing.assert_allclose(mean[[0, 4]], [-beat, beat], rtol=0.1)


def test_an_input_locks_it_within_half_of_that_range():
    # Of cos Ωt in one equation only the half that turns with the oscillator acts: |Δω| < F / 2r.
    driving, strength = 6.0, 0.6

    def feedback(t, phase):
        return strength * jnp.cos(driving * t) * jnp.ones_like(phase)

    pushed = Hopf(turn=0.0, push=1.0)
    detuning = np.array([-0.36, -0.24, 0.24, 0.36])
    phase = followed(pushed, driving + detuning, duration_s=120.0, feedback=feedback).phase
    late = len(phase) // 2
    mean = (phase[-1] - phase[late]) / ((len(phase) - late - 1) * STEP_S) - driving
    np.testing.assert_allclose(mean[1:3], 0.0, atol=0.01)
    assert np.all(np.abs(mean[[0, 3]]) > 0.1)


def test_an_adaptive_hopf_oscillator_takes_on_the_frequency_of_its_input():
    driving = 7.0

    def feedback(t, phase):
        return 2.0 * jnp.cos(driving * t) * jnp.ones_like(phase)

    pushed = AdaptiveHopf(turn=0.0, push=1.0, learning_per_s=1.0)
    result = followed(pushed, (5.0, 7.5, 9.0), duration_s=120.0, feedback=feedback)
    learned = np.array([5.0, 7.5, 9.0]) + result.shift_rad_per_s[-4000:].mean(axis=0)
    np.testing.assert_allclose(learned, driving, rtol=0.01)


# Van der Pol


def cartesian(oscillator, state, omega):
    """Velocity of (x, y) that follows from the rates of phase and radius."""
    still = np.zeros_like(state[0])
    rate = jax.jit(oscillator.rate)(state, still + omega, still)
    sine, cosine, radius = np.sin(state[0]), np.cos(state[0]), state[1]
    turning, growing = np.asarray(rate[0]), np.asarray(rate[1])
    return (radius * cosine, radius * sine), (
        growing * cosine - radius * sine * turning,
        growing * sine + radius * cosine * turning,
    )


def test_in_polar_coordinates_it_is_van_der_pols_equation():
    oscillator, omega = VanDerPol(mu=1.5), 3.0
    with jax.enable_x64(True):
        state = VanDerPol.State(np.linspace(0.0, 6.0, 7), 0.4 + 0.1 * np.arange(7.0))
        (x, y), (x_rate, y_rate) = cartesian(oscillator, state, omega)
    speed = period_ratio(1.5) * omega
    z, z_rate = 2.0 * x, -2.0 * y  # in van der Pol's own variable and time
    np.testing.assert_allclose(2.0 * x_rate / speed, z_rate, atol=1e-9)
    np.testing.assert_allclose(-2.0 * y_rate / speed, 1.5 * (1 - z**2) * z_rate - z, atol=1e-9)


def test_its_amplitude_is_two_and_its_period_that_of_the_series_and_of_the_whole_range():
    mu = np.array([0.1, 0.3, 1.0, 1.9])
    share = np.log(mu / 0.05) / np.log(2.0 / 0.05)
    weight = np.log(share / (1.0 - share))  # from the middle of the range
    middle = Learned(VanDerPol(mu=math.sqrt(0.05 * 2.0)))
    result = followed(middle, weights=(0.0, 0.0, 0.0, weight), duration_s=100.0)
    np.testing.assert_allclose(frequency(result.phase), OMEGA, rtol=0.003)
    late = result.radius[-1600:] * np.cos(result.phase[-1600:])
    np.testing.assert_allclose(2.0 * late.max(axis=0), 2.0, rtol=0.012)
    small = np.array([0.0, 0.1, 0.3])
    np.testing.assert_allclose(period_ratio(small), 1 + small**2 / 16, rtol=1e-4)


# Matsuoka


def test_in_polar_coordinates_it_is_matsuokas_pair_of_neurons():
    half_centre, omega = Matsuoka(slowness=1.5, adaptation=3.0), 4.0
    a, b = half_centre.inhibition, half_centre.adaptation
    with jax.enable_x64(True):
        state = Matsuoka.State(np.linspace(0.1, 6.0, 9), *np.full((3, 9), [[0.7], [0.1], [0.2]]))

        @jax.jit
        def neurons_and_rates(state):
            rate = half_centre.rate(state, jnp.full(9, omega), jnp.zeros(9))
            neurons = half_centre.neurons
            return jax.jvp(lambda *values: neurons(values), tuple(state), tuple(rate))

        neurons, rates = jax.tree.map(np.asarray, neurons_and_rates(state))
    u1, u2, v1, v2 = neurons
    tau = half_centre.cycle().omega / omega
    y1, y2 = np.maximum(u1, 0.0), np.maximum(u2, 0.0)
    assert (y1 == 0.0).any()
    assert (y1 > 0.0).any()
    expected = (
        (-u1 - b * v1 - a * y2 + 1.0) / tau,
        (-u2 - b * v2 - a * y1 + 1.0) / tau,
        (y1 - v1) / (1.5 * tau),
        (y2 - v2) / (1.5 * tau),
    )
    np.testing.assert_allclose(rates, expected, atol=1e-6)


def test_matsuokas_frequency_holds_to_8_percent_and_his_amplitude_to_13_in_the_ranges_allowed():
    # A weight far from 0 is a parameter at its bound.
    corners = np.array(np.meshgrid([-9.0, 0.0, 9.0], [-9.0, 9.0], [-9.0, 0.0, 9.0])).reshape(3, -1)
    learned = Learned(Matsuoka())
    result = followed(learned, weights=(0.0, 0.0, 0.0, *corners), duration_s=60.0)
    np.testing.assert_allclose(frequency(result.phase), OMEGA, rtol=0.08)
    x = (result.radius * np.cos(result.phase))[-1600:].max(axis=0)
    np.testing.assert_allclose(x, 1.0, atol=0.13)
    # Its phase never runs backwards by itself.
    assert np.diff(result.phase[-1600:], axis=0).min() > 0.0


# Feedback


def test_feedback_turns_the_state_of_any_of_them_alike():
    for oscillator in PLANAR.values():
        rates_at = jax.jit(
            lambda phase, f, o=oscillator: o.rate(o.start(phase), OMEGA + 0.0 * f, f)
        )
        phase = np.linspace(0.0, 6.0, 5, dtype="float32")
        still, turned = (rates_at(phase, np.full(5, f, "float32")) for f in (0.0, -2.5))
        np.testing.assert_allclose(turned.phase - still.phase, -2.5, rtol=1e-5)
        np.testing.assert_array_equal(turned.radius, still.radius)


def test_a_state_that_went_through_the_origin_is_on_its_other_side():
    hopf = Hopf()
    settled = hopf.settle(hopf.start(jnp.array([1.0]), radius=jnp.array([-0.25])))
    assert float(settled.radius[0]) == 0.25
    assert float(settled.phase[0]) == pytest.approx(1.0 + math.pi)


# Trained numbers


def test_weights_of_zero_are_the_oscillator_itself_and_others_keep_it_in_its_ranges():
    for oscillator in PLANAR.values():
        learned = Learned(oscillator)
        neutral = learned.with_weights([0.0] * learned.n_weights)
        for name, bounds in oscillator.RANGES.items():
            assert float(getattr(neutral, name)) == pytest.approx(
                getattr(oscillator, name), rel=1e-6
            )
            if bounds is not None:
                for sign, bound in zip((-30.0, 30.0), bounds, strict=True):
                    far = learned.with_weights([sign] * learned.n_weights)
                    assert float(getattr(far, name)) == pytest.approx(bound, rel=1e-5)


# Misuse


def test_what_is_out_of_range_is_refused():
    refused(r"to be trained it must be between 0\.05 and 2", lambda: Learned(VanDerPol(mu=3.0)))
    refused("a PhaseOscillator has no numbers to train", lambda: Learned(PhaseOscillator()))
    refused(r"no oscillator is called 'hopff'.*hopf", oscillator_named, "hopff")


def test_one_that_is_too_stiff_for_the_tick_is_refused_before_it_runs():
    stiff = replace(recipe("V-reflex-w8").controller(), oscillator=VanDerPol(mu=5.0))
    rollout = Rollout(controller=stiff, timing=Timing(duration_s=1.0, tick_s=0.002))
    with pytest.raises(TegotaeError, match=r"VanDerPol at omega 8 is too stiff for ticks of 0.002"):
        rollout.run([2.0], Scenario(omega=8.0), Hopper())


def test_a_start_with_a_state_that_it_has_not_is_refused():
    rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=1.0))
    with pytest.raises(
        TegotaeError, match="PhaseOscillator has no oscillator_state 'radius'; it takes none"
    ):
        rollout.run([2.0], Scenario(omega=8.0, oscillator_state={"radius": 0.5}))
