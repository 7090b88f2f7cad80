"""Controllers read from a folder: every file of it, or one line on the one that cannot be."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tegotae import TegotaeError, build
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.training.collection import read


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder of three controllers, one of them in a subfolder."""
    controller = build("V-reflex-w8")
    (tmp_path / "more").mkdir()
    for gain, name in enumerate(("a", "b", "more/c"), 1):
        weights = np.array([float(gain)])
        controller_file.save(
            SavedController.of(controller, weights, 8.0), tmp_path / f"{name}.json"
        )
    return tmp_path


def gains(folder: Path) -> list[float]:
    return [float(weight) for runs in read(folder) for weight in runs.weights.ravel()]


def test_all_controllers_of_a_folder_are_read(folder):
    assert gains(folder) == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    "text", ["{}", "[]", "null", "7", '{"configuration": {}}', '{"format": "tegotae study"}']
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
    "very short": (lambda content: content[:5], CUT_SHORT),
    "cut short": (lambda content: content[:-10], CUT_SHORT),
    "no text": (lambda content: b"\xff\xfe\x00" * 9, CUT_SHORT),
    "without weights": (
        lambda content: content.replace(b'"weights"', b'"wights"'),
        "is damaged: it has no entry 'weights'",
    ),
}


@pytest.mark.parametrize("name", ["a.json", "more/c.json"])
@pytest.mark.parametrize("damage", UNUSABLE)
def test_a_file_that_may_have_been_a_controller_is_named(folder, damage, name):
    path = folder / name
    spoil, said = UNUSABLE[damage]
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(TegotaeError) as raised:
        read(folder)
    assert str(raised.value).startswith(f"{path} {said}")
    assert "\n" not in str(raised.value)


def test_a_file_that_cannot_be_read_is_named(folder, monkeypatch):
    whole = Path.open

    def denied(path, *args, **kwargs):
        if path.name == "b.json":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return whole(path, *args, **kwargs)

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(TegotaeError, match=f"^cannot read {folder / 'b.json'}: Permission denied$"):
        read(folder)


def test_a_link_to_nothing_is_named(folder):
    (folder / "b.json").unlink()
    (folder / "b.json").symlink_to(folder / "gone")
    with pytest.raises(TegotaeError, match=f"^cannot read {folder / 'b.json'}: No such file"):
        read(folder)


def test_a_subfolder_that_cannot_be_read_is_named(folder, monkeypatch):
    scan = os.scandir

    def denied(place):
        if Path(place).name == "more":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))
        return scan(place)

    monkeypatch.setattr(os, "scandir", denied)
    with pytest.raises(TegotaeError, match=f"^cannot read {folder / 'more'}: Permission denied$"):
        read(folder)


def test_evaluate_names_it_in_one_line_from_a_plain_shell(folder):
    (folder / "b.json").write_bytes(b"")
    found = subprocess.run(
        [sys.executable, "-m", "tegotae", "evaluate", str(folder)], capture_output=True, text=True
    )
    assert (found.returncode, found.stdout) == (2, "")
    assert found.stderr == f"tegotae: {folder / 'b.json'} is empty; remove it from the folder\n"
