"""Smoke studies in processes of their own, to be disturbed."""

import fcntl
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from research.reproduction.folder import Folder
from tegotae.systems.controller_file import SUFFIX

MODELS = ("V-sector-w8", "ART-rF-tphif-w8", "T-Fv")
"""The models of the smoke scale."""
PROGRAMS = "programs"
"""Beside the undisturbed study, what XLA compiled for it."""
WHOLE_CACHE = {
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
    "JAX_COMPILATION_CACHE_MAX_SIZE": str(2**30),  # with a limit JAX locks what it writes
}
"""JAX's settings to keep every program."""


def start(
    folder: Path, *extra: str, programs_of: Path | None = None, keep: Path | None = None
) -> subprocess.Popen[str]:
    """Start `python -m research.reproduction run` in a session of its own, as in a terminal of its
    own.

    Args:
        folder: of the study.
        more: words of the command.
        programs_of: the undisturbed study, whose programs XLA does not compile again.
        keep: where the programs that XLA compiles are kept; nowhere by default.
    """
    if programs_of is not None:  # a copy, which a killed process may spoil
        keep = folder.with_name(f"{folder.name}-programs")
        shutil.copytree(programs_of.with_name(PROGRAMS), keep, dirs_exist_ok=True)
    cache = {} if keep is None else {"JAX_COMPILATION_CACHE_DIR": str(keep), **WHOLE_CACHE}
    words = ["run", "--dir", str(folder), "--scale", "smoke", *extra]
    return subprocess.Popen(
        [sys.executable, "-m", "research.reproduction", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | cache,
    )


def finish(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Wait for a run that is to end well: what it printed to stdout and to stderr."""
    out, err = process.communicate(timeout=900)
    assert process.returncode == 0, err
    return out, err


def undisturbed(place: Path) -> Path:
    """The folder `smoke` in `place`, holding a study that was run to its end in one go."""
    folder = place / "smoke"
    with (place / "smoke.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (place / "smoke.printed").exists():
            out, err = finish(start(folder, "--workers", "1", keep=place / PROGRAMS))
            (place / "smoke.printed").write_text(out + err)
    return folder


def records(folder: Path) -> list[Path]:
    """The files of a study's records."""
    return sorted((folder / "records").glob(f"*{SUFFIX}"))


def copy(undisturbed: Path, folder: Path, *models: str) -> Path:
    """A folder in which only some models of the undisturbed study are done."""
    (folder / "records").mkdir(parents=True)
    (folder / "study.json").write_bytes((undisturbed / "study.json").read_bytes())
    for path in records(undisturbed):
        if path.name.startswith(models):
            (folder / "records" / path.name).write_bytes(path.read_bytes())
    return folder


def numbers(folder: Path) -> dict[str, Any]:
    """Everything a study found, model by model: configuration, weights, curves, metrics."""
    result, wrong = Folder(folder).all()
    assert wrong == []
    return {
        record.model: {
            "configuration": record.configuration,
            "weights": record.weights,
            "deviation": record.deviation,
            "best_fitness": record.best_fitness,
            "generations": record.generations,
            "ended": record.ended.tolist(),
            "at_budgets": record.at_budgets,
            "omega": record.omega,
            "curves": record.curves,
            "episodes": record.episodes,
            "sampled": record.sampled,
        }
        for record in result
    }


def assert_same(folder: Path, undisturbed: Path) -> None:
    """Two studies found the same, to the last bit, and left nothing half-done."""
    ours, theirs = numbers(folder), numbers(undisturbed)
    assert sorted(ours) == sorted(MODELS)
    np.testing.assert_equal(ours, theirs)
    assert {path.name for path in (folder / "records").iterdir()} == {
        path.name for path in records(undisturbed)
    }


def workers(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """The worker processes of a run."""
    result = []
    for child in psutil.Process(process.pid).children(recursive=True):
        try:
            if "spawn_main" in " ".join(child.cmdline()):
                result.append(child)
        except psutil.NoSuchProcess:
            continue
    return result


def wait_for(event: Callable[[], Any], subject: str, process: Any = None) -> Any:
    """Return an event's value once it is true; fail if it never is, or once a run has ended."""
    deadline = time.monotonic() + 120.0
    while not (observation := event()):
        assert time.monotonic() < deadline, f"never seen: {subject}"
        assert process is None or process.poll() is None, f"the run ended before {subject}"
        time.sleep(0.01)
    return observation


def assert_ended(processes: list[psutil.Process]) -> None:
    """All of these end, or are gone."""

    def gone() -> bool:
        return not any(p.is_running() and p.status() != psutil.STATUS_ZOMBIE for p in processes)

    wait_for(gone, "the end of all workers")
