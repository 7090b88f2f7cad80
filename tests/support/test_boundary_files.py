"""Hostile files and parts from elsewhere: each is refused in one line, before any work."""

import io
import warnings
from pathlib import Path

import numpy as np
import pytest

from refusals import refused
from research.reproduction.commands.study import experiments_at
from tegotae import TegotaeError
from tegotae._support.files import read_arrays
from tegotae.cli.console import warn_in_one_line
from tegotae.measures import recordings
from tegotae.measures.recordings import read_columns
from tegotae.systems import controller_file


def archive(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def lone_array() -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.arange(9.0))
    return stream.getvalue()


def flipped(content: bytes, position: int) -> bytes:
    return content[:position] + bytes([content[position] ^ 0x55]) + content[position + 1 :]


WALK = archive(
    time_s=np.arange(200) * 0.01, height_m=np.random.default_rng(0).uniform(1.0, 1.2, 200)
)
DAMAGED = {
    "an .npy by another name": lone_array(),
    "one byte of the numbers": flipped(WALK, len(WALK) // 3),
    "cut short": WALK[: len(WALK) // 2],
    "empty": b"",
    "a text": b"time_s,height_m\n",
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_a_damaged_archive_is_no_recording(tmp_path, one_line_error, kind):
    path = tmp_path / "walk.npz"
    path.write_bytes(DAMAGED[kind])
    assert f"{path} is no recording" in one_line_error("measure", str(path), "--rest-length-m", "1")


def test_wherever_a_byte_is_flipped_a_recording_is_refused_or_the_same(tmp_path):
    path = tmp_path / "walk.npz"
    path.write_bytes(WALK)
    complete = read_columns(path)
    for position in range(0, len(WALK), 37):
        path.write_bytes(flipped(WALK, position))
        try:
            result = read_columns(path)
        except TegotaeError:
            continue
        for name, values in result.items():  # what the archive says of itself: a date, a flag
            np.testing.assert_array_equal(values, complete[name])


def test_a_recording_that_would_unpack_to_gigabytes_is_not_unpacked(tmp_path, monkeypatch):
    path = tmp_path / "walk.npz"
    path.write_bytes(archive(time_s=np.zeros(2**20), height_m=np.zeros(2**20)))
    assert path.stat().st_size < 100_000
    monkeypatch.setattr(recordings, "MOST_BYTES", 2**22)
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it was unpacked"))
    refused("it unpacks to 16 MiB, more than 4 MiB", read_columns, path)


DEEP = "[" * 5000 + "]" * 5000


def test_documents_that_are_nested_without_end_are_refused(tmp_path):
    pytest.importorskip("gymnasium")
    from tegotae.envs import load_wiring

    readers = {
        "leg.toml": load_wiring,
        "leg.json": load_wiring,
        "plans.json": lambda path: experiments_at(str(path)),
    }
    for name, read in readers.items():
        path = tmp_path / name
        path.write_text(f"limbs = {DEEP}" if name.endswith(".toml") else DEEP)
        refused("nested deeper than 64 levels", read, path)
    refused("is not a controller file", controller_file.load, tmp_path / "plans.json")


SPACELESS = """
import gymnasium

class Bare(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))

class Blind(gymnasium.Env):
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))
"""
WIRING = """
[[limbs]]
drives = "action[0]"
[limbs.senses]
spring_force = "observation[0]"
"""


@pytest.mark.parametrize(("kind", "space"), [("Bare", "action"), ("Blind", "observation")])
def test_an_environment_without_a_space_is_told_which(tmp_path, one_line_error, kind, space):
    pytest.importorskip("gymnasium")
    path, wiring = tmp_path / f"made_{kind.lower()}.py", tmp_path / "leg.toml"
    path.write_text(SPACELESS)
    wiring.write_text(WIRING)
    words = ["--wiring", str(wiring), "--out", str(tmp_path / "out"), "--workers", "0"]
    message = one_line_error("train", "ART", "--env", f"{path}:{kind}", *words)
    assert f"the environment has no {space}_space" in message


def test_a_warning_is_one_line_without_a_place_in_the_source(capsys, monkeypatch):
    monkeypatch.delenv("TEGOTAE_DEBUG", raising=False)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warn_in_one_line()
        for _ in range(2):
            warnings.warn("a scale\nis missing \x1b[31m", stacklevel=1)
            np.float64(1e308) * np.float64(10.0)
    assert capsys.readouterr().err.splitlines() == [
        r"tegotae: warning: a scale is missing \x1b[31m",
        "tegotae: warning: overflow encountered in scalar multiply",
    ]


def test_with_debug_a_warning_says_where_it_arose(monkeypatch):
    monkeypatch.setenv("TEGOTAE_DEBUG", "1")
    with warnings.catch_warnings(record=True) as told_in_full:
        warnings.simplefilter("always")
        warn_in_one_line()
        warnings.warn("a scale is missing", stacklevel=1)
    assert [Path(frame.filename).name for frame in told_in_full] == ["test_boundary_files.py"]


def test_an_archive_of_objects_runs_nothing(tmp_path):
    path = tmp_path / "walk.npz"
    np.savez(path, time_s=np.array([print], dtype=object))
    with pytest.raises(ValueError, match="Object arrays cannot be loaded"):
        read_arrays(path, 2**20)
