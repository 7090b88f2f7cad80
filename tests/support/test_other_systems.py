"""The package without POSIX modules, as on Windows: other locks, all cores, no permissions."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOREIGN = Path(__file__).parents[1] / "helpers" / "foreign"


def elsewhere(*arguments, **options):
    """Run Python without POSIX modules, in this process's path."""
    paths = os.pathsep.join([str(FOREIGN), *sys.path])
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        **options,
    )


def test_posix_is_taken_away():
    code = "import os, signal, sys; print(hasattr(os, 'getuid'), sys.modules['fcntl'])"
    assert elsewhere("-c", code).stdout == "False None\n"


def test_a_hopper_is_simulated_and_drawn(tmp_path):
    run = elsewhere("-m", "tegotae", "demo", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "demo/hop.gif").read_bytes().startswith(b"GIF89a")


def test_a_training_is_learned_and_resumed_and_evaluated_and_exported(tmp_path):
    def tegotae(*words):
        run = elsewhere("-m", "tegotae", *words, cwd=tmp_path)
        assert run.returncode == 0, run.stderr
        return run.stdout

    words = ("train", "AR", "--seeds", "2", "--duration-s", "13", "--out", "runs")
    tegotae(*words, "--generations", "2")
    tegotae(*words, "--generations", "3")
    assert "CoT⁻¹" in tegotae("evaluate", "runs")
    tegotae("export", "c", "runs/AR-rF-reflex-w8-seed0.json", "--tick-s", "0.002", "--out", "robot")
    assert (tmp_path / "robot/tegotae.c").exists()


def test_two_programs_do_not_share_a_folder(tmp_path):
    code = f"""
import sys, subprocess
from pathlib import Path
from tegotae._support.workplace import locked
folder = Path({str(tmp_path)!r})
with locked(folder):
    if len(sys.argv) == 1:
        sys.exit(subprocess.run([sys.executable, __file__, "again"]).returncode)
"""
    script = tmp_path / "twice.py"
    script.write_text(code)
    run = elsewhere(str(script))
    assert "another run is at work" in run.stderr
    assert run.returncode == 1
    assert elsewhere(str(script), "alone").returncode == 0, "the lock ended with its process"


def test_workers_share_a_study(tmp_path):
    words = ("-m", "research.reproduction", "run", "--dir", str(tmp_path / "study"))
    run = elsewhere(*words, "--scale", "smoke", "--workers", "2", "--models", "V*", "T-Fv")
    assert run.returncode == 0, run.stderr
    assert len(list((tmp_path / "study").rglob("*.npz"))) == 2


@pytest.mark.parametrize("content", ["first", "second"])
def test_a_file_is_written_whole_and_abandoned_ones_are_removed(tmp_path, content):
    (tmp_path / ".result.txt.0a1b2c3d").write_text("half of")
    code = (
        "from pathlib import Path; from tegotae._support.files import write_atomically;"
        f"write_atomically(Path({str(tmp_path / 'result.txt')!r}), {content!r})"
    )
    assert elsewhere("-c", code).returncode == 0
    assert [path.name for path in tmp_path.iterdir()] == ["result.txt"]
    assert (tmp_path / "result.txt").read_text() == content
