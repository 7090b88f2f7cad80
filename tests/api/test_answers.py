"""Answers: which runs are paired, what an interval is called, and how sets are told apart."""

import json
from pathlib import Path

import numpy as np
import pytest

from refusals import refused
from tegotae.api.controllers import load, load_all
from tegotae.api.evaluations import EXACT, INDEPENDENT, PAIRED, EvaluationTable
from tegotae.api.hopping import HopperController
from tegotae.api.parameters import filled
from tegotae.api.results import Film
from tegotae.cli import main
from tegotae.measures.metric import Metric
from tegotae.measures.statistics import interval
from tegotae.systems import controller_file
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.system import System

REFLEX, ART = recipe("V-reflex-w8").controller(), recipe("ART").controller()
SHARE = Metric(name="share", label="share", about="", range=(0.0, 1.0), more_is_better=True)
TRAINING = {"release": {"height_m": 1.2}, "algorithm": {"name": "pgpe", "population": 16}}
CMA_ES = {"algorithm": {"name": "cma-es", "population": 16}}
VARIED = {"conditions": [{"kind": "Uniform"}]}


def runs(name: str, controller=REFLEX, labels=("0", "1"), **training) -> ControllerSet:
    weights = np.ones((len(labels), controller.n_weights))
    return ControllerSet(name, System(controller=controller, omega=8.0), weights, labels, training)


def trained(name: str, controller=REFLEX, labels=("0", "1"), **changed) -> ControllerSet:
    return runs(name, controller, labels, **{**TRAINING, **changed})


def answer(one: ControllerSet, shares: tuple[float, ...]) -> EvaluationTable:
    controller = HopperController(one)
    options = filled({"protocol": None}, controller.defaults())
    rows = {"run": one.labels, "share": shares}
    return controller._measurements(rows, (SHARE,), options)


def compared(
    ours: ControllerSet, base: ControllerSet, ours_are=None, base_is=None
) -> EvaluationTable:
    shares = [given or (0.5,) * len(x.labels) for x, given in ((base, base_is), (ours, ours_are))]
    both = EvaluationTable.joined([answer(base, shares[0]), answer(ours, shares[1])])
    return both.compared_with(base.name)


@pytest.mark.parametrize(
    ("other", "how"),
    [
        (trained("b"), PAIRED),
        (trained("b", release={"height_m": 1.4}), PAIRED),  # which draws nothing
        (trained("b", labels=("0", "2")), INDEPENDENT),
        (trained("b", recipe("V-sector-w8").controller()), INDEPENDENT),
        (trained("b", ART), INDEPENDENT),
        (trained("b", **CMA_ES), INDEPENDENT),
        (trained("b", **VARIED), INDEPENDENT),
        (runs("b"), INDEPENDENT),
        (runs("b", labels=("search",)), EXACT),
    ],
)
def test_runs_are_paired_where_they_share_what_is_random_and_nowhere_else(other, how):
    assert compared(other, trained("a")).differences()["runs"].tolist() == [how]
    assert compared(trained("a"), other).differences()["runs"].tolist() == [how]


def test_two_unknown_trainings_are_not_paired_by_the_numbers_of_their_seeds():
    assert compared(runs("a"), runs("b")).differences()["runs"].tolist() == [INDEPENDENT]


def test_against_a_gain_that_a_search_found_the_interval_is_that_of_the_others():
    learned, shares = trained("learned", ART, ("0", "1", "2")), (0.7, 0.8, 0.9)
    single = runs("single", labels=("search",))
    (share,) = compared(learned, single, shares, (0.5,)).differences()["share"]
    alone = interval(np.array(shares) - 0.5)
    assert (share.mean, share.low, share.high) == pytest.approx((0.3, alone.low, alone.high))
    one = trained("one", ART, ("0",))
    (share,) = compared(learned, one, shares, (0.5,)).differences()["share"]
    assert np.isnan(share.low), "a single learned run is a sample of many"


def test_the_interval_of_a_difference_is_called_what_it_is():
    said = compared(trained("b"), trained("a"), (0.5, 0.6)).texts()[1]
    assert said["interval"].tolist() == ["paired runs, Student's t"]
    one = runs("one", labels=("search",))
    said = compared(one, runs("two", labels=("search",))).texts()[1]
    assert said["interval"].tolist() == ["one run is exact, no interval"]


def test_an_answer_is_a_table_that_prints_draws_and_writes(tmp_path):
    both = compared(trained("b"), trained("a"), (0.9, 1.0), (0.1, 0.2))
    assert "minus a" in repr(both)
    assert "0.8 [0.8, 0.8] +" in repr(both)
    assert "<table" in both._repr_html_()
    assert both.table["controller"].tolist() == ["a", "a", "b", "b"]
    names = sorted(path.name for path in both.save(tmp_path))
    assert names == ["intervals.png", "numbers.csv", "numbers.json"]
    document = json.loads((tmp_path / "numbers.json").read_text())
    assert document["differences"][0]["share"]["mean"] == pytest.approx(0.8)
    assert document["settings"]["a"]["protocol"]["drop_m"] == 0.2


# How sets are told apart.


@pytest.fixture
def two_folders(tmp_path, monkeypatch):
    """Two trainings of one model."""
    for folder, gain, seeds in (("first", 2.0, 3), ("second", 3.0, 4)):
        (tmp_path / folder).mkdir()
        for seed in range(seeds):
            saved = SavedController.from_weights(
                REFLEX, np.array([gain + 0.1 * seed]), 8.0, name="V-reflex-w8",
                training={"seed": seed},
            )  # fmt: skip
            controller_file.save(saved, tmp_path / folder / f"{seed}.json")
    monkeypatch.chdir(tmp_path)
    return "first", "second"


def test_sets_called_alike_are_named_by_their_place(two_folders):
    names = [task.name for task in load_all(*two_folders, "V-sector-w8")]
    assert names == ["V-reflex-w8 (first)", "V-reflex-w8 (second)", "V-sector-w8"]


def test_two_folders_of_the_same_model_are_compared(two_folders, capsys):
    words = ["--undisturbed-s", "4", "--disturbed-s", "4", "--metric", "cot_inverse", "--json"]
    assert main(["compare", *two_folders, *words]) == 0
    document = json.loads(capsys.readouterr().out)
    (found,) = document["differences"]
    assert (found["controller"], found["minus"]) == ("V-reflex-w8 (second)", "V-reflex-w8 (first)")
    assert found["runs"] == INDEPENDENT
    assert len(document["rows"]) == 7 * 5


def test_runs_that_two_names_hold_are_refused(two_folders, one_line_error):
    said = one_line_error("compare", "first", "second", "first/0.json")
    assert "first and first/0.json hold the same runs of V-reflex-w8" in said
    assert "name them once" in one_line_error("robustness", "first", "first")


def test_a_summary_shows_means_with_their_intervals():
    shown = answer(trained("a"), (0.5, 0.7)).summary().to_string()
    assert "0.6 [" in shown
    assert "Interval" not in shown


@pytest.mark.parametrize(
    ("film", "shown"),
    [
        (Film(b"GIF89a"), '<img src="data:image/gif;base64,R0lGODlh">'),
        (Film(b"GIF89a", Path("hop.gif")), '<img src="data:image/gif;base64,R0lGODlh">'),
        (Film(b"GIF89a", Path("hop.webp")), '<img src="data:image/webp;base64,R0lGODlh">'),
        (
            Film(b"mp4", Path("hop.mp4")),
            '<video controls src="data:video/mp4;base64,bXA0"></video>',
        ),
    ],
)
def test_a_notebook_shows_a_film_whether_it_was_written_or_not(film, shown):
    assert film._repr_html_() == shown


def test_a_film_that_was_written_is_called_by_its_file(tmp_path):
    run = load("paper").simulate(duration_s=2.0)
    film = run.animate(tmp_path / "hop.gif")
    assert str(film) == str(tmp_path / "hop.gif")
    assert film.content == (tmp_path / "hop.gif").read_bytes()


def test_a_loaded_controller_shows_its_name_and_size():
    assert repr(load("zoo:ART/all")) == "<HopperController ART-rF-tphif-w8: 15 runs of 96 weights>"
    assert repr(load("quadruped-c")) == "<WalkerController quadruped-c: 1 run of 1 weight>"


def test_the_runs_of_a_training_can_be_loaded_as_an_object():
    runs = load("zoo:ART/all").runs
    assert np.array_equal(load(runs).runs.weights, runs.weights)
    assert load(runs).name == runs.name


@pytest.mark.parametrize("value", [3, None, {"a": 1}, object()])
def test_an_object_that_is_no_controller_is_refused(value):
    refused("it must be a text or an object with weights", load, value)


STIFF = "zoo:ARGT-rF-gF-tphi-w4/2"


def test_an_evaluation_names_the_controllers_that_its_tick_does_not_resolve():
    table = load("V-reflex-w8").evaluate(STIFF, protocol={"tick_s": 0.002}, metric=("cot_inverse",))
    unresolved = table.table.groupby("controller").resolved.agg(lambda x: (~x).sum())
    assert unresolved.to_dict() == {"V-reflex-w8": 0, "ARGT-rF-gF-tphi-w4": 4}
    (note,) = [note for note in table.notes if "resolved" in note]
    assert note.startswith("Not resolved by a tick of 2 ms: 4 of 5 episodes of ARGT-rF-gF-tphi-w4.")


def test_a_rollout_says_if_its_tick_does_not_resolve_it_unless_the_controller_is_held():
    def notes(name, **options):
        return [note for note in load(name).simulate(**options).notes if "resolved" in note]

    assert notes(STIFF, tick_s=0.002) == [
        "Not resolved by a tick of 2 ms: half the tick moves an apex by 0.049 m."
    ]
    assert notes(STIFF, tick_s=0.002, hold=True) == notes("V-reflex-w8") == []
