"""Compiled code is kept for the next process, and only what is whole and of this user is run."""

import errno
import os

import numpy as np
import pytest
from jax._src import compilation_cache

from lanewise.machine import Code, target_of
from tegotae._support import compiled, xla_programs
from tegotae._support.xla_programs import one_module
from tegotae.cli import main
from tegotae.cli.kept_texts import is_help
from tegotae.cli.program import Command, CommandGroup

MODULE = "define void @put(ptr %x) {\n  store i32 7, ptr %x\n  ret void\n}\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv(compiled.VARIABLE, str(tmp_path / "kept"))
    return tmp_path / "kept"


def put(code: Code) -> int:
    number = np.zeros(1, np.int32)
    code.function("put", 1)(number.ctypes.data)
    return int(number[0])


def test_code_is_compiled_once(place, monkeypatch):
    assert put(Code.compiled(MODULE, target_of("host"), store=compiled)) == 7
    monkeypatch.setattr("lanewise.machine.object_file", None)
    assert put(Code.compiled(MODULE, target_of("host"), store=compiled)) == 7


def test_damaged_code_is_compiled_again(place):
    Code.compiled(MODULE, target_of("host"), store=compiled)
    (file,) = place.glob("*.o")
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)
    assert compiled.stored_code(file.stem) is None
    assert put(Code.compiled(MODULE, target_of("host"), store=compiled)) == 7
    assert compiled.stored_code(file.stem) is not None


KEYS = [compiled.key_of(name) for name in "abcd"]


def test_of_code_that_there_is_no_space_for_nothing_is_left(place, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    compiled.store_code(KEYS[0], b"code")
    monkeypatch.setattr("os.fsync", full)
    compiled.store_code(KEYS[1], b"code")
    assert sorted(file.name for file in place.iterdir()) == sorted([f"{KEYS[0]}.o", "CACHEDIR.TAG"])


@pytest.mark.parametrize("where", ["off", os.devnull])
def test_where_nothing_can_be_kept_nothing_is(where, monkeypatch):
    monkeypatch.setenv(compiled.VARIABLE, where)
    compiled.store_code(KEYS[0], b"code")
    assert compiled.stored_code(KEYS[0]) is None
    compiled.check_code_folder()


@pytest.mark.parametrize("variable", ["HOME", "XDG_CACHE_HOME"])
def test_an_empty_variable_is_no_folder(variable, monkeypatch, tmp_path):
    for name in (compiled.VARIABLE, "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv(variable, "")
    standard = tmp_path / ".cache" / "tegotae"
    assert compiled.folder() == (None if variable == "HOME" else standard)


def test_the_oldest_code_goes_first_and_files_of_the_user_never(place, monkeypatch):
    monkeypatch.setattr(compiled, "_MOST_FILES", 2)
    for age, key in enumerate(KEYS[:3]):
        compiled.store_code(key, b"code")
        os.utime(place / f"{key}.o", (age, age))
    theirs = [place / "thesis.o", place / "papers" / f"{KEYS[0]}.o"]
    for file in theirs:
        file.parent.mkdir(exist_ok=True)
        file.touch()
        os.utime(file, (0, 0))
    compiled.store_code(KEYS[3], b"code")
    assert {f.stem for f in place.glob("*.o")} == {*KEYS[2:], "thesis"}
    assert all(file.exists() for file in theirs)


def test_code_that_was_used_last_goes_last(place, monkeypatch):
    monkeypatch.setattr(compiled, "_MOST_FILES", 2)
    for age, key in enumerate(KEYS[:2]):
        compiled.store_code(key, b"code")
        os.utime(place / f"{key}.o", (age, age))
    assert compiled.stored_code(KEYS[0]) == b"code"
    compiled.store_code(KEYS[2], b"code")
    assert {f.stem for f in place.glob("*.o")} == {KEYS[0], KEYS[2]}


def test_a_folder_with_files_of_the_user_is_refused_and_left_as_it_is(place, one_line_error):
    place.mkdir()
    (place / "thesis.tex").touch()
    (place / "thesis.tex").chmod(0o600)
    compiled.store_code(KEYS[0], b"code")
    assert compiled.stored_code(KEYS[0]) is None
    message = one_line_error("simulate", "paper")
    assert "TEGOTAE_CACHE is" in message
    assert (
        "has a file of another program or user, 'thesis.tex'; name a new folder, or off" in message
    )
    assert [file.name for file in place.iterdir()] == ["thesis.tex"]


def linked(file):
    os.link(file, file.with_name("other"))


def pointed(file):
    file.rename(file.with_name("other"))
    file.symlink_to(file.with_name("other"))


@pytest.mark.parametrize("change", [lambda file: file.chmod(0o666), linked, pointed])
def test_a_file_that_another_user_can_have_made_is_not_run(place, change):
    compiled.store_code(KEYS[0], b"code")
    assert compiled.stored_code(KEYS[0]) == b"code"
    change(place / f"{KEYS[0]}.o")
    assert compiled.stored_code(KEYS[0]) is None


def test_a_file_of_another_user_is_not_run(place, monkeypatch):
    compiled.store_code(KEYS[0], b"code")
    status_of = os.fstat

    def foreign(file):
        status = [*status_of(file)]
        return os.stat_result([*status[:4], status[4] + 1, *status[5:]])

    monkeypatch.setattr("os.fstat", foreign)
    assert compiled.stored_code(KEYS[0]) is None


def test_a_file_under_the_name_of_another_is_not_run(place):
    compiled.store_code(KEYS[0], b"code")
    (place / f"{KEYS[0]}.o").rename(place / f"{KEYS[1]}.o")
    assert compiled.stored_code(KEYS[1]) is None


def test_a_folder_that_others_can_write_to_is_not_used(place, one_line_error):
    compiled.store_code(KEYS[0], b"code")
    place.chmod(0o777)
    assert compiled.folder() is None
    assert compiled.stored_code(KEYS[0]) is None
    compiled.store_code(KEYS[1], b"code")
    assert not (place / f"{KEYS[1]}.o").exists()
    message = one_line_error("simulate", "paper")
    assert "which others can write to; name a new folder, or off" in message


def test_what_another_user_left_in_a_folder_that_is_not_marked_is_refused(place):
    place.mkdir()
    (place / f"{KEYS[0]}.o").symlink_to("elsewhere")
    assert compiled.folder() is None


def test_a_program_of_xlas_is_kept_whole_and_with_a_checksum(place):
    programs = xla_programs.KeptPrograms(str(place))
    programs.put("jit_f-key", b"program")
    assert programs.get("jit_f-key") == b"program"
    (file,) = place.glob("*.o")
    file.write_bytes(file.read_bytes()[:-1])
    assert programs.get("jit_f-key") is None
    programs.put("jit_f-key", b"program")
    assert programs.get("jit_f-key") == b"program"


def test_jax_keeps_its_programs_so_in_our_folder_and_not_in_the_users(place, tmp_path):
    cache, _ = compilation_cache.get_file_cache(compiled.xla_folder(place))
    assert isinstance(cache, xla_programs.KeptPrograms)
    theirs, _ = compilation_cache.get_file_cache(str(tmp_path / "theirs"))
    assert not isinstance(theirs, xla_programs.KeptPrograms)


def test_help_is_made_once(place, monkeypatch, capsys):
    def help_text() -> str:
        assert main(["cite", "--help"]) == 0
        return capsys.readouterr().out

    first = help_text()
    monkeypatch.setattr("tegotae.cli.parsed", None)
    assert help_text() == first
    assert "cite" in first


@pytest.mark.parametrize(
    "words",
    [
        ["train", "mine.py:experiment", "--help"],
        ["train", "AR@mine.toml", "--help"],
        ["train", "ART", "--algorithm=mine.py:search", "--help"],
        ["--parts=mine.py", "train", "ART", "--help"],
    ],
)
def test_help_that_a_file_of_the_user_decides_is_made_each_time(words):
    assert not is_help(words)


def test_help_of_another_program_is_made_each_time(place, capsys):
    for text in ("First.", "Second."):
        command = CommandGroup(
            text, {"run": Command("research.reproduction.commands.study:StudyRun", "run")}
        )
        assert main(["--help"], command, "python -m research.reproduction") == 0
        assert text in capsys.readouterr().out
    assert not list(place.glob("*.o"))


def test_xla_has_the_options_with_which_it_compiles_in_little_time():
    assert one_module()
