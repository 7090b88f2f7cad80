"""Contract of a metric, and a catalogue of metrics: the package's own and users'.

A hopper's are in `tegotae.measures.hopping.metrics`, those of several legs in
`tegotae.measures.gaits.metrics`, and a robot's in `tegotae.measures.robots`.
"""

from __future__ import annotations

import inspect
import pkgutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Self, SupportsIndex

from tegotae._support.errors import TegotaeError, unknown
from tegotae.measures.statistics import UNBOUNDED, Range

TABLE, FIGURE, REPORT = "table", "figure", "report"
PLACES = (TABLE, FIGURE, REPORT)
"""Outputs that can show a metric: tables on the screen, the study's figures, the report's page."""


@dataclass(frozen=True, kw_only=True)
class Metric:
    """Description common to all metrics. The subclass decides what `compute` takes.

    Args:
        name: by which it is asked for, and its column in tables; with its unit, such as "t0_s".
        label: a short name for a person, such as "T0".
        about: its meaning in one line.
        more_is_better: whether more of it is better; None if neither is.
        unit: empty for a pure number.
        range: least and largest possible value; intervals do not reach beyond.
        math: the label in figures, where $...$ is mathematics; the plain label by default.
        shown: where it is shown unasked, of `PLACES`. Exported tables and documents hold all.
    """

    name: str
    label: str
    about: str
    more_is_better: bool | None
    unit: str = ""
    range: Range = UNBOUNDED
    math: str = ""
    shown: tuple[str, ...] = PLACES

    CATALOGUE: ClassVar[Catalogue]
    """Catalogue of the metrics of the same bodies."""

    @property
    def sources(self) -> tuple[str, ...]:
        """Names of metrics that it follows from."""
        return ()

    @classmethod
    def described(cls, **fields: Any) -> Callable[[Callable[..., Any]], Self]:
        """Return a decorator that makes a metric of a function.

        The function's name is the metric's, and the first line of its docstring the meaning.

        Args:
            fields: all other fields, or another name.

        Example:
            >>> from tegotae.measures.hopping import GaitMetric
            >>> @GaitMetric.described(label="first apex", unit="m", more_is_better=None)
            ... def first_apex_m(episode):
            ...     '''height of the first apex'''
            ...     return episode.hops.height_m[0]
            >>> first_apex_m.about
            'height of the first apex'
        """

        def wrap(compute: Callable[..., Any]) -> Self:
            text = (inspect.getdoc(compute) or "").partition("\n")[0]
            entries = {"name": compute.__name__, "about": text, "compute": compute}
            return cls(**{**entries, **fields})

        return wrap

    @property
    def heading(self) -> str:
        """The label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[object, ...]:
        """Pickle it by its place, as functions are; its own function may be a lambda."""
        for module, loaded in list(sys.modules.items()):
            for name, value in list(getattr(loaded, "__dict__", {}).items()):
                if value is self:
                    return pkgutil.resolve_name, (f"{module}:{name}",)
        return super().__reduce_ex__(protocol)


ALL = "all"
"""Name that stands for every metric of a catalogue."""


class Catalogue:
    """Metrics of one kind of body: the package's own, and those that a user registered.

    Args:
        kind: what they are metrics of, for errors, such as "hopping".
        reserved: names of further columns, which no metric may take.

    Example:
        >>> from tegotae.measures.hopping import HOPPING
        >>> HOPPING.find("t0_s").unit
        's'
        >>> [metric.label for metric in HOPPING.metrics("figure")][:3]
        ['CoT⁻¹', 'of optimum', 'T0']
    """

    def __init__(self, kind: str, *reserved: str) -> None:
        self.kind = kind
        self.built_in: tuple[Metric, ...] = ()
        """The package's own metrics, in the order of a table's columns."""
        self._registered: dict[str, Metric] = {}
        self._reserved = (ALL, *reserved)

    @property
    def registered(self) -> tuple[Metric, ...]:
        """The user's metrics."""
        return tuple(self._registered.values())

    def metrics(self, place: str | None = None) -> tuple[Metric, ...]:
        """Return all metrics, the package's own first.

        Args:
            place: one of `PLACES`, for the metrics that are shown there alone.
        """
        available = (*self.built_in, *self.registered)
        return tuple(metric for metric in available if place is None or place in metric.shown)

    def names(self, place: str | None = None) -> tuple[str, ...]:
        """Return the names of the same.

        Args:
            place: one of `PLACES`.
        """
        return tuple(metric.name for metric in self.metrics(place))

    def find(self, name: str) -> Metric:
        """Return the metric of a name.

        Raises:
            TegotaeError: if there is none, with the nearest names.
        """
        for metric in self.metrics():
            if metric.name == name:
                return metric
        raise unknown(f"metric of {self.kind}", name, self.names())

    def select(self, requested: Iterable[str | Metric] | None = None) -> tuple[Metric, ...]:
        """Return the requested metrics in the order of all; every one by default.

        Args:
            requested: names, or metrics that are registered.

        Raises:
            TegotaeError: for one that is not there.
        """
        names: set[str] = set()
        for item in (ALL,) if requested is None else requested:
            if item == ALL:
                return self.metrics()
            metric = self.find(item if isinstance(item, str) else item.name)
            if isinstance(item, Metric) and item != metric:
                raise TegotaeError(f"{item.name} is not registered; tegotae.register it first")
            names.add(metric.name)
        return tuple(metric for metric in self.metrics() if metric.name in names)

    def range_of(self, name: str) -> Range:
        """Return the least and largest possible value of a metric; of an unknown one, any."""
        ranges = {metric.name: metric.range for metric in self.metrics()}
        return ranges.get(name, UNBOUNDED)

    def add(self, metric: Metric) -> bool:
        """Add a user's metric, or a new version of it; return False if it is there already.

        Args:
            metric: the metric (`tegotae.register`).

        Raises:
            TegotaeError: for a name of the package, or of a metric in another file, or one that
                follows from unknown metrics.
        """
        if metric.name in {*self._reserved, *(own.name for own in self.built_in)}:
            raise TegotaeError(f"the name {metric.name!r} is taken by the package; choose another")
        previous = self._registered.get(metric.name)
        if previous is not None and _origin(previous) != _origin(metric):
            raise TegotaeError(
                f"there are two metrics named {metric.name!r}, of {_origin(previous)} and "
                f"{_origin(metric)}; rename one"
            )
        for name in metric.sources:
            self.find(name)
        if previous is metric:
            return False
        self._registered[metric.name] = metric
        return True

    def forget(self, name: str) -> None:
        """Remove a user's metric; one that is not registered is no error."""
        self._registered.pop(name, None)


def _origin(metric: Metric) -> str:
    """Return the module and the name of a metric's function."""
    function = getattr(metric, "compute", None)
    return f"{getattr(function, '__module__', '?')}.{getattr(function, '__qualname__', '?')}"
