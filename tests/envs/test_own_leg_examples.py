"""Examples on a leg of one's own run, draw their picture, and their check holds."""

from __future__ import annotations

import runpy
import sys

import matplotlib
import pytest

from places import ROOT


@pytest.mark.parametrize(("name", "needs"), [("mujoco_leg", "mujoco"), ("sb3", "torch")])
def test_an_example_runs_draws_and_checks_itself(name, needs, tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    pytest.importorskip(needs)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [f"{name}.py"])
    with matplotlib.rc_context({"savefig.dpi": 100}):
        runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    assert (tmp_path / f"{name}.png").stat().st_size > 5000
