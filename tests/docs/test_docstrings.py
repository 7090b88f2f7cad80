"""The examples in the docstrings do what they say, in every module that has some."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import tegotae

_OPTIONAL = {"tegotae.__main__", "tegotae.cli.optimum_table"}
"""Modules that are programs."""


def examples() -> dict[str, list[doctest.DocTest]]:
    """The docstrings with examples of every module that can be imported here, by its name."""
    found = {}
    for info in pkgutil.walk_packages(tegotae.__path__, "tegotae."):
        if info.name in _OPTIONAL:
            continue
        try:
            module = importlib.import_module(info.name)
        except (ImportError, tegotae.TegotaeError):  # an extra that is not installed
            continue
        tests = doctest.DocTestFinder(exclude_empty=True).find(module)
        if tests := [test for test in tests if test.examples]:
            found[info.name] = tests
    return found


FOUND = examples()
SLOW = (
    "tegotae.studies.analysis.",
    "tegotae.simulation.checks.",
    "tegotae.systems.designs.",
    "tegotae.studies.gaits.",
)
"""Where examples roll out and so compile much; other tests do the same."""


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
        said: list[str] = []
        doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS).run(
            test, out=said.append
        )
        assert not said, "".join(said)


def test_there_are_examples_in_most_packages():
    packages = {name.split(".")[1] for name in FOUND}
    assert {"parts", "simulation", "measures", "systems", "envs", "training", "studies"} <= packages
    assert len(FOUND) > 40
