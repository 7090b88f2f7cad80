"""The rooms stand on each other as the page on architecture says."""

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import tegotae
from places import ROOT

PACKAGE = ROOT / "src" / "tegotae"
ROOMS = (
    "_support",
    "parts",
    "simulation",
    "measures",
    "systems",
    "envs",
    "training",
    "analysis",
    "figures",
    "api",
    "cli",
)
"""Rooms, from the lowest to the highest."""


def module_name(file: Path) -> str:
    return ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(
        ".__init__"
    )


FILES = {module_name(file): file for file in PACKAGE.rglob("*.py")}


def imports(node: ast.AST, *, when_called: bool) -> Iterator[str]:
    """Modules of the package that code imports: when it is loaded, or when it is called, too.

    What only type checkers read is no import.
    """
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and getattr(child.test, "id", "") == "TYPE_CHECKING":
            continue
        if isinstance(child, ast.FunctionDef | ast.Lambda) and not when_called:
            continue
        if isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names if alias.name in FILES)
        if isinstance(child, ast.ImportFrom) and (child.module or "").split(".")[0] == "tegotae":
            for alias in child.names:
                within = f"{child.module}.{alias.name}"
                yield within if within in FILES else str(child.module)
        yield from imports(child, when_called=when_called)


def arrows(*, when_called: bool) -> dict[str, set[str]]:
    """Return the imports of every file."""
    return {
        name: set(imports(ast.parse(file.read_text(encoding="utf-8")), when_called=when_called))
        for name, file in FILES.items()
    }


def room(module: str) -> str | None:
    """The room that a module is in; None for those of the package itself."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in ROOMS else None


def test_every_folder_of_the_package_is_a_room():
    within = {file.relative_to(PACKAGE).parts for file in FILES.values()}
    assert {parts[0] for parts in within if len(parts) > 1} == set(ROOMS)


def test_no_room_imports_from_one_above_it():
    up = [
        f"{file} imports {imported}"
        for file, imports in arrows(when_called=True).items()
        for imported in imports
        if (mine := room(file))
        and (level := room(imported))
        and ROOMS.index(level) > ROOMS.index(mine)
    ]
    assert up == []


def test_no_files_import_each_other_in_a_circle():
    try:
        TopologicalSorter(arrows(when_called=False)).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(error.args[1]))


def test_the_page_on_architecture_has_every_room_in_this_order():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert tuple(re.findall(r"^\| `(\w+)/` \|", page, re.MULTILINE)) == ROOMS


def test_the_files_that_the_page_on_architecture_names_are_there():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rooms = "|".join(ROOMS)
    paths = re.findall(rf"`((?:{rooms})/[\w/]*(?:\.py)?)`", page)
    assert len(paths) > len(ROOMS)
    assert [name for name in paths if not (PACKAGE / name).exists()] == []


def test_the_page_on_architecture_names_every_shape():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.split("## Shapes\n")[1].split("\n## ")[0]
    tree = ast.parse((PACKAGE / "parts" / "_shapes.py").read_text(encoding="utf-8"))
    stored = (n for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    shapes = {node.id for node in stored if not node.id.startswith("_")}
    assert shapes <= set(re.findall(r"`(\w+)`", section))


def test_the_page_of_names_has_what_the_package_names():
    page = (ROOT / "docs" / "api" / "names.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"`(\w+) <tegotae", page)) == sorted(tegotae.__all__)


def test_the_compiler_below_the_package_imports_nothing_of_it():
    files = (ROOT / "src" / "lanewise").glob("*.py")
    assert [file.name for file in files if "tegotae" in file.read_text(encoding="utf-8")] == []


def test_the_package_imports_nothing_of_the_one_above_it():
    imports_it = re.compile(r"^\s*(?:import|from) tegotae_robots", re.MULTILINE)
    asks = [name for name, x in FILES.items() if imports_it.search(x.read_text("utf-8"))]
    assert asks == []
