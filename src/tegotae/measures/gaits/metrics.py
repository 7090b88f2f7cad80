"""Metrics of several legs: what they are computed from, their kind, and the package's own.

The package's own stand at the end of the file, in the order in which tables show them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import require_known
from tegotae.measures.gaits.names import NO_GAIT
from tegotae.measures.gaits.summary import total_mass_kg
from tegotae.measures.metric import Catalogue, Metric
from tegotae.measures.statistics import POSITIVE, SHARE, mean_defined
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped

GAIT = "gait"
"""Label of every release beside its metrics: the name of its gait, or the reason for none."""
WALKING = Catalogue("walking", "run", "omega", GAIT)
"""The metrics of several legs."""


@dataclass(frozen=True)
class Walks:
    """Releases of several legs, as many in each row. A row is a run at a frequency.

    Example:
        >>> from tegotae.parts.bodies import Walker
        >>> walks = Walks({"speed_m_per_s": [0.2, 0.4, 0.1, 0.3]}, 2, Walker())
        >>> walks["speed_m_per_s"].tolist()
        [[0.2, 0.4], [0.1, 0.3]]
    """

    columns: Mapping[str, ArrayLike]
    """Gait and coordination by name (`tegotae.measures.gaits.summary.coordination_columns`), a
    value a release."""
    starts: int
    """Number of releases in a row."""
    body: Body
    """The body, for its weight and size."""
    channels: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])
    """Recorded channels that metrics declare, [frames, (limbs,) releases] each."""

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column, [rows, starts], or a channel, [frames, (limbs,) rows, starts].

        Raises:
            TegotaeError: if there is none of this name.
        """
        values = {**self.columns, **self.channels}
        require_known("quantity of a walk", name, values)
        array = np.asarray(values[name])
        return array.reshape(*array.shape[:-1], -1, self.starts)

    @property
    def stands(self) -> np.ndarray:
        """True for releases that do not fall, [rows, starts]."""
        return ~np.isfinite(self["fall_time_s"])

    @property
    def locks(self) -> np.ndarray:
        """True for releases whose legs lock into one gait, [rows, starts]."""
        return self.stands & ~np.isin(self[GAIT].astype(str), NO_GAIT[1:])

    @property
    def gravity_m_per_s2(self) -> float:
        """Gravity g [m/s²]."""
        body: Any = unwrapped(self.body)
        return float(body.gravity_m_per_s2)

    @property
    def weight_n(self) -> float:
        """Weight of the body [N]."""
        return float(total_mass_kg(unwrapped(self.body))) * self.gravity_m_per_s2

    @property
    def common(self) -> list[tuple[str, int]]:
        """The gait that most releases of a row end in, and their number, [rows]."""
        return [Counter(row.tolist()).most_common(1)[0] for row in self[GAIT]]


@dataclass(frozen=True, kw_only=True)
class WalkMetric(Metric):
    """A metric of several legs.

    Args:
        compute: function of `Walks` to an array [rows, starts], of which the mean over the starts
            counts, or [rows]; NaN where undefined.
        channels: names of the recorded channels that it reads beside the coordination.

    Example:
        >>> @WalkMetric.described(label="duty", more_is_better=None)
        ... def fore_duty(walks):
        ...     '''share of the stride in stance of the left fore leg'''
        ...     return walks["duty_factor_LF"]
        >>> fore_duty.about
        'share of the stride in stance of the left fore leg'
    """

    compute: Callable[[Walks], np.ndarray]
    channels: tuple[str, ...] = ()

    CATALOGUE: ClassVar[Catalogue] = WALKING

    def values(self, walks: Walks) -> np.ndarray:
        """Return its values, [rows]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = np.asarray(self.compute(walks))
        return mean_defined(values) if values.ndim == 2 else values


def over_starts(walks: Walks, metrics: Sequence[Metric] | None = None) -> dict[str, np.ndarray]:
    """Return selected metrics of walks by name, [rows], or all of them and the common `gait`.

    Args:
        walks: the releases.
        metrics: metrics of several legs.
    """
    selected = WALKING.metrics() if metrics is None else metrics
    values = {m.name: m.values(walks) for m in selected if isinstance(m, WalkMetric)}
    if metrics is None:
        values[GAIT] = np.array([name for name, _ in walks.common])
    return values


# Source: of this library.
@WalkMetric.described(label="upright", more_is_better=True, range=SHARE)
def upright(walks: Walks) -> np.ndarray:
    """share of the releases that do not fall"""
    return walks.stands


# Source: of this library.
@WalkMetric.described(label="locked", more_is_better=True, range=SHARE)
def locked(walks: Walks) -> np.ndarray:
    """share of the releases whose legs lock into one gait"""
    return walks.locks


# Source: of this library.
@WalkMetric.described(label="locks in", unit="s", more_is_better=False, range=POSITIVE)
def lock_time_s(walks: Walks) -> np.ndarray:
    """median time until the legs lock into one gait"""
    times = np.where(walks.locks, walks["lock_time_s"], np.nan)
    return np.ma.median(np.ma.masked_invalid(times), axis=-1).filled(np.nan)


# Source: of this library.
@WalkMetric.described(label="speed", unit="m/s", more_is_better=None)
def speed_m_per_s(walks: Walks) -> np.ndarray:
    """mean speed over ground of the releases that stay up"""
    return walks["speed_m_per_s"]


# Source: of this library.
@WalkMetric.described(label="CoT", more_is_better=False, range=POSITIVE)
def cost_of_transport(walks: Walks) -> np.ndarray:
    """mean power over weight and mean speed"""
    speed, power = mean_defined(walks["speed_m_per_s"]), mean_defined(walks["power_w"])
    return np.where(speed > 0.0, power / (walks.weight_n * speed), np.nan)


# Source: R. McN. Alexander, The gaits of bipedal and quadrupedal animals (1984).
@WalkMetric.described(label="Froude number", more_is_better=None, range=POSITIVE, shown=())
def froude(walks: Walks) -> np.ndarray:
    """Froude number of the mean speed"""
    length_m = float(walks.body.rest_length_m)
    return mean_defined(walks["speed_m_per_s"]) ** 2 / (walks.gravity_m_per_s2 * length_m)


# Source: of this library.
@WalkMetric.described(label="slip", more_is_better=False, range=POSITIVE)
def slip(walks: Walks) -> np.ndarray:
    """way that each foot slips over the way of the body"""
    slips = walks.stands & (walks["distance_m"] > 0.0)
    return np.where(slips, walks["slip_m"] / walks["distance_m"] / walks.body.limbs, np.nan)


# Source: of this library.
@WalkMetric.described(label="share of it", more_is_better=None, range=SHARE, shown=())
def gait_share(walks: Walks) -> np.ndarray:
    """share of the releases that end in the common gait"""
    return np.array([count / walks.starts for _, count in walks.common])


WALKING.built_in = tuple(x for x in tuple(globals().values()) if isinstance(x, Metric))
