"""Scenario of a lane: release, frequency, ground, and changes during the run. All of it is data."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts._shapes import LaneNumbers, Number, PerLimb
from tegotae.parts.bodies import Body
from tegotae.parts.fields import FieldNumber, path_of
from tegotae.parts.parameters import changed
from tegotae.simulation.schedules import TickClock, is_scheduled, schedule_of

GROUND = "ground_m"
"""The name of a change of the ground's height, which is no field of the body."""


ByName = Mapping[str, LaneNumbers] | tuple[tuple[str, LaneNumbers], ...]
"""Numbers by name; () for none."""


class Scenario(NamedTuple):
    """Scenario of a lane: each entry a number, or an array of shape [lanes].

    Of a controller for several limbs, `omega` and `phase_rad` may be of shape [limbs, lanes]; else
    they are the same for all limbs.
    """

    omega: LaneNumbers
    """Prescribed frequency ω [rad/s]."""
    height_m: LaneNumbers = 1.2
    """Release height [m]."""
    velocity_m_per_s: LaneNumbers = 0.0
    """Release velocity [m/s]."""
    phase_rad: LaneNumbers = 0.0
    """Oscillator phase at release [rad]."""
    drop_m: LaneNumbers = 0.0
    """Height by which the ground drops [m]."""
    drop_time_s: LaneNumbers = math.inf
    """Time of the drop [s]; it happens at the first control tick not earlier."""
    initial_pose: ByName = ()
    """Further entries of the body's release, by name: {"pitch_rad": 0.1} for a bar."""
    oscillator_state: ByName = ()
    """Initial state of the oscillator beside the phase, by name: {"radius": 0.5}
    (`Oscillator.STATE`)."""
    changes: ByName = ()
    """Fields of the body that are otherwise, and a frequency that changes on the way.

    By name, such as {"mass_kg": [0.08, 0.1, 0.12]} for a mass a lane, or {"mass_kg": Step(0.13,
    from_s=10.0)}; "omega" names the frequency, and "ground_m" the height of the ground
    (`tegotae.simulation.world`)."""

    @classmethod
    def at_frequency(cls, omega: float | None, **entries: LaneNumbers | ByName) -> Scenario:
        """Return a scenario at a prescribed frequency [rad/s], None without an oscillator.

        Nothing reads a frequency then; a number, which the lanes are made of, stands in for it.
        """
        return cls(0.0 if omega is None else omega, **entries)


def ground_m(scenario: Scenario, tick: jax.Array, tick_s: jax.Array) -> jax.Array:
    """Return the height of the ground during a control tick [m].

    Args:
        scenario: the world of every lane.
        tick: number of the control tick.
        tick_s: control period [s].
    """
    drop_tick = jnp.ceil(scenario.drop_time_s / tick_s - 1e-3)
    ground = jnp.where(tick.astype(drop_tick.dtype) >= drop_tick, -scenario.drop_m, 0.0)
    change = dict(scenario.changes).get(GROUND)
    return ground if change is None else change.at(TickClock(tick, tick_s), ground)


@dataclass(frozen=True)
class Condition(ABC):
    """A number that episodes of training do not have in common, and how it is drawn.

    A frozen dataclass. One of your own says its value at each share of its draws (the quantile
    function) and between which values that lies.

    Args:
        name: a field of the body ("mass_kg", "terrain.rise_m"), an entry of the scenario
            ("omega", "height_m", "velocity_m_per_s", "phase_rad", "drop_m", "drop_time_s"), or a
            initial pose of the release ("pitch_rad").
        from_s: from when on it holds [s]; of "drop_m" when the ground drops.
        until_s: until when [s]; None to the end.

    Raises:
        TegotaeError: for times that are none, or not in this order.
    """

    name: str
    from_s: float = 0.0
    until_s: float | None = None

    def __post_init__(self) -> None:
        require_finite(f"from_s of {self.name}", self.from_s, least=0.0)
        if self.until_s is not None:
            require_finite(f"until_s of {self.name}", self.until_s, above=self.from_s)

    @abstractmethod
    def quantile(self, share: np.ndarray) -> np.ndarray:
        """Return the value below which this share of its draws lies, 0 <= share < 1, entry by
        entry.

        Values that are themselves one a limb make an array [limbs, draws] of shares [draws].
        """

    @property
    @abstractmethod
    def extremes(self) -> tuple[FieldNumber, ...]:
        """Values between which all draws lie: numbers, or tuples of one per limb."""

    @property
    def lasts(self) -> bool:
        """True if the value holds for the whole episode."""
        return self.from_s == 0.0 and self.until_s is None


@dataclass(frozen=True, kw_only=True)
class Uniform(Condition):
    """Any value between two, all alike: `low + (high - low) u`, u uniform in [0, 1).

    What belongs to the limbs is drawn limb by limb.

    Args:
        low: the least value, in the unit of the quantity.
        high: the largest.

    Raises:
        TegotaeError: for limits that are not finite, or not in this order.

    Example:
        >>> Uniform("mass_kg", low=0.08, high=0.12).quantile(np.array([0.0, 0.5]))
        array([0.08, 0.1 ])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(f"the lowest {self.name}", self.low)
        require_finite(f"the highest {self.name}", self.high, least=self.low)

    def quantile(self, share: np.ndarray) -> np.ndarray:
        """Return the value at each share."""
        return self.low + (self.high - self.low) * share

    @property
    def extremes(self) -> tuple[float, ...]:
        """Both limits, or one if they are equal."""
        return (self.low,) if self.low == self.high else (self.low, self.high)


@dataclass(frozen=True, kw_only=True)
class OneOf(Condition):
    """One of some values, all equally often.

    Args:
        values: numbers, or tuples of one a limb, such as which legs are present.

    Raises:
        TegotaeError: for no value, values of several lengths, or one that is not finite.

    Example:
        >>> lost = OneOf("present", values=((1.0, 1.0), (0.0, 1.0)))
        >>> lost.quantile(np.array([0.2, 0.7, 0.8]))
        array([[1., 0., 0.],
               [1., 1., 1.]])
    """

    values: tuple[float | tuple[float, ...], ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.values:
            raise TegotaeError(f"{self.name} has no values to be one of; give at least one")
        if len({np.shape(value) for value in self.values}) > 1:
            raise TegotaeError(
                f"{self.name} is one of {self.values}; they must all be numbers, or all tuples of "
                "one number a limb"
            )
        for value in np.ravel(np.asarray(self.values, object)):
            require_finite(self.name, value)

    def quantile(self, share: np.ndarray) -> np.ndarray:
        """Return the value at each share, limb by limb if it has limbs."""
        index = (np.asarray(share) * len(self.values)).astype(int)
        values = np.asarray(self.values, float)[index]
        return np.moveaxis(values, -1, 0) if self._by_limb else values

    @property
    def _by_limb(self) -> bool:
        return isinstance(self.values[0], tuple)

    @property
    def extremes(self) -> tuple[FieldNumber, ...]:
        """The least and the largest number, or all values of several limbs."""
        return self.values if self._by_limb else tuple(sorted({min(self.values), max(self.values)}))


T = TypeVar("T")

OMEGA = "omega"
"""The name of a change of the frequency, which is no field of the body."""
DROP = "drop_m"
"""The name of the one drop of the ground; a `Step` says when."""
ENTRIES = (OMEGA, "height_m", "velocity_m_per_s", "phase_rad", DROP, "drop_time_s")
"""Entries of a scenario that can be otherwise; other names are the body's."""


def with_changes(scenario: Scenario, body: Body, changes: Mapping[str, LaneNumbers]) -> Scenario:
    """Return the scenario with the named changes.

    Args:
        scenario: as it is otherwise.
        body: whose numbers and initial pose are meant.
        changes: by the name of an entry of the scenario ("omega", "height_m"), of a number of the
            release's initial pose ("pitch_rad"), of a field of the body ("mass_kg",
            "terrain.rise_m"), or "ground_m": a value, or a `Schedule`, such as a `Step`. Values are
            numbers, or arrays [lanes] or [limbs, lanes]. A `Step` of "drop_m" has the time of the
            drop.

    Raises:
        TegotaeError: for a name that nothing has, or a schedule of what is of the release.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> from tegotae.simulation.schedules import Step
        >>> drop = {"drop_m": Step(0.05, from_s=30.0), "inertia_ratio": 0.6}
        >>> found = with_changes(Scenario(omega=8.0), Sensors(body=Bar()), drop)
        >>> found.drop_m, found.drop_time_s, found.changes
        (0.05, 30.0, {'body.inertia_ratio': 0.6})
    """
    entries: dict[str, LaneNumbers] = {}
    initial_pose, of_body = dict(scenario.initial_pose), dict(scenario.changes)
    for name, change in changes.items():
        scheduled = is_scheduled(change)
        if name == DROP and scheduled:
            if (once := schedule_of(change).once) is None:
                raise TegotaeError(
                    f"{DROP} is for good; ground that changes otherwise is a schedule of {GROUND}"
                )
            entries |= dict(zip((DROP, "drop_time_s"), once, strict=True))
        elif name in (OMEGA, GROUND) and scheduled:
            of_body[name] = change
        elif name in ENTRIES or name in body.pose_names:
            if scheduled:
                raise TegotaeError(f"{name} is of the release; it cannot change on the way")
            (entries if name in ENTRIES else initial_pose)[name] = change
        elif name == GROUND:
            raise TegotaeError(
                f"{GROUND} changes by a schedule, such as a Step; for a drop name {DROP}"
            )
        else:
            of_body[path_of(body, name)] = change
    return scenario._replace(
        **entries,
        initial_pose=initial_pose or scenario.initial_pose,
        changes=of_body or scenario.changes,
    )


def apply_changes(
    body: T,
    omega: PerLimb,
    changes: Mapping[str, LaneNumbers],
    tick: jax.Array,
    tick_s: LaneNumbers,
) -> tuple[T, PerLimb]:
    """Return body and frequency during a control tick.

    Args:
        body: the body as it usually is.
        omega: ω [rad/s].
        changes: what changes, by the name of a field ("mass_kg", "terrain.rise_m") or "omega".
        tick: the tick's number.
        tick_s: the control period [s].
    """
    clock = TickClock(tick, tick_s)
    for name, change in changes.items():
        if name == OMEGA:
            omega = change.at(clock, omega)
        elif name != GROUND:
            body = changed(body, name, lambda nominal, c=change: c.at(clock, _stacked(nominal)))
    return body, omega


def whole_run(body: T, changes: Mapping[str, LaneNumbers]) -> tuple[T, dict[str, LaneNumbers]]:
    """Return the body with the changes that hold for the whole run, and the remaining changes.

    Args:
        body: the body.
        changes: by the path of a field, values or changes in time.
    """
    entries: dict[str, LaneNumbers] = {}
    for name, change in changes.items():
        if is_scheduled(change):
            entries[name] = change
        else:
            body = changed(body, name, lambda _, value=change: value)
    return body, entries


def _stacked(nominal: LaneNumbers) -> Number:
    """Return a field of the limbs as an array, [limbs, 1]; an array is returned unchanged."""
    if type(nominal) is not tuple:
        return nominal
    return jnp.stack([jnp.asarray(x) for x in cast(tuple[float, ...], nominal)])[:, None]
