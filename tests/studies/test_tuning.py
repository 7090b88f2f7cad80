"""Tuning: what may be tried is valid, bad settings are pruned, a killed search goes on."""

import dataclasses
import inspect
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import toy_tuning
from inline import InlineWorkers
from places import ROOT
from programs import main
from refusals import refused
from research.tuning import (
    SPACES,
    TuningTask,
    describe,
    evaluate_settings,
    tune,
    tuner,
)
from research.tuning.command import task_of
from research.tuning.record import confirmation, ranking, tried_first
from research.tuning.spaces.population import evolved
from tegotae import TegotaeError, Timing
from tegotae.measures.objectives.fitness import Fitness
from tegotae.simulation import native
from tegotae.systems.recipe import recipe
from tegotae.training import settings as configurations
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import (
    agents,
    configuration,
    evolutions,
    learner,
    load_configuration,
    settings_named,
    tuned,
)
from toy_tuning import TASK

optuna = pytest.importorskip("optuna")

TINY = TuningTask(
    experiments=(
        recipe("AR").experiment(
            budget=8,
            timing=Timing(duration_s=3.0, tick_s=0.004),
            objective=Fitness(settle_s=1.0),
        ),
    ),
    seeds=2,
    budget_s=256 * 3.0,
)
"""A task that can be trained for in a test."""


PROCESSES = tuner._pool


@pytest.fixture
def toy(monkeypatch):
    """Makes the toy space known to `tune`, as a user's own space is made known.

    It is searched without processes, but for tests of these.
    """
    monkeypatch.setitem(SPACES, "toy", toy_tuning.space())
    monkeypatch.setattr(tuner, "_pool", InlineWorkers)


def search(storage: Path, trials: int, **options):
    return tune("toy", TASK, storage, trials=trials, **options)


def states(trials) -> list[str]:
    return [trial.state.name for trial in trials]


# What may be tried.


@pytest.mark.parametrize("algorithm", SPACES)
def test_every_point_of_a_space_is_a_valid_setting_of_its_algorithm(algorithm):
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    for _ in range(100):
        settings = SPACES[algorithm].suggest(study.ask())
        assert isinstance(settings, learner(algorithm))


@pytest.mark.parametrize("algorithm", ["cma-es", "openai-es", "snes"])
def test_a_search_begins_with_the_settings_that_the_algorithm_has_by_default(algorithm):
    first = tried_first(SPACES[algorithm])
    assert dataclasses.asdict(first) == pytest.approx(dataclasses.asdict(learner(algorithm)()))


def test_the_search_that_found_the_steps_of_pgpe_begins_where_it_began():
    began = configuration("pgpe-80x16").found["tried_first"]["settings"]  # type: ignore[index]
    assert dataclasses.asdict(tried_first(SPACES["pgpe"])) == pytest.approx(began)


@pytest.mark.parametrize("algorithm", evolutions())
def test_every_setting_is_worth_the_same_simulated_time(algorithm):
    """Every budget buys a whole number of generations, at least one."""
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    task = dataclasses.replace(TINY, budget_s=1000 * 3.0)
    (experiment,) = task.experiments
    for _ in range(30):
        population = SPACES[algorithm].suggest(study.ask()).population
        minimum = SPACES[algorithm].least_episodes
        assert population <= minimum <= task.episodes(experiment, minimum=population)


# How a setting is judged.


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """Population, seeds and fitness of a training on disk that spends what TINY allows."""
    run = Run(
        experiment=TINY.experiments[0],
        seeds=(7, 8),
        learner=Evolution(
            algorithm=PGPE(population=16, learning_rate=0.1), stopping=Stopping.after(16)
        ),
    )
    paths = train(run, tmp_path_factory.mktemp("trained"))
    return run, [json.loads(path.read_text())["training"]["best_fitness"] for path in paths]


def test_a_value_is_the_best_fitness_of_a_training_that_spends_the_budget(trained):
    run, fitness = trained
    assert evolved(run.learner.algorithm, TINY, TINY.experiments[0], run.seeds) == pytest.approx(
        fitness
    )


def test_settings_that_differ_in_no_shape_share_one_compiled_program(trained):
    run, fitness = trained
    # Programs of an earlier test may have been dropped to save memory: compile here.
    evolved(run.learner.algorithm, TINY, TINY.experiments[0], run.seeds)
    compiled = native._kernel.cache_info().misses
    variant = dataclasses.replace(run.learner.algorithm, std=0.05, learning_rate=0.3, max_speed=0.9)
    assert evolved(variant, TINY, TINY.experiments[0], run.seeds) != pytest.approx(fitness)
    assert native._kernel.cache_info().misses == compiled


def test_a_trials_value_is_the_mean_over_models_and_seeds(toy, tmp_path):
    (trial,) = search(tmp_path / "s", 1)
    expected = [
        toy_tuning.parabola(toy_tuning.Toy(0.0), TASK, experiment, (TASK.first_seed + seed,))[0]
        for experiment in TASK.experiments
        for seed in range(TASK.seeds)
    ]
    assert [trial.intermediate_values[i] for i in range(TASK.instances)] == expected
    assert trial.value == pytest.approx(np.mean(expected))


def test_bad_settings_are_given_up_before_all_seeds_are_trained(toy, tmp_path):
    trials = search(tmp_path / "s", 25)
    pruned = [trial for trial in trials if trial.state.name == "PRUNED"]
    assert pruned
    best = ranking(trials)[0]
    for trial in pruned:
        assert 0 < len(trial.intermediate_values) < TASK.instances
        assert abs(trial.params["x"] - 1.0) > abs(best.params["x"] - 1.0)


def test_the_search_improves_on_what_it_began_with(toy, tmp_path):
    trials = search(tmp_path / "s", 25, workers=2)
    assert trials[0].params == {"x": 0.0}
    assert abs(ranking(trials)[0].params["x"] - 1.0) < 0.5


@pytest.mark.thorough
def test_the_order_of_the_work_of_many_workers_does_not_mix_up_the_values():
    settings = [toy_tuning.Toy(x) for x in (0.0, 1.0, 3.0)]
    values = evaluate_settings(toy_tuning.space(), settings, TASK, workers=3)
    expected = [
        [
            toy_tuning.parabola(each_setting, TASK, experiment, (TASK.first_seed + seed,))[0]
            for experiment in TASK.experiments
            for seed in range(TASK.seeds)
        ]
        for each_setting in settings
    ]
    np.testing.assert_array_equal(values, expected)


def test_the_best_settings_are_compared_pair_by_pair():
    first = np.array([1.0, 2.0, 30.0])
    comparison = confirmation(TASK, first, first + 1.0)
    assert comparison["difference"] == pytest.approx({"mean": 1.0, "low": 1.0, "high": 1.0})
    assert comparison["best"]["mean"] == pytest.approx(12.0)
    assert comparison["best"]["low"] < 12.0 < comparison["best"]["high"]


# Going on.


def test_a_search_goes_on_where_it_stopped_and_draws_no_settings_twice(toy, tmp_path):
    first_search = search(tmp_path / "s", 4)
    second_search = search(tmp_path / "s", 8)
    assert [trial.params for trial in second_search[:4]] == [trial.params for trial in first_search]
    assert len({trial.params["x"] for trial in second_search}) == len(second_search) == 8


def test_a_finished_search_trains_nothing(toy, tmp_path, monkeypatch):
    search(tmp_path / "s", 2)
    monkeypatch.setitem(SPACES, "toy", toy_tuning.space(toy_tuning.refusing))
    assert states(search(tmp_path / "s", 2)) == ["COMPLETE"] * 2


def test_a_killed_tuner_leaves_a_storage_that_the_next_one_goes_on_with(toy, tmp_path):
    storage, release = tmp_path / "storage", tmp_path / "release"
    os.mkfifo(release)
    killed = subprocess.Popen(
        [sys.executable, toy_tuning.__file__, str(storage)],
        env={**os.environ, "TOY_RELEASE": str(release)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert killed.stdout.readline() == "waiting\n"
    killed.kill()
    killed.wait()
    journal = storage.read_bytes()
    release.write_bytes(b"")
    # The worker holds the other end: it has ended too, without having written any more.
    assert killed.stdout.read() == ""
    assert storage.read_bytes() == journal

    trials = search(storage, 5)
    assert storage.read_bytes().startswith(journal)
    (failure,) = [trial for trial in trials if trial.state.name == "FAIL"]
    assert failure.intermediate_values
    (again,) = [trial for trial in trials if "retry_of" in trial.user_attrs]
    assert again.user_attrs["retry_of"] == failure.number
    assert again.params == failure.params
    assert len(trials) == 6


def test_half_a_line_that_a_crash_left_is_cut_off(toy, tmp_path):
    first_search = search(tmp_path / "s", 2)
    with (tmp_path / "s").open("a") as stream:
        stream.write('{"op_code":4,"worker_id":"x')
    second_search = search(tmp_path / "s", 3)
    assert [trial.params for trial in second_search[:2]] == [trial.params for trial in first_search]
    assert len(second_search) == 3


def test_a_worker_that_dies_ends_the_search_in_one_line_and_loses_nothing(
    toy, tmp_path, monkeypatch
):
    search(tmp_path / "s", 1)
    monkeypatch.setitem(SPACES, "toy", toy_tuning.space(toy_tuning.dying))
    monkeypatch.setattr(tuner, "_pool", PROCESSES)
    refused(r"a worker process has ended.*fewer workers", search, tmp_path / "s", 3)
    monkeypatch.setitem(SPACES, "toy", toy_tuning.space())
    monkeypatch.setattr(tuner, "_pool", InlineWorkers)
    trials = search(tmp_path / "s", 3)
    assert states(trials).count("FAIL") == 1
    assert len(trials) == 4


def test_what_a_training_refuses_is_said_as_it_said_it(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(SPACES, "toy", toy_tuning.space(toy_tuning.refusing))
    monkeypatch.setattr(tuner, "_pool", PROCESSES)
    refused(r"^x is out of the question$", search, tmp_path / "s", 1)


# A storage file of something else.


def test_a_storage_of_another_tuning_is_refused_with_what_differs(toy, tmp_path):
    storage = tmp_path / "s"
    search(storage, 1)
    content = storage.read_bytes()
    with pytest.raises(TegotaeError, match=r"differs in seeds, budget_s; choose another file"):
        tune("toy", dataclasses.replace(TASK, seeds=3, budget_s=9e4), storage, trials=1)
    refused(r"a tuning of toy .* differs in algorithm;", tune, "pgpe", TASK, storage, trials=1)
    assert storage.read_bytes() == content


def test_a_storage_of_another_program_is_refused(toy, tmp_path):
    storage = tmp_path / "s"
    journal = optuna.storages.journal
    backend = journal.JournalFileBackend(str(storage))
    optuna.create_study(study_name="mine", storage=journal.JournalStorage(backend))
    content = storage.read_bytes()
    refused(r"holds the study 'mine'; choose another file", search, storage, 1)
    assert storage.read_bytes() == content


@pytest.mark.parametrize("content", ["not a journal", "not\na journal\n", '{"a": 1}\n', "[1]\n"])
def test_a_file_that_is_no_storage_is_refused_and_left_as_it_was(toy, tmp_path, content):
    (tmp_path / "s").write_text(content)
    refused(r"holds no tuning.*; choose another file", search, tmp_path / "s", 1)
    assert (tmp_path / "s").read_text() == content


def test_a_storage_in_use_is_refused(toy, tmp_path):
    fcntl = pytest.importorskip("fcntl")
    search(tmp_path / "s", 1)
    with (tmp_path / "s").open() as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        refused(r"in use by another tuner", search, tmp_path / "s", 2)


# Named configurations.


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


# The command, and its page.


def test_the_examples_of_the_page_run(toy, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(SPACES, "my-cma-es", None)  # the page's own is taken away afterwards
    search(tmp_path / "pgpe.journal", 2)
    page = ROOT / "docs" / "tuning.md"
    blocks = re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    for block in blocks:
        exec(block, {})
    assert capsys.readouterr().out.startswith("2 ")
    assert SPACES["my-cma-es"] is not None


@pytest.mark.thorough
def test_the_command_keeps_settings_that_are_a_configuration(tmp_path, capsys):
    arguments = [
        "tuning",
        "AR",
        "--storage",
        str(tmp_path / "s"),
        "--keep",
        str(tmp_path / "k.json"),
    ]
    arguments += ["--trials", "2", "--seeds", "2", "--confirm", "2", "--simulated-s", "768"]
    arguments += ["--duration-s", "3", "--tick-s", "0.004", "--settle-s", "1", "--budget", "8"]
    assert main([*arguments, "--algorithm", "openai-es"]) == 0
    saved = load_configuration(tmp_path / "k.json")
    assert saved.algorithm == "openai-es"
    assert saved.found["trials"] == {"complete": 2, "pruned": 0, "fail": 0}
    assert [entry["name"] for entry in saved.found["task"]["experiments"]] == ["AR-rF-reflex-w8"]
    assert saved.found["confirmation"]["first_seed"] != saved.found["task"]["first_seed"]
    out = capsys.readouterr().out
    assert re.search(rf"^ *population +{saved.settings.population} *$", out, re.MULTILINE)
    assert "2 fresh seeds" in out


def test_a_configuration_is_of_the_best_trial(toy, tmp_path):
    trials = search(tmp_path / "s", 6)
    document = describe("toy", TASK, SPACES["toy"], trials)
    best = max((t for t in trials if t.state.name == "COMPLETE"), key=lambda t: t.value)
    assert document["settings"] == best.params
    assert document["found"]["mean_fitness"] == best.value
    assert document["found"]["tried_first"]["settings"] == {"x": 0.0}
    assert document["found"]["tried_first"]["mean_fitness"] == trials[0].value


def test_without_optuna_the_extra_is_named(one_line_error, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    message = one_line_error("tuning", "ART", "--storage", str(tmp_path / "s"))
    assert "pip install 'tegotae[tune]'" in message


@pytest.mark.parametrize(("algorithm", "follows"), [("pgpe", True), ("sac", False), ("ppo", False)])
def test_agents_are_tuned_for_what_they_are_paid(algorithm, follows):
    options = {"algorithm": algorithm, "seeds": 2, "simulated_s": 96.0}
    assert task_of(["AR"], options).experiments[0].objective.follow_omega is follows
