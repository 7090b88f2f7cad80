"""Changes to the world by name: an entry of the scenario, or a number of the body, from when on.

Whatever changes the world, a condition of training, a disturbance, a lesion or an axis of a map,
names what changes and gives a value or a schedule; `with_changes` makes the scenario.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import LaneNumbers, Number, PerLimb
from tegotae.parts.bodies import Body
from tegotae.parts.fields import path_of
from tegotae.parts.parameters import changed
from tegotae.simulation.world.scenario import GROUND, Scenario

T = TypeVar("T")

OMEGA = "omega"
"""The name of a change of the frequency, which is no field of the body."""
DROP = "drop_m"
"""The name of the one drop of the ground; a `Step` says when."""
ENTRIES = (OMEGA, "height_m", "velocity_m_per_s", "phase_rad", DROP, "drop_time_s")
"""Entries of a scenario that can be otherwise; other names are the body's."""


class Step(NamedTuple):
    """Another value for a time: a lost leg, a push, a load; a square pulse.

    Each entry a number, or an array of shape [lanes]; `value` may be [limbs, lanes], if it belongs
    to the limbs. A time counts from the first control tick that does not begin earlier.

    Example:
        >>> import jax.numpy as jnp
        >>> heavier = Step(0.13, from_s=10.0)
        >>> [float(heavier.at(jnp.asarray(t), 0.1, 1.0)) for t in (9, 10)]  # at ticks of 1 s
        [0.10000000149011612, 0.12999999523162842]
    """

    value: LaneNumbers
    """What it is meanwhile."""
    from_s: LaneNumbers = 0.0
    """From when on [s]."""
    until_s: LaneNumbers = math.inf
    """Until when [s]."""

    def at(self, tick: jax.Array, usual: LaneNumbers, tick_s: LaneNumbers) -> jax.Array:
        """The value during a control tick, given the usual one."""
        begun = _reached(self.from_s, tick, tick_s) & ~_reached(self.until_s, tick, tick_s)
        return jnp.where(begun, self.value, usual)


class Staircase(NamedTuple):
    """A value that rises by a step, or falls, again and again.

    After n dwells the value is the usual one plus n steps, and after `levels` of them in all it
    stays. Each entry a number, or an array of shape [lanes].

    Example:
        >>> import jax.numpy as jnp
        >>> stairs = Staircase(step=0.5, dwell_s=10.0, levels=3)
        >>> [float(stairs.at(jnp.asarray(t), 2.0, 1.0)) for t in (9, 10, 25, 99)]
        [2.0, 2.5, 3.0, 3.0]
    """

    step: LaneNumbers
    """How much it rises at once."""
    dwell_s: LaneNumbers
    """How long a level lasts [s]."""
    levels: LaneNumbers = math.inf
    """How many levels there are, the first included."""

    def at(self, tick: jax.Array, usual: LaneNumbers, tick_s: LaneNumbers) -> jax.Array:
        """The value during a control tick, given the usual one."""
        dwell = jnp.round(self.dwell_s / tick_s)
        level = jnp.minimum(jnp.floor(tick.astype(dwell.dtype) / dwell), self.levels - 1.0)
        rise = level * self.step
        shape = np.broadcast_shapes(jnp.shape(usual), jnp.shape(rise))
        return jnp.broadcast_to(usual, shape) + jnp.broadcast_to(rise, shape)


Change = Step | Staircase
"""How a value changes during a run."""


def with_changes(scenario: Scenario, body: Body, changes: Mapping[str, LaneNumbers]) -> Scenario:
    """The scenario in which what is named is otherwise.

    Args:
        scenario: as it is otherwise.
        body: whose numbers and initial pose are meant.
        changes: by the name of an entry of the scenario ("omega", "height_m"), of a number of the
            release's initial pose ("pitch_rad"), of a field of the body ("mass_kg",
            "terrain.rise_m"), or "ground_m": a value, or a schedule (`Step`, `Staircase`). Values
            are numbers, or arrays [lanes] or [limbs, lanes]. A `Step` of "drop_m" has the time of
            the drop.

    Raises:
        TegotaeError: for a name that nothing has, or a schedule of what is of the release.

    Example:
        >>> from tegotae.parts.bodies import Bar, Sensors
        >>> drop = {"drop_m": Step(0.05, from_s=30.0), "inertia_ratio": 0.6}
        >>> found = with_changes(Scenario(omega=8.0), Sensors(body=Bar()), drop)
        >>> found.drop_m, found.drop_time_s, found.changes
        (0.05, 30.0, {'body.inertia_ratio': 0.6})
    """
    entries: dict[str, LaneNumbers] = {}
    initial_pose, of_body = dict(scenario.initial_pose), dict(scenario.changes)
    for name, change in changes.items():
        scheduled = isinstance(change, (Step, Staircase))
        if name == DROP and isinstance(change, Step):
            if not np.all(np.isinf(change.until_s)):
                raise TegotaeError(
                    f"{DROP} is for good; ground that rises again is a Step of {GROUND}"
                )
            entries |= {DROP: change.value, "drop_time_s": change.from_s}
        elif name in (OMEGA, GROUND) and scheduled:
            of_body[name] = change
        elif name in ENTRIES or name in body.pose_names:
            if scheduled:
                raise TegotaeError(f"{name} is of the release; it cannot change on the way")
            (entries if name in ENTRIES else initial_pose)[name] = change
        elif name == GROUND:
            raise TegotaeError(
                f"{GROUND} changes by a schedule, a Step or a Staircase; for a drop name {DROP}"
            )
        else:
            of_body[path_of(body, name)] = change
    return scenario._replace(
        **entries,
        initial_pose=initial_pose or scenario.initial_pose,
        changes=of_body or scenario.changes,
    )


def _reached(time_s: LaneNumbers, tick: jax.Array, tick_s: LaneNumbers) -> jax.Array:
    # Late times are whole ticks only to within the digits of float32.
    exact = time_s / tick_s
    first = jnp.ceil(exact - 1e-3 - 3e-7 * jnp.where(jnp.isfinite(exact), exact, 0.0))
    return tick.astype(first.dtype) >= first


def apply_changes(
    body: T,
    omega: PerLimb,
    changes: Mapping[str, LaneNumbers],
    tick: jax.Array,
    tick_s: LaneNumbers,
) -> tuple[T, PerLimb]:
    """Body and frequency during a control tick.

    Args:
        body: the body as it usually is.
        omega: ω [rad/s].
        changes: what changes, by the name of a field ("mass_kg", "terrain.rise_m") or "omega".
        tick: the tick's number.
        tick_s: the control period [s].
    """
    for name, change in changes.items():
        if name == OMEGA:
            omega = change.at(tick, omega, tick_s)
        elif name != GROUND:
            body = changed(body, name, lambda usual, c=change: c.at(tick, _stacked(usual), tick_s))
    return body, omega


def whole_run(body: T, changes: Mapping[str, LaneNumbers]) -> tuple[T, dict[str, LaneNumbers]]:
    """The body with what holds for the whole run, and the changes that are left.

    Args:
        body: the body.
        changes: by the path of a field, values or changes in time.
    """
    left: dict[str, LaneNumbers] = {}
    for name, change in changes.items():
        if isinstance(change, (Step, Staircase)):
            left[name] = change
        else:
            body = changed(body, name, lambda _, value=change: value)
    return body, left


def map_change(function: Callable[[LaneNumbers], LaneNumbers], change: LaneNumbers) -> LaneNumbers:
    """A change with a function applied to its entries; to the value, where it is no more.

    Args:
        function: of one entry.
        change: a `Step`, a `Staircase`, or a value.
    """
    if isinstance(change, (Step, Staircase)):
        return type(change)(*map(function, change))
    return function(change)


def _stacked(usual: LaneNumbers) -> Number:
    """A field of the limbs as an array, [limbs, 1]; what is one already as it is."""
    if type(usual) is not tuple:
        return usual
    return jnp.stack([jnp.asarray(x) for x in cast(tuple[float, ...], usual)])[:, None]
