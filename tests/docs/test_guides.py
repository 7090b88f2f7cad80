"""The guides are followed literally, and the pages that list things list what there is."""

from __future__ import annotations

import ast
import dataclasses
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

from pages import DOCS, blocks
from programs import main, parsed, words_of
from tegotae.cli.asking import Question, options_by_subject
from tegotae.cli.commands import COMMANDS
from tegotae.cli.program import Command

SOURCE = DOCS.parent / "src"


def steps(page: Path) -> list[tuple[str, str]]:
    """Language and text of a page's blocks that a reader follows, in their order."""
    found = [
        (start, language, text.replace("\\\n", ""))
        for language in ("console", "python")
        for start, text in blocks(page, language)
    ]
    return [(language, text) for _, language, text in sorted(found)]


def follow(page: Path, leave_out: str = "#") -> None:
    """Type what the page says, in the folder that one is in, but for lines that begin so."""
    namespace: dict = {}
    for language, text in steps(page):
        if language == "python":
            named = re.match(r"# (\w+\.py)\n", text)
            if named:  # a file that the reader is to write
                Path(named.group(1)).write_text(text, encoding="utf-8")
            exec(text, namespace)
            continue
        for line in text.splitlines():
            if line.startswith(leave_out):
                continue
            assert line.startswith("tegotae "), line
            assert main(shlex.split(line)[1:]) == 0, line


def test_the_guide_on_recordings_does_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # The file that the guide takes for the reader's own.
    time_s = np.arange(5000) / 500.0
    rows = np.stack([310.0 + 30.0 * np.sin(9.0 * time_s), 2.0 + np.cos(9.0 * time_s)], axis=-1)
    np.savetxt("robot.csv", rows, delimiter=",", header="com z,motor", comments="")
    follow(DOCS / "guides" / "your-recordings.md")
    said = capsys.readouterr().out
    assert "limit cycle\n1.14 m/J, settled after 10.3 s\nthere was no disturbance" in said
    assert {"walk.png", "walk.frames.csv", "walk.hops.csv"} <= {p.name for p in Path().iterdir()}


def test_the_page_on_hardware_drives_its_leg(tmp_path, monkeypatch, capsys, clock):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    follow(DOCS / "deploy" / "live.md", leave_out="python studies")
    said = capsys.readouterr().out
    assert "('spring_force',) ('force',) 1" in said
    assert "8000 steps" in said
    assert "hop rate" in said


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_guide_on_policies_does_what_it_says(tmp_path, monkeypatch, capsys):
    for package in ("gymnasium", "stable_baselines3", "onnx", "onnxruntime"):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "my_policy", raising=False)
    follow(DOCS / "guides" / "your-policy.md")
    monkeypatch.delitem(sys.modules, "my_policy", raising=False)
    assert re.search(r"0\.\d\d m/J, \d\d% of what is possible", capsys.readouterr().out)
    drawn = {path.name for path in Path().glob("*.png")}
    assert drawn == {"surface.png", "portrait.png", "agent.png", "network.png"}


@pytest.fixture(scope="module")
def reference():
    """The command-line reference, as it is written when the pages are built."""
    sys.path.insert(0, str(DOCS))
    try:
        from command_reference import command_reference
    finally:
        sys.path.remove(str(DOCS))
    return command_reference()


def options(name: str) -> list[str]:
    """The options of a command, told from its class; a group has none of its own."""
    entry = COMMANDS[name]
    if not isinstance(entry, Command):
        return []
    kind = entry.load()
    if isinstance(kind, Question):
        known = (name for own in options_by_subject(kind).values() for name in own)
        return [name.replace("_", "-") for name in known]
    fields = dataclasses.fields(kind)
    return [field.name.replace("_", "-") for field in fields]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_and_option_is_in_the_reference(reference, name):
    (own,) = re.findall(rf"^## `tegotae {name}`\n(.*?)(?=^## |\Z)", reference, re.M | re.S)
    for option in options(name):
        assert f"`--{option}" in own or f"`{option.upper()}" in own or f"[{option.upper()}" in own
    assert main([name, "paper", "--no-such-option-at-all"]) == 2


def test_commands_below_commands_are_in_the_reference_too(reference):
    for name in ("figure surface", "gait map", "export c"):
        (own,) = re.findall(rf"^### `tegotae {name}`\n(.*?)(?=^##|\Z)", reference, re.M | re.S)
        assert "| `--" in own


def test_the_page_of_commands_has_a_place_for_the_reference():
    configuration = (DOCS / "conf.py").read_text(encoding="utf-8")
    (marker,) = re.findall(r'marker = "(.*)"', configuration)
    assert marker in (DOCS / "commands.md").read_text(encoding="utf-8")


def messages() -> list[str]:
    """The texts of the source, with … for what is put into them."""
    texts = []
    for path in SOURCE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                parts = (v.value if isinstance(v, ast.Constant) else "…" for v in node.values)
                texts.append("".join(map(str, parts)))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value)
    return texts


def troubles() -> list[str]:
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    return re.findall(r"^\| `([^`]+)` \|", page, re.M)


def test_the_messages_that_are_explained_are_those_of_the_source():
    there = "\n".join(messages())
    assert len(troubles()) > 20
    for trouble in troubles():
        # In pieces: what stands between them may be put together of several.
        for piece in (piece.strip() for piece in trouble.split("…")):
            assert piece in there, f"{trouble!r}: nothing says {piece!r}"


def test_the_commands_of_the_gallery_are_understood():
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    commands = re.findall(r"\| `((?:tegotae|python -m) .*?)` \|$", page, re.M)
    assert len(commands) > 10
    for command in commands:
        words = words_of(command)
        assert words
        parsed(words)


def test_readers_of_every_kind_are_shown_where_to_begin():
    for page in (DOCS / "index.md", DOCS.parent / "README.md"):
        text = page.read_text(encoding="utf-8").lower()
        for reader in ("researcher", "student", "roboticist", "engineer"):
            assert reader in text, f"{page.name} says nothing to a {reader}"
