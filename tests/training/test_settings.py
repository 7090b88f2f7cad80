"""Named settings of the learning algorithms: their origin, and faults of their files."""

import dataclasses
import inspect
import json
import re

import numpy as np
import pytest

from refusals import refused
from tegotae.systems.recipe import recipe
from tegotae.training import settings as configurations
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.algorithms import PGPE
from tegotae.training.run import Run
from tegotae.training.settings import (
    agents,
    configuration,
    evolutions,
    learner,
    load_configuration,
    settings_named,
    tuned,
)


def trained_for(task: dict) -> int:
    """For how many experiments settings were judged; some files name models alone."""
    return len(task.get("experiments") or task["models"])


@pytest.mark.parametrize("name", configurations.configuration_names())
def test_every_configuration_of_the_package_says_how_it_was_found(name):
    saved = configuration(name)
    assert isinstance(saved.settings, learner(saved.algorithm))
    if name == "pgpe":  # not by a search, but by a comparison that a page shows
        assert "research/experiments/plateau.py" in saved.found["about"]
        return
    record = saved.found
    assert record["trials"]["complete"] > 0
    assert record["mean_fitness"] == pytest.approx(np.mean(record["fitness"]))
    assert len(record["fitness"]) == trained_for(record["task"]) * record["task"]["seeds"]
    assert {"tegotae", "jax", "optuna"} <= set(record["software"])


def most_simulated_s(name: str) -> float:
    """Simulated time that a configuration's search could spend [s]."""
    record = configuration(name).found
    trials = record["trials"]["complete"] + record["trials"]["pruned"]
    return trials * record["task"]["budget_s"] * len(record["fitness"])


def test_the_algorithms_of_fig_3_were_tuned_with_the_same_simulated_time():
    assert len({most_simulated_s(name) for name in ("pgpe-figure3", "sac", "ppo")}) == 1


@pytest.mark.parametrize("algorithm", [*evolutions(), *agents()])
def test_every_algorithm_has_tuned_settings_or_those_of_its_class(algorithm):
    kind = learner(algorithm)
    is_tuned = algorithm in configurations.configuration_names()
    assert tuned(algorithm) == (configuration(algorithm).settings if is_tuned else kind())


@pytest.mark.parametrize("algorithm", [*evolutions(), "sac"])
def test_a_class_has_the_settings_of_the_command_line_by_default(algorithm):
    assert learner(algorithm)() == settings_named(algorithm)


def test_the_docstring_of_ppo_names_the_settings_in_which_the_tuned_ones_differ():
    tuned_settings, defaults = tuned("ppo"), learner("ppo")()
    differing = {
        field.name
        for field in dataclasses.fields(defaults)
        if getattr(defaults, field.name) != getattr(tuned_settings, field.name)
    }
    text = inspect.getdoc(learner("ppo")).split("differ in")[1].split(". ")[0]
    assert set(re.findall(r"`(\w+)`", text)) == differing


def test_a_run_in_python_learns_as_the_command_does():
    assert Run(experiment=recipe("AR").experiment()).learner.algorithm == settings_named("pgpe")
    assert AgentLearner().settings == settings_named("sac")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"settings": {"populaton": 4}}, "a pgpe has no 'populaton'"),
        ({"settings": {"population": 7}}, "population is 7"),
        ({"algorithm": "hill climbing"}, "needs your part hill climbing"),
        ({"settings": 3}, "its settings is 3; it must be an object"),
    ],
)
def test_a_damaged_configuration_is_refused(tmp_path, change, message):
    document = {"algorithm": "pgpe", "settings": {"population": 8}, "found": {}}
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(document))
    assert load_configuration(path).settings == PGPE(population=8)
    path.write_text(json.dumps({**document, **change}))
    refused(message, load_configuration, path)


def test_a_missing_configuration_is_refused(tmp_path):
    refused("cannot read", load_configuration, tmp_path / "none.json")
    refused("no configuration is called 'pgep'", configuration, "pgep")
    refused("no algorithm is called 'pgep'", tuned, "pgep")
