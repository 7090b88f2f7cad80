"""Oscillators in the place of the paper's: on bodies, in models, training, files and analyses."""

import dataclasses

import numpy as np
import pytest

from refusals import refused
from tegotae import Experiment, Rollout, Scenario, Timing
from tegotae.analysis.orbit import find_orbit
from tegotae.analysis.phase_response import measure_phase_response
from tegotae.analysis.poincare import poincare_section
from tegotae.api.experiments import with_parts
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.bodies import Bar, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import (
    AdaptiveHopf,
    Clamped,
    Hopf,
    Learned,
    Matsuoka,
    VanDerPol,
)
from tegotae.parts.terms import EllipticFoot
from tegotae.systems.controller_file import SavedController, load, save
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import experiment_of, vanilla
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train

SHORT = Timing(duration_s=4.0, tick_s=0.002)


def driven(oscillator, name="V-sector-w8"):
    """The vanilla controller with another oscillator."""
    return dataclasses.replace(recipe(name).controller(), oscillator=oscillator)


# Models


def test_a_models_name_takes_an_oscillators():
    model = recipe("ART+matsuoka")
    assert model.name == "ART-rF-tphif-w8+matsuoka"
    assert model.terms.architecture == "ART"
    assert model.controller().oscillator == Matsuoka()
    assert recipe(model.name) == model


def test_trained_numbers_of_an_oscillator_are_part_of_the_budget():
    for name in ("ART+learned-matsuoka", "AR+learned-hopf", "ARGT+learned-adaptive-hopf"):
        controller = recipe(name).controller()
        assert controller.oscillator.n_weights > 3
        assert 90 < controller.n_weights <= 96


def test_a_vanilla_model_with_an_oscillator_to_train_is_trained_and_not_searched():
    assert recipe("V+hopf").experiment().is_searched
    assert not recipe("V+learned-hopf").experiment().is_searched
    assert not recipe("V+learned-hopf").controller().has_a_gain_alone


def test_unknown_oscillators_and_networks_without_one_are_refused():
    refused(r"no oscillator is called 'matsuka'.*matsuoka", recipe, "ART+matsuka")
    refused("T-F is a network without an oscillator; leave hopf", recipe, "T+hopf")


# The command line


def test_commands_take_an_oscillator_by_name():
    controller = vanilla("paper+van-der-pol")
    assert controller.controller.oscillator == VanDerPol()
    np.testing.assert_array_equal(vanilla("paper+learned-hopf").weights[1:], 0.0)
    experiment = with_parts(experiment_of("ART"), oscillator="learned-matsuoka")
    assert experiment == recipe("ART+learned-matsuoka").experiment()
    refused("no oscillator is called 'hop'", vanilla, "paper+hop")


# Training, and files


def test_an_oscillator_is_trained_saved_and_resumed(tmp_path):
    experiment = recipe("V+learned-van-der-pol").experiment(
        timing=Timing(duration_s=3.0, tick_s=0.002), objective=Fitness(settle_s=1.0)
    )
    assert Experiment.from_document(experiment.document) == experiment

    def trained(generations, folder):
        run = Run(
            experiment=experiment,
            seeds=(0, 1),
            learner=Evolution(algorithm=PGPE(population=4), stopping=Stopping.after(generations)),
        )
        return load(train(run, folder)[0])

    trained(2, tmp_path / "parts")
    resumed, at_once = trained(3, tmp_path / "parts"), trained(3, tmp_path / "whole")
    assert resumed.controller.oscillator == Learned(VanDerPol())
    assert np.any(resumed.weights[1:] != 0.0)
    np.testing.assert_array_equal(resumed.weights, at_once.weights)


def test_a_controller_file_keeps_the_oscillators_own_numbers(tmp_path):
    controller = driven(AdaptiveHopf(mu=2.0, learning_per_s=0.1))
    save(SavedController.from_weights(controller, np.array([2.0]), 8.0), tmp_path / "adaptive.json")
    assert load(tmp_path / "adaptive.json").controller == controller


# Bodies


def test_clamped_it_stands_still_in_all_of_its_state():
    rollout = Rollout(controller=driven(Clamped(Matsuoka())), timing=SHORT)
    path = rollout.run([2.0], Scenario(omega=8.0, phase_rad=1.0, oscillator_state={"radius": 0.5}))
    for name, value in {"phase_rad": 1.0, "radius": 0.5}.items():
        np.testing.assert_allclose(path.channels[name], value, rtol=1e-6)
    assert np.ptp(path.mean_fatigue) == 0.0


@pytest.mark.thorough
def test_half_centres_drive_the_legs_of_a_bar_each_by_itself():
    controller = dataclasses.replace(driven(Matsuoka()), limbs=2)
    starts = np.array([[0.0], [2.0]])
    path = Rollout(controller=controller, timing=SHORT).run(
        [2.0], Scenario(omega=8.0, phase_rad=starts), Bar()
    )
    assert path.mean_fatigue.shape == (SHORT.n_frames, 2, 1)
    assert not path.failed.any()
    assert np.ptp(path.radius[:, 0] - path.radius[:, 1]) > 0.01


@pytest.mark.thorough
def test_half_centres_walk_a_torso_and_shift_their_lags():
    vanilla = recipe("V-reflex-w8").controller().tegotae
    foot = EllipticFoot(stride_m=0.2, lift_m=0.12, press_m=0.03, shift_rad=0.4)
    controller = Controller(foot, Matsuoka(), vanilla, limbs=4)
    timing = Timing(duration_s=20.0, tick_s=0.0125, frame_s=0.1)
    starts = np.random.default_rng(3).uniform(0.0, 6.0, (4, 1))
    path = Rollout(controller=controller, timing=timing).run(
        [1.25], Scenario(omega=2.0, height_m=Walker().standing_height_m, phase_rad=starts), Walker()
    )
    assert np.isfinite(path.phase_rad).all()
    turned = np.unwrap(path.phase_rad[:, :, 0], axis=0)[-1] - starts[:, 0]
    # Left alone, all legs would have made the same way.
    assert np.ptp(turned) > 0.1


# Analyses


@pytest.mark.thorough
def test_an_amplitude_adds_its_own_multiplier_to_those_of_the_phase_oscillator():
    # At r = 1 a radius returns as exp(-2 γ t), whatever the hopper does.
    gamma = 1.0
    sections = []
    for controller in (
        recipe("V-reflex-w8").controller(),
        driven(Hopf(recovery_per_s=gamma), "V-reflex-w8"),
    ):
        saved = SavedController.from_weights(controller, np.array([2.0]), 8.0)
        orbit = find_orbit(saved, settle_s=40.0)
        sections.append(poincare_section(saved, orbit, turns=3))
    plain, hopf = (np.sort(np.abs(section.multipliers)) for section in sections)
    multiplier = np.exp(-2.0 * gamma * sections[1].period_s)
    np.testing.assert_allclose(hopf, np.sort([*plain, multiplier]), atol=2e-3)
    np.testing.assert_allclose(sections[1].fixed_point, [*sections[0].fixed_point, 1.0], atol=1e-6)


@pytest.mark.thorough
def test_a_phase_response_starts_with_all_of_the_oscillators_state():
    saved = SavedController.from_weights(
        driven(VanDerPol(mu=0.5), "V-reflex-w8"), np.array([2.0]), 8.0
    )
    orbit = find_orbit(saved)
    assert np.ptp(orbit.oscillator_state["radius"]) > 0.05
    response = measure_phase_response(saved, orbit, np.array([0.0, 0.02]), points=5, cycles=20)
    assert np.isfinite(response.shift_rad).all()
    none, pushed = response.shift_rad.to_numpy().reshape(2, -1)
    np.testing.assert_allclose(none, 0.0, atol=1e-9)
    assert np.abs(pushed).max() > 1e-3
