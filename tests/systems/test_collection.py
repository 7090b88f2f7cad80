"""Controllers read from a folder: every file of it, or one line on the one that cannot be."""

import errno
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, TegotaeError
from tegotae.measures.objectives.fitness import Fitness, HoppingLegs
from tegotae.simulation.world import Uniform
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.training.collection import read_runs


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder of three controllers, one of them in a subfolder."""
    controller = recipe("V-reflex-w8").controller()
    (tmp_path / "more").mkdir()
    for gain, name in enumerate(("a", "b", "more/c"), 1):
        weights = np.array([float(gain)])
        controller_file.save(
            SavedController.from_weights(controller, weights, 8.0), tmp_path / f"{name}.json"
        )
    return tmp_path


def gains(folder: Path) -> list[float]:
    return [float(weight) for runs in read_runs(folder) for weight in runs.weights.ravel()]


def test_all_controllers_of_a_folder_are_read(folder):
    assert gains(folder) == [1.0, 2.0, 3.0]


def test_a_copy_of_a_controller_file_counts_once_and_a_line_says_so(folder, capsys):
    shutil.copy(folder / "a.json", folder / "copy.json")
    assert gains(folder) == [1.0, 2.0, 3.0]
    message = capsys.readouterr().err
    assert message.startswith("tegotae: 1 of 4 runs have the weights of another, such as ")
    assert message.endswith("copy.json; equal ones count once\n")


@pytest.mark.parametrize(
    "text",
    [
        "{}",
        "[]",
        "null",
        "7",
        '{"configuration": {}}',
        '{"format": "python -m research.reproduction"}',
    ],
)
def test_other_documents_are_passed_over(folder, text):
    (folder / "run.json").write_text(text)
    (folder / "readme.txt").touch()
    (folder / "folder.json").mkdir()
    assert gains(folder) == [1.0, 2.0, 3.0]


def test_a_long_entry_before_the_format_hides_no_controller(folder):
    path = folder / "a.json"
    path.write_text(path.read_text().replace("{", '{"note": "' + "long " * 100 + '", ', 1))
    assert gains(folder) == [1.0, 2.0, 3.0]


CUT_SHORT = "is damaged: it is cut short, or no JSON; remove it"
UNUSABLE = {
    "empty": (lambda content: b"", "is empty; remove it"),
    "cut short": (lambda content: content[:-10], CUT_SHORT),
    "without weights": (
        lambda content: content.replace(b'"weights"', b'"wights"'),
        "is damaged: it has no entry 'weights'",
    ),
}


@pytest.mark.parametrize("name", ["a.json", "more/c.json"])
@pytest.mark.parametrize("damage", UNUSABLE)
def test_a_file_that_may_have_been_a_controller_is_named(folder, damage, name):
    path = folder / name
    spoil, message = UNUSABLE[damage]
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(TegotaeError) as raised:
        read_runs(folder)
    assert str(raised.value).startswith(f"{path} {message}")
    assert "\n" not in str(raised.value)


def test_a_file_that_cannot_be_read_is_named(folder, monkeypatch):
    open_path = Path.open

    def denied(path, *args, **kwargs):
        if path.name == "b.json":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return open_path(path, *args, **kwargs)

    monkeypatch.setattr(Path, "open", denied)
    refused(f"^cannot read {folder / 'b.json'}: Permission denied$", read_runs, folder)


def test_a_link_to_nothing_is_named(folder):
    (folder / "b.json").unlink()
    (folder / "b.json").symlink_to(folder / "gone")
    refused(f"^cannot read {folder / 'b.json'}: No such file", read_runs, folder)


def test_a_subfolder_that_cannot_be_read_is_named(folder, monkeypatch):
    scan = os.scandir

    def denied(place):
        if Path(place).name == "more":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))
        return scan(place)

    monkeypatch.setattr(os, "scandir", denied)
    refused(f"^cannot read {folder / 'more'}: Permission denied$", read_runs, folder)


def test_evaluate_names_it_in_one_line(folder, one_line_error):
    (folder / "b.json").write_bytes(b"")
    message = f"tegotae: {folder / 'b.json'} is empty; remove it from the folder\n"
    assert one_line_error("evaluate", str(folder)) == message


# Which files are runs of one set.


def training(seed: int, **changed: Any) -> dict[str, Any]:
    """Return the training of a file, with some of its entries changed."""
    document = {
        "algorithm": {"name": "pgpe", "population": 16},
        "stopping": {"least": 100},
        "seeds": [0, 1],
        "seed": seed,
        "generations": 100 + seed,
        "best_fitness": 0.5 + seed,
    }
    for place, value in changed.items():
        entry: Any = document
        *path, last = place.split("__")
        for name in path:
            entry = entry[name]
        entry[last] = value
    return document


OF_EXPERIMENT = ("omega", "body", "height_m", "objective", "conditions")


def leave(folder: Path, runs: tuple[int, ...] = (0, 1), **changed: Any):
    """Files of a training, a folder of them."""
    folder.mkdir(parents=True, exist_ok=True)
    overrides = {name: changed.pop(name) for name in OF_EXPERIMENT if name in changed}
    experiment = recipe("V-reflex-w8").experiment(**overrides)
    for seed in runs:
        saved = SavedController(
            experiment.system,
            np.array([float(seed)]),
            name="V-reflex-w8",
            experiment=experiment,
            training=training(seed, **changed),
        )
        controller_file.save(saved, folder / f"V-reflex-w8-seed{seed}.json")


def reported(folder: Path) -> list[tuple[str, tuple[str, ...]]]:
    return [(runs.name, runs.labels) for runs in read_runs(folder)]


OTHERS = {
    "algorithm": ({"algorithm": {"name": "cma-es", "std": 0.3}}, "algorithm {}"),
    "setting": ({"algorithm__population": 32}, "algorithm.population {}"),
    "objective": ({"objective": Fitness(work="net")}, "objective.work {}"),
    "kind of objective": ({"objective": HoppingLegs()}, "objective {}"),
    "release": ({"height_m": 1.4}, "release.height_m {}"),
    "frequency": ({"omega": 7.0}, "omega {}"),
    "body": ({"body": Hopper(mass_kg=0.2)}, "body.mass_kg {}"),
}
VALUES = {
    "algorithm": ("pgpe", "cma-es"),
    "setting": (16, 32),
    "objective": ("absolute", "net"),
    "kind of objective": ("Fitness", "HoppingLegs"),
    "release": ("1.2", "1.4"),
    "frequency": (8, 7),
    "body": (0.1, 0.2),
}


@pytest.mark.parametrize("difference", OTHERS)
def test_runs_of_different_trainings_are_sets_of_their_own_that_say_what_differs(
    tmp_path, difference
):
    changed, label = OTHERS[difference]
    leave(tmp_path / "a")
    leave(tmp_path / "b", **changed)
    assert reported(tmp_path) == [
        (f"V-reflex-w8 ({label.format(value)})", ("0", "1")) for value in VALUES[difference]
    ]


def test_seeds_of_one_training_are_one_set_wherever_they_are(tmp_path):
    leave(tmp_path / "a", (0, 1))
    leave(tmp_path / "b", (2, 3), seeds=[2, 3])
    assert reported(tmp_path) == [("V-reflex-w8", ("0", "1", "2", "3"))]


def test_no_set_has_a_seed_twice(tmp_path):
    """The same training of other lengths: the cap is no part of what decides a generation."""
    leave(tmp_path / "a")
    leave(tmp_path / "b", generations=7)
    assert reported(tmp_path) == [
        (f"V-reflex-w8 (in {tmp_path / name})", ("0", "1")) for name in ("a", "b")
    ]


def test_what_differs_beyond_a_few_entries_is_counted(tmp_path):
    leave(tmp_path / "a")
    leave(
        tmp_path / "b",
        omega=7.0,
        body=Hopper(mass_kg=0.2),
        height_m=1.4,
        algorithm__population=32,
        stopping__least=5,
    )
    (single, _), (second, _) = reported(tmp_path)
    assert single.endswith("2 more differ)")
    assert single != second


def test_a_training_under_conditions_is_told_from_one_without(tmp_path):
    leave(tmp_path / "a")
    leave(tmp_path / "b", conditions=(Uniform("mass_kg", low=0.08, high=0.12),))
    names = [name for name, _ in reported(tmp_path)]
    assert names == ["V-reflex-w8 (no conditions)", "V-reflex-w8 (conditions)"]
