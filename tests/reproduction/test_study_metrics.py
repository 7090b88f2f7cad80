"""A user's metric is measured in a study, in processes that know nothing of its file, and shown."""

import dataclasses
import json
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

import study_runs
from places import TESTS
from programs import main
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from tegotae._support.errors import TegotaeError
from tegotae.cli import split_parts
from tegotae.measures.evaluation import evaluate
from tegotae.measures.hopping import HOPPING
from tegotae.systems.registry import imported

FILE = str(TESTS / "users" / "grf.py")
OWN = ("peak_grf_n", "peak_grf_in_weights")


@pytest.fixture(autouse=True)
def forgotten():
    """Each test begins as a new process does, that knows no metrics but the package's."""
    yield
    for name in OWN:
        HOPPING.forget(name)


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    """A study of one model with a metric of a user's, done by the command."""
    folder = tmp_path_factory.mktemp("own") / "study"
    process = study_runs.start(
        folder, "--models", "T-Fv", "--seeds", "1", "--workers", "1", "--parts", FILE
    )
    study_runs.finish(process)
    return folder


def test_a_users_metric_is_measured_in_the_workers_at_every_budget(study):
    (record,), wrong = Folder(study).all()
    assert wrong == []
    assert list(record.configuration["metrics"]) == ["peak_grf_n"]
    force_n = record.episodes["peak_grf_n"]
    assert force_n.shape == record.episodes["cot_inverse"].shape
    assert np.isfinite(force_n).all()
    assert (force_n > 0.5).all()  # it stands on the ground at times
    assert record.at_budgets["peak_grf_n"].shape == (1, *force_n.shape)


def test_a_controller_drawn_from_the_best_distribution_is_evaluated_as_the_mean_is(study):
    (record,), _ = Folder(study).all()
    experiment = record.experiment
    assert (record.deviation > 0.0).all()
    normal = np.random.default_rng(0).standard_normal(record.weights.shape[1])
    drawn = record.weights + record.deviation * normal.astype("float32")
    again = evaluate(
        experiment.controller, drawn, None, experiment.body, experiment.protocol
    ).episodes
    for name in ("cot_inverse", "t0_s", "limit_cycle_share"):
        np.testing.assert_allclose(record.sampled[name], again[name], rtol=1e-3, err_msg=name)
    assert (record.sampled["cot_inverse"] != record.episodes["cot_inverse"]).any()


def test_a_users_metric_is_exported_with_what_follows_from_it(study, tmp_path):
    out = tmp_path / "table.csv"
    words = ["reproduction", "export", "--dir", str(study), "--out", str(out)]
    assert main([*words, "--parts", FILE]) == 0
    heading, row = (line.split(",") for line in out.read_text().splitlines())
    cells = dict(zip(heading, row, strict=True))
    assert float(cells["peak_grf_n"]) > 0.5
    assert float(cells["peak_grf_in_weights"]) > 0.5
    assert float(cells["limit_cycle_share"]) >= 0.0


def test_a_users_metric_is_exported_without_its_file_and_told_of(study, tmp_path, capsys):
    out = tmp_path / "table.csv"
    assert main(["reproduction", "export", "--dir", str(study), "--out", str(out)]) == 0
    assert "peak_grf_n" in out.read_text().splitlines()[0]
    assert "peak_grf_n: no metric known here; to draw it, give --parts FILE.py" in (
        capsys.readouterr().out
    )


def test_a_users_metric_is_in_the_report_and_in_the_figure(study, monkeypatch):
    drawn = []

    def figure(table):
        drawn.extend(metric.name for metric in table.metrics_shown("figure"))
        raise TegotaeError("enough")

    page = study / "report.html"
    monkeypatch.setattr(
        "research.reproduction.report.models._surface", lambda *_: {}
    )  # which take long
    monkeypatch.setattr("research.reproduction.report.models._hop", lambda *_: {})
    assert main(["reproduction", "report", "--dir", str(study), "--parts", FILE]) == 0
    assert '"label":"peak GRF",' in page.read_text(encoding="utf-8")
    monkeypatch.setattr("research.reproduction.figures.study.architectures_figure", figure)
    words = ["reproduction", "figures", str(study), "--out", str(study), "--parts", FILE]
    assert main(words) == 2
    assert set(OWN) < set(drawn)


def test_a_study_with_other_metrics_of_ones_own_is_another_study(study, one_line_error, tmp_path):
    words = ["reproduction", "run", "--dir", str(study), "--scale", "smoke", "--seeds", "1"]
    message = one_line_error(*words, "--models", "T-Fv")
    assert "holds a study with another set of your own metrics (peak_grf_n; see --parts)" in message


def test_a_study_with_a_metric_that_was_edited_is_another_study(
    study, one_line_error, tmp_path, monkeypatch
):
    monkeypatch.setattr(sys, "path", sys.path[:])
    monkeypatch.delitem(sys.modules, "grf", raising=False)
    (tmp_path / "grf.py").write_text(Path(FILE).read_text().replace("jnp.max", "jnp.mean"))
    sys.path[:] = [path for path in sys.path if not path.endswith("users")]
    words = ["reproduction", "run", "--dir", str(study), "--scale", "smoke", "--seeds", "1"]
    message = one_line_error(*words, "--models", "T-Fv", "--parts", str(tmp_path / "grf.py"))
    sys.modules.pop("grf")
    assert "holds a study with another code of peak_grf_n" in message


def test_a_study_without_metrics_of_ones_own_is_described_as_before():
    without = plan("smoke")
    assert "metrics" not in without.document
    assert all("metrics" not in unit.configuration for unit in without.units)
    imported(FILE)
    assert list(json.loads(json.dumps(plan("smoke").document))["metrics"]) == ["peak_grf_n"]
    assert {u.key for u in plan("smoke").units}.isdisjoint(u.key for u in without.units)


def test_a_metric_reaches_another_process_by_its_place_even_with_a_lambda_of_its_own():
    module = imported(FILE)
    assert pickle.loads(pickle.dumps(module.peak_grf)) is module.peak_grf


def test_a_metric_that_no_module_holds_is_refused_before_any_work():
    hidden = [dataclasses.replace(imported(FILE).peak_grf, name="hidden_n")]
    with pytest.raises(TegotaeError, match="hidden_n cannot be given to worker processes; let a"):
        dataclasses.replace(plan("smoke"), metrics=tuple(hidden))


def test_a_metric_that_breaks_its_contract_is_refused_before_any_work(
    tmp_path, one_line_error, monkeypatch
):
    path = tmp_path / "wrong_metric.py"
    path.write_text(Path(FILE).read_text().replace(", axis=0),", "),"))
    monkeypatch.setattr("sys.path", sys.path[:])
    words = ["reproduction", "run", "--dir", str(tmp_path / "study"), "--scale", "smoke"]
    assert "peak_grf_n" in one_line_error(*words, "--parts", str(path))
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    "words",
    [
        ["--parts", "a.py", "--parts", "b.py", "reproduction", "run"],
        ["--parts", "a.py", "b.py", "reproduction", "run"],
        ["reproduction", "--parts=a.py", "run", "--parts=b.py"],
        ["reproduction", "run", "--parts", "a.py", "b.py"],
    ],
)
def test_several_files_of_parts_are_given_one_by_one_or_as_a_list(words):
    assert split_parts(words) == (["reproduction", "run"], ["a.py", "b.py"])


@pytest.mark.parametrize(
    ("words", "count"),
    [
        ([], 3),
        (["--models", "V-*", "T-*"], 2),
        (["--models", "V-*", "--models", "T-*"], 2),
        (["--models", "V-*", "--models", "T-*", "ART*"], 3),
        (["--models", "V-*"], 1),
    ],
)
def test_several_models_are_given_one_by_one_or_as_a_list(words, count, monkeypatch, tmp_path):
    planned = []
    monkeypatch.setattr(
        "research.reproduction.runner.run_study",
        lambda study, *_, **__: planned.append(study) or len(study.units),
    )
    assert main(["reproduction", "run", "--dir", str(tmp_path), "--scale", "smoke", *words]) == 0
    assert len(planned[0].units) == count
