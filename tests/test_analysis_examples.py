"""The examples in the docstrings of the analysis do what they say."""

import doctest
import importlib

import pytest

MODULES = ("basin", "gain_sweep", "orbit", "outcome", "poincare", "ridge", "surface")


@pytest.mark.parametrize("name", MODULES)
def test_docstring_examples(name):
    tried = doctest.testmod(importlib.import_module(f"tegotae.analysis.{name}"))
    assert tried.attempted
    assert not tried.failed
