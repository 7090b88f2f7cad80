"""Oscillators with state of their own, with weights, with or without a phase."""

import dataclasses

import jax
import numpy as np
import pytest
from oscillators import LearnedAmplitude, Relaxation

from refusals import refused
from tegotae import Controller, Hopper, Rollout, Scenario, TegotaeError, Timing, check
from tegotae.analysis.orbit import find_orbit
from tegotae.analysis.phase_response import measure_phase_response
from tegotae.analysis.poincare import poincare_section
from tegotae.parts.oscillators import Clamped, PhaseOscillator, WaryOscillator
from tegotae.parts.terms import LearnedActuation, Sector
from tegotae.simulation.loop import check_senses
from tegotae.simulation.recorder import Trajectory, needing
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe

TIMING = Timing(duration_s=4.0)
VANILLA = recipe("V-reflex-w8").controller()
SWELLING = dataclasses.replace(VANILLA, oscillator=LearnedAmplitude())
PHASELESS = Controller(LearnedActuation(("activity",), 2), Relaxation())


def run(controller: Controller, weights, **options) -> Trajectory:
    return Rollout(controller=controller, timing=TIMING, **options).run(
        weights, Scenario(omega=8.0)
    )


@pytest.mark.parametrize("oscillator", [LearnedAmplitude(), Relaxation()], ids=str)
def test_a_users_oscillator_keeps_the_contract(oscillator):
    check(oscillator)
    check(Clamped(oscillator))


def test_an_oscillators_weights_come_after_those_of_the_terms():
    assert SWELLING.n_weights == VANILLA.n_weights + 1
    assert SWELLING.layout["oscillator"] == slice(1, 2)
    assert SWELLING.initial(jax.random.key(0)).shape == (2,)


def test_its_state_is_recorded_where_it_declares_so():
    path = run(SWELLING, [[2.0, 0.0], [2.0, 0.5]])
    still, swells = path.amplitude.T
    np.testing.assert_allclose(still, 1.0, atol=1e-6)
    assert np.ptp(swells) > 0.01
    # The amplitude has no part in the reflex: the motion is that of the phase oscillator.
    np.testing.assert_allclose(path.height_m[:, 1], run(VANILLA, [2.0]).height_m[:, 0], atol=1e-5)


def test_clamped_it_keeps_all_of_its_state_and_its_weights():
    clamped = dataclasses.replace(SWELLING, oscillator=Clamped(LearnedAmplitude()))
    assert clamped.n_weights == SWELLING.n_weights
    path = run(clamped, [2.0, 0.5])
    np.testing.assert_array_equal(path.amplitude, 1.0)
    np.testing.assert_array_equal(path.phase_rad, 0.0)


def test_an_oscillator_without_a_phase_drives_what_reads_its_signals():
    assert not Relaxation().has_phase
    path = run(PHASELESS, np.random.default_rng(0).normal(size=(8, PHASELESS.n_weights)) * 3.0)
    assert np.ptp(path.actuator_force_n) > 0.1
    np.testing.assert_array_equal(path.phase_rad, 0.0)


def test_what_needs_a_phase_is_refused_without_one():
    with pytest.raises(TegotaeError, match=r"Sector needs a phase, and .* has Relaxation, without"):
        run(Controller(Sector(), Relaxation()), [])
    with pytest.raises(TegotaeError, match=r"Sector needs a phase, and .* has no oscillator"):
        check_senses(Controller(Sector()), Hopper())
    with pytest.raises(TegotaeError, match="reads 'cos_phase', which nothing provides"):
        run(dataclasses.replace(VANILLA, oscillator=Relaxation()), [1.0])


def test_analyses_that_enter_an_orbit_refuse_an_oscillator_with_state_that_nothing_tells():
    assert PhaseOscillator().is_open
    orbit = find_orbit(SavedController.from_weights(VANILLA, np.array([2.0]), 8.0))
    swelling = SavedController.from_weights(SWELLING, np.array([2.0, 0.5]), 8.0)
    refused("LearnedAmplitude has more state than it names", poincare_section, swelling, orbit)
    with pytest.raises(TegotaeError, match="LearnedAmplitude has more state than it names"):
        measure_phase_response(swelling, orbit, np.array([0.01]))
    phaseless = SavedController.from_weights(PHASELESS, np.zeros(PHASELESS.n_weights), 8.0)
    refused("Relaxation has no phase", poincare_section, phaseless, orbit)


def test_the_alarm_of_a_wary_oscillator_is_recorded_and_is_part_of_its_orbit():
    wary = dataclasses.replace(VANILLA, oscillator=WaryOscillator(fall_s=0.3))
    assert run(wary, [-2.0]).alarm_rad_per_s.max() > 0.0
    saved = SavedController.from_weights(wary, np.array([-2.0]), 8.0)
    orbit = find_orbit(saved)
    assert list(orbit.apex_oscillator_state) == ["alarm_rad_per_s"]
    assert len(poincare_section(saved, orbit).fixed_point) == 3


# What is recorded


@needing("height_m", "work_absolute_j")
def height_and_work(trajectory, scenario, body, timing):
    return trajectory


def test_only_what_a_summary_needs_is_recorded():
    some = run(VANILLA, [2.0], summary=height_and_work)
    assert list(some.channels) == ["height_m", "work_absolute_j"]
    trajectory = run(VANILLA, [2.0])
    np.testing.assert_array_equal(some.work_absolute_j, trajectory.work_absolute_j)
    with pytest.raises(AttributeError, match="'climb_m' was not recorded; recorded are height_m"):
        _ = some.climb_m


@needing("heigth_m")
def misspelt(trajectory, scenario, body, timing):
    return trajectory


def test_a_channel_that_nobody_declares_is_refused_with_those_there_are():
    refused(r"no channel is called 'heigth_m'.*height_m", run, VANILLA, [2.0], summary=misspelt)


@dataclasses.dataclass(frozen=True)
class TakesAName(LearnedAmplitude):
    @property
    def channels(self):
        (channel,) = super().channels
        return (dataclasses.replace(channel, name="height_m"),)


def test_a_channel_cannot_take_the_name_of_another():
    taken = dataclasses.replace(VANILLA, oscillator=TakesAName())
    refused("height_m is recorded already", run, taken, [2.0, 0.0])
