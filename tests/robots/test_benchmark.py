"""The benchmark of sparse sensing: what an episode and an entry score, and what is kept."""

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest

from brief_subjects import BriefHopper, BriefQuadruped
from places import ROOT
from tegotae.measures.objectives.fitness import HopOutcome
from tegotae.simulation.integrators import Hold
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems.controller_file import load
from tegotae_robots.api.benchmark import KEPT
from tegotae_robots.api.robots import benchmark
from tegotae_robots.benchmark.bodies import HopperSubject, QuadrupedSubject
from tegotae_robots.benchmark.entries import read_entry
from tegotae_robots.benchmark.subject import TRACKS, of_walk, summary

KIND = {"hopper": BriefHopper, "quadruped": BriefQuadruped}


# The score of an episode


@dataclass(frozen=True)
class OneStart(BriefHopper):
    """Brief hopper from the default release alone."""

    RELEASES: ClassVar = {"height_m": (0.0, 0.0), "velocity_m_per_s": (0.0, 0.0)}
    starts: int = 1


def test_a_hopper_scores_what_the_simulator_itself_finds_for_its_controller():
    """m g Σh / E of the same controller in a rollout of the engine, sampled and held."""
    saved, subject = load("zoo:ARG-rF-gF-both-w4/5"), OneStart()
    system = dataclasses.replace(saved.system, integrator=Hold(), timing=subject.TIMING)
    weights = np.asarray(saved.weights, np.float32)[None]
    rollout, scenario = system.rollout(whole_trajectory, subject.TIMING), system.scenario()
    path = rollout.run(weights, scenario, system.body)
    outcome = subject.OBJECTIVE.outcome(path, scenario, system.body, subject.TIMING)
    expected = float(outcome.cot_inverse[0][0]) * 0.1 * 9.81
    scores = subject.scores(read_entry(saved, subject, "load"), "load")
    assert scores[0, 0] == pytest.approx(expected, rel=2e-3)


def test_the_efficiency_of_a_heavier_hopper_is_with_its_own_weight():
    outcome = HopOutcome(*[np.array([[1.0, 1.0]])] * len(HopOutcome._fields))
    worth = HopperSubject().worth(outcome, np.array([1.0, 1.5]))
    np.testing.assert_allclose(worth, [0.981, 1.4715])


def test_a_walk_is_worth_its_efficiency_where_it_keeps_the_speed():
    worth = of_walk([4.0, 4.0, 4.0, 4.0], [0.5, 0.4, 0.6, 1.0], 0.5)
    np.testing.assert_allclose(worth, [4.0, 3.2, 3.2, 0.0])


def test_a_walk_backwards_and_no_walk_are_worth_nothing():
    assert of_walk([-4.0, np.nan, 0.0], [-0.5, 0.5, 0.0], 0.5).tolist() == [0.0, 0.0, 0.0]


# The score of an entry


def test_a_fall_counts_as_zero_in_the_score_and_against_stands():
    scored = summary(np.array([[2.0, np.nan], [2.0, 2.0]]))
    assert scored["score"] == 1.5
    assert scored["stands"] == 0.75
    assert scored["stands_low"] < 0.75 < scored["stands_high"]


def test_the_interval_is_over_starts_not_over_conditions():
    between_conditions = summary(np.array([[1.0] * 16, [3.0] * 16]))
    assert between_conditions["low"] == between_conditions["high"] == 2.0
    between_starts = summary(np.array([[1.0, 3.0] * 8] * 2))
    assert between_starts["low"] < 2.0 < between_starts["high"]


def test_more_conditions_from_the_same_starts_narrow_neither_interval():
    single = np.array([[1.0, np.nan, 3.0, 2.0] * 4])
    assert summary(np.repeat(single, 6, axis=0)) == pytest.approx(summary(single))


@pytest.mark.thorough
def test_who_folds_all_legs_falls_and_who_keeps_them_stands():
    subject = BriefQuadruped()
    folded = subject.scores(lambda: lambda observation: np.repeat([0.0, 1.0], 4), "load")
    stored = subject.scores(lambda: lambda observation: np.zeros(8), "load")
    assert np.isnan(folded).all()
    assert stored.tolist() == [[0.0, 0.0]] * 2  # it stands, and does not walk


@pytest.fixture(scope="module")
def still():
    """The scores of a hopper that never pushes, and all that its policy observed."""
    observed = []
    scores = BriefHopper().scores(lambda: lambda seen: observed.append(seen.copy()) or [0.0], "all")
    return scores, np.array(observed[:4])


def test_a_hopper_that_never_pushes_stands_and_scores_nothing(still):
    assert still[0].tolist() == [[0.0, 0.0]] * 2


# What is met


@pytest.mark.parametrize("subject", [HopperSubject(), QuadrupedSubject()], ids=lambda x: x.NAME)
def test_a_track_senses_all_that_the_one_before_it_does(subject):
    load_, imu, all_ = (set(subject.senses[track]) for track in TRACKS)
    assert load_ < imu < all_
    assert all("force" in name for name in load_)


def test_a_policy_is_given_what_the_track_lists(still):
    """Its first observation is that of the release: no load, falling or rising, at a height."""
    _, first = still
    assert BriefHopper().senses["all"] == ("spring_force", "velocity", "height")
    assert (first[:, 0] == 0.0).all()
    assert (np.abs(first[:, 1]) <= 0.5).all()
    assert ((first[:, 2] > 1.0) & (first[:, 2] < 1.6)).all()


def test_all_conditions_begin_from_the_same_starts_and_these_differ(still):
    undisturbed, heavy = still[1][:2], still[1][2:]
    np.testing.assert_array_equal(undisturbed, heavy)
    assert not np.array_equal(undisturbed[0], undisturbed[1])


@pytest.mark.thorough
def test_the_same_entry_scores_the_same_again():
    subject = BriefHopper()
    entry = read_entry("zoo:V-sector-w4/0", subject, "load")
    np.testing.assert_array_equal(subject.scores(entry, "load"), subject.scores(entry, "load"))


# The answer


@pytest.fixture
def brief(monkeypatch):
    monkeypatch.setattr("tegotae_robots.api.benchmark._subject", lambda name: KIND[name]())


def test_an_entry_is_shown_among_the_kept_ones_that_sense_no_more(brief, tmp_path):
    answer = benchmark("zoo:V-sector-w4/0", track="load")
    (output,) = answer.texts()
    assert "zoo:V-sector-w4/0 (this one)" in output.index
    assert set(output["track"]) == {"load"}
    assert "zoo:ART-rF-tphif-w4/0" in output.index
    assert not any("quadruped" in name for name in output.index)


def test_the_table_has_a_row_an_episode_and_the_document_the_score(brief):
    answer = benchmark("zoo:V-sector-w4/0")
    table = answer.table.reset_index()
    assert table["condition"].tolist() == ["none", "none", "mass", "mass"]
    assert table["start"].tolist() == [0, 1, 0, 1]
    document = answer.to_dict()
    assert document["score"] == pytest.approx(table["score"].mean())
    assert document["stands"] == 1.0


# What is kept


def test_the_kept_rows_are_those_of_the_page_and_of_five_kinds():
    stored = pd.read_csv(KEPT)
    assert KEPT.read_text() == (ROOT / "docs/_static/benchmark/scores.csv").read_text()
    assert len(stored) >= 10
    assert set(stored["kind"]) == {"name", "controller file", "function", "ONNX", "C"}
    assert (stored["cpu_s"] < 3600).all()


def test_the_table_of_the_page_follows_from_the_kept_rows(study, monkeypatch, tmp_path):
    benchmark = study("benchmarks.scores")
    monkeypatch.setattr(benchmark, "OUT", tmp_path)
    benchmark.report()
    page = ROOT / "docs/_static/benchmark/scores.md"
    assert (tmp_path / "scores.md").read_text() == page.read_text()
