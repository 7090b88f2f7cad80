"""CMA-ES with as many weights as the paper's controllers have."""

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.thorough
def test_it_ends_with_ninety_six_weights_and_several_seeds(tmp_path):
    # In a process of its own: what went wrong once is a wait for ever, of two devices for a pool.
    words = ("ART", "--algorithm", "cma-es", "--seeds", "4", "--population", "8")
    more = ("--generations", "3", "--duration", "3", "--settle", "1", "--out", str(tmp_path / "o"))
    ended = subprocess.run(
        [sys.executable, "-m", "tegotae", "train", *words, *more],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert ended.returncode == 0, ended.stderr
    assert len(list((tmp_path / "o").glob("*seed?.json"))) == 4
