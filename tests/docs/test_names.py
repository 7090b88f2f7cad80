"""Names are the field's terms, and each stands for one thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from places import ROOT
from vocabulary import NAMES

PACKAGE = ROOT / "src" / "tegotae"
FILES = sorted(PACKAGE.rglob("*.py"))


def definitions(file: Path) -> Iterator[tuple[str, int]]:
    """Names of classes, functions, arguments and variables that a file defines, with their line."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            yield node.name, node.lineno
        elif isinstance(node, ast.arg):
            yield node.arg, node.lineno
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, node.lineno


def test_no_two_classes_have_one_name():
    places = defaultdict(list)
    for file in FILES:
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                places[node.name].append(str(file.relative_to(PACKAGE)))
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


@pytest.mark.parametrize("word", NAMES)
def test_a_name_is_the_fields_term(word):
    found = [
        f"{file.relative_to(PACKAGE)}:{line} {name}: {NAMES[word]}"
        for file in FILES
        for name, line in definitions(file)
        if word in re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower())
    ]
    assert found == []
