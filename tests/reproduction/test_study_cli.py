"""`python -m research.reproduction`: folders, tables, merges and refusals."""

import csv
import dataclasses
import errno
import json
import os
import resource
import subprocess
from pathlib import Path

import numpy as np
import pytest

import study_runs
from places import ROOT
from programs import main, parsed
from refusals import refused
from research.reproduction import runner
from research.reproduction.about import study_summary
from research.reproduction.claims.atomic import ATOMIC_CLAIMS
from research.reproduction.claims.effect_table import effects_csv, read_effects
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from research.reproduction.readings.named import reading_named
from research.reproduction.record import read_record
from research.reproduction.table import tabulate
from research.reproduction.unit import FORMAT, record_key
from tegotae import Hopper
from tegotae._support.errors import TegotaeError
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.fields import replace
from tegotae.systems.controller_file import SUFFIX
from tegotae.systems.recipe import recipe


@pytest.fixture
def half(smoke_study, tmp_path) -> Path:
    """A study of which one of three models is missing."""
    return study_runs.copy(smoke_study, tmp_path / "half", "V", "A")


@pytest.fixture
def damaged(smoke_study, tmp_path) -> Path:
    """A study of which one of three records was cut short."""
    folder = study_runs.copy(smoke_study, tmp_path / "damaged", *study_runs.MODELS)
    path = study_runs.records(folder)[0]
    path.write_bytes(path.read_bytes()[:-100])
    return folder


@pytest.fixture
def no_work(monkeypatch):
    """Makes any work on a study fail the test."""

    def begin(*_, **__):
        raise AssertionError("work was begun before the input was checked")

    monkeypatch.setattr("tegotae.study.on_cores", begin)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != ".lock"
    }


CALIBRATED = reading_named("calibrated")
NINE = (
    *("--mass", "0.06861", "--stiffness", "4.38103", "--damping", "0.343426"),
    *("--flight-damping", "0.343426", "--max-force", "1.23844", "--rest-length", "0.6331"),
    *("--height", "0.653992", "--drop", "0.12662", "--frequency-weight", "0.08085"),
)
"""The calibrated reading as options: records of this reading were kept under their keys."""


def export(folder: Path, out: Path, *options: str) -> Path:
    assert main(["reproduction", "export", "--dir", str(folder), "--out", str(out), *options]) == 0
    return out


# A study from the command line.


def keys(*words: str) -> list[str]:
    """The keys of the records that a run keeps."""
    run = parsed(["reproduction", "run", "--dir", "study", "--scale", "smoke", *words])
    return [unit.key for unit in run.plan.units]


def test_a_reading_keeps_the_records_of_its_options(tmp_path):
    assert keys("--reading", "calibrated") == keys(*NINE)
    assert keys("--reading", "calibrated", "--drop", "0.1") == keys(*NINE, "--drop", "0.1")
    assert keys("--reading", "study") == keys() != keys(*NINE)
    (tmp_path / "mine.json").write_text('{"mass": 0.2, "cot_only": true}')
    assert keys("--reading", str(tmp_path / "mine.json")) == keys("--mass", "0.2", "--cot-only")
    (tmp_path / "mine.toml").write_text("mass = 0.2\ncot_only = true\n")
    assert keys("--reading", str(tmp_path / "mine.toml")) == keys("--mass", "0.2", "--cot-only")


def test_a_reading_names_the_frequencies_at_which_its_models_are_trained(tmp_path):
    (tmp_path / "mine.toml").write_text("omega_t = [3.0, 6.5]\nmass = 0.2\n")
    words = ["reproduction", "run", "--dir", "x", "--scale", "smoke"]
    run = parsed([*words, "--reading", str(tmp_path / "mine.toml")])
    planned = {
        experiment.name: (experiment.omega, experiment.body.mass_kg)
        for experiment in run.plan.experiments
    }
    assert planned == {
        "V-sector-w3": (3.0, 0.2),
        "V-sector-w6.5": (6.5, 0.2),
        "ART-rF-tphif-w3": (3.0, 0.2),
        "ART-rF-tphif-w6.5": (6.5, 0.2),
        "T-Fv": (None, 0.2),
    }


def test_patterns_and_the_status_go_by_the_frequencies_of_a_reading(tmp_path, capsys):
    words = ["reproduction", "run", "--dir", "x", "--scale", "smoke", "--omega-t", "3", "6"]
    run = parsed([*words, "--models", "V-*-w3", "T-Fv"])
    assert [experiment.name for experiment in run.plan.experiments] == ["V-sector-w3", "T-Fv"]
    (tmp_path / "records").mkdir()
    Folder(tmp_path).describe(parsed([*words, "--models", "V-*"]).plan.document)
    assert main(["reproduction", "status", "--dir", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "0 of 5 models done\nmissing: V-sector-w3, V-sector-w6, ART-rF-tphif-w3, ART" in said


def test_the_reading_to_fill_in_is_at_first_the_studys_own():
    paper = ("--scale", "paper")  # the smoke scale has shorter episodes
    assert keys(*paper, "--reading", str(ROOT / "reading.toml")) == keys(*paper)


@pytest.mark.parametrize(
    ("reading", "message"),
    [
        ("calibrate", "no reading is called 'calibrate'; did you mean calibrated?"),
        ('{"mass_kg": 0.2}', "no option is called 'mass_kg'; did you mean mass"),
        ('{"mass": "heavy"}', "its mass is 'heavy'; it must be a number"),
        ("[0.2]", "it is a list; it must be an object"),
        (None, "there is no such file"),
    ],
)
def test_what_is_no_reading_is_said_before_the_work(reading, message, tmp_path, no_work, capsys):
    name = tmp_path / "mine.json"
    if reading and reading[0] in "[{":
        name.write_text(reading)
    elif reading:
        name = reading
    assert main(["reproduction", "run", "--dir", str(tmp_path / "s"), "--reading", str(name)]) == 2
    assert message in capsys.readouterr().err


def test_a_run_says_how_far_it_is_and_what_comes_next(smoke_study):
    lines = smoke_study.with_name("smoke.printed").read_text().splitlines()
    assert (
        lines[0] == f"3 records in {smoke_study}; next: "
        f"python -m research.reproduction report --dir {smoke_study}"
    )
    assert lines[1] == "study  0/3  done before"
    _, completed, model, rate, remaining = lines[-1].split("  ")
    assert (completed, remaining) == ("3/3", "0 s left")
    assert model in study_runs.MODELS
    assert float(rate.removesuffix("/min").removesuffix("/s")) > 0.0


def test_a_finished_study_has_nothing_to_do(smoke_study, no_work, capsys):
    previous = contents(smoke_study)
    assert main(["reproduction", "run", "--dir", str(smoke_study), "--scale", "smoke"]) == 0
    assert capsys.readouterr().out.startswith("3 records in ")
    assert contents(smoke_study) == previous


def test_status_says_what_is_done_and_what_is_missing(half, smoke_study, capsys):
    assert main(["reproduction", "status", "--dir", str(smoke_study)]) == 0
    assert capsys.readouterr().out == "scale smoke: 3 of 3 models done\n"
    assert main(["reproduction", "status", "--dir", str(half)]) == 0
    assert capsys.readouterr().out == "scale smoke: 2 of 3 models done\nmissing: T-Fv\n"


def test_a_study_may_have_experiments_beside_the_models_of_its_scale(half, capsys):
    """One more experiment, made from Python: it is counted, tabulated, and stands by itself."""
    experiment = dataclasses.replace(recipe("T-F").experiment(), name="mine")
    complete = plan("smoke", "V-*", [experiment])
    added = next(unit for unit in complete.units if unit.run.experiment is experiment)
    (source,) = half.glob("records/ART-*")
    record = dataclasses.replace(read_record(source), configuration=added.configuration)
    runner.run_study(complete, half, lambda todo: ((unit, record.result) for [unit] in todo))
    assert sorted(r.model for r in Folder(half).all()[0]) == [
        "ART-rF-tphif-w8",
        "V-sector-w8",
        "mine",
    ]
    assert main(["reproduction", "status", "--dir", str(half)]) == 0
    assert capsys.readouterr().out.endswith("scale smoke: 3 of 4 models done\nmissing: T-Fv\n")
    table = tabulate(Folder(half).all()[0])
    assert table.where(model="mine")["architecture"].tolist() == ["mine", "mine"]


def test_two_experiments_of_one_name_are_refused(half, no_work):
    second = dataclasses.replace(recipe("T-F").experiment(), name="V-sector-w8")
    refused("2 experiments are called V-sector-w8", plan, "smoke", "V-*", [second])
    alone = plan("smoke", "", [second])
    refused(r"holds a study with another .*controller", runner.run_study, alone, half)


def test_both_kinds_of_table_hold_the_same(smoke_study, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = parquet.read_table(export(smoke_study, tmp_path / "a.parquet")).to_pydict()
    with export(smoke_study, tmp_path / "a.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == list(columns)
    # A row a run: T-Fv and ART have two, and the searched gain of V two releases.
    assert len(rows) == 6
    for name, values in columns.items():
        cells = [row[name] for row in rows]
        if isinstance(values[0], float):
            np.testing.assert_array_equal([float(x or "nan") for x in cells], values)
        else:
            assert cells == [str(value) for value in values]


@pytest.mark.thorough
def test_an_exported_table_gives_the_same_figures_as_the_study(smoke_study, tmp_path):
    budgets = ["--budgets", str(tmp_path / "budgets.csv")]
    table = export(smoke_study, tmp_path / "a.csv", *budgets)
    for source, out, options in ((smoke_study, "study", []), (table, "table", budgets)):
        assert (
            main(["reproduction", "figures", str(source), "--out", str(tmp_path / out), *options])
            == 0
        )
    files = contents(tmp_path / "study")
    pictures = ["architectures.png", "correlations.png", "metrics.png"]  # of no claim's effect
    tables = ["endings.md"]
    # How training went is in the study's records alone.
    curves = ["convergence-w8.png", "convergence.csv"]
    assert sorted(files) == sorted([*pictures, *tables, *curves])
    assert contents(tmp_path / "table") == {n: c for n, c in files.items() if n not in curves}


def test_an_exported_table_gives_the_same_claims_as_the_study(smoke_study, tmp_path, capsys):
    options_beside = [
        *("--budgets", str(tmp_path / "budgets.csv")),
        *("--sampled", str(tmp_path / "sampled.csv")),
    ]
    table = export(smoke_study, tmp_path / "a.csv", *options_beside)
    for source, out, options in ((smoke_study, "study", []), (table, "table", options_beside)):
        assert (
            main(["reproduction", "claims", str(source), "--out", str(tmp_path / out), *options])
            == 0
        )
    files = contents(tmp_path / "study")
    assert sorted(files) == [
        *("claims-by-budget.md", "claims-by-design.md", "claims.md", "effects.csv"),
    ]
    assert contents(tmp_path / "table") == files
    printed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in printed[-1 - len(ATOMIC_CLAIMS) : -1]] == [
        claim.name for claim in ATOMIC_CLAIMS
    ]


def test_outcomes_of_another_study_and_of_each_budget_stand_beside(smoke_study, tmp_path):
    table = export(smoke_study, tmp_path / "old.csv")
    head, *rows = table.read_text().splitlines()
    budgets = [f"{row},{episodes}" for episodes in (1280, 5120) for row in rows]
    (tmp_path / "budgets.csv").write_text("\n".join([f"{head},training_budget", *budgets]))
    words = ["--budgets", str(tmp_path / "budgets.csv"), "--beside", str(table)]
    words += ["--experiments", str(ROOT / "research" / "experiments")]
    out = tmp_path / "out"
    assert main(["reproduction", "claims", str(table), "--out", str(out), *words]) == 0
    heads = [row for row in (out / "claims.md").read_text().splitlines() if "| Outcome |" in row]
    assert heads
    assert all(row.endswith("| Ways: + / 0 / − |") for row in heads)
    beside = (out / "claims-beside.md").read_text()
    assert beside.startswith("| | the study | old |\n")
    assert ", `map-sector-line` | reproduced | not measured |\n" in beside, "of its own folder only"
    first = (out / "claims-by-budget.md").read_text().splitlines()[0]
    assert first == "| | 1280 episodes | 5120 episodes | plateau |"
    old, current = ((out / name).read_text() for name in ("effects-old.csv", "effects.csv"))
    measured = {row for row in old.splitlines() if "not measured" not in row}
    assert measured
    assert measured < set(current.splitlines())


def test_effects_are_read_as_they_were_written(smoke_study, tmp_path):
    table = export(smoke_study, tmp_path / "a.csv")
    assert main(["reproduction", "claims", str(table), "--out", str(tmp_path)]) == 0
    results = read_effects(tmp_path / "effects.csv")
    assert [finding.claim for finding in results] == list(ATOMIC_CLAIMS)
    assert effects_csv(results) == (tmp_path / "effects.csv").read_text()


def test_only_a_table_that_is_given_can_be_calibrated(smoke_study, tmp_path, one_line_error):
    words = ["reproduction", "claims", str(smoke_study), "--calibrated"]
    assert "--calibrated names other.csv; it must be one of" in one_line_error(*words, "other.csv")


def test_a_table_that_does_not_say_its_budgets_is_refused(smoke_study, tmp_path, one_line_error):
    table = export(smoke_study, tmp_path / "a.csv")
    words = ["--out", str(tmp_path / "out"), "--budgets", str(table)]
    message = one_line_error("reproduction", "figures", str(table), *words)
    assert "the table has no training_budget" in message
    assert not (tmp_path / "out").exists()


def test_a_table_with_a_run_twice_is_refused(tmp_path, one_line_error):
    lines = (
        (ROOT / "research" / "reproduction" / "kept" / "study" / "paper.csv")
        .read_text()
        .splitlines()
    )
    (tmp_path / "table.csv").write_text("\n".join([*lines, lines[5]]) + "\n")
    message = one_line_error("reproduction", "claims", str(tmp_path / "table.csv"))
    name = f"model {lines[5].split(',')[0]}, run 4"
    assert f"{tmp_path / 'table.csv'} has 2 rows of {name}; it must have one" in message


@pytest.mark.parametrize("content", [None, "", "model,run\n", "model,run\nART,0\n", "a,b\n1\n"])
def test_what_is_no_table_is_refused(tmp_path, one_line_error, content):
    path = tmp_path / "table.csv"
    if content is not None:
        path.write_text(content)
    message = one_line_error("reproduction", "figures", str(path), "--out", str(tmp_path / "out"))
    assert str(path) in message
    assert not (tmp_path / "out").exists()


def test_two_halves_merge_into_the_whole(half, smoke_study, tmp_path, capsys):
    other_half = study_runs.copy(smoke_study, tmp_path / "other", "T", "A")
    assert main(["reproduction", "merge", str(other_half), "--dir", str(half)]) == 0
    assert capsys.readouterr().out == f"1 records copied to {half}\n"
    assert main(["reproduction", "merge", str(other_half), "--dir", str(half)]) == 0
    assert capsys.readouterr().out == f"0 records copied to {half}\n"
    study_runs.assert_same(half, smoke_study)
    expected = export(smoke_study, tmp_path / "whole.csv").read_text()
    assert export(half, tmp_path / "merged.csv").read_text() == expected


# Records that are not what they should be.


def test_status_tells_of_a_damaged_record(damaged, capsys):
    name = study_runs.records(damaged)[0].name
    assert main(["reproduction", "status", "--dir", str(damaged)]) == 0
    first, missing, message = capsys.readouterr().out.splitlines()
    assert first == "scale smoke: 2 of 3 models done"
    assert missing == "missing: ART-rF-tphif-w8"
    assert message.startswith(f"{name} is damaged: ")
    assert message.endswith("; run the study again to replace it")


def test_a_report_leaves_a_damaged_record_out_and_says_so(damaged, monkeypatch, capsys):
    def page(records, subtitle, *_) -> str:
        return f"{' '.join(sorted(record.model for record in records))}: {subtitle}"

    monkeypatch.setattr("research.reproduction.report.page.report_page", page)
    assert main(["reproduction", "report", "--dir", str(damaged)]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert "is damaged" in first
    assert last == f"The report is {damaged.resolve() / 'report.html'}"
    models, scale, body = (damaged / "report.html").read_text().split(": ", 2)
    assert (models, scale) == ("T-Fv V-sector-w8", "Scale smoke")
    assert body.startswith("2 models, ")
    reading = "The study's own reading: a hopper of 0.1 kg, a leg of 1 m, 5 N/m, "
    assert f" {reading}0.2 N s/m in stance, 0 in flight, at most 4 N, released at 1.2 m, " in body
    assert body.endswith(" a drop of 0.2 m, absolute work, ΔΩ weighs 1.")


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({}, "The study's own reading"),
        ({"mass_kg": 0.2}, "A reading of its own"),
        (CALIBRATED.overrides, "A calibrated reading (damped in flight, though III-B of the paper"),
    ],
)
def test_a_report_names_the_reading_that_it_is_of(changed, name):
    document = plan("smoke").document
    for experiment in document["experiments"].values():
        experiment["system"]["body"] |= changed
    assert f". {name}" in study_summary(document, 3)


def test_a_whole_record_replaces_a_damaged_one_in_a_merge(damaged, smoke_study, tmp_path, capsys):
    source = study_runs.copy(smoke_study, tmp_path / "other", *study_runs.MODELS)
    assert main(["reproduction", "merge", str(source), "--dir", str(damaged)]) == 0
    assert capsys.readouterr().out == f"1 records copied to {damaged}\n"
    study_runs.assert_same(damaged, smoke_study)


def test_a_damaged_record_is_not_merged(damaged, half, capsys):
    assert main(["reproduction", "merge", str(damaged), "--dir", str(half)]) == 0
    output = capsys.readouterr().out
    assert "is damaged" in output
    assert f"1 records copied to {half}" in output


@pytest.mark.parametrize("command", ["status", "export --out table.csv", "run --scale smoke"])
def test_a_record_that_cannot_be_read_is_not_called_damaged(
    half, no_work, one_line_error, monkeypatch, command
):
    path, open_path = study_runs.records(half)[0], Path.open

    def denied(place, *args, **kwargs):
        if place == path:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return open_path(place, *args, **kwargs)

    monkeypatch.setattr(Path, "open", denied)
    message = one_line_error("reproduction", *command.split(), "--dir", str(half))
    assert f"cannot read {path}: Permission denied" in message
    assert path.exists()


@pytest.mark.parametrize(
    "change",
    [
        {"format": 0},
        {"stopping": {}},
        {"seeds": [0, 1, 2]},
        {"budgets": []},
        {"experiment": {"release_m": 1.1}},
        {"experiment": {"fitness": {**Fitness(work="positive").__dict__, "kind": "Fitness"}}},
        {"experiment": {"something": "new"}},
        {"something": "new"},
    ],
)
def test_a_whole_record_of_other_settings_is_never_mixed_in(half, smoke_study, change, capsys):
    record = read_record(next(half.glob("records/V-*")))
    experiment = {**record.configuration["experiment"], **change.get("experiment", {})}
    record.configuration.update({**change, "experiment": experiment})
    name = f"{record_key(record.configuration)}{SUFFIX}"
    record.result.write(half / "records" / name)
    records, problems = Folder(half).all()
    assert sorted(r.model for r in records) == ["ART-rF-tphif-w8", "V-sector-w8"]
    assert problems == [f"{name} is of another study; it is left out"]


# What is refused: in one line, and nothing is lost.


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scale", "quick"], "holds a study with another "),
        (["--scale", "smoke", "--models", "Z*"], "no model of this scale is called 'Z*'"),
        (["--scale", "huge"], "no scale is called 'huge'"),
        (["--scale", "smoke", "--workers", "0"], "workers is 0"),
    ],
)
def test_a_run_that_cannot_be_is_refused_before_any_work(
    half, no_work, one_line_error, words, message
):
    previous = contents(half)
    assert message in one_line_error("reproduction", "run", "--dir", str(half), *words)
    assert contents(half) == previous


@pytest.mark.parametrize("place", ["file", "file/study"])
def test_a_place_that_cannot_be_written_is_refused(tmp_path, no_work, one_line_error, place):
    (tmp_path / "file").touch()
    words = ["--dir", str(tmp_path / place), "--scale", "smoke"]
    assert f"cannot write to the folder {tmp_path / place}: " in one_line_error(
        "reproduction", "run", *words
    )


def test_a_full_disk_keeps_what_is_done(smoke_study, tmp_path, monkeypatch):
    records = {record.model: record for record in Folder(smoke_study).all()[0]}
    ended = []

    def results(bundles):
        try:
            for bundle in bundles:
                for unit in bundle:
                    yield unit, records[unit.name].result
        finally:
            ended.append(True)

    attempts = []

    def fsync(_) -> None:
        attempts.append(True)
        if len(attempts) == 3:  # study.json, a record, and now
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as disk:
        disk.setattr("tegotae._support.files.os.fsync", fsync)
        with pytest.raises(TegotaeError) as raised:
            runner.run_study(plan("smoke"), tmp_path / "study", results)
        assert ended == [True]
    message = str(raised.value)
    assert message.startswith("cannot write ")
    assert message.endswith(
        f": No space left on device; {tmp_path / 'study'} keeps 1 of 3 models, "
        "the same command continues from there"
    )
    assert len(list((tmp_path / "study" / "records").iterdir())) == 1
    runner.run_study(plan("smoke"), tmp_path / "study", results)
    study_runs.assert_same(tmp_path / "study", smoke_study)


@pytest.mark.thorough
def test_a_record_that_cannot_be_written_ends_the_workers_too(half, smoke_study, monkeypatch):
    # For this process and those that it starts no file may grow beyond one kilobyte.
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    process = study_runs.start(half)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (1024, limits[1]))
    pids = study_runs.wait_for(lambda: study_runs.workers(process), "workers", process)
    out, err = process.communicate(timeout=900)
    study_runs.assert_ended(pids)
    assert (process.returncode, out) == (2, "")
    assert err.splitlines()[-1].endswith(
        f": File too large; {half} keeps 2 of 3 models, the same command continues from there"
    )
    assert "Traceback" not in err


@pytest.mark.parametrize("command", ["status", "report", "export --out table.csv", "merge ."])
def test_a_folder_that_holds_no_study_is_refused(tmp_path, one_line_error, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    for place in ("folder", "nowhere"):
        message = one_line_error("reproduction", *command.split(), "--dir", place)
        assert "holds no study; start one with python -m research.reproduction run" in message
    if command != "merge .":
        assert "Not a directory" in one_line_error(
            "reproduction", *command.split(), "--dir", "file"
        )
    assert sorted(os.listdir(tmp_path)) == ["file", "folder"]
    assert os.listdir(tmp_path / "folder") == []


@pytest.mark.parametrize("text", ["", "{", "[]", "7", "{}", '{"scale": "smoke"}'])
def test_a_damaged_description_of_a_study_is_refused(half, one_line_error, text):
    (half / "study.json").write_text(text)
    for words in (["run", "--scale", "smoke"], ["status"]):
        message = one_line_error("reproduction", *words, "--dir", str(half))
        assert f"{half / 'study.json'} is damaged: it " in message
    assert len(study_runs.records(half)) == 2


def test_a_study_of_another_version_is_refused(half, one_line_error, tmp_path):
    document = json.loads((half / "study.json").read_text())
    (half / "study.json").write_text(json.dumps({**document, "format": FORMAT - 1}))
    previous = contents(half)
    export = ["export", "--out", str(tmp_path / "table.csv")]
    for words in (["run", "--scale", "smoke"], ["status"], ["report"], export):
        message = one_line_error("reproduction", *words, "--dir", str(half))
        assert f"{half / 'study.json'} is of another version of tegotae" in message
    assert contents(half) == previous


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("objective.work", {"objective": Fitness(settle_s=2.0, work="positive")}),
        ("objective.follow_omega", {"objective": Fitness(settle_s=2.0, follow_omega=False)}),
        ("body.mass_kg", {"body": Hopper(mass_kg=0.2)}),
    ],
)
def test_a_study_of_another_measure_or_body_is_another_study(half, name, changed):
    complete = plan("smoke")
    experiments = tuple(replace(experiment, changed) for experiment in complete.experiments)
    changed_plan = dataclasses.replace(complete, experiments=experiments)
    previous = contents(half)
    refused(f"holds a study with another {name}; ", runner.run_study, changed_plan, half)
    assert contents(half) == previous
    ours = {unit.key for unit in plan("smoke").units}
    assert ours.isdisjoint(unit.key for unit in changed_plan.units)


def test_a_study_without_records_has_no_table(half, one_line_error, tmp_path):
    for path in study_runs.records(half):
        path.unlink()
    out = tmp_path / "table.csv"
    message = one_line_error("reproduction", "export", "--dir", str(half), "--out", str(out))
    assert f"{half} holds no records yet; first: python -m research.reproduction run" in message
    assert not out.exists()


def test_records_of_different_versions_are_told_of(half, tmp_path, capsys):
    path = study_runs.records(half)[0]
    record = read_record(path)
    dataclasses.replace(record, software={**record.software, "jax": "0.0.1"}).result.write(path)
    export(half, tmp_path / "table.csv")
    assert (
        "the records were made with different versions of jax: 0.0.1, " in capsys.readouterr().out
    )


def test_a_study_is_of_one_engine(half, tmp_path, one_line_error, monkeypatch):
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    message = one_line_error("reproduction", "run", "--scale", "smoke", "--dir", str(half))
    assert f"{half} holds a study of the engine native, and this is xla" in message
    assert "set TEGOTAE_ENGINE=native, or choose another folder" in message


def test_studies_of_different_engines_are_not_merged(half, smoke_study, one_line_error):
    path = study_runs.records(half)[0]
    record = read_record(path)
    dataclasses.replace(record, software={**record.software, "engine": "xla"}).result.write(path)
    output = one_line_error("reproduction", "merge", str(smoke_study), "--dir", str(half))
    assert "are of different engines, native and xla; they cannot be merged" in output


def test_other_numbers_at_equal_settings_are_told_of_in_a_merge(half, smoke_study, capsys):
    path = study_runs.records(half)[0]
    record = read_record(path)
    software = {**record.software, "numpy": "1.0"}
    changed = dataclasses.replace(record, software=software, weights=record.weights + 1e-6)
    changed.result.write(path)
    previous = path.read_bytes()
    assert main(["reproduction", "merge", str(smoke_study), "--dir", str(half)]) == 0
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith(
        f"{record.model} differs in {smoke_study} and {half}, at equal settings: made with "
    )
    assert "numpy 1.0" in first
    assert last == f"1 records copied to {half}"
    assert path.read_bytes() == previous


def test_a_table_of_unknown_kind_is_refused(half, one_line_error, tmp_path):
    words = ["--dir", str(half), "--out", str(tmp_path / "table.xlsx")]
    message = one_line_error("reproduction", "export", *words)
    assert "cannot write a table as 'table.xlsx'; use .csv or .parquet" in message


def test_a_folder_without_a_study_is_not_merged(half, one_line_error, tmp_path):
    for words in ((str(tmp_path), "--dir", str(half)), (str(half), "--dir", str(tmp_path))):
        output = one_line_error("reproduction", "merge", *words)
        assert output.startswith(f"tegotae: {tmp_path} holds no study")


def test_different_studies_are_not_merged(half, smoke_study, one_line_error):
    document = json.loads((half / "study.json").read_text())
    (half / "study.json").write_text(
        json.dumps({**document, "stopping": {**document["stopping"], "generations": 4}})
    )
    previous = contents(half)
    output = one_line_error("reproduction", "merge", str(smoke_study), "--dir", str(half))
    assert "hold different studies, with another stopping.generations" in output
    assert "they cannot be merged" in output
    assert contents(half) == previous


def test_the_report_of_ones_own_numbers_asks_for_no_experiments_that_were_not_made():
    words = ["make", "--dry-run", "reproduce", "READING=reading.toml"]
    planned = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    (report,) = (line for line in planned.splitlines() if "reproduction report" in line)
    assert report.split()[2:] == [
        "research.reproduction",
        "report",
        "--dir",
        "results/paper-reading",
    ]
