"""The guides can be followed: their files, programs and commands, in their order and shortened."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from places import ROOT
from tegotae.cli import main

GUIDES = ROOT / "docs" / "guides"
SHORTER = {"--generations 40": "--generations 1", "--population 16": "--population 4"}
SHORTER |= {"--duration 6": "--duration 1", "range(1200)": "range(450)"}


def steps(page: Path) -> list[tuple[str, str]]:
    """Language and text of a page's fenced blocks, in their order."""
    fence = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return fence.findall(page.read_text(encoding="utf-8"))


def test_the_guide_to_a_leg_of_ones_own(tmp_path, monkeypatch, capsys):
    pytest.importorskip("mujoco")
    pytest.importorskip("gymnasium")
    monkeypatch.chdir(tmp_path)
    namespace: dict = {"__name__": "guide"}
    shown = []
    for language, text in steps(GUIDES / "your-leg.md"):
        for long, short in SHORTER.items():
            text = text.replace(long, short)
        if language == "toml":
            Path("my_leg.toml").write_text(text)
        elif language == "text":
            shown += text.splitlines()
        elif language == "python":
            exec(compile(text, "your-leg.md", "exec"), namespace)
        elif language == "console" and text.startswith("tegotae "):
            assert main(shlex.split(text)[1:]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [line for line in shown if line not in printed] == []
    assert Path("my_leg.png").exists()
    assert Path("my_curves.png").exists()
