"""Compiled code is kept for the next process, and only what is whole and of this user is run."""

from __future__ import annotations

import errno
import os
import warnings

import numpy as np
import pytest

from lanewise.machine import Code, target_of
from tegotae._support import compiled
from tegotae.cli import main
from tegotae.cli.console import DEBUG, warn_in_one_line

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
    whole = bytearray(file.read_bytes())
    whole[-1] ^= 1
    file.write_bytes(whole)
    assert compiled.kept(file.stem) is None
    assert put(Code.compiled(MODULE, target_of("host"), store=compiled)) == 7
    assert compiled.kept(file.stem) is not None


def test_a_folder_that_others_can_write_to_is_not_used(place):
    compiled.keep("key", b"code")
    assert compiled.kept("key") == b"code"
    place.chmod(0o777)
    assert compiled.folder() is None
    assert compiled.kept("key") is None
    compiled.keep("other", b"code")
    assert not (place / "other.o").exists()


def test_of_code_that_there_is_no_space_for_nothing_is_left(place, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    compiled.keep("key", b"code")
    monkeypatch.setattr("os.fsync", full)
    compiled.keep("other", b"code")
    assert [file.name for file in place.iterdir()] == ["key.o"]


@pytest.mark.parametrize("where", ["off", os.devnull])
def test_where_nothing_can_be_kept_nothing_is(where, monkeypatch):
    monkeypatch.setenv(compiled.VARIABLE, where)
    compiled.keep("key", b"code")
    assert compiled.kept("key") is None


def test_the_oldest_code_goes_first(place, monkeypatch):
    monkeypatch.setattr(compiled, "_MOST_FILES", 2)
    for age, key in enumerate(("a", "b", "c")):
        compiled.keep(key, b"code")
        os.utime(place / f"{key}.o", (age, age))
    compiled.keep("d", b"code")
    assert sorted(file.stem for file in place.iterdir()) == ["c", "d"]


def test_a_damaged_program_of_xlas_goes_without_a_word(place, monkeypatch, capsys):
    compiled.keep("key", b"code")
    damaged = place / "xla-here" / "jit_f-cache"
    damaged.parent.mkdir()
    damaged.write_bytes(b"half")
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(damaged.parent))
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    monkeypatch.delenv(DEBUG, raising=False)
    warn_in_one_line()
    warnings.showwarning(
        UserWarning("Error reading persistent compilation cache entry for 'f': truncated"),
        UserWarning,
        "compiler.py",
        1,
    )
    assert not damaged.exists()
    assert compiled.kept("key") == b"code"
    assert capsys.readouterr().err == ""


def test_a_folder_of_programs_that_is_the_users_is_left_alone(place, tmp_path, monkeypatch):
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    (theirs / "jit_f-cache").touch()
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(theirs))
    assert not compiled.forget_xla_programs()
    assert (theirs / "jit_f-cache").exists()


def test_help_is_made_once(place, monkeypatch, capsys):
    def shown() -> str:
        with pytest.raises(SystemExit) as end:
            main(["cite", "--help"])
        assert not end.value.code
        return capsys.readouterr().out

    first = shown()
    monkeypatch.setattr("tegotae.cli.parsed", None)
    assert shown() == first
    assert "cite" in first
