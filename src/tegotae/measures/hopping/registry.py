"""The metrics there are: those of the package, and those that a user registers.

What is in `tegotae.measures.hopping.catalogue`, or registered, is evaluated, compared,
exported, drawn and reported.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.part_code import code_of_file
from tegotae.measures.hopping.metric import (
    HOP_CHANNELS,
    REGIME,
    Conditions,
    DerivedMetric,
    GaitMetric,
    Metric,
)
from tegotae.measures.hopping.statistics import UNBOUNDED, Range

ALL = "all"
"""Stands for every metric there is."""

_registered: dict[str, Metric] = {}
_codes: dict[str, str | None] = {}
"""The code of each as it was when it was registered, by name."""


def built_in() -> tuple[Metric, ...]:
    """The package's own metrics, in the order of a table's columns."""
    from tegotae.measures.hopping.catalogue import METRICS  # which stands on this room

    return METRICS


@cache
def built_in_gait() -> tuple[GaitMetric, ...]:
    """Those of a gait's recording. They are compiled together."""
    return tuple(metric for metric in built_in() if isinstance(metric, GaitMetric))


def channels_of(selected: Iterable[Metric]) -> tuple[str, ...]:
    """The channels of a recording that some metrics are computed from."""
    further = (channel for m in selected if isinstance(m, GaitMetric) for channel in m.channels)
    return tuple(dict.fromkeys((*HOP_CHANNELS, *further)))


def metrics(place: str | None = None) -> tuple[Metric, ...]:
    """All metrics, the package's own first; only those shown at a place, if one is named.

    Example:
        >>> [metric.label for metric in metrics("figure")][:3]
        ['CoT⁻¹', 'of optimum', 'T0']
    """
    available = (*built_in(), *_registered.values())
    return tuple(metric for metric in available if place is None or place in metric.shown)


def metric_names(place: str | None = None) -> tuple[str, ...]:
    """The names of the same."""
    return tuple(metric.name for metric in metrics(place))


def measured_own() -> tuple[Metric, ...]:
    """A user's metrics that are measured in an episode, and do not follow from others alone."""
    return tuple(metric for metric in _registered.values() if not isinstance(metric, DerivedMetric))


def metric_code_noted(metric: Metric) -> str | None:
    """The hash of the file that computes a user's metric, as that was registered, if it has one."""
    return _codes.get(metric.name)


def register_metric(metric: Metric) -> Metric:
    """Make a user's metric known, so that it is evaluated and shown like the package's own.

    Registered again, as when its file is run anew, it takes the place of the one before.

    Args:
        metric: a `GaitMetric`, `ClampedMetric` or `DerivedMetric`;
        `tegotae.measures.hopping.check.check_metric`
            tries it thoroughly.

    Returns:
        The metric.

    Raises:
        TegotaeError: for anything else, a name that the package has, or that a metric of another
            file has, or one derived from metrics that are not there.
    """
    if not isinstance(metric, Metric):
        raise TegotaeError(
            f"{metric!r} is no metric; make a GaitMetric, ClampedMetric or DerivedMetric of "
            "tegotae.measures.hopping"
        )
    if metric.name in {builtin.name for builtin in built_in()} | {REGIME, ALL}:
        raise TegotaeError(f"the name {metric.name!r} is taken by the package; choose another")
    previous = _registered.get(metric.name)
    if previous is not None and _origin(previous) != _origin(metric):
        raise TegotaeError(
            f"there are two metrics named {metric.name!r}, of {_origin(previous)} and "
            f"{_origin(metric)}; rename one"
        )
    for name in metric.of if isinstance(metric, DerivedMetric) else ():
        if name != REGIME:
            find_metric(name)
    if previous is not metric:
        _registered[metric.name], _codes[metric.name] = metric, _code(metric)
    return metric


def forget(name: str) -> None:
    """Take a user's metric out again; one that is not registered is no error."""
    _registered.pop(name, None)


def find_metric(name: str) -> Metric:
    """The metric of a name.

    Raises:
        TegotaeError: if there is none, with those that are spelt alike.

    Example:
        >>> find_metric("t0_s").unit
        's'
    """
    for metric in metrics():
        if metric.name == name:
            return metric
    raise unknown("metric", name, metric_names())


def select_metrics(requested: Iterable[str | Metric] | None = None) -> tuple[Metric, ...]:
    """The metrics that are asked for, in the order of all; every one by default.

    Args:
        requested: names, or metrics that are registered.

    Raises:
        TegotaeError: for one that is not there.
    """
    names: set[str] = set()
    for item in (ALL,) if requested is None else requested:
        if item == ALL:
            return metrics()
        metric = find_metric(item if isinstance(item, str) else item.name)
        if isinstance(item, Metric) and item != metric:
            raise TegotaeError(f"{item.name} is not registered; tegotae.register it first")
        names.add(metric.name)
    return tuple(metric for metric in metrics() if metric.name in names)


def with_needed(requested: Iterable[Metric]) -> tuple[Metric, ...]:
    """The same with the metrics that they are derived from, those first."""
    needed: dict[str, Metric] = {}
    for metric in requested:
        sources = metric.of if isinstance(metric, DerivedMetric) else ()
        for source in with_needed(find_metric(name) for name in sources if name != REGIME):
            needed.setdefault(source.name, source)
        needed.setdefault(metric.name, metric)
    return tuple(needed.values())


def derived(values: Mapping[str, np.ndarray], conditions: Conditions) -> dict[str, np.ndarray]:
    """Metrics of some episodes that are not among their values but follow from them.

    Args:
        values: of metrics, by name, arrays of one shape: a value an episode, not means of several.
        conditions: under which they were measured.

    Example:
        >>> from tegotae import Hopper
        >>> gait = {"cot_inverse": 0.6, "hop_rate": 4.0, "limit_cycle_period": 1}
        >>> gait = {name: np.array([value]) for name, value in gait.items()}
        >>> found = derived(gait, Conditions(Hopper()))
        >>> sorted(found), f"{found['optimum_share'][0]:.2f}"
        (['optimum_share'], '0.50')
    """
    results = dict(values)
    for metric in with_needed(m for m in metrics() if isinstance(m, DerivedMetric)):
        if not isinstance(metric, DerivedMetric) or metric.name in results:
            continue
        if results.keys() >= {*metric.of}:
            results[metric.name] = metric.values(results, conditions)
    return {name: results[name] for name in results if name not in values}


def range_of(name: str) -> Range:
    """Least and largest possible value of a metric; of one that is not registered here, any."""
    return next((metric.range for metric in metrics() if metric.name == name), UNBOUNDED)


def _code(metric: Metric) -> str | None:
    module = getattr(getattr(metric, "compute", None), "__module__", None) or ""
    file = getattr(sys.modules.get(module), "__file__", None)
    return code_of_file(Path(file), module) if file and Path(file).is_file() else None


def _origin(metric: Metric) -> str:
    """Return the module in which a metric's function was written."""
    function = getattr(metric, "compute", None)
    return f"{getattr(function, '__module__', '?')}.{getattr(function, '__qualname__', '?')}"
