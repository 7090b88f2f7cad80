"""A command is in every list of the pages; the test names the lists that lack one."""

from __future__ import annotations

import inspect
import re

import pytest

import tegotae as tg
from pages import DOCS
from tegotae.api.controller import LoadedController
from tegotae.cli.commands import COMMANDS
from tegotae.cli.program import Command

_FOR_THE_SHELL = ("completion", "conditions", "doctor", "metrics")
"""Commands that are no functions of the public package."""
_FAMILIES = {"plot": tg.plot, "gaits": tg.gaits, "robots": tg.robots}
_PAGES = {path: path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md")}


def commands() -> dict[str, Command]:
    """Every command by its words."""
    found: dict[str, Command] = {}
    for name, entry in COMMANDS.items():
        if isinstance(entry, Command):
            found[name] = entry
        else:
            found |= {f"{name} {word}": command for word, command in entry.commands.items()}
    return found


@pytest.mark.parametrize(("name", "command"), commands().items())
def test_a_command_is_a_public_function_on_a_page(name, command):
    function = command.load()
    homes = [LoadedController] if "." in function.__qualname__ else [tg, *_FAMILIES.values()]
    is_public = any(getattr(home, function.__name__, None) is function for home in homes)
    assert is_public or name in _FOR_THE_SHELL, "name it in __init__.pyi, or __all__ of its family"
    pattern = re.compile(rf"tegotae {name}\b")
    assert any(pattern.search(page) for page in _PAGES.values()), "no page of docs/ shows it"
    if name.startswith(("figure ", "gait ")):
        assert pattern.search(_PAGES[DOCS / "gallery.md"]), "docs/gallery.md has no row for it"


@pytest.mark.parametrize("family", _FAMILIES)
def test_the_page_of_names_lists_the_functions_of_a_family(family):
    row = re.search(rf"^\| .py:mod.`{family} .*: (.*) \|$", _PAGES[DOCS / "api/names.md"], re.M)
    assert row is not None
    home = _FAMILIES[family]
    functions = [name for name in home.__all__ if inspect.isfunction(getattr(home, name))]
    assert sorted(row[1].split(", ")) == functions
