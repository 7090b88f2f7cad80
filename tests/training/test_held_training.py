"""A training may hold the controller over its ticks, as a robot does."""

import dataclasses

from refusals import refused
from tegotae import Experiment
from tegotae.api.experiments import adjusted
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold, PredictorCorrector
from tegotae.simulation.rollout import Timing
from tegotae.systems.recipe import recipe
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.run import Run

CONTINUOUS = recipe("AR-rF-sector-w8").experiment()
HELD = replace(CONTINUOUS, {"integrator": Hold()})


def test_a_held_training_rolls_out_its_episodes_held():
    assert CONTINUOUS.evaluator().rollouts.integrator == PredictorCorrector()
    assert HELD.evaluator().rollouts.integrator == Hold()


def test_the_document_of_a_held_training_says_so():
    assert HELD.document["system"]["integrator"] == {"kind": "Hold"}
    assert Experiment.from_document(HELD.document) == HELD
    assert Experiment.from_document(CONTINUOUS.document) == CONTINUOUS


def test_the_option_holds_and_leaves_alone_what_holds_already():
    assert adjusted(CONTINUOUS, {"hold": True}) == HELD
    assert adjusted(HELD, {}) == HELD


def test_agents_learn_in_continuous_time_and_say_so():
    refused("agents learn in continuous time", lambda: Run(experiment=HELD, learner=AgentLearner()))


def test_the_gain_of_a_vanilla_controller_is_searched_held():
    from tegotae.training.scoring import best_gain

    baseline = recipe("V-reflex-w8").experiment()
    short = replace(
        baseline,
        {
            "timing": Timing(duration_s=6.0, tick_s=0.01),
            "objective": dataclasses.replace(baseline.objective, settle_s=2.0),
        },
    )
    continuous, held = (
        best_gain(replace(short, {"integrator": integrator}))
        for integrator in (PredictorCorrector(), Hold())
    )
    assert continuous[1] != held[1]
