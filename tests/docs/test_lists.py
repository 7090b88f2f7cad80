"""A public function is a command, and in every list of the pages; the test names what lacks it."""

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import tegotae as tg
import tegotae.api
import tegotae_robots.api
from pages import DOCS
from tegotae.api.controller import LoadedController
from tegotae.api.parameters import check_types
from tegotae.api.results import Table
from tegotae.cli.commands import COMMANDS
from tegotae.cli.program import Command

_FOR_THE_SHELL = ("doctor", "list_conditions", "list_metrics")
"""Functions that are commands alone."""
_FAMILIES = {"plot": tg.plot, "gaits": tg.gaits, "robots": tg.robots}
_PAGES = {path: path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md")}


def words_by_function() -> dict[Any, str]:
    """Return the words of every command by its function."""
    words: dict[Any, str] = {}
    for name, entry in COMMANDS.items():
        if isinstance(entry, Command):
            words[entry.load()] = name
        else:
            words |= {command.load(): f"{name} {x}" for x, command in entry.commands.items()}
    return words


_WORDS = words_by_function()


def functions() -> Iterator[Callable[..., Any]]:
    """Yield the functions of the rooms `api` that check their options, as those of a command do."""
    owners: list[Any] = [LoadedController]
    for package in (tegotae.api, tegotae_robots.api):
        names = (x.name for x in pkgutil.iter_modules(package.__path__, f"{package.__name__}."))
        owners += map(importlib.import_module, names)
    for owner in owners:
        module = getattr(owner, "__module__", owner.__name__)
        for value in vars(owner).values():
            if not inspect.isfunction(value) or value.__module__ != module:
                continue
            is_public = not value.__name__.startswith("_") and not hasattr(value, "registry")
            if is_public and hasattr(value, "__wrapped__"):
                yield value


def lists_without(function: Callable[..., Any]) -> list[str]:
    """Return what is missing for a function: the file, and what to write there."""
    name, words, lists = function.__name__, _WORDS.get(function), []
    if words is None:
        lists.append("cli/commands.toml: a table with two examples")
    homes = (tg, LoadedController, *_FAMILIES.values())
    if name not in _FOR_THE_SHELL and all(getattr(x, name, None) is not function for x in homes):
        lists.append("__init__.pyi, or __all__ of its family: the name")
    pattern = re.compile(rf"tegotae {words or name}\b")
    if not any(pattern.search(page) for page in _PAGES.values()):
        lists.append("docs/: a page that shows the command")
    is_drawn = function.__module__ in ("tegotae.api.plot", "tegotae.api.gaits")
    if is_drawn and not pattern.search(_PAGES[DOCS / "gallery.md"]):
        lists.append("docs/gallery.md: a row")
    return lists


@pytest.mark.parametrize("function", [*functions()], ids=lambda x: x.__qualname__)
def test_a_public_function_is_a_command_in_every_list(function):
    assert lists_without(function) == []


def test_of_a_new_function_every_list_is_named():
    @check_types
    def jump() -> Table:
        return Table()

    jump.__module__ = "tegotae.api.plot"
    assert lists_without(jump) == [
        "cli/commands.toml: a table with two examples",
        "__init__.pyi, or __all__ of its family: the name",
        "docs/: a page that shows the command",
        "docs/gallery.md: a row",
    ]


@pytest.mark.parametrize("family", _FAMILIES)
def test_the_page_of_names_lists_the_functions_of_a_family(family):
    row = re.search(rf"^\| .py:mod.`{family} .*: (.*) \|$", _PAGES[DOCS / "api/names.md"], re.M)
    assert row is not None
    home = _FAMILIES[family]
    functions = [name for name in home.__all__ if inspect.isfunction(getattr(home, name))]
    assert sorted(row[1].split(", ")) == functions
