"""What a metric is: its name and meaning, what it needs, and how it is computed."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn, SupportsIndex

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.episode import ClampedEpisodes, Episode
from tegotae.measures.hopping.statistics import UNBOUNDED, Range
from tegotae.parts.bodies import Body

TABLE, FIGURE, REPORT = "table", "figure", "report"
PLACES = (TABLE, FIGURE, REPORT)
"""Where a metric can be shown: tables on the screen, the study's figures, the report's page."""

REGIME = "regime"
"""A label of every episode beside its metrics: an index into `REGIMES`."""


class UnknownBodyError(TegotaeError):
    """A parameter of a body is needed, and the body is unknown."""


class UnknownBody:
    """Stands for the unknown body of a recording.

    Raises:
        UnknownBodyError: for whatever is asked of it.
    """

    def __getattr__(self, name: str) -> NoReturn:
        raise UnknownBodyError(f"{name} was asked of a body that is not given")


@dataclass(frozen=True)
class Conditions:
    """Under what some episodes were measured.

    Args:
        body: the body; one that is not given is an `UnknownBody`.
        work: definition of work, one of "absolute", "positive", "net".
        drop_m: how far the ground dropped [m]; 0 if it did not.
    """

    body: Body | UnknownBody
    work: str = "absolute"
    drop_m: float = 0.0


@dataclass(frozen=True)
class Derivation:
    """How a metric follows from others of the same episode.

    Args:
        of: names of these, or `REGIME`.
        compute: function of their values, NumPy arrays of one shape by name, NaN where undefined,
            and of the `Conditions`; to an array of that shape.
    """

    of: tuple[str, ...]
    compute: Callable[[Mapping[str, np.ndarray], Conditions], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Metric:
    """What every metric says of itself. Of which kind it is says how it is computed.

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

    @property
    def heading(self) -> str:
        """The label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    @property
    def is_share(self) -> bool:
        """Whether it lies between none and all."""
        return self.range == (0.0, 1.0)

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[object, ...]:
        """Pickle it by its place, as functions are: its own function may be a lambda."""
        place = _place_of(self)
        return super().__reduce_ex__(protocol) if place is None else (_at, place)


def _place_of(metric: Metric) -> tuple[str, str] | None:
    """The module and the name in it that hold a metric; None if no module does."""
    for module, loaded in list(sys.modules.items()):
        for name, value in list(getattr(loaded, "__dict__", {}).items()):
            if value is metric:
                return module, name
    return None


def _at(module: str, name: str) -> Metric:
    return getattr(importlib.import_module(module), name)


@dataclass(frozen=True, kw_only=True)
class GaitMetric(Metric):
    """A metric of a rollout's recording.

    Args:
        compute: function of an `Episode` to an array [lanes], NaN where undefined; it is compiled,
            so jnp functions only.
        channels: what it reads of the recording beside `HOP_CHANNELS`, such
            as "impulse_ns".
        parameters: what it needs beside the recording, of "omega" and "max_force_n".
        disturbed: whether it is about what comes after the ground drops.
        otherwise: how it follows from others where it was not measured, such as in a record from
            before there was the metric.

    Example:
        >>> import jax.numpy as jnp
        >>> apex = GaitMetric(
        ...     name="mean_apex_m",
        ...     label="mean apex",
        ...     unit="m",
        ...     about="mean height of the apexes of the hops",
        ...     more_is_better=True,
        ...     compute=lambda episode: jnp.nanmean(episode.hops.height_m, axis=0),
        ... )
        >>> apex.heading
        'mean apex [m]'
    """

    compute: Callable[[Episode], jax.Array]
    channels: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    disturbed: bool = False
    otherwise: Derivation | None = None


@dataclass(frozen=True, kw_only=True)
class ClampedMetric(Metric):
    """A metric of rollouts in which the oscillator stands still, at one phase after the other.

    It is undefined for a controller without oscillator.

    Args:
        compute: function of `ClampedEpisodes` to an array [lanes], NaN where undefined.
    """

    compute: Callable[[ClampedEpisodes], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class DerivedMetric(Metric):
    """A metric that follows from others of the same episode.

    Args:
        derivation: from which, and how.
    """

    derivation: Derivation


def derivation_of(metric: Metric) -> Derivation | None:
    """How a metric follows from others; None if it can only be measured."""
    if isinstance(metric, DerivedMetric):
        return metric.derivation
    return metric.otherwise if isinstance(metric, GaitMetric) else None
