"""Names are the field's terms, and each stands for one thing."""

import ast
import re
from collections import defaultdict

import pytest

from places import ROOT
from tegotae.parts.oscillators import PLANAR
from vocabulary import NAMES

PROGRAMS = (
    "src",
    "research/reproduction",
    "research/benchmarks",
    "apps",
)
FILES = sorted(file for folder in PROGRAMS for file in (ROOT / folder).rglob("*.py"))

VERBS = {
    "basin", "fit_template", "front", "identify", "load", "measure", "stability",
    "suggest_wiring", "sweep", "train",
}  # fmt: skip
"""Questions of the public interface, each over the function of this name that answers it."""
SHARED = {"changed", "kind_of", "kinds"}
"""Other names of several functions. A change may shorten the two lists and never lengthen one."""


def is_metric(node: ast.FunctionDef) -> bool:
    """Return whether a function is made a metric, which has the name of its column."""
    return any(".described(" in ast.unparse(decorator) for decorator in node.decorator_list)


@pytest.fixture(scope="module")
def parsed():
    """The files of the package and of the programs beside it, by their paths."""
    return {
        str(file.relative_to(ROOT)): ast.parse(file.read_text(encoding="utf-8")) for file in FILES
    }


@pytest.fixture(scope="module")
def definitions(parsed):
    """Names of classes, functions, arguments and variables, by their words, with their places."""
    places = defaultdict(list)
    for file, tree in parsed.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                name = node.name
            elif isinstance(node, ast.arg):
                name = node.arg
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                name = node.id
            else:
                continue
            words = re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower())
            for word in words:
                places[word].append(f"{file}:{node.lineno} {name}")
    return places


def test_no_two_classes_have_one_name(parsed):
    places = defaultdict(list)
    for file, tree in parsed.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                places[node.name].append(file)
    assert {name: owners for name, owners in places.items() if len(owners) > 1} == {}


def test_no_two_public_functions_of_the_library_have_one_name(parsed):
    places = defaultdict(list)
    for file, tree in parsed.items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and node.name[0] != "_" and not is_metric(node):
                places[node.name].append(file)
    shared = {
        name: files
        for name, files in places.items()
        if len({file for file in files if file.startswith("src/")}) > 1
    }
    assert {name: shared[name] for name in shared.keys() - VERBS - SHARED} == {}


@pytest.mark.parametrize("word", NAMES)
def test_a_name_is_the_fields_term(word, definitions):
    assert definitions["term"]  # a word that the package has
    faults = [f"{place}: {NAMES[word]}" for place in definitions.get(word, [])]
    assert faults == []


@pytest.mark.parametrize(
    "file",
    [
        "src/tegotae/api/training.py",
        "research/reproduction/readings/named.py",
        "research/reproduction/commands/gain_map.py",
        "docs/oscillators.md",
    ],
)
def test_option_texts_and_their_page_name_every_oscillator(file):
    text = (ROOT / file).read_text(encoding="utf-8")
    assert [name for name in PLANAR if name not in text] == []
