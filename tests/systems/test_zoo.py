"""Trained controllers by name: what the zoo hands out is what the study found."""

import json
import shutil
import subprocess
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pages import blocks
from places import ROOT
from programs import main
from prose_numbers import kept_file
from refusals import refused
from research.reproduction.folder import Folder
from research.reproduction.zoo import ZooEntry, core, write_archive
from tegotae import TegotaeError
from tegotae._support.files import read_arrays
from tegotae.measures.evaluation import evaluate
from tegotae.measures.statistics import mean_defined
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController, load
from tegotae.systems.recipe import study_recipes
from tegotae.systems.resolve import resolve
from tegotae.systems.zoo import FOLDER, MOST_BYTES, open_zoo, studies, zoo_names
from tegotae.training import collection

MODEL = "ART-rF-tphif-w8"


@pytest.fixture(scope="module")
def records(smoke_study):
    """The study's records by model."""
    return {record.model: record for record in Folder(smoke_study).all()[0]}


@pytest.fixture(scope="module")
def file(smoke_study, tmp_path_factory):
    """The same study as a file of trained controllers, made by the command."""
    out = tmp_path_factory.mktemp("zoo") / "smoke.npz"
    words = ["--dir", str(smoke_study), "--name", "smoke", "--out", str(out)]
    assert main(["reproduction", "zoo", *words]) == 0
    return out


def with_arrays(file, path, **changes):
    """The file with some of its arrays changed."""
    arrays = read_arrays(file, MOST_BYTES)
    np.savez_compressed(path, **{**arrays, **changes})
    return path


def test_a_run_has_the_weights_of_its_record_to_the_bit(file, records):
    for model, record in records.items():
        for run, weights in enumerate(record.weights):
            result = load(f"zoo:{file}:{model}/{run}").weights
            assert result.astype("float32").tobytes() == weights.tobytes()


def test_the_name_of_a_model_is_its_run_with_the_best_fitness(file, records):
    best = int(np.argmax(records[MODEL].best_fitness))
    for name in (MODEL, "ART"):
        saved = resolve(f"zoo:{file}:{name}").controller()
        assert saved.training["run"] == best
        np.testing.assert_array_equal(saved.weights, records[MODEL].weights[best])


def test_all_names_every_run_as_one_set(file, records):
    (runs,) = collection.read_runs(f"zoo:{file}:{MODEL}/all")
    np.testing.assert_array_equal(runs.weights, records[MODEL].weights)
    assert (runs.name, runs.labels) == (MODEL, ("0", "1"))


def test_a_run_says_where_it_is_from_and_how_training_went(file, records):
    record = records[MODEL]
    saved = load(f"zoo:{file}:{MODEL}/1")
    assert saved.software == record.software
    assert {"engine", "tegotae"} <= saved.software.keys()
    expected = {
        "study": "smoke",
        "run": 1,
        "seed": record.configuration["seeds"][1],
        "best_fitness": record.best_fitness[1].item(),
        "generations": record.generations[1].item(),
        "ended": record.ended[1].item(),
        "algorithm": record.configuration["algorithm"],
    }
    assert {name: saved.training[name] for name in expected} == expected
    assert saved.experiment == record.experiment


def test_its_metrics_are_means_over_the_episodes_of_the_evaluation(file, records):
    runs = open_zoo(file).runs(MODEL)
    for name, episodes in records[MODEL].episodes.items():
        np.testing.assert_array_equal(runs[name], mean_defined(episodes).astype("float32"))


def evaluated(name):
    """The metrics of the runs of a name, evaluated anew."""
    (runs,) = collection.read_runs(name)
    return evaluate(
        runs.controller,
        runs.weights,
        runs.omega,
        runs.body,
        runs.protocol,
        start=runs.system.scenario(),
        integrator=runs.system.integrator,
    ).runs()


def test_evaluating_a_controller_gives_its_metrics(file):
    name = f"zoo:{file}:{MODEL}/1"
    result = evaluated(name)
    stored = load(name).training["evaluation"]
    assert {"cot_inverse", "t0_s", "failed_share"} <= stored.keys()
    for metric in result.keys() & stored.keys():
        value = np.nan if stored[metric] is None else stored[metric]
        np.testing.assert_allclose(result[metric][0], value, rtol=1e-5, err_msg=metric)


def test_a_file_of_one_run_can_be_saved_and_read_back(file, tmp_path):
    from tegotae import save

    saved = load(f"zoo:{file}:{MODEL}/1")
    save(saved, tmp_path / "one.json")
    again = load(tmp_path / "one.json")
    assert (again.system, again.training) == (saved.system, saved.training)
    np.testing.assert_array_equal(again.weights, saved.weights)


@pytest.mark.parametrize(
    ("words", "contents"),
    [
        ("simulate {name} --duration-s 1 --csv out.csv", "out.csv"),
        pytest.param(
            "figure surface {name} --resolution 8", "surface-ART-1.png", marks=pytest.mark.thorough
        ),
        ("export c {name} --out robot", "robot/tegotae.c"),
        ("export native {name} --out leg.native", "leg.native"),
    ],
)
def test_commands_take_a_trained_controller_by_name(
    file, tmp_path, monkeypatch, capsys, words, contents
):
    monkeypatch.chdir(tmp_path)
    assert main(words.format(name=f"zoo:{file}:ART/1").split()) == 0, capsys.readouterr().err
    assert (tmp_path / contents).stat().st_size > 0


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("{file}:ARTT", "no trained controller of {file} is called 'ARTT'; did you mean ART"),
        ("{file}:V-sektor-w8", "did you mean V-sector-w8"),
        ("{file}:ART/2", f"{MODEL} has the runs 0 to 1"),
        ("{file}:ART/-1", f"{MODEL} has the runs 0 to 1"),
        ("{file}:ART/best", f"{MODEL} has the runs 0 to 1"),
        ("{file}:ART/all", "name one"),
        ("nowhere.npz:ART", "cannot read nowhere.npz"),
        ("papr:ART", "no study of the zoo is called 'papr'"),
        ("", "no trained controller is called ''"),
    ],
)
def test_a_name_that_means_nothing_is_refused_in_one_line(file, one_line_error, name, message):
    printed = one_line_error("simulate", "zoo:" + name.format(file=file))
    assert message.format(file=file) in printed


@pytest.mark.parametrize("cut", [10_000_000, 2, 100])
def test_a_damaged_file_is_refused_in_one_line(file, tmp_path, one_line_error, cut):
    damaged = tmp_path / "damaged.npz"
    data = file.read_bytes()
    damaged.write_bytes(data[: len(data) // cut] or b"no archive")
    for words in (["simulate", f"zoo:{damaged}:ART"], ["models", f"{damaged}:*", "--zoo"]):
        assert f"{damaged} is damaged, or no file of" in one_line_error(*words)


def test_a_file_of_a_later_version_is_refused(file, tmp_path):
    header = json.loads(str(read_arrays(file, MOST_BYTES, ["header"])["header"]))
    text = np.array(json.dumps({**header, "version": 2}))
    with pytest.raises(TegotaeError, match="of version 2; this program reads version 1"):
        open_zoo(with_arrays(file, tmp_path / "later.npz", header=text))


def test_the_models_of_an_installed_package_are_an_option_of_the_command(smoke_study, tmp_path):
    out = tmp_path / "core.npz"
    words = f"reproduction zoo --dir {smoke_study} --name smoke --out {out} --core"
    assert main(words.split()) == 0
    assert list(open_zoo(out).models) == [MODEL, "T-Fv"]


def test_a_study_written_twice_gives_the_same_bytes(file, smoke_study, tmp_path):
    again = tmp_path / "again.npz"
    assert main(f"reproduction zoo --dir {smoke_study} --name smoke --out {again}".split()) == 0
    assert again.read_bytes() == file.read_bytes()


def test_the_list_shows_best_runs_or_all(file, records, capsys):
    def listed(pattern):
        assert main(["models", f"{file}:{pattern}", "--zoo", "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    best = int(np.argmax(records[MODEL].best_fitness))
    assert [entry["name"] for entry in listed("ART")] == [f"zoo:{file}:{MODEL}/{best}"]
    assert len(listed("*/all")) == sum(len(record.weights) for record in records.values())
    (entry_of_run,) = listed(f"{MODEL}/1")
    assert entry_of_run["fitness"] == records[MODEL].best_fitness[1].item()
    assert main(["models", f"{file}:*", "--zoo"]) == 0
    assert "3 controllers; studies: smoke by tegotae" in capsys.readouterr().out
    assert load(entry_of_run["name"]).training["run"] == 1


def test_the_list_names_a_model_of_two_studies_by_its_study(capsys):
    assert main(["models", "AR-rF-sector-w8", "--zoo"]) == 0
    labels = capsys.readouterr().out
    listed = [word for word in labels.split() if word.startswith("zoo:")]
    assert [name.rpartition("/")[0] for name in listed] == [
        "zoo:AR-rF-sector-w8",
        "zoo:calibrated:AR-rF-sector-w8",
    ]


def test_a_file_holds_controllers_of_legs_too(tmp_path, capsys):
    experiment = resolve("AR@quadruped-c").experiment()
    weights = np.random.default_rng(0).normal(size=(2, experiment.controller.n_weights))
    saved = SavedController(experiment.system, weights[0], experiment.name, experiment)
    document = controller_file.described(saved, "a document")
    none = np.zeros(2, int)
    entry = ZooEntry(
        document={name: value for name, value in document.items() if name != "weights"},
        weights=weights,
        seed=none,
        fitness=np.array([0.1, 0.2]),
        generations=none,
        ended=np.array(["plateau", "cap"]),
        metrics={"cost_of_transport": np.array([0.2, np.nan])},
    )
    write_archive(tmp_path / "legs.npz", "legs", [entry])
    name = f"zoo:{tmp_path / 'legs.npz'}:{experiment.name}"
    result = resolve(name)
    assert result.legs().system.body == experiment.system.body
    assert result.controller().training["ended"] == "cap"
    np.testing.assert_array_equal(result.controller().weights, weights[1].astype("float32"))
    assert main(["models", f"{name}/all", "--zoo"]) == 0
    assert "cost_of_transport" in capsys.readouterr().out
    refused(f"known: {experiment.name}$", load, f"zoo:{tmp_path / 'legs.npz'}:zz")


def test_a_pattern_without_controllers_is_refused_with_the_nearest_names(file, one_line_error):
    assert "did you mean T-Fv" in one_line_error("models", f"{file}:T-Fw*", "--zoo")
    assert "no trained controller is called" in one_line_error("models", f"{file}:ART/7", "--zoo")
    assert "no study of the zoo" in one_line_error("models", "papr:ART", "--zoo")


packaged = pytest.mark.skipif(not studies(), reason="no file of trained controllers yet")


@packaged
def test_the_package_has_fifteen_runs_of_the_papers_models():
    paper = studies()[0]
    assert paper.study == "paper"
    assert set(paper.models.values()) == {15}
    assert list(paper.models) == [name for name in study_recipes() if name in paper.models]
    assert paper.software["engine"] == "native"


@packaged
def test_every_name_of_the_package_means_one_controller():
    registry = zoo_names()
    assert len(registry) == sum(len(zoo.models) for zoo in studies())
    for name in registry[:: len(registry) // 8]:
        saved = load(name)
        source, _, model = name.removeprefix("zoo:").rpartition(":")
        assert saved.name == model
        zoo = next(zoo for zoo in studies() if source in ("", zoo.study) and model in zoo.models)
        runs = zoo.runs(saved.name)
        best = np.argmax(runs.get("selection", runs["fitness"]))
        assert saved.training["best_fitness"] == runs["fitness"][best]
        study = f"zoo:{zoo.study}:{saved.name}/{saved.training['run']}"
        np.testing.assert_array_equal(load(study).weights, saved.weights)


OF_TABLES = {
    "paper": ("study/paper", "model", "run", {"fitness": "best_fitness"}),
    "core": ("study/paper", "model", "run", {"fitness": "best_fitness"}),
    "legs": ("learned_legs/selection", "cell", "run", {"selection": "score"}),
    "lost-leg": ("lost_leg/reacting", "body", "run", {"selection": "selection"}),
}
"""Tables of the studies: their path, their columns of models and runs, and their names of the zoo's
fields."""


@packaged
@pytest.mark.parametrize("study", OF_TABLES)
def test_the_zoos_controllers_are_the_runs_of_the_studys_table(study):
    name, models, runs, columns = OF_TABLES[study]
    zoo = open_zoo(FOLDER / f"{study}.npz")
    table = pd.read_csv(kept_file(f"{name}.csv")).drop_duplicates([models, runs])
    for model in zoo.models:
        rows = table[table[models].isin([model, model.partition("@")[0]])].sort_values(runs)
        for of_zoo, of_table in columns.items():
            stored = zoo.runs(model)[of_zoo]
            np.testing.assert_allclose(stored, rows[of_table], rtol=1e-6, err_msg=model)


LEARNED = [name for name, model in study_recipes().items() if model.terms.learned]


@packaged
@pytest.mark.parametrize(
    "model",
    ["ART-rF-tphif-w4", *(pytest.param(name, marks=pytest.mark.thorough) for name in LEARNED)],
)
def test_evaluating_the_zoos_controllers_gives_the_studys_table(model):
    found = evaluated(f"zoo:paper:{model}/all")["cot_inverse"]
    table = pd.read_csv(kept_file("study/paper.csv")).query("model == @model")
    np.testing.assert_allclose(found, table.sort_values("run").cot_inverse, rtol=1e-4)


def entries(archive: Path) -> list[tuple[str, bytes]]:
    """Return the members of an archive, to the byte; the headers of a zip differ between
    Pythons."""
    with zipfile.ZipFile(archive) as file:
        return [(name, file.read(name)) for name in file.namelist()]


@packaged
def test_a_wheel_has_some_of_the_trained_controllers(tmp_path):
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = settings["tool"]["hatch"]["build"]["targets"]["wheel"]
    beside = [f"src/tegotae/systems/zoo/data/{name}.npz" for name in ("calibrated", "paper")]
    packages = [f"src/{name}" for name in ("tegotae", "tegotae_robots", "lanewise")]
    assert wheel == {"packages": packages, "exclude": beside}
    for place in [*FOLDER.glob("*.npz")]:
        assert place.stat().st_size < 2e6
        words = ["git", "check-ignore", "--quiet", str(place)]
        assert subprocess.run(words, cwd=ROOT).returncode != 0
    write_archive(tmp_path / "core.npz", "paper", core(open_zoo(FOLDER / "paper.npz")))
    assert entries(tmp_path / "core.npz") == entries(FOLDER / "core.npz")


def test_an_installed_package_says_where_the_whole_zoo_is(tmp_path, monkeypatch, one_line_error):
    for name in ("core", "legs"):
        shutil.copy(FOLDER / f"{name}.npz", tmp_path)
    complete = load("zoo:ART")
    monkeypatch.setattr("tegotae.systems.zoo.FOLDER", tmp_path)
    assert len(studies()[0].models) == 38
    assert load("zoo:ART").weights.tobytes() == complete.weights.tobytes()
    assert load("zoo:paper:ART/3").training["run"] == 3
    for name in ("ART-rFv-tphif-w8", "calibrated:ART"):
        message = one_line_error("simulate", f"zoo:{name}")
        assert "all are in paper.npz and calibrated.npz of its sources" in message


@packaged
def test_the_example_of_the_page_runs(capsys):
    page = ROOT / "docs" / "guides" / "trained-controllers.md"
    exec("".join(text for _, text in blocks(page, "python")), {})
    assert capsys.readouterr().out.startswith(f"{MODEL} (96,) ")
