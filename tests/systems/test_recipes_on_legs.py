"""Recipes on legs: terms of a controller on a legged system, by name; and how it is judged."""

import dataclasses
import json

import numpy as np
import pytest

from refusals import refused
from tegotae import Experiment, TegotaeError, Timing
from tegotae._support.tables import read_csv
from tegotae.analysis.gaits.releases import release_all
from tegotae.cli import main
from tegotae.measures.gaits.metrics import WALKING
from tegotae.measures.objectives.fitness import HoppingLegs
from tegotae.parts.fields import replace
from tegotae.parts.terms import (
    EllipticFoot,
    LearnedFoot,
    Sector,
    VanillaAction,
    WholeBodyFoot,
)
from tegotae.systems import controller_file
from tegotae.systems.recipe import is_on_legs, recipe, recipes_on_legs
from tegotae.systems.resolve import legged_system as system
from tegotae.systems.term_sets import BUDGET
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned

# Names


def test_every_listed_design_has_a_name_that_finds_it_and_makes_an_experiment():
    listed = recipes_on_legs()
    assert {name.partition("@")[2] for name in listed} >= {"quadruped-c", "plate-light-pitch"}
    for name, listed_design in listed.items():
        assert recipe(name).name == name
        built = listed_design.experiment()
        assert 1 <= built.controller.n_weights <= BUDGET, name
        assert Experiment.from_document(json.loads(json.dumps(built.document))) == built


def test_a_bare_architecture_is_its_plainest_member():
    assert recipe("ARGT@hexapod").name == "ARGT-rF-gF-tphif@hexapod"
    assert recipe("VG@hexapod").terms.about == "Tegotae with G learned, a unit a leg"


def test_a_users_own_system_has_designs_too(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from tegotae.systems.resolve import legged_system as system\nrobot = system('bar-light')\n"
    )
    result = recipe(f"AR@{tmp_path / 'mine.py'}:robot")
    assert result.name == "AR-rF@robot"
    assert result.experiment().body == system("bar-light").body


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("ARZ@hexapod", "no controller is called 'ARZ'"),
        ("ART@heptapod", "no legged system is called 'heptapod'"),
        ("ART-rX@hexapod", "no observation is called 'X'"),
        ("T-Q@hexapod", "no observation is called 'Q'"),
        ("ART-tpsi@hexapod", "no input of a learned actuation is called 'psi'"),
        ("AR-gF@hexapod", "says what G senses, and it is not learned"),
        ("AR-w1.2.3@hexapod", "has no frequency behind -w"),
        ("AR-w0@hexapod", "omega is 0"),
        ("ART-t+phif@plate-heavy", "no ellipse"),
    ],
)
def test_a_name_that_says_nothing_is_refused_in_one_line(name, message):
    refused(message.replace("+", r"\+"), lambda: recipe(name).experiment())


@pytest.mark.parametrize("family", ["ARGT", "T-F", "W-F", "cos", "V"])
def test_a_budget_too_small_for_the_layout_is_refused_in_one_line(family):
    smallest = {"ARGT": 22, "T-F": 6, "W-F": 13, "cos": 2, "V": 1}[family]
    assert recipe(f"{family}@quadruped-c").controller(smallest).n_weights == smallest
    if smallest > 1:
        with pytest.raises(TegotaeError, match=f"too small: .* has at least {smallest} weights"):
            recipe(f"{family}@quadruped-c").controller(smallest - 1)


def test_a_models_name_is_no_designs():
    assert not is_on_legs("ART-rF-tphif-w8")
    assert not is_on_legs("/home/me@work/mine.py:experiment")


# Experiments


def test_what_is_not_learned_is_the_systems_own():
    controller = system("quadruped-c").controller
    learned = recipe("AR@quadruped-c").controller()
    assert learned.actuation == controller.actuation == EllipticFoot(0.2, 0.12, 0.03, 0.4)
    assert (learned.oscillator, learned.limbs) == (controller.oscillator, 4)
    assert isinstance(recipe("VG@quadruped-c").controller().terms["action"], VanillaAction)
    assert isinstance(recipe("AR@plate-heavy").controller().actuation, Sector)


def test_vanilla_is_the_system_itself():
    assert recipe("V@quadruped-c").controller() == system("quadruped-c").controller
    assert recipe("V@plate-heavy").experiment().is_searched


def test_networks_without_oscillators_are_as_large_as_the_others_and_have_no_frequency():
    for family, kind in (("T-F", LearnedFoot), ("W-F", WholeBodyFoot)):
        built = recipe(f"{family}@quadruped-c").experiment()
        assert isinstance(built.controller.actuation, kind)
        assert built.omega is None
        assert built.controller.n_weights > 0.9 * BUDGET


def test_the_frequency_says_which_speed_is_wanted_with_an_oscillator_or_without():
    for family in ("AR", "T-F"):
        slow, fast = (recipe(f"{family}-w{w}@quadruped-c").experiment() for w in (1, 3))
        assert slow.objective.speed_m_per_s == pytest.approx(2 * 0.2 / np.pi)
        assert fast.objective.speed_m_per_s == pytest.approx(3 * slow.objective.speed_m_per_s)
    assert recipe("AR@quadruped-c").experiment().omega == system("quadruped-c").omega


def test_legs_that_push_are_trained_to_hop_and_follow_their_frequency():
    assert recipe("AR@plate-heavy").experiment().measure == HoppingLegs()
    assert recipe("T-F@plate-heavy").experiment().measure == HoppingLegs(follow_omega=False)


def test_every_design_of_a_system_begins_with_the_same_irregular_phases():
    starts = {
        recipe(f"{f}@quadruped-c").experiment().system.release.phase_rad
        for f in ("V", "ARGT", "Wphi-F")
    }
    (phases,) = starts
    assert len(set(phases)) == 4


# Training and judging


@pytest.fixture(scope="module")
def short():
    """A training of seconds: two generations of short episodes."""
    result = recipe("Wphi-F@quadruped-c")
    timing = Timing(duration_s=4.0, tick_s=0.008, frame_s=0.08)
    fitness = dataclasses.replace(result.fitness, settle_s=2.0)
    return result.experiment(budget=30, timing=timing, objective=fitness)


def run_of(experiment: Experiment, generations: int) -> Run:
    algorithm = dataclasses.replace(tuned("pgpe"), population=4)
    stopping = Stopping.after(generations)
    return Run(
        experiment=experiment,
        seeds=(0, 1),
        learner=Evolution(algorithm=algorithm, stopping=stopping),
    )


@pytest.fixture(scope="module")
def trained(short, tmp_path_factory):
    folder = tmp_path_factory.mktemp("designs")
    return train(run_of(short, 2), folder / "at-once")


def test_a_design_is_trained_kept_and_resumed_to_the_same_weights(short, trained, tmp_path):
    train(run_of(short, 1), tmp_path)
    again = train(run_of(short, 2), tmp_path)
    for first, second in zip(trained, again, strict=True):
        weights = controller_file.load(first).weights
        assert np.ptp(weights) > 0.0
        np.testing.assert_array_equal(weights, controller_file.load(second).weights)


def test_a_controller_file_says_what_each_weight_of_a_network_for_all_legs_is(trained):
    neurons = json.loads(trained[0].read_text())["weights"]["actuation"]["neuron"]
    first = neurons["0"] if isinstance(neurons, dict) else neurons[0]
    assert {"leg", "sin_phase", "cos_phase", "bias", "output"} == set(first)


@pytest.fixture(scope="module")
def judged():
    """The named quadruped, and the same without feedback."""
    weights = np.array([[1.25], [0.0]])
    return release_all(system("quadruped-c"), weights, (2.0, 3.0), 4, seed=1).summary


def test_the_named_quadruped_is_judged_at_each_frequency(judged):
    assert judged[["run", "omega"]].values.tolist() == [[0, 2], [0, 3], [1, 2], [1, 3]]
    assert (judged["upright"] == 1.0).all()
    assert judged["locked"].tolist() == [1.0, 1.0, 0.0, 0.0]  # σ = 0 locks nothing
    assert 0.2 < judged["speed_m_per_s"][0] < judged["speed_m_per_s"][1]
    np.testing.assert_allclose(judged["froude"], judged["speed_m_per_s"] ** 2, rtol=1e-5)
    assert judged["gait"][0] == "diagonal-sequence walk"


def test_controllers_of_a_folder_are_judged_together(judged, tmp_path, capsys):
    legged, folder = system("quadruped-c"), tmp_path / "runs"
    folder.mkdir()
    for seed, sigma in enumerate((1.25, 0.0)):
        controller_file.save(
            controller_file.SavedController.from_weights(
                legged.controller,
                np.array([sigma]),
                2.0,
                legged.body,
                name="V@quadruped-c",
                training={"seed": seed},
            ),
            folder / f"V-seed{seed}.json",
        )
    table = tmp_path / "judged.csv"
    options = ("--omega", "2", "3", "--starts", "4", "--csv", str(table))
    assert main(["evaluate", str(folder), *options]) == 0
    assert "V@quadruped-c" in capsys.readouterr().out
    rows = read_csv(table)
    assert list(rows["run"]) == ["0", "0", "1", "1"]
    for name in WALKING.names():
        theirs = np.array([float(x) if x else np.nan for x in rows[name]])
        np.testing.assert_allclose(theirs, judged[name], rtol=1e-4)


def test_a_judgement_of_what_has_no_frequency_takes_none():
    result = system("quadruped-c")
    single = replace(
        result.system, {"controller": recipe("T-F@quadruped-c").controller(), "omega": None}
    )
    legged = dataclasses.replace(result, system=single, weights=(0.0,) * 96)
    refused("no oscillator, and so no omega", release_all, legged, np.zeros((1, 96)), (2.0,))
    refused("this controller has 96", release_all, legged, np.zeros((1, 3)))


def test_models_lists_designs_for_a_pattern_with_an_at(capsys):
    assert main(["models", "ART*@quadruped-?", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in listed] == [
        "ART-rF-tphif@quadruped-a",
        "ART-rF-tphif@quadruped-c",
        "ART-rF-tphif@quadruped-g",
    ]
    assert listed[0]["parameters"] == 96
