"""The guides can be followed: their files, programs and commands, in their order and shortened."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from places import ROOT
from tegotae.cli import main

GUIDES = ROOT / "docs" / "guides"
SHORTER = {
    "--episodes 160 --seeds 3": "--episodes 4 --seeds 1",
    "--generations 40": "--generations 1",
    "--population 16": "--population 4",
}
SHORTER |= {"--duration 6": "--duration 0.5", "--seeds 3": "--seeds 2", "--starts 8": "--starts 2"}
SHORTER |= {"baseline my_leg.xml": "baseline my_leg.xml --frequencies 17.5"}
SHORTER |= {" --animate gait.gif": ""}
LONGEST = 40
"""Lines of code and commands of a walk."""


def steps(page: Path) -> list[tuple[str, str]]:
    """Language and text of a page's fenced blocks, in their order."""
    fence = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return fence.findall(page.read_text(encoding="utf-8"))


def test_the_guide_to_a_leg_of_ones_own(tmp_path, monkeypatch, capsys):
    pytest.importorskip("mujoco")
    pytest.importorskip("stable_baselines3")
    monkeypatch.chdir(tmp_path)
    namespace: dict = {"__name__": "guide"}
    shown = []
    for language, text in steps(GUIDES / "your-leg.md"):
        for long, short in SHORTER.items():
            text = text.replace(long, short)
        if language == "text":
            shown += [line.rstrip() for line in text.splitlines()]
        elif language == "python":
            exec(compile(text, "your-leg.md", "exec"), namespace)
        elif language == "console" and text.startswith("tegotae "):
            for line in text.splitlines():
                assert main(shlex.split(line)[1:]) == 0
    printed = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert [line for line in shown if line not in printed] == []
    assert all(map(Path.exists, map(Path, ("gait.png", "gait.csv", "curves.png", "runs.csv"))))


def test_the_walk_from_a_model_to_its_measures_is_short():
    blocks = [text for language, text in steps(GUIDES / "your-leg.md") if language != "text"]
    assert sum(len(text.splitlines()) for text in blocks) <= LONGEST
