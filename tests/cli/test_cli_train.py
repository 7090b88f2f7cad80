"""`tegotae train`: controllers and what they are made of, in a folder; Ctrl-C loses nothing."""

import csv
import importlib.metadata
import json
import os
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

import tiny
from refusals import refused
from tegotae.api.experiments import adjusted
from tegotae.api.trained import TrainedControllers
from tegotae.cli import main
from tegotae.parts.bodies import Hopper
from tegotae.parts.fields import replace
from tegotae.parts.terms import SectorAndReflex
from tegotae.systems import controller_file
from tegotae.systems.experiment import GAINS
from tegotae.systems.recipe import recipe
from tegotae.training.curves import longest_s, read_curves
from tegotae.training.run import train


@pytest.fixture
def no_training(monkeypatch):
    """Makes any training, search or start of one fail the test."""

    def begin(*_, **__):
        raise AssertionError("a training was started before the input was checked")

    for name in ("Evolution.start", "Evolution.evolve", "best_gain"):
        monkeypatch.setattr(f"tegotae.training.evolution.{name}", begin)


# What it leaves.


def test_controllers_curves_configuration_and_versions_are_written(tiny_training):
    assert sorted(tiny.contents(tiny_training)) == [
        "ART-rF-tphif-w8-seed0.json",
        "ART-rF-tphif-w8-seed1.json",
        "checkpoint.npz",
        "curves.csv",
        "run.json",
    ]
    document = json.loads((tiny_training / "run.json").read_text())
    assert document["configuration"] == json.loads(json.dumps(tiny.RUN.configuration))
    assert document["software"]["jax"] == importlib.metadata.version("jax")
    assert document["software"]["tegotae"] == importlib.metadata.version("tegotae")
    with (tiny_training / "curves.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(int(row["seed"]), int(row["step"])) for row in rows] == [
        (seed, generation) for seed in tiny.SEEDS for generation in range(tiny.GENERATIONS)
    ]
    curves = {"fitness", "cot_inverse", "mean_fitness", "best_fitness"}
    assert all(np.isfinite(float(row[name])) for row in rows for name in curves)
    assert all(0.0 <= float(row["failed_share"]) <= 1.0 for row in rows)


def test_nothing_that_is_written_needs_pickle(tiny_training):
    with np.load(tiny_training / "checkpoint.npz", allow_pickle=False) as stored:
        assert all(stored[name].dtype != object for name in stored.files)
    for path in tiny_training.glob("*.json"):
        json.loads(path.read_text())


def test_how_it_went_is_printed_and_how_far_it_is_goes_to_stderr(capsys, tmp_path):
    assert tiny.train(tmp_path, "--seeds", "2") == 0
    out, err = capsys.readouterr()
    for path in tiny.controllers(tmp_path):
        (line,) = (line for line in out.splitlines() if path.name in line)
        training = controller_file.load(path).training
        assert line.split(maxsplit=4)[1:4] == [
            f"{training['best_fitness']:.4f}",
            str(training["best_generation"]),
            str(tiny.GENERATIONS),
        ]
        assert line.strip().endswith("at the cap: more generations may gain more")
    first, *_, last = err.splitlines()
    assert first.startswith("ART-rF-tphif-w8  1/4  fitness ")
    assert "CoT⁻¹" in first
    assert last.startswith("ART-rF-tphif-w8  4/4  ")
    assert last.endswith(" s left")


def test_that_no_candidate_came_through_its_episode_is_said(tiny_training, tmp_path):
    good, bad = tiny.controllers(tiny_training)
    lost = json.loads(bad.read_text())
    lost["training"]["best_fitness"] = -999999.875
    path = tmp_path / bad.name
    path.write_text(json.dumps(lost))
    assert TrainedControllers.from_files("ART", tmp_path, (good,), "generation").notes == []
    _, said = TrainedControllers.from_files("ART", tmp_path, (good, path), "generation").notes
    assert said.startswith("1 of 2 learned nothing: no candidate survived")


def test_a_training_that_never_gained_says_what_to_try(tiny_training, tmp_path):
    (good, *_) = tiny.controllers(tiny_training)
    kept = json.loads(good.read_text())
    for best, length, says in ((0, 100, True), (1, 100, False), (0, 10, False)):
        kept["training"] |= {"best_generation": best, "generations": length}
        (path := tmp_path / good.name).write_text(json.dumps(kept))
        notes = TrainedControllers.from_files("ART", tmp_path, (path,), "generation").notes
        assert [note.startswith("1 of 1 never got better") for note in notes] == [True] * says


@pytest.mark.parametrize(
    ("unit", "cure"), [("generation", "--std"), ("episode", "--learning-rate")]
)
def test_a_stuck_training_is_told_options_of_its_own_algorithm(tiny_training, tmp_path, unit, cure):
    (good, *_) = tiny.controllers(tiny_training)
    kept = json.loads(good.read_text())
    kept["training"] |= {f"best_{unit}": 0, f"{unit}s": 100}
    (path := tmp_path / good.name).write_text(json.dumps(kept))
    (note,) = TrainedControllers.from_files("ART", tmp_path, (path,), unit).notes
    assert cure in note
    assert ("cma-es" in note) == (unit == "generation")


def test_all_runs_of_a_training_are_evaluated_together(tiny_training):
    trained = TrainedControllers.from_files(
        "ART", tiny_training, tuple(tiny.controllers(tiny_training)), "generation"
    )
    judged = trained.controllers.evaluate(
        metric=("failed_share",), protocol={"undisturbed_s": 2.0}
    ).table
    assert judged["run"].nunique() == len(tiny.SEEDS)


@pytest.mark.parametrize("seed", tiny.SEEDS)
def test_simulate_reads_a_trained_controller(capsys, tiny_training, seed):
    path = tiny.controllers(tiny_training)[seed]
    assert main(["simulate", str(path), "--duration-s", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["settings"]["omega"] == 8.0


def test_the_folder_is_named_after_the_model_unless_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = [*tiny.OPTIONS, "--generations", "1"]
    assert main(["train", *words]) == 0
    assert (tmp_path / "runs" / "ART-rF-tphif-w8" / "run.json").exists()


def test_the_first_seed_is_an_option(tmp_path, tiny_training):
    assert tiny.train(tmp_path, "--first-seed", "1") == 0
    names = sorted(path.name for path in tmp_path.glob("*-seed*.json"))
    assert names == [f"ART-rF-tphif-w8-seed{seed}.json" for seed in (1, 2)]
    one = controller_file.load(tmp_path / names[0]).weights
    np.testing.assert_array_equal(one, tiny.learned(tiny_training)["weights"][1])


def test_a_training_goes_on_from_the_weights_of_a_controller_by_name(tmp_path, tiny_training):
    path = tiny.controllers(tiny_training)[0]
    assert tiny.train(tmp_path, "--start", str(path)) == 0
    first = read_curves([tmp_path], "fitness").groupby("seed")["fitness"].first()
    best = controller_file.load(path).training["best_fitness"]
    assert first.tolist() == pytest.approx([best, best], rel=1e-5)


def test_a_controller_of_another_model_is_no_start(tmp_path, one_line_error, no_training):
    words = "train", *tiny.OPTIONS, "--start", "zoo:AR-rF-sector-w8", "--out", str(tmp_path)
    assert "has other terms than ART-rF-tphif-w8; start from" in one_line_error(*words)


def test_a_vanilla_models_gain_is_found_by_search(capsys, tmp_path):
    words = ["--seeds", "2", "--duration-s", "3", "--settle-s", "1", "--out", str(tmp_path)]
    assert main(["train", "V-reflex-w8", *words]) == 0
    # A search is the same for every seed: one controller.
    (path,) = tmp_path.glob("*-seed*.json")
    (sigma,) = controller_file.load(path).weights
    assert sigma in GAINS
    assert str(path) in capsys.readouterr().out


# Going on.


def test_training_in_two_parts_equals_training_in_one_bit_for_bit(tiny_training, tmp_path):
    assert tiny.train(tmp_path, generations=2) == 0
    header, *rows = tiny.learned(tiny_training)["curves"]
    assert tiny.learned(tmp_path)["curves"] == [header, *(row for row in rows if int(row[1]) < 2)]
    assert tiny.train(tmp_path) == 0
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)


def test_fewer_generations_than_there_are_is_refused(tiny_training, one_line_error):
    before = tiny.contents(tiny_training)
    words = [*tiny.OPTIONS, "--out", str(tiny_training), "--generations", "3"]
    assert "generations is 3, and 4 have been trained already" in one_line_error("train", *words)
    assert tiny.contents(tiny_training) == before


def test_a_training_does_not_go_on_under_other_versions(tiny_training, tmp_path, one_line_error):
    folder = tmp_path / "earlier"
    shutil.copytree(tiny_training, folder)
    document = json.loads((folder / "run.json").read_text())
    document["software"] |= {"jax": "0.4.30", "numpy": "2.0.0"}
    (folder / "run.json").write_text(json.dumps(document))
    before = tiny.contents(folder)
    words = [*tiny.OPTIONS, "--out", str(folder), "--generations", "5"]
    said = one_line_error("train", *words)
    assert "made with jax 0.4.30, numpy 2.0.0, and here is jax" in said
    assert "install those versions, choose another folder with --out, or start again" in said
    assert tiny.contents(folder) == before


def test_a_folder_without_a_training_says_nothing_of_how_long_to_learn(tmp_path):
    refused("holds no training to learn as long as", longest_s, tmp_path)


def test_ctrl_c_keeps_what_was_learned_and_says_so_in_one_line(tmp_path):
    words = [*tiny.OPTIONS, "--generations", "1000000", "--out", str(tmp_path)]
    script = "import conftest; from tegotae.cli import entry; entry()"
    process = subprocess.Popen(
        [sys.executable, "-c", script, "train", *words],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    # The first line about progress: a generation is done, and a million are to come.
    first = next(line for line in process.stderr if " 1/1000000 " in line)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=900)
    assert process.returncode == 130
    assert out == ""
    *progress, last = [first, *err.splitlines()]
    assert last == (
        f"tegotae: interrupted; {tmp_path} keeps what was learned, "
        "the same command continues from there"
    )
    assert all(line.startswith("ART-rF-tphif-w8  ") for line in progress)

    kept = tiny.learned(tmp_path)
    generations = kept["training"][0]["generations"]
    assert 1 <= generations < 1_000_000
    undisturbed = tmp_path / "undisturbed"
    train(tiny.run_of(generations), undisturbed)
    # What was interrupted has not ended; what was asked for so many generations has.
    assert [each.pop("ended") for each in kept["training"]] == ["", ""]
    whole = tiny.learned(undisturbed)
    assert [each.pop("ended") for each in whole["training"]] == ["cap", "cap"]
    assert whole == kept


FIRST = """
import sys
import conftest  # the tests' promotion rules: with others XLA may round otherwise
import tiny
from tegotae.cli import entry
from tegotae.training.evolution import Evolution

start = Evolution.start

def wait_and_start(*arguments):
    print("at work", flush=True)
    sys.stdin.readline()
    return start(*arguments)

Evolution.start = wait_and_start
entry()
"""
"""`tegotae train` that waits where it has claimed its folder, before it learns anything."""


def test_a_second_training_in_a_folder_is_refused_and_the_first_undisturbed(
    tiny_training, tmp_path, one_line_error
):
    words = ["train", *tiny.OPTIONS, "--generations", str(tiny.GENERATIONS), "--out", str(tmp_path)]
    with subprocess.Popen(
        [sys.executable, "-c", FIRST, *words],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as first:
        assert first.stdout is not None
        assert first.stdout.readline() == "at work\n"
        assert one_line_error(*words, "--first-seed", "5") == (
            f"tegotae: another run is at work in {tmp_path}; "
            "wait for it, or choose another folder\n"
        )
        _, err = first.communicate("go on\n", timeout=900)
        assert first.returncode == 0, err
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)
    assert sorted(tiny.contents(tmp_path)) == sorted(tiny.contents(tiny_training))


# TensorBoard.


def test_tensorboard_logs_lie_beside_the_controllers(tiny_training, tmp_path):
    pytest.importorskip("tensorboardX")
    assert tiny.train(tmp_path, "--tensorboard") == 0
    (events,) = (tmp_path / "tensorboard").iterdir()
    assert events.name.startswith("events.out.tfevents")
    assert b"cot_inverse/seed0" in events.read_bytes()
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)


def test_without_tensorboardx_its_option_names_the_extra_at_once(
    tmp_path, monkeypatch, one_line_error, no_training
):
    monkeypatch.setitem(sys.modules, "tensorboardX", None)
    words = [*tiny.OPTIONS, "--tensorboard", "--out", str(tmp_path / "new")]
    assert "pip install 'tegotae[tensorboard]'" in one_line_error("train", *words)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("model", ["ART", "V"])
@pytest.mark.parametrize(
    ("place", "said"), [("file", "it is a file"), ("file/folder", "Not a directory")]
)
def test_a_folder_that_cannot_be_written_is_refused_before_the_training(
    tmp_path, one_line_error, no_training, model, place, said
):
    (tmp_path / "file").touch()
    out = str(tmp_path / place)
    for more in ([], ["--tensorboard"]):
        error = one_line_error("train", model, "--out", out, *more)
        assert f"cannot write to the folder {out}: {said}" in error


# What the paper leaves open of vanilla parts.


def applied(name, **given):
    experiment = recipe(name).experiment()
    return adjusted(experiment, given)


def test_options_of_vanilla_parts_are_in_the_experiment_and_learned_ones_have_none():
    given = {"sector_start_rad": 5.0, "sector_duration_s": 0.06, "newtons_per_feedback": 2.0}
    both = applied("V-both-w8", **given, tuned_over=(-1.0, 1.0))
    assert both.controller.actuation == SectorAndReflex(5.0, 0.0, 0.06, 2.0)
    assert both.search_offsets == (-1.0, 1.0)
    assert applied("ART", **given).controller == recipe("ART").experiment().controller
    assert applied("V-both-w8") == recipe("V-both-w8").experiment()


def test_a_sector_that_lasts_no_time_is_refused():
    refused("duration_s", applied, "V-sector-w8", sector_duration_s=-0.1)


def test_a_gain_is_searched_for_at_the_same_weights_on_any_hopper():
    plain = recipe("V-sector-w8").experiment()
    heavy = replace(plain, {"body": Hopper(mass_kg=0.2, stiffness_n_per_m=10.0, max_force_n=8.0)})
    np.testing.assert_array_equal(plain.gains, GAINS)
    np.testing.assert_allclose(heavy.gains * heavy.body.weight_n, GAINS * plain.body.weight_n)
