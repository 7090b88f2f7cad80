"""`tegotae compare` names both sides apart, and says what its intervals are."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tegotae import build
from tegotae.cli import main
from tegotae.cli.compare import (
    EXACT,
    INDEPENDENT,
    PAIRED,
    compare,
    methods,
    paired,
    with_distinct_names,
)
from tegotae.measures.evaluation import Evaluation, Protocol
from tegotae.measures.hopping.registry import names as metric_names
from tegotae.measures.hopping.statistics import interval
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.controller_set import ControllerSet
from tegotae.systems.system import System

REFLEX = build("V-reflex-w8")
HOPPER = System(controller=REFLEX, omega=8.0)


def runs(name: str, number: int = 3) -> ControllerSet:
    labels = tuple(map(str, range(number)))
    return ControllerSet(name, HOPPER, np.ones((number, 1)), labels)


def names(*sets: tuple[str, str]) -> list[str]:
    return [
        found.name for found in with_distinct_names([(place, runs(name)) for place, name in sets])
    ]


@pytest.mark.parametrize(
    ("sets", "expected"),
    [
        ((("a", "ART"), ("b", "VG")), ["ART", "VG"]),
        ((("a", "ART"), ("b", "ART")), ["ART (a)", "ART (b)"]),
        ((("a", "ART"), ("b", "ART"), ("b", "VG")), ["ART (a)", "ART (b)", "VG"]),
        ((("a", "ART"), ("a", "ART")), ["ART (a) (no. 1)", "ART (a) (no. 2)"]),
        (
            (("a", "ART"), ("b", "ART"), ("a", "ART")),
            ["ART (a) (no. 1)", "ART (b)", "ART (a) (no. 2)"],
        ),
    ],
)
def test_sets_called_alike_are_distinguished_by_their_place(sets, expected):
    assert names(*sets) == expected


def test_the_interval_of_a_difference_is_called_what_it_is():
    few, many = interval([1.0, 2.0]), interval(np.arange(9.0))
    assert methods(PAIRED, {"a": few, "b": few}) == "paired runs, Student's t"
    assert methods(PAIRED, {"a": many, "b": few}) == "paired runs, bootstrap and Student's t"
    assert methods(INDEPENDENT, {"a": interval([1.0])}) == "independent runs, no interval"


@pytest.fixture
def two_folders(tmp_path, monkeypatch):
    """Two trainings of one model, and an evaluation of made-up numbers in place of rollouts."""
    for folder, gain, seeds in (("first", 2.0, 3), ("second", 3.0, 4)):
        (tmp_path / folder).mkdir()
        for seed in range(seeds):
            weights = np.array([gain + 0.1 * seed])
            saved = SavedController.of(
                REFLEX, weights, 8.0, name="V-reflex-w8", training={"seed": seed}
            )
            controller_file.save(saved, tmp_path / folder / f"{seed}.json")

    def evaluate_all(sets, protocol, asked=None):
        found = []
        for i, chosen in enumerate(sets):
            share = np.full(len(chosen.labels), 1.0)
            share[0] = 0.2 + 0.4 * i
            episodes = dict.fromkeys(metric_names(), share[:, None])
            episodes |= {"delta_omega": -share[:, None], "limit_cycle_period": 1.0 + share[:, None]}
            found.append((chosen, Evaluation(Protocol(**protocol), np.array([8.0]), episodes)))
        return found

    monkeypatch.setattr("tegotae.cli.compare.evaluate_all", evaluate_all)
    monkeypatch.chdir(tmp_path)
    assert Protocol().drop_m == 0.2
    return "first", "second"


def test_two_folders_of_the_same_model_are_two_rows(two_folders, capsys):
    assert main(["compare", *two_folders]) == 0
    said = capsys.readouterr().out
    assert "V-reflex-w8 (first)" in said
    assert "V-reflex-w8 (second)" in said
    assert "minus V-reflex-w8 (first)" in said
    assert "independent runs, Welch's t" in said
    assert "bootstrap" not in said
    # Three runs, one of which settles less often: no share is above 1.
    assert "0.733 [0, 1]" in said


def test_the_document_tells_them_apart_too_and_stays_in_range(two_folders, capsys):
    assert main(["compare", *two_folders, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [c["name"] for c in document["controllers"]] == [
        "V-reflex-w8 (first)",
        "V-reflex-w8 (second)",
    ]
    (found,) = document["differences"]
    assert (found["name"], found["minus"]) == ("V-reflex-w8 (second)", "V-reflex-w8 (first)")
    for name in metric_names():
        assert found[name]["method"] == "Welch's t"
    share = found["limit_cycle_share"]
    assert -1.0 <= share["low"] < share["mean"] < share["high"] <= 1.0


def evaluated(*shares: float) -> Evaluation:
    values = np.array(shares)[:, None]
    return Evaluation(Protocol(), np.array([8.0]), {"limit_cycle_share": values})


def test_against_a_gain_that_a_search_found_the_interval_is_that_of_the_others():
    learned = trained(build("ART"), labels=("0", "1", "2"))
    (found,) = compare(learned, evaluated(0.7, 0.8, 0.9), runs("V", 1), evaluated(0.5)).values()
    alone = interval(np.array([0.7, 0.8, 0.9]) - 0.5)
    assert (found.mean, found.low, found.high) == pytest.approx((0.3, alone.low, alone.high))
    (found,) = compare(runs("V", 1), evaluated(0.5), runs("U", 1), evaluated(0.7)).values()
    assert methods(EXACT, {"a": found}) == "one run is exact, no interval"
    single = trained(build("ART"), labels=("0",))
    (found,) = compare(learned, evaluated(0.7, 0.8, 0.9), single, evaluated(0.5)).values()
    assert np.isnan(found.low), "a single learned run is a sample of many"


def test_runs_that_two_names_hold_are_refused(two_folders, one_line_error):
    said = one_line_error("compare", "first", "second", "first/0.json")
    assert "first and first/0.json hold the same runs of V-reflex-w8" in said
    assert "name them once" in one_line_error("generalise", "first", "first")


# Which runs are paired.

TRAINING = {
    "release": {"height_m": 1.2},
    "algorithm": {"name": "pgpe", "population": 16},
}
CMA_ES = {"algorithm": {"name": "cma-es", "population": 16}}
VARIED = {"conditions": [{"kind": "Uniform"}]}


def trained(controller=REFLEX, labels=("0", "1"), **changed) -> ControllerSet:
    training = {**TRAINING, **changed}
    weights = np.ones((len(labels), controller.n_weights))
    system = System(controller=controller, omega=8.0)
    return ControllerSet("any", system, weights, labels, training)


@pytest.mark.parametrize(
    ("other", "shared"),
    [
        (trained(), True),
        (trained(release={"height_m": 1.4}), True),  # which draws nothing
        (trained(labels=("0", "2")), False),
        (trained(build("V-sector-w8")), False),
        (trained(build("ART")), False),
        (trained(**CMA_ES), False),
        (trained(**VARIED), False),
        (runs("of unknown training", 2), False),
    ],
)
def test_runs_are_paired_where_they_share_what_is_random_and_nowhere_else(other, shared):
    assert paired(other, trained()) is shared
    assert paired(trained(), other) is shared


def test_two_unknown_trainings_are_not_paired_by_the_numbers_of_their_seeds():
    assert not paired(runs("a"), runs("b"))
