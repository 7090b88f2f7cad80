"""Metrics on the command line: by name, or a user's own as FILE.py:OBJECT."""

from __future__ import annotations

from collections.abc import Sequence

from tegotae.measures.hopping.metric import Metric
from tegotae.measures.hopping.registry import chosen, register
from tegotae.systems import user_objects as references


def named(given: Sequence[str]) -> tuple[Metric, ...] | None:
    """The metrics that were named; None if none was, which stands for all.

    A user's own, given as FILE.py:OBJECT or MODULE:OBJECT, is registered.

    Raises:
        TegotaeError: for a name or a file that is not there, or an object that is no metric.
    """
    if not given:
        return None
    return chosen([_name(each) for each in given])


def _name(given: str) -> str:
    if not references.is_reference(given):
        return given
    return register(references.named(given, Metric, "metric")).name
