"""The examples in the docstrings do what they say, in every module that has some."""

import doctest
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from inspect import getdoc, isabstract, isclass, isfunction, isroutine, signature
from pathlib import Path

import pytest

import lanewise
import tegotae
import tegotae_robots
from api import public
from apps import playground
from research import reproduction
from tegotae.measures import gaits, hopping
from tegotae.measures.gaits.metrics import WALKING
from tegotae.measures.hopping import HOPPING
from tegotae.parts.couplings import Coupling
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.terms import Term
from tegotae.simulation.integrators import Integrator
from tegotae.training.algorithms import Algorithm


def _modules() -> Iterator[str]:
    """The modules of the package, of its compiler and robots, and of the programs beside it."""
    for package in (tegotae, tegotae_robots, lanewise, reproduction, playground):
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not info.name.endswith("__main__"):
                yield info.name


class _Finder(doctest.DocTestFinder):
    """Finder that takes a decorated function for one of the module that wrote it."""

    def _from_module(self, module, object):
        return super()._from_module(module, inspect.unwrap(object))


def examples() -> dict[str, list[doctest.DocTest]]:
    """The docstrings with examples of every module that can be imported here, by its name."""
    examples_by_module = {}
    for name in _modules():
        try:
            module = importlib.import_module(name)
        except (ImportError, tegotae.TegotaeError):  # an extra that is not installed
            continue
        tests = _Finder(exclude_empty=True).find(module)
        if tests := [test for test in tests if test.examples]:
            examples_by_module[name] = tests
    return examples_by_module


FOUND = examples()
SLOW = (
    "tegotae.analysis.",
    "tegotae.simulation.checks.",
    "tegotae.systems.recipe",
    "tegotae.systems.term_sets",
    "research.reproduction.",
)
"""Modules whose examples roll out and so compile much; other tests do the same."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough if name.startswith(SLOW) else ())
        for name in FOUND
    ],
)
def test_the_examples_of_a_module_do_what_they_say(name, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for test in FOUND[name]:
        output: list[str] = []
        doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS).run(
            test, out=output.append
        )
        assert not output, "".join(output)


def test_there_are_examples_in_most_packages():
    packages = {name.split(".")[1] for name in FOUND}
    assert {
        "parts",
        "simulation",
        "measures",
        "systems",
        "envs",
        "training",
        "analysis",
    } <= packages
    assert len(FOUND) > 40


PUBLIC = dict(public())
"""Every name of the API's pages."""
CODE = [name for name, value in PUBLIC.items() if isroutine(value) or isclass(value)]
SOURCED = (
    "tegotae.parts.couplings.",
    "tegotae.parts.oscillators.",
    "tegotae.parts.terms.",
    "tegotae.simulation.integrators.",
    "tegotae.training.algorithms.",
)
"""Rooms whose parts are somebody's: equations of the paper, a reference, or this library's own."""
SOURCE = re.compile(r"\bSource:|\bReferences?:|paper (?:equations?|[IV]+-[A-Z])")


_EXPLAINED = tuple(
    f"tegotae.{room}." for room in ("parts", "simulation", "measures", "systems", "training")
)
_CONTRACTS = (Algorithm, Coupling, Integrator, Oscillator, Term)


def is_part(value: object) -> bool:
    """Return whether it is a part that can be chosen, and no contract or tuple of numbers."""
    return isclass(value) and not isabstract(value) and issubclass(value, _CONTRACTS)


def test_every_public_class_and_function_has_a_docstring():
    assert [name for name in CODE if not (PUBLIC[name].__doc__ or "").strip()] == []


def test_every_public_method_has_a_docstring():
    missing = [
        f"{name}.{method}"
        for name in CODE
        if isclass(value := PUBLIC[name]) and value.__module__.startswith("tegotae.")
        for method, member in vars(value).items()
        if not method.startswith("_") and isfunction(member) and not getdoc(member)
    ]
    assert missing == []


def test_every_part_names_its_source():
    parts = [name for name in CODE if name.startswith(SOURCED) and is_part(PUBLIC[name])]
    assert len(parts) > 25
    assert [name for name in parts if not SOURCE.search(PUBLIC[name].__doc__)] == []


def test_every_metric_of_the_package_names_its_source():
    for module, catalogue in ((hopping.metrics, HOPPING), (gaits.metrics, WALKING)):
        count = Path(module.__file__).read_text().count("\n# Source: ")
        assert count == len(catalogue.built_in)


def test_every_public_function_of_several_arguments_explains_them():
    missing = [
        name
        for name in CODE
        if name.startswith(_EXPLAINED)
        and isfunction(value := PUBLIC[name])
        and len(signature(value).parameters) > 1
        and "Args:" not in value.__doc__
    ]
    assert missing == []
