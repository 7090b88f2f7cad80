"""A study's records are whole or not there, and its folder holds one study only."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from records import instant, made_up
from refusals import refused
from research.reproduction import runner
from research.reproduction.export import read_study_csv, write_study_csv
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from research.reproduction.record import (
    Record,
    read_record,
)
from research.reproduction.table import tabulate
from research.reproduction.unit import work
from tegotae import Timing, study
from tegotae._support.documents import DamagedDocumentError
from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training import collection
from tegotae.training.evolution import Stopping


def equal_records(a: Record, b: Record) -> bool:
    arrays = [(a.weights, b.weights), (a.best_fitness, b.best_fitness)]
    arrays += [(a.episodes[name], b.episodes[name]) for name in HOPPING.names()]
    return a.configuration == b.configuration and all(
        np.array_equal(x, y, equal_nan=True) for x, y in arrays
    )


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    runner.run_study(plan("smoke"), tmp_path / "study", instant)
    return Folder(tmp_path / "study")


def test_a_record_reads_back_as_it_was_written(tmp_path: Path) -> None:
    record = made_up(plan("smoke").units[0])
    record.result.write(tmp_path / "a.npz")
    assert equal_records(read_record(tmp_path / "a.npz"), record)


def test_a_table_says_how_many_numbers_a_model_learns(folder: Folder, tmp_path: Path) -> None:
    table = tabulate(folder.all()[0])
    learned = {name: recipe(name).controller().n_weights for name in table["model"].tolist()}
    assert table["parameters"].tolist() == [learned[name] for name in table["model"].tolist()]
    assert "parameters" not in table.metrics
    write_study_csv(table, tmp_path / "table.csv")
    again = read_study_csv(tmp_path / "table.csv")
    assert again["parameters"].tolist() == table["parameters"].tolist()
    assert again["parameters"].dtype.kind == "i"


def test_a_unit_is_evaluated_as_its_system_is_released_and_held(monkeypatch) -> None:
    class AskedError(Exception):
        pass

    def evaluate(*arguments, start, integrator, **options):
        velocity = start.velocity_m_per_s  # heights and phases are drawn for a searched gain
        raise AskedError(arguments[4].release_m, arguments[4].tick_s, velocity, integrator)

    standard = plan("smoke", "V-sector-w8").units[0]
    held = replace(
        standard.run.experiment,
        {
            "integrator": Hold(),
            "timing": Timing(duration_s=4.0, tick_s=0.004),
            "height_m": 1.1,
            "velocity_m_per_s": 0.5,
        },
    )
    unit = dataclasses.replace(standard, run=dataclasses.replace(standard.run, experiment=held))
    monkeypatch.setattr("research.reproduction.unit.evaluate", evaluate)
    with pytest.raises(AskedError) as raised:
        work(unit)
    assert raised.value.args == (1.1, 0.004, 0.5, Hold())
    assert unit.key != standard.key


def test_a_period_that_cannot_be_measured_is_refused_before_training() -> None:
    standard = plan("smoke", "V-sector-w8").units[0]
    odd = replace(
        standard.run.experiment,
        {"integrator": Hold(), "timing": Timing(duration_s=4.2, tick_s=0.003, frame_s=0.021)},
    )
    with pytest.raises(TegotaeError, match=r"the control period is 0.003 s; hops are measured"):
        work(dataclasses.replace(standard, run=dataclasses.replace(standard.run, experiment=odd)))


def test_a_studys_folder_is_a_name_of_its_controllers(folder: Folder, tmp_path: Path) -> None:
    records = folder.all()[0]
    sets = collection.read_runs(folder.path)
    assert [runs.name for runs in sets] == [record.model for record in records]
    for runs, record in zip(sets, records, strict=True):
        assert runs.experiment == record.experiment
        assert runs.labels == tuple(str(seed) for seed in record.configuration["seeds"])
        np.testing.assert_array_equal(runs.weights, record.weights)
    with pytest.raises(TegotaeError, match=r"holds \d+ controllers; name a file of one"):
        resolve(folder.path).controller()
    for path in folder.records.iterdir():
        path.write_bytes(path.read_bytes()[:100])
    refused(r"has no record that is whole: .* is damaged", resolve, folder.path)


@pytest.mark.parametrize("damage", ["cut", "flipped", "foreign", "empty"])
def test_a_damaged_record_is_found(tmp_path: Path, damage: str) -> None:
    path = tmp_path / "a.npz"
    made_up(plan("smoke").units[0]).result.write(path)
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) // 2]
    elif damage == "flipped":
        content[content.index(b"weights.npy") + 100] ^= 0xFF  # in the array, not in its label
    elif damage == "foreign":
        content = bytearray(b"not a record")
    else:
        content = bytearray()
    path.write_bytes(bytes(content))
    with pytest.raises(DamagedDocumentError, match=r"a\.npz is damaged"):
        read_record(path)


def test_units_are_named_by_what_defines_their_content() -> None:
    unit = plan("smoke").units[0]
    longer = dataclasses.replace(
        unit,
        run=dataclasses.replace(
            unit.run, learner=dataclasses.replace(unit.run.learner, stopping=Stopping.after(4))
        ),
    )
    assert unit.key == plan("smoke").units[0].key
    assert longer.key != unit.key


def test_running_again_does_only_what_is_missing(folder: Folder) -> None:
    requested = []

    def counting(bundles):
        requested.extend(bundles)
        yield from instant(bundles)

    study = plan("smoke")
    folder.study([]).place(study.units[1]).unlink()
    runner.run_study(study, folder.path, counting)
    assert [[unit.key for unit in bundle] for bundle in requested] == [[study.units[1].key]]


def test_a_record_of_another_configuration_is_set_aside_and_done_again(folder: Folder, capsys):
    unit, second = plan("smoke").units[:2]
    place = folder.study([]).place(unit)
    place.write_bytes(folder.study([]).place(second).read_bytes())
    runner.run_study(plan("smoke"), folder.path, instant)
    assert equal_records(read_record(place), made_up(unit))
    assert "it holds another configuration" in capsys.readouterr().out


def test_a_result_of_another_configuration_is_no_result_of_the_study(tmp_path: Path) -> None:
    def edited(bundles):
        for unit, result in instant(bundles):
            document = {**result.document, "seeds": [7, 8]}
            yield unit, dataclasses.replace(result, document=document)

    with pytest.raises(TegotaeError, match="was computed with another seeds: a file was edited"):
        runner.run_study(plan("smoke"), tmp_path / "study", edited)
    assert not list((tmp_path / "study").rglob("*.record.npz"))


def test_a_folder_of_unknown_records_is_refused(folder: Folder) -> None:
    (folder.path / "study.json").unlink()
    refused(r"no study\.json", lambda: runner.run_study(plan("smoke"), folder.path, instant))


def test_the_paper_scale_is_the_papers() -> None:
    full = plan("paper")
    assert len(full.units) == 218
    assert full.seeds == 15
    # One compiled program per shape of model: ω_t is no part of it.
    assert len(study.bundles(full.units)) == 110


def test_every_architecture_is_in_the_quick_scale() -> None:
    architectures = {
        recipe(unit.run.experiment.name).terms.architecture for unit in plan("quick").units
    }
    assert architectures == {"V", "VG", "VT", "VGT", "AR", "ART", "ARG", "ARGT", "T"}
