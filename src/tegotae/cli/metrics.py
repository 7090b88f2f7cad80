"""Metrics on the command line: by name, or a user's own as module:object."""

from __future__ import annotations

from collections.abc import Sequence

from tegotae.cli.objects import load_object
from tegotae.metrics.metric import Metric
from tegotae.metrics.registry import chosen, register


def named(given: Sequence[str]) -> tuple[Metric, ...] | None:
    """The metrics that were named; None if none was, which stands for all.

    A user's own, given as module:object, is registered. The module is imported from the current
    folder too.

    Raises:
        TegotaeError: for a name or a module that is not there, or an object that is no metric.
    """
    if not given:
        return None
    return chosen([register(load_object(name)).name if ":" in name else name for name in given])
