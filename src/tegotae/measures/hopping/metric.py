"""What a metric is: its name and meaning, what it needs, and how it is computed."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import SupportsIndex

import jax
import numpy as np

from tegotae.measures.hopping.episode import ClampedEpisodes, Episode
from tegotae.measures.hopping.statistics import UNBOUNDED, Range
from tegotae.parts.bodies import Body

TABLE, FIGURE, REPORT = "table", "figure", "report"
PLACES = (TABLE, FIGURE, REPORT)
"""Where a metric can be shown: tables on the screen, the study's figures, the report's page."""

REGIME = "regime"
"""A label of every episode beside its metrics: an index into `REGIMES`."""


@dataclass(frozen=True)
class Conditions:
    """Under what some episodes were measured.

    Args:
        body: the body; None where it is not known, as in a recording.
        work: definition of work, one of "absolute", "positive", "net".
        drop_m: how far the ground dropped [m]; 0 if it did not.
    """

    body: Body | None
    work: str = "absolute"
    drop_m: float = 0.0


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
        of: names of these, or `REGIME`.
        compute: function of their values, NumPy arrays of one shape by name, NaN where undefined,
            and of the `Conditions`; to an array of that shape.
        needs_body: whether it takes the body; undefined where that is not known.
    """

    of: tuple[str, ...]
    compute: Callable[[Mapping[str, np.ndarray], Conditions], np.ndarray]
    needs_body: bool = False

    def values(self, known: Mapping[str, np.ndarray], conditions: Conditions) -> np.ndarray:
        """Its values, of those of other metrics, arrays of one shape."""
        inputs = {name: known[name] for name in self.of}
        if self.needs_body and conditions.body is None:
            return np.full(np.shape(next(iter(inputs.values()))), np.nan)
        return np.asarray(self.compute(inputs, conditions), float)
