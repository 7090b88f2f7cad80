"""Gains by learning: runs judged without their feedback, and the primary analysis."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from research.reproduction import runner
from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.claims.random_effects import crossed
from research.reproduction.figures.learning import learning_figure
from research.reproduction.folder import Folder
from research.reproduction.learning import atlas
from research.reproduction.learning.atlas import (
    KINDS,
    NONE,
    atlas_tables,
    feedback_kinds,
    forms_by_numbers,
    measure_atlas,
    shortest_form,
)
from research.reproduction.learning.forms import Retuning
from research.reproduction.learning.judged import (
    MEASURED,
    RELEASES,
    VARIANTS,
    EvaluatedRuns,
    judge_runs,
    releases,
)
from research.reproduction.learning.page import feedback_table, primary_tables
from research.reproduction.learning.primary import BEST_RUN, best_law, contrast
from research.reproduction.learning.runs import LAW, read_runs, run_rows
from research.reproduction.plan import MAIN, OMEGAS, plan
from research.reproduction.table import record_place
from tegotae.measures.evaluation import Protocol
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.study import run_locally
from tegotae.systems.recipe import recipe
from tegotae.systems.term_sets import LAWS

SHORT = Protocol(undisturbed_s=10.0, disturbed_s=1.0, offsets=(0.0, 1.0))


def test_the_plan_has_every_architecture_and_law_at_every_frequency():
    names = [experiment.name for experiment in plan("learning").experiments]
    assert len(names) == len(set(names)) == (3 * len(MAIN) + len(LAWS)) * len(OMEGAS)
    assert {"V-sector-w3", "ARGT-rF-gF-tphif-w10", "latch-w5"} <= set(names)


def test_a_model_at_another_frequency_has_its_place_in_the_design():
    experiment = recipe("AR-rF-both-w5").experiment()
    record = SimpleNamespace(model=experiment.name, experiment=experiment, weights=np.zeros((1, 9)))
    assert record_place(record)["architecture"] == "AR"
    assert record_place(record)["omega_t"] == 5.0


def test_the_common_releases_are_the_same_for_all_models():
    a, b = (recipe(name).experiment().system.scenario() for name in ("V-sector-w4", "ART"))
    np.testing.assert_array_equal(releases(a).height_m, releases(b).height_m)
    assert releases(a).phase_rad.shape == (RELEASES,)


def test_a_run_is_judged_whole_cut_and_frozen():
    experiment = recipe("V-reflex-w8").experiment(protocol=SHORT)
    judged = judge_runs(experiment, np.array([[2.0], [0.0]], "float32"))
    for name in MEASURED:
        assert judged[name].shape == (len(VARIANTS), 2, RELEASES, 2)
    complete, cut, frozen = judged["limit_cycle_share"].mean(axis=(2, 3))
    assert complete[0] > 0.5
    assert cut[0] == 0.0  # a reflex without feedback never pushes
    # A gain of zero is no feedback: nothing is left to cut.
    assert complete[1] == cut[1] == frozen[1]
    assert HOPPING.registered == ()  # the metric of the mean feedback is in no later study


def test_one_network_is_judged_whole_alone():
    experiment = recipe("T-F").experiment(protocol=SHORT)
    judged = judge_runs(experiment, np.zeros((1, experiment.controller.n_weights), "float32"))
    assert np.isfinite(judged["limit_cycle_share"][0]).all()
    assert np.isnan(judged["limit_cycle_share"][1:]).all()


def table(learned=0.6, v=0.4, law=0.5, runs=4, seed=0):
    """Runs with these merits, of designs and frequencies that vary, too."""
    draw = np.random.default_rng(seed)
    of_omega = dict(zip((3.0, 4.0, 5.0, 6.0), draw.normal(0.0, 0.05, 4), strict=True))
    rows = []

    def add(architecture, drive, merit, count):
        for omega, shift in of_omega.items():
            for run in range(count):
                value = merit + shift + draw.normal(0.0, 0.02)
                model = f"{architecture}-{drive}-w{omega:g}"
                rows.append(
                    {"model": model, "architecture": architecture, "senses": "F", "drive": drive}
                    | {"omega_t": omega, "run": run, "fitness": value, "settled": 0.9}
                    | {f"merit{kind}": value for kind in ("", "_cut", "_frozen")}
                    | {"merit_chosen": value, "merit_judged": value, "following": 1.0}
                )

    for drive in ("φ", "f", "φf"):
        add("V", drive, v, 1)
        for architecture in LEARNED_FEEDBACK:
            add(architecture, drive, learned, runs)
    for name, merit in (("load", law), ("latch", law - 0.2), ("clock", law - 0.3)):
        add(LAW, name, merit, runs)
    return pd.DataFrame(rows)


def test_contrasts_find_the_differences_that_are_there():
    runs = table()
    over_v, over_law = contrast(runs), contrast(runs, best_law(runs), outcome="merit_judged")
    assert over_v.effect == pytest.approx(0.2, abs=0.03)
    assert over_law.effect == pytest.approx(0.1, abs=0.03)
    for difference in (over_v, over_law):
        for low, high in (difference.crossed, difference.runs, difference.drawn):
            assert low < difference.effect < high
    assert contrast(runs, run=BEST_RUN).effect > over_v.effect
    assert list(over_v.of_omega) == [3.0, 4.0, 5.0, 6.0]


def test_the_best_law_is_chosen_on_releases_that_do_not_judge_it():
    runs = table()
    runs["merit_judged"] = 1.0 - runs.merit_judged
    assert best_law(runs) == "load"


def test_frequencies_that_differ_widen_the_interval_over_runs_alone():
    runs = table()
    learned = runs.architecture.isin(LEARNED_FEEDBACK)
    runs.loc[learned, "merit"] += np.where(runs.omega_t[learned] > 4.5, 0.3, -0.3)
    difference = contrast(runs)
    assert difference.crossed[0] < 0.0 < difference.crossed[1]
    assert difference.runs[1] - difference.runs[0] < 0.1


def test_the_crossed_interval_is_students_where_only_one_factor_varies():
    by_omega = np.array([0.1, 0.4, 0.2, 0.5])
    low, high = crossed(np.tile(by_omega, (5, 1)) + 1e-9 * np.arange(5)[:, None])
    interval = stats.t.interval(0.95, 3, by_omega.mean(), stats.sem(by_omega))
    assert (low, high) == pytest.approx(interval, rel=1e-3)


def test_the_crossed_interval_covers():
    draw = np.random.default_rng(1)
    hits = 0
    for _ in range(300):
        noise = draw.normal(0, 0.2, (12, 7))
        sample = noise + draw.normal(0, 0.3, (12, 1)) + draw.normal(0, 0.3, (1, 7))
        low, high = crossed(sample)
        hits += low < 0.0 < high
    assert 0.91 < hits / 300 < 0.99


def test_the_tables_name_bodies_and_kinds():
    runs = table()
    overall, by_omega = primary_tables({"study": runs})
    assert overall.count("| study |") == by_omega.count("| study: ") == 9
    assert by_omega.splitlines()[0] == "| ω_t | 3 | 4 | 5 | 6 |"
    assert len(learning_figure({"study": runs, "other": runs}).axes) == 2
    rows = feedback_table(runs).splitlines()[2:]
    assert len(rows) == 4 * (1 + len(LEARNED_FEEDBACK) + 3)


def test_a_table_of_something_else_or_of_a_part_is_refused_in_one_line(tmp_path, one_line_error):
    table().to_csv(tmp_path / "whole.csv", index=False)
    assert len(read_runs(tmp_path / "whole.csv")) == len(table())
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    (tmp_path / "words.csv").write_text((tmp_path / "whole.csv").read_text().replace("0.9", "nine"))
    runs = table()
    runs[runs.architecture == LAW].to_csv(tmp_path / "part.csv", index=False)
    for name, message in (
        ("missing", "cannot read"),
        ("other", "it has no column model"),
        ("words", "it holds what is no number"),
        ("part", "has no runs of AR; judge a whole study"),
    ):
        assert message in one_line_error("reproduction", "primary", str(tmp_path / f"{name}.csv"))


def test_a_study_without_whole_records_is_refused_before_any_work(tmp_path, one_line_error):
    folder = Folder(tmp_path / "study")
    with folder.claimed(plan("smoke")):
        pass
    out = tmp_path / "out"
    message = one_line_error(
        "reproduction", "learning", "--dir", str(folder.path), "--out", str(out)
    )
    assert "has no whole record of *; run the study" in message
    assert not out.exists()


@pytest.mark.thorough
def test_another_window_is_another_cell(tmp_path):
    (record,) = _records_of_smoke(tmp_path)
    cells = [EvaluatedRuns(record), EvaluatedRuns(record, undisturbed_s=12.0)]
    assert len({str(cell.document) for cell in cells}) == 2
    standard, longer = (cell.measure().arrays["limit_cycle_share"] for cell in cells)
    assert standard.shape == longer.shape == (3, 1, RELEASES, 2)
    frame = run_rows(record.experiment, record.best_fitness, cells[0].measure().arrays)
    assert frame.iloc[0][["model", "architecture", "drive"]].tolist() == ["V-sector-w8", "V", "φ"]


def _records_of_smoke(tmp_path):
    runner.run_study(plan("smoke", "V-*"), tmp_path / "smoke", run_locally)
    return Folder(tmp_path / "smoke").all()[0]


def of_kind(merit, cut, frozen=0.0, flight=0.0, stance=0.0):
    merits = {"merit": merit, "merit_cut": cut, "merit_frozen": frozen}
    return merits | {"waits_flight": flight, "waits_stance": stance}


def test_the_kind_of_a_feedback_is_what_cutting_and_freezing_leave_of_the_merit():
    runs = [
        of_kind(0.001, 0.5),
        of_kind(0.5, 0.6),
        of_kind(0.5, 0.49),
        of_kind(0.5, 0.1, frozen=0.5),
        of_kind(0.5, 0.1, flight=0.3, stance=0.3),
        of_kind(0.5, 0.1, stance=0.3),
        of_kind(0.5, 0.1),
        of_kind(0.5, np.nan, frozen=np.nan),
    ]
    assert feedback_kinds(pd.DataFrame(runs)).tolist() == list(KINDS)


def test_the_shortest_form_is_the_first_that_keeps_enough():
    shares = {f"kept {form}": [0.0, 0.0] for form in forms_by_numbers()}
    shares |= {"kept load": [0.9, 0.0], "kept latch": [0.97, 0.0]}
    runs = pd.DataFrame({"best": True, "kind": KINDS[4], **shares})
    assert shortest_form(runs, 0.8).tolist() == ["load", NONE]
    assert shortest_form(runs, 0.95).tolist() == ["latch", NONE]


@pytest.mark.thorough
def test_an_atlas_replaces_a_vanilla_law_by_the_short_law_that_it_is(tmp_path, monkeypatch):
    forms = {name: LAWS[name] for name in ("clock", "load")}
    monkeypatch.setattr(atlas, "forms_of_a_leg", lambda: forms)
    (record,) = _records_of_smoke(tmp_path)
    retuning = Retuning(generations=1)
    runs = measure_atlas(tmp_path / "smoke", [record], retuning, run_locally)
    (run,) = runs.to_dict("records")
    assert run["action_1"] == run["load"] == pytest.approx(1.0)
    assert run["swing"] > 0.0
    assert run["kept load"] > run["kept clock"]
    again = measure_atlas(tmp_path / "smoke", [record], retuning, run_locally)
    pd.testing.assert_frame_equal(again, runs)
    assert "| load |" in atlas_tables(runs)
