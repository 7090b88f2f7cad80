"""Schedules: values that change during a run, in a step, along a ramp or by a staircase.

A schedule is one class, and holds wherever time passes: in a compiled rollout, in another
simulator, and in the checks before a run. It reads the time from a `Clock`. A schedule of your own
is a frozen dataclass of numbers, marked `traceable`, with `at` and `corners`; and with `neutral`,
if it does more than go to a `value`.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.parameters import traceable


@dataclass(frozen=True)
class TickClock:
    """Clock of a compiled rollout: a time has come with the first tick that is not earlier.

    Args:
        tick: number of the control tick.
        tick_s: control period [s].
    """

    tick: jax.Array
    tick_s: LaneNumbers

    xp: ClassVar[Any] = jnp
    """Module of the array functions."""

    def reached(self, time_s: LaneNumbers) -> jax.Array:
        """Return True where a time [s] has come."""
        # Late times are whole ticks only to within the digits of float32.
        exact = time_s / self.tick_s
        first = jnp.ceil(exact - 1e-3 - 3e-7 * jnp.where(jnp.isfinite(exact), exact, 0.0))
        return self.tick.astype(first.dtype) >= first

    def since_s(self, time_s: LaneNumbers) -> jax.Array:
        """Return the time from another one to the beginning of the tick [s]."""
        time_s = jnp.asarray(time_s)
        return self.tick.astype(time_s.dtype) * self.tick_s - time_s

    def periods(self, period_s: LaneNumbers) -> jax.Array:
        """Return the number of periods [s] since the release, each rounded to whole ticks."""
        ticks = jnp.round(period_s / self.tick_s)
        return jnp.floor(self.tick.astype(ticks.dtype) / ticks)


@dataclass(frozen=True)
class SecondClock:
    """Clock of checks, and of simulators that are stepped from Python.

    Args:
        time_s: time since the release [s]; for a step of a simulator its middle.
    """

    time_s: LaneNumbers

    xp: ClassVar[Any] = np
    """Module of the array functions."""

    def reached(self, time_s: LaneNumbers) -> Any:
        """Return True where a time [s] has come."""
        return np.less_equal(time_s, self.time_s)

    def since_s(self, time_s: LaneNumbers) -> Any:
        """Return the time that has passed since another one [s]."""
        return np.subtract(self.time_s, time_s)

    def periods(self, period_s: LaneNumbers) -> Any:
        """Return the number of whole periods [s] since the release."""
        return np.floor(np.divide(self.time_s, period_s) + 1e-6)


Clock = TickClock | SecondClock
"""Time of a run, as schedules read it."""


class Schedule(ABC):
    """A value that changes during a run: a frozen dataclass of numbers, `traceable`.

    Each entry is a number, or an array of shape [lanes]; entries that are values of the changed
    quantity (`VALUES`) may be of shape [limbs, lanes], if it belongs to the limbs.

    Example:
        >>> @traceable
        ... @dataclass(frozen=True)
        ... class Swell(Schedule):
        ...     amplitude: LaneNumbers
        ...     period_s: LaneNumbers
        ...
        ...     VALUES = ("amplitude",)
        ...
        ...     def at(self, clock, nominal):
        ...         angle = 2.0 * math.pi * clock.since_s(0.0) / self.period_s
        ...         return nominal + self.amplitude * clock.xp.sin(angle)
        ...
        ...     def corners(self, duration_s):
        ...         return 0.25 * self.period_s, 0.75 * self.period_s
        ...
        ...     def neutral(self, nominal):
        ...         return dataclasses.replace(self, amplitude=0.0)
        >>> float(Swell(0.1, period_s=4.0).at(SecondClock(1.0), 1.0))
        1.1
    """

    VALUES: ClassVar[tuple[str, ...]] = ("value",)
    """Names of the entries that are values of the changed quantity."""
    ENDLESS: ClassVar[tuple[str, ...]] = ()
    """Names of the entries that may be infinite."""

    @abstractmethod
    def at(self, clock: Clock, nominal: LaneNumbers) -> Any:
        """Return the value at a time.

        Args:
            clock: the time, and the array functions to compute with (`Clock.xp`).
            nominal: the value without the schedule.
        """

    @abstractmethod
    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return the times [s] between which the value is monotonic; checks look at these.

        Args:
            duration_s: duration of the run [s].
        """

    def neutral(self, nominal: LaneNumbers) -> Schedule:
        """Return a schedule of this class that keeps the nominal value."""
        return dataclasses.replace(self, value=nominal)  # type: ignore[type-var]

    @property
    def once(self) -> tuple[LaneNumbers, LaneNumbers] | None:
        """Value and time [s] of a schedule that changes once and for good; None for others."""
        return None

    @property
    def parts(self) -> tuple[Schedule, ...]:
        """Schedules that it is made of: itself, unless it is a `Chain`."""
        return (self,)

    @property
    def entries(self) -> dict[str, LaneNumbers]:
        """The numbers by name."""
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        return {field.name: getattr(self, field.name) for field in fields}

    def mapped(self, function: Callable[[LaneNumbers], LaneNumbers]) -> Schedule:
        """Return the schedule with a function applied to each entry."""
        return type(self)(**{name: function(x) for name, x in self.entries.items()})

    def least(self, tick_s: float) -> Mapping[str, float]:
        """Return the smallest allowed number of some entries, by name."""
        return {}

    def check(self, name: str, tick_s: float) -> None:
        """Check the numbers.

        Args:
            name: of the changed quantity.
            tick_s: control period [s].

        Raises:
            TegotaeError: for an entry that is no number or out of its range, or a change that ends
                before it begins.
        """
        least = self.least(tick_s)
        for entry, value in self.entries.items():
            label = f"the change of {name}" + ("" if entry == "value" else f", {entry},")
            for number in np.ravel(np.asarray(value, object)):
                if not (entry in self.ENDLESS and number == math.inf):
                    require_finite(label, number, least=least.get(entry))
        from_s, until_s = (self.entries.get(entry, math.inf) for entry in ("from_s", "until_s"))
        if not np.all(np.less(from_s, until_s) | np.isinf(from_s)):  # inf: never
            raise TegotaeError(
                f"the change of {name} ends at {until_s} s and begins at {from_s} s; let it begin "
                "first"
            )


@traceable
@dataclass(frozen=True)
class Constant(Schedule):
    """A value that holds for the whole run. A plain number or array means the same.

    Args:
        value: the value.
    """

    value: LaneNumbers

    def at(self, clock: Clock, nominal: LaneNumbers) -> LaneNumbers:
        """Return the value."""
        return self.value

    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return no times."""
        return ()


@traceable
@dataclass(frozen=True)
class Step(Schedule):
    """Another value from a time on, such as a lost leg or a load; with an end, a square pulse.

    Args:
        value: value during the step.
        from_s: begin [s].
        until_s: end [s].

    Example:
        >>> heavier = Step(0.13, from_s=10.0)
        >>> [float(heavier.at(SecondClock(t), 0.1)) for t in (9.0, 10.0)]
        [0.1, 0.13]
    """

    value: LaneNumbers
    from_s: LaneNumbers = 0.0
    until_s: LaneNumbers = math.inf

    ENDLESS = ("from_s", "until_s")

    def at(self, clock: Clock, nominal: LaneNumbers) -> Any:
        """Return the value at a time."""
        begun = clock.reached(self.from_s) & ~clock.reached(self.until_s)
        return clock.xp.where(begun, self.value, nominal)

    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return begin and end [s]."""
        return self.from_s, self.until_s

    @property
    def once(self) -> tuple[LaneNumbers, LaneNumbers] | None:
        """Value and begin [s], without an end."""
        return (self.value, self.from_s) if np.all(np.isinf(self.until_s)) else None


@traceable
@dataclass(frozen=True)
class Ramp(Schedule):
    """A value that goes linearly to another one, and stays there, such as a wind that rises.

    Args:
        value: value at the end.
        from_s: begin [s].
        until_s: end [s].

    Example:
        >>> rising = Ramp(3.0, from_s=10.0, until_s=20.0)
        >>> [float(rising.at(SecondClock(t), 1.0)) for t in (9.0, 15.0, 25.0)]
        [1.0, 2.0, 3.0]
    """

    value: LaneNumbers
    from_s: LaneNumbers
    until_s: LaneNumbers

    ENDLESS = ("from_s", "until_s")

    def at(self, clock: Clock, nominal: LaneNumbers) -> Any:
        """Return the value at a time."""
        xp, happens = clock.xp, clock.xp.isfinite(self.from_s)
        from_s = xp.where(happens, self.from_s, 0.0)
        share = clock.since_s(from_s) / xp.where(happens, self.until_s - from_s, 1.0)
        share = xp.where(clock.reached(self.from_s), xp.clip(share, 0.0, 1.0), 0.0)
        return nominal + share * (self.value - nominal)

    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return begin and end [s], an end after that of the run as this."""
        return self.from_s, np.minimum(self.until_s, duration_s)


@traceable
@dataclass(frozen=True)
class Staircase(Schedule):
    """A value that rises or falls by a step again and again.

    After n dwells the value is the nominal one plus n steps; after the last level it stays.

    Args:
        step: rise from level to level.
        dwell_s: duration of a level [s].
        levels: number of levels, the first included.

    Example:
        >>> stairs = Staircase(step=0.5, dwell_s=10.0, levels=3)
        >>> [float(stairs.at(SecondClock(t), 2.0)) for t in (9.0, 10.0, 25.0, 99.0)]
        [2.0, 2.5, 3.0, 3.0]
    """

    step: LaneNumbers
    dwell_s: LaneNumbers
    levels: LaneNumbers = math.inf

    VALUES = ("step",)
    ENDLESS = ("levels",)

    def at(self, clock: Clock, nominal: LaneNumbers) -> Any:
        """Return the value at a time."""
        xp = clock.xp
        rise = xp.minimum(clock.periods(self.dwell_s), self.levels - 1.0) * self.step
        shape = np.broadcast_shapes(np.shape(nominal), np.shape(rise))
        return xp.broadcast_to(nominal, shape) + xp.broadcast_to(rise, shape)

    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return the time of the last rise [s]."""
        dwell_s, levels = np.asarray(self.dwell_s), np.asarray(self.levels)
        return (dwell_s * np.minimum(np.floor(duration_s / dwell_s), levels - 1.0),)

    def neutral(self, nominal: LaneNumbers) -> Staircase:
        """Return a staircase without rises."""
        return dataclasses.replace(self, step=0.0)

    def least(self, tick_s: float) -> Mapping[str, float]:
        """Return a control period for a dwell, and one level."""
        return {"dwell_s": tick_s, "levels": 1.0}


@traceable
@dataclass(frozen=True)
class Chain(Schedule):
    """Several schedules of one quantity; each changes the value that the one before it left.

    Args:
        schedules: the schedules, in this order.

    Example:
        >>> both = Chain((Step(2.0, from_s=1.0), Staircase(0.5, dwell_s=2.0)))
        >>> [float(both.at(SecondClock(t), 1.0)) for t in (0.0, 1.0, 3.0)]
        [1.0, 2.0, 2.5]
    """

    schedules: tuple[Schedule, ...]

    def at(self, clock: Clock, nominal: LaneNumbers) -> Any:
        """Return the value at a time."""
        for schedule in self.schedules:
            nominal = schedule.at(clock, nominal)
        return nominal

    def corners(self, duration_s: float) -> Sequence[LaneNumbers]:
        """Return the corners of all schedules [s]."""
        return [time for schedule in self.schedules for time in schedule.corners(duration_s)]

    def neutral(self, nominal: LaneNumbers) -> Chain:
        """Return the chain of neutral schedules."""
        return Chain(tuple(schedule.neutral(nominal) for schedule in self.schedules))

    @property
    def parts(self) -> tuple[Schedule, ...]:
        """The schedules."""
        return tuple(part for schedule in self.schedules for part in schedule.parts)

    def mapped(self, function: Callable[[LaneNumbers], LaneNumbers]) -> Chain:
        """Return the chain with a function applied to each entry of each schedule."""
        return Chain(tuple(schedule.mapped(function) for schedule in self.schedules))


def is_scheduled(change: LaneNumbers) -> bool:
    """Return True for a schedule, False for numbers that hold for the whole run."""
    return isinstance(change, Schedule)


def schedule_of(change: LaneNumbers) -> Schedule:
    """Return a schedule as it is, and numbers as a `Constant`."""
    return change if isinstance(change, Schedule) else Constant(change)


def mapped_change(
    function: Callable[[LaneNumbers], LaneNumbers], change: LaneNumbers
) -> LaneNumbers:
    """Return a change with a function applied to its entries; numbers are one entry.

    Args:
        function: of one entry.
        change: a schedule or numbers.
    """
    return change.mapped(function) if isinstance(change, Schedule) else function(change)
