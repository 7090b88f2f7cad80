"""Files are written whole or not at all, and what cannot be written is said in one line."""

import errno
import os
import stat
from pathlib import Path

import pytest

from refusals import refused
from tegotae import TegotaeError
from tegotae._support import files
from tegotae._support.files import hold, output_file, output_folder, write_atomically


@pytest.mark.parametrize(
    ("content", "expected"),
    [("φ̇ = ω + f\n", "φ̇ = ω + f\n".encode()), (b"\x00\xff", b"\x00\xff"), ("", b"")],
)
def test_text_and_bytes_are_written_as_they_are(tmp_path, content, expected):
    path = tmp_path / "file"
    write_atomically(path, content)
    assert path.read_bytes() == expected


def test_a_file_is_replaced_and_nothing_else_is_left_behind(tmp_path):
    path = tmp_path / "file"
    write_atomically(path, "a longer text than the one that follows")
    write_atomically(path, "new")
    assert path.read_text() == "new"
    assert os.listdir(tmp_path) == ["file"]


def test_the_longest_name_that_a_file_can_have_is_written(tmp_path):
    path = tmp_path / ("ω" * 125 + ".json")
    write_atomically(path, "written")
    write_atomically(path, "again")
    assert len(os.fsencode(path.name)) == 255
    assert os.listdir(tmp_path) == [path.name]


def test_what_a_killed_process_left_beside_a_file_is_removed_and_what_is_at_work_is_not(tmp_path):
    abandoned, at_work = tmp_path / ".file.0a1b2c3d", tmp_path / ".file.4e5f6071"
    neighbours = [tmp_path / ".other.0a1b2c3d", tmp_path / ".file.json", tmp_path / ".file.notes"]
    for place in (abandoned, *neighbours):
        place.touch()
    with at_work.open("xb") as stream:
        hold(stream.fileno())
        write_atomically(tmp_path / "file", "new")
        assert not abandoned.exists()
        assert {*tmp_path.iterdir()} == {tmp_path / "file", at_work, *neighbours}


def test_a_temporary_file_that_is_taken_for_abandoned_is_made_again(tmp_path, monkeypatch):
    plain, taken = files.hold, []

    def late(file):
        if not taken:
            taken.append(next(tmp_path.glob(".file.*")))
            taken[0].unlink()
        return plain(file)

    monkeypatch.setattr(files, "hold", late)
    write_atomically(tmp_path / "file", "new")
    assert (tmp_path / "file").read_text() == "new"


@pytest.mark.parametrize("step", ["os.fsync", "pathlib.Path.replace"])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch, step):
    def interrupt(*_):
        raise KeyboardInterrupt

    path = tmp_path / "file"
    write_atomically(path, "old")
    monkeypatch.setattr(step, interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["file"]


def test_a_full_disk_leaves_the_old_file_and_is_said_in_one_line(tmp_path, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "file"
    write_atomically(path, "old")
    monkeypatch.setattr("os.fsync", full)
    refused(f"^cannot write {path}: No space left on device$", write_atomically, path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["file"]


def test_a_file_gets_the_permissions_that_the_user_asks_for(tmp_path):
    previous = os.umask(0o027)
    try:
        write_atomically(tmp_path / "file", "")
    finally:
        os.umask(previous)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def unwritable(tmp_path: Path) -> dict[str, Path]:
    """Folders in which nobody, not even root, can write."""
    (tmp_path / "file").touch()
    places = {
        "below a file": tmp_path / "file" / "folder",
        "proc": Path("/proc/folder"),
        "long": tmp_path / ("x" * 300),
    }
    return {name: place for name, place in places.items() if place.parent.exists()}


@pytest.mark.parametrize("name", ["below a file", "proc", "long"])
def test_a_folder_that_cannot_be_made_is_refused_in_one_line(tmp_path, name):
    places = unwritable(tmp_path)
    if name not in places:
        pytest.skip("this system has no such place")
    with pytest.raises(TegotaeError, match=f"^cannot write to the folder {places[name]}: [^\n]+$"):
        output_folder(places[name])
    with pytest.raises(TegotaeError, match=f"^cannot write {places[name] / 'file'}: [^\n]+$"):
        write_atomically(places[name] / "file", "")


def test_a_file_where_a_folder_is_wanted_is_called_one(tmp_path):
    (tmp_path / "file").write_text("kept")
    refused(r"it is a file$", output_folder, tmp_path / "file")
    assert (tmp_path / "file").read_text() == "kept"


def test_a_folder_is_made_with_those_above_it_and_left_empty(tmp_path):
    folder = output_folder(tmp_path / "a" / "b")
    assert folder == tmp_path / "a" / "b"
    assert os.listdir(folder) == []
    assert output_folder(folder) == folder


def test_a_file_is_checked_before_the_work_and_leaves_nothing_until_it_is_written(tmp_path):
    path = output_file(tmp_path / "plots" / "late" / "hop.png")
    assert os.listdir(tmp_path) == []
    write_atomically(path, "drawn")
    assert path.read_text() == "drawn"
    assert output_file(path) == path
    assert path.read_text() == "drawn"


def test_a_folder_where_a_file_is_wanted_is_called_one(tmp_path):
    refused(r"it is a folder$", output_file, tmp_path)
    refused(r"Is a directory$", write_atomically, tmp_path, "")
