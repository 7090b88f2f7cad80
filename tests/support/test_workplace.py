"""A folder is for one kind of work, and work that is begun anew loses nothing."""

import json

import pytest

import tiny
from programs import main
from refusals import refused
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from tegotae import TegotaeError
from tegotae._support.workplace import (
    GENERALISATION,
    STUDY,
    TRAINING,
    alone,
    earlier,
)
from tegotae.analysis.generalisation.run import generalise
from tegotae.systems.recipe import recipe
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.collection import read_runs
from tegotae.training.run import Run, train

HELD = {
    "a training": "run.json",
    "a study": "study.json",
    "a test of robustness": "records/a.trial.npz",
    "a map of gaits": "records/a.map.npz",
}
WORDS = {
    "a training": ["train", "AR", "--out"],
    "a study": ["reproduction", "run", "--scale", "smoke", "--dir"],
    "a test of robustness": ["robustness", "V-sector-w8", "--out"],
    "a map of gaits": [
        *("gait", "map", "bar-light", "--x", "sigma", "1", "2", "--y", "omega", "6", "8", "--out")
    ],
}


def held(folder, kind: str):
    """The folder, with what such work leaves there."""
    path = folder / HELD[kind]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("{}")
    return folder


@pytest.mark.parametrize(
    ("content", "work"), [(content, work) for content in HELD for work in WORDS if content != work]
)
def test_work_does_not_take_the_folder_of_another_kind(content, work, tmp_path, one_line_error):
    folder = held(tmp_path / "out", content)
    previous = tiny.contents(folder)
    message = one_line_error(*WORDS[work], str(folder))
    assert f"holds {content}, and is not for {work}; choose another folder" in message
    assert tiny.contents(folder) == previous


def test_neither_do_a_multiverse_agents_or_training_on_an_environment(tmp_path, one_line_error):
    training = str(held(tmp_path / "training", "a training"))
    study = held(tmp_path / "study", "a study")
    message = "and is not for a study"
    assert message in one_line_error(
        "reproduction", "readings", "run", "--scale", "smoke", "--dir", training
    )
    pytest.importorskip("stable_baselines3")
    with pytest.raises(TegotaeError, match="holds a study, and is not for a training"):
        train(Run(experiment=recipe("AR").experiment(), learner=AgentLearner()), study)
    pytest.importorskip("mujoco")
    words = ["train", "AR", "--env", "hopper", "--omega", "8", "--workers", "0"]
    assert "and is not for a training" in one_line_error(*words, "--out", str(study))


def test_a_training_that_is_begun_anew_sets_the_earlier_one_aside(tmp_path, capsys, one_line_error):
    out = tmp_path / "art"
    assert tiny.train(out, generations=1) == 0
    previous = tiny.contents(out)
    second = ["train", *tiny.OPTIONS, "--generations", "1", "--out", str(out), "--mass-kg", "0.12"]
    capsys.readouterr()
    assert "or start again with --restart" in one_line_error(*second)
    assert main([*second, "--restart"]) == 0
    aside = tmp_path / "art.earlier1"
    assert f"is now in {aside}" in capsys.readouterr().out
    assert tiny.contents(aside) == previous
    saved = json.loads((out / "run.json").read_text())["configuration"]["experiment"]
    assert saved["system"]["body"]["mass_kg"] == 0.12
    assert [len(runs.labels) for runs in read_runs(tmp_path)] == [2]  # of the new one alone
    assert [len(runs.labels) for runs in read_runs(aside)] == [2]


def test_so_do_a_study_and_what_controllers_generalise_to(tmp_path):
    folder = Folder(tmp_path / "study")
    with folder.claimed(plan("smoke", "V-*")):
        pass
    with folder.claimed(plan("smoke", "ART-*"), restart=True):
        assert list(folder.document["experiments"]) == ["ART-rF-tphif-w8"]
    assert "V-sector-w8" in Folder(tmp_path / "study.earlier1").document["experiments"]
    tried = held(tmp_path / "tried", "a test of robustness")
    with alone(tried, GENERALISATION, restart=True):
        assert not (tried / "records").exists()
    assert (tmp_path / "tried.earlier1" / "records" / "a.trial.npz").exists()
    refused("no controllers", generalise, [], [], tried, restart=True)


def test_what_others_left_in_a_folder_is_not_set_aside(tmp_path):
    folder = held(tmp_path / "out", "a training")
    (folder / "notes.txt").write_text("mine")
    with alone(folder, TRAINING, restart=True):
        assert [path.name for path in folder.iterdir() if path.name != ".lock"] == ["notes.txt"]
    with alone(folder, STUDY, restart=True):
        pass
    assert not earlier(folder).name.endswith("earlier1")
