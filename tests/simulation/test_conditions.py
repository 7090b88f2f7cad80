"""Training under changing conditions: what is drawn, who meets it, and what is refused."""

import dataclasses
import json

import numpy as np
import pytest

import tiny
from refusals import refused
from tegotae import Hopper, TegotaeError
from tegotae.api.experiments import adjusted, conditions_named
from tegotae.measures.objectives.evaluator import Generation
from tegotae.parts.bodies import Bar
from tegotae.simulation.draws import Randomization, applied, draw
from tegotae.simulation.schedules import Step
from tegotae.simulation.world import OneOf, Scenario, Uniform
from tegotae.systems import controller_file
from tegotae.systems.experiment import Experiment
from tegotae.training.run import train

MASS = Uniform("mass_kg", low=0.08, high=0.12)
RELEASE = Uniform("height_m", low=1.1, high=1.3)
LOST = OneOf("present", values=((1.0, 1.0), (0.0, 1.0)))


def varied(*conditions, episodes: int = 1, **settings) -> Experiment:
    fields = {"conditions": conditions, "episodes": episodes, **settings}
    return tiny.changed(tiny.RUN, **fields).experiment


# What is drawn.


def test_few_draws_are_spread_over_the_whole_range_one_in_each_share_of_it():
    for key in range(5):
        draws = draw([MASS, RELEASE], Hopper(), 8, (key,))
        share = (draws["mass_kg"] - 0.08) / 0.04 * 8
        assert sorted(share.astype(int)) == list(range(8))
    orders = [tuple(np.argsort(x)) for x in draws.values()]
    assert orders[0] != orders[1]  # independent of each other


def test_one_of_several_values_is_drawn_equally_often():
    draws = draw([OneOf("omega", values=(6.0, 8.0))], Hopper(), 10, (3,))
    assert sorted(draws["omega"]) == [6.0] * 5 + [8.0] * 5


def test_what_belongs_to_limbs_is_drawn_limb_by_limb_and_a_leg_is_lost_as_a_whole():
    bar = Bar()
    phases = draw([Uniform("phase_rad", low=0.0, high=6.0)], bar, 4, (1,))["phase_rad"]
    assert phases.shape == (2, 4)
    assert not np.array_equal(*phases)
    assert OneOf("x", values=((1.0, 2.0), (3.0, 4.0))).quantile(np.array([0.9, 0.1])).tolist() == [
        [3.0, 1.0],
        [4.0, 2.0],
    ]


def test_a_condition_for_a_time_is_a_step_and_one_for_the_whole_episode_is_a_number():
    conditions = [MASS, Uniform("gravity_m_per_s2", low=8.0, high=9.0, from_s=1.0, until_s=2.0)]
    values = {"mass_kg": [0.1, 0.11], "gravity_m_per_s2": [8.0, 8.5]}
    scenario = applied(conditions, values, Scenario(8.0), Hopper())
    assert scenario.changes["mass_kg"] == [0.1, 0.11]
    assert scenario.changes["gravity_m_per_s2"] == Step([8.0, 8.5], 1.0, 2.0)


# Who meets it.


def test_all_candidates_of_a_generation_meet_the_same_and_the_next_generation_meets_another():
    randomization = Randomization((MASS,), Hopper(), Scenario(8.0))
    first, second = (
        randomization.generation((0, 1), number, 4, 3, 3).changes["mass_kg"].reshape(2, 5, 3)
        for number in (0, 1)
    )
    assert (first[:, :4] == first[:, :1]).all()
    assert not np.array_equal(first[0, 0], first[1, 0])  # every seed has its own
    assert not np.array_equal(first[0, 0], second[0, 0])


def test_the_centre_by_which_the_best_is_chosen_always_meets_the_same():
    randomization = Randomization((MASS,), Hopper(), Scenario(8.0))
    evaluation_set = randomization.evaluation_set(2, 3).changes["mass_kg"]
    np.testing.assert_array_equal(evaluation_set[:3], evaluation_set[3:])
    for number in (0, 7):
        lanes = (
            randomization.generation((0, 1), number, 4, 3, 3).changes["mass_kg"].reshape(2, 5, 3)
        )
        np.testing.assert_array_equal(lanes[:, 4], [evaluation_set[:3]] * 2)


def test_what_a_seed_meets_does_not_depend_on_the_others():
    randomization = Randomization((MASS,), Hopper(), Scenario(8.0))
    together = randomization.generation((0, 1), 2, 4, 3, 3).changes["mass_kg"]
    alone = randomization.generation((1,), 2, 4, 3, 3).changes["mass_kg"]
    np.testing.assert_array_equal(together[15:], alone)


def test_the_evaluation_set_has_several_episodes_even_where_candidates_have_one(monkeypatch):
    def scored(_, mass, __):
        return {"fitness": mass, "cot_inverse": mass, "failed": mass > 0.118}

    prefix = "tegotae.measures.objectives.evaluator."
    monkeypatch.setattr(
        prefix + "Rollout.run_lanes", lambda _, lanes, body: lanes.scenario.changes["mass_kg"]
    )
    monkeypatch.setattr(prefix + "by_blocks", scored)
    evaluator = varied(MASS).evaluator()
    weights = np.zeros((2, 5, varied(MASS).controller.n_weights), "float32")
    verdicts = [
        evaluator.evaluate(weights, Generation((0, 1), np.full(2, True), n)) for n in (0, 7)
    ]
    evaluation_set = draw([MASS], Hopper(), 4, (0,))["mass_kg"]
    for verdict in verdicts:
        assert verdict.failed.shape == (2, 5)
        np.testing.assert_allclose(verdict.fitness[:, -1], evaluation_set.mean(), rtol=1e-6)
        assert (verdict.failed[:, -1] == (evaluation_set > 0.118).any()).all()
    assert not np.allclose(verdicts[0].fitness[:, :-1], verdicts[1].fitness[:, :-1])
    searched = evaluator.evaluate(weights[:1], Generation.alike())
    np.testing.assert_allclose(searched.fitness, evaluation_set.mean(), rtol=1e-6)


# Trained, kept, gone on with.


@pytest.fixture(scope="module")
def run():
    return dataclasses.replace(tiny.RUN, experiment=varied(MASS, RELEASE, episodes=2))


@pytest.fixture(scope="module")
def trained(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("varied")
    return folder, train(run, folder)


def test_a_training_under_changing_conditions_learns_something_else(trained, tiny_training):
    _, paths = trained
    steady = [controller_file.load(path).weights for path in tiny.controllers(tiny_training)]
    for path, baseline in zip(paths, steady, strict=True):
        assert not np.allclose(controller_file.load(path).weights, baseline)


def test_stopped_and_gone_on_with_it_ends_in_the_same_numbers(run, trained, tmp_path):
    folder, _ = trained
    stopped = dataclasses.replace(run, learner=tiny.run_of(2).learner)
    train(stopped, tmp_path)
    train(run, tmp_path)
    assert tiny.learned(tmp_path) == tiny.learned(folder)


def test_a_candidates_fitness_is_the_mean_over_its_episodes(run):
    # A range of no width: every episode is the usual one.
    still = [
        Uniform("mass_kg", low=0.1, high=0.1),
        Uniform("height_m", low=1.2, high=1.2),
    ]
    twice = dataclasses.replace(run, experiment=varied(*still, episodes=2))
    _, of_two = next(twice.learner.evolve(twice.experiment, twice.seeds))
    _, of_one = next(tiny.RUN.learner.evolve(tiny.RUN.experiment, tiny.RUN.seeds))
    np.testing.assert_allclose(of_two.centre_fitness, of_one.centre_fitness, rtol=1e-5)
    np.testing.assert_allclose(of_two.best_fitness, of_one.best_fitness, rtol=1e-5)


def test_the_document_has_the_conditions():
    window = Uniform("gravity_m_per_s2", low=9.0, high=9.81, from_s=1.0)
    experiment = varied(MASS, OneOf("omega", values=(7.0, 8.0)), window, episodes=3)
    document = json.loads(json.dumps(experiment.document, allow_nan=False))
    assert Experiment.from_document(document) == experiment
    assert tiny.RUN.experiment.document["conditions"] == []


# What is refused, before work begins.


@pytest.mark.parametrize(
    ("conditions", "says"),
    [
        ([Uniform("masss", low=1.0, high=2.0)], "did you mean mass_kg"),
        ([Uniform("mass_kg", low=-0.1, high=0.1)], "mass_kg is -0.1"),
        ([MASS, MASS], "mass_kg is varied 2 times"),
        ([Uniform("omega", low=0.0, high=8.0)], "must be greater than 0"),
        ([Uniform("drop_m", low=0.0, high=0.1)], "the time from which on"),
        (
            [Uniform("height_m", low=1.0, high=1.2, from_s=2.0)],
            "height_m is of the release; it cannot change on the way",
        ),
        ([OneOf("omega", values=((4.0, 5.0), (6.0, 7.0)))], "omega is one number for all limbs"),
        (
            [
                Uniform("drop_m", low=0.0, high=0.1, from_s=2.0),
                Uniform("drop_time_s", low=1.0, high=2.0),
            ],
            "drops once, at one time",
        ),
        ([Uniform("stiffness_n_per_m", low=5.0, high=5e6)], "too long for this hopper"),
    ],
)
def test_a_condition_that_makes_no_sense_is_refused_in_one_line(conditions, says):
    refused(says, lambda: varied(*conditions))


def test_conditions_in_which_nothing_can_move_are_refused_before_training():
    experiment = varied(Uniform("max_force_n", low=0.5, high=4.0))
    refused("cannot hop", experiment.check)
    with pytest.raises(TegotaeError, match="does not fall onto its leg"):
        varied(Uniform("height_m", low=0.9, high=1.2)).check()


def test_several_episodes_that_would_be_the_same_are_refused():
    refused("would all be the same", varied, episodes=2)


def test_no_episodes_at_all_are_refused_and_not_taken_for_the_usual_number():
    experiment = tiny.RUN.experiment
    settings = {"vary": ("mass_kg=0.08:0.12",), "episodes_per_candidate": 0}
    refused("episodes is 0", adjusted, experiment, settings)


def test_limits_the_wrong_way_round_and_no_values_are_refused():
    refused("must be at least 2", Uniform, "mass_kg", low=2.0, high=1.0)
    refused("no values", OneOf, "mass_kg", values=())


def test_conditions_are_written_in_one_word_on_the_command_line():
    assert conditions_named(["mass_kg=0.08:0.12", "present=1,1/0,1"]) == (MASS, LOST)
    (push,) = conditions_named(["push_x_n=-5:5@8:8.2"])
    assert push == Uniform("push_x_n", low=-5.0, high=5.0, from_s=8.0, until_s=8.2)
    for text in (
        *("mass_kg", "mass_kg=", "mass_kg=a:b", "mass_kg=1:2:3", "mass_kg=1:2@x"),
        "mass_kg=1:2@8:8.2:9",
    ):
        refused("is no condition; write NAME=LOW:HIGH", conditions_named, [text])
