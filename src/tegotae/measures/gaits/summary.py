"""The coordination of the legs of every lane in a few numbers, made where the lanes are advanced.

Thousands of lanes need little memory so: a block's frames are gone when the next one begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_count
from tegotae.measures.gaits.lags import (
    OfPhases,
    OfTouchdowns,
    circular_mean,
    circular_spread,
    largest_drift,
    order_parameter,
    over_strides,
    step_frequency_hz,
    time_to_lock,
)
from tegotae.parts._shapes import AnyArray, Number
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.fields import unwrapped
from tegotae.parts.parameters import Part, finite, whole
from tegotae.parts.terms import WholeBody
from tegotae.simulation.recorder import Trajectory, declared
from tegotae.simulation.rollout import Scenario, Timing

TOLERANCE = 0.05
"""Largest distance of a locked gait's lags from their mean [cycles]."""

LEAST_FRAMES = 8
"""Frames of the shortest recording from which a gait is measured."""

_OF_ALL = ("time_s", "failed", "stance_time_s", "touchdown_time_s", "work_absolute_j")
_OF_SOME = ("x_m", "y_m", "slid_m")


class Coordination(NamedTuple):
    """Coordination of the legs of every lane: arrays [limbs, lanes] of legs, else [lanes].

    All is measured over the last whole strides of the window, lags and their lock over the whole
    recording before it as well. What is undefined or not recorded is NaN; of a lane that fell that
    is everything but `fall_time_s`, `slip_m` and `distance_m`.
    """

    lag: AnyArray
    """Mean lag behind the reference leg, in [0, 1) [cycles], [limbs, lanes]."""
    lag_spread: AnyArray
    """Circular standard deviation of the lag averaged over strides [cycles], [limbs, lanes]."""
    touchdown_lag: AnyArray
    """Mean lag of the footfalls [cycles], [limbs, lanes]; as `lag`, if that is theirs."""
    lock_time_s: AnyArray
    """Time after which the lags stay near their mean [s]; NaN if not before the window begins."""
    moved: AnyArray
    """Largest change of the lags since the release [cycles]."""
    order_parameter: AnyArray
    """|Σ exp(2πi lag)| / n: 1 if all legs are in phase."""
    cycle_frequency_hz: AnyArray
    """Cycles of the reference leg per second: turns of its oscillator, if it has one; 0 if it makes
    less than one in the window."""
    step_frequency_hz: AnyArray
    """Touchdowns per second, [limbs, lanes]."""
    duty_factor: AnyArray
    """Share of the stride in stance, [limbs, lanes]."""
    flight_share: AnyArray
    """Share of the time in which no leg is on the ground."""
    power_w: AnyArray
    """Mean of the actuators' |power|, each leg's by itself [W]."""
    distance_m: AnyArray
    """Straight distance of the body over the ground from the release [m]."""
    speed_m_per_s: AnyArray
    """Speed over ground, over whole strides, as the crow flies [m/s]; `heading` has those ahead."""
    cost_of_transport: AnyArray
    """Power / (weight · speed). Of |power|: of a walker's leg its two axes are netted, the swing is
    free, and forces have no limit."""
    froude: AnyArray
    """Froude number speed² / (g l0)."""
    slip_m: AnyArray
    """Total way that the feet slipped [m]."""
    fall_time_s: AnyArray
    """Time of the lane's fall [s]; NaN if it did not fall."""


OF_LEGS = ("lag", "lag_spread", "touchdown_lag", "step_frequency_hz", "duty_factor")
"""Fields of a `Coordination` that are one a leg."""
_TITLES = {name: f"{name}_cycles" for name in ("lag", "lag_spread", "touchdown_lag", "moved")}


def coordination_columns(coordination: Coordination, legs: Sequence[str]) -> dict[str, np.ndarray]:
    """Return the coordination of lanes as columns; the name of a leg ends the columns that belong
    to it.

    Args:
        coordination: arrays [limbs, lanes] and [lanes].
        legs: the legs' names.

    Example:
        >>> values = {name: np.zeros(3) for name in Coordination._fields}
        >>> values |= {name: np.zeros((2, 3)) for name in OF_LEGS}
        >>> list(coordination_columns(Coordination(**values), ("H", "F")))[:3]
        ['lag_cycles_H', 'lag_cycles_F', 'lag_spread_cycles_H']
    """
    columns = {}
    for name, values in coordination._asdict().items():
        title = _TITLES.get(name, name)
        if name in OF_LEGS:
            columns |= {f"{title}_{leg}": values[i] for i, leg in enumerate(legs)}
        else:
            columns[title] = values
    return {name: np.asarray(values) for name, values in columns.items()}


@dataclass(frozen=True, kw_only=True)
class CoordinationSummary(Part):
    """A `Rollout`'s summary: the `Coordination` of every lane.

    Args:
        reference: the leg that lags are measured from.
        tolerance: how far the lags of a locked gait may stray from their mean [cycles].
        rhythm: where lags are read from: `OfPhases` or `OfTouchdowns`.
        channels: what it reads of those that not every body records (`on`).

    Raises:
        TegotaeError: for a tolerance that is not positive, or no leg.

    Example:
        >>> import dataclasses, numpy as np
        >>> from tegotae import Rollout, Scenario
        >>> from tegotae.systems.recipe import recipe
        >>> from tegotae.parts.bodies import Bar
        >>> bar, sector = Bar(inertia_ratio=0.6), recipe("V-sector-w8").controller()
        >>> legs = dataclasses.replace(sector, limbs=2)
        >>> rollout = Rollout(controller=legs, summary=CoordinationSummary.on(legs, bar))
        >>> found = rollout.run([1.0], Scenario(omega=8.0, phase_rad=np.array([[0.0], [2.0]])), bar)
        >>> found.lag.round(2).tolist()
        [[0.0], [0.5]]
    """

    reference: int = whole(0, least=0)
    tolerance: float = finite(TOLERANCE, above=0.0, most=0.5)
    rhythm: OfPhases | OfTouchdowns = field(default_factory=OfPhases)
    channels: tuple[str, ...] = ()

    @classmethod
    def on(cls, controller: Controller, body: Body, **settings: Any) -> Self:
        """Return the summary of a controller on a body: of its oscillators, or else of its
        footfalls.

        Args:
            controller: what drives the body.
            body: the body.
            more: arguments of the summary.

        Raises:
            TegotaeError: for a body of one leg, or a reference that it does not have.
        """
        if body.limbs < 2:
            raise TegotaeError(
                f"a {type(body).__name__} has one leg; a gait is how several legs go together"
            )
        require_count("reference", settings.get("reference", 0), least=0, most=body.limbs - 1)
        has_phase = controller.oscillator is not None and controller.oscillator.has_phase
        # Legs of one network for the whole body do not follow oscillators of their own.
        has_phase &= not isinstance(controller.actuation, WholeBody)
        channels = declared(controller, body)
        return cls(
            **{
                "rhythm": OfPhases() if has_phase else OfTouchdowns(),
                "channels": tuple(name for name in _OF_SOME if name in channels),
                **settings,
            }
        )

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that are recorded for it."""
        return tuple(dict.fromkeys((*_OF_ALL, *self.rhythm.needs, *self.channels)))

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Any:
        """Return the `Coordination` of every lane, or of a subclass that measures more.

        Raises:
            TegotaeError: for a recording of fewer than eight frames.
        """
        frames = len(trajectory.time_s)
        if frames < LEAST_FRAMES:
            raise TegotaeError(
                f"the duration is {timing.duration_s:g}; a gait takes {LEAST_FRAMES} frames at "
                f"least ({LEAST_FRAMES * timing.frame_s:g} s)"
            )
        return coordination(self, trajectory, body, timing.frame_s, frames - max(frames // 4, 2))


def coordination(
    summary: CoordinationSummary,
    trajectory: Trajectory,
    body: Body,
    frame_s: float,
    begins: int,
    reference: int | None = None,
) -> Coordination:
    """Return the coordination of the legs at the end of a recording.

    Args:
        summary: how it is measured.
        trajectory: of several limbs; frames of shape [frames, limbs, lanes] or [frames, lanes].
        body: the body, for its weight and size.
        frame_s: recording period [s].
        begins: the frame with which the window begins that is measured.
        reference: the leg that lags are measured from, if it is not the summary's.
    """
    t, rhythm = trajectory, summary.rhythm
    reference = summary.reference if reference is None else reference
    hz = rhythm.frequency_hz(t, reference, begins)
    raw = rhythm.lag(t, reference)
    frames, limbs, _ = raw.shape
    window = frames - 1 - begins
    steps = hz > 1.0 / (frame_s * max(window, 1))  # one stride in the window at least
    stride = jnp.where(steps, 1.0 / (jnp.where(steps, hz, 1.0) * frame_s), window)
    lag = over_strides(raw, jnp.round(stride).astype("int32"))

    strides = jnp.maximum(jnp.floor(window / stride), 1.0)
    first = jnp.clip(frames - 1 - jnp.round(strides * stride), 0, frames - 2).astype("int32")
    frame = jnp.arange(frames)[:, None, None]
    measured = frame > first[None, None]
    mean = circular_mean(jnp.where(measured, raw, jnp.nan))
    lock = time_to_lock(lag, mean, t.time_s, summary.tolerance)
    begun = t.time_s[begins]
    footfalls = OfTouchdowns().lag(t, reference)

    def over_window(total: AnyArray) -> jax.Array:
        """Return the change of a total, or of a position, over the window."""
        total = jnp.asarray(total)
        start = jnp.broadcast_to(
            first.reshape(1, *[1] * (total.ndim - 2), -1), (1, *total.shape[1:])
        )
        return total[-1] - jnp.take_along_axis(total, start, axis=0)[0]

    time = over_window(t.time_s)
    fell = t.failed[-1]
    power = over_window(t.work_absolute_j) / time
    undefined = jnp.full_like(time, jnp.nan)
    travels = "x_m" in t.channels
    places = [t.channels[name] for name in ("x_m", "y_m") if name in t.channels]
    speed = length([over_window(place) for place in places]) / time if travels else undefined
    body = unwrapped(body)
    weight = total_mass_kg(body) * body.gravity_m_per_s2  # type: ignore[attr-defined]
    slip = t.channels.get("slid_m")

    # Of a frame that a stance begins or ends in, the longest stance counts.
    on_ground = jnp.diff(t.stance_time_s, axis=0).max(axis=1) / frame_s
    flies = jnp.where(measured[1:, 0], 1.0 - on_ground, jnp.nan)

    def of_standing(x: jax.Array) -> jax.Array:
        return jnp.where(jnp.broadcast_to(fell, x.shape), jnp.nan, x)

    return Coordination(
        lag=of_standing(mean),
        lag_spread=of_standing(circular_spread(jnp.where(measured, lag, jnp.nan))),
        touchdown_lag=of_standing(circular_mean(jnp.where(measured, footfalls, jnp.nan))),
        lock_time_s=of_standing(jnp.where(lock <= begun, lock, jnp.nan)),
        moved=of_standing(largest_drift(raw)),
        order_parameter=of_standing(order_parameter(mean)),
        cycle_frequency_hz=of_standing(jnp.where(steps, hz, 0.0)),
        step_frequency_hz=of_standing(step_frequency_hz(t.touchdown_time_s, begins)),
        duty_factor=of_standing(over_window(t.stance_time_s) / time[None]),
        flight_share=of_standing(jnp.clip(jnp.nanmean(flies, axis=0), 0.0, 1.0)),
        power_w=of_standing(power),
        distance_m=length([place[-1] - place[0] for place in places]) if travels else undefined,
        speed_m_per_s=of_standing(speed),
        cost_of_transport=of_standing(power / (weight * speed)),
        froude=of_standing(speed**2 / (body.gravity_m_per_s2 * body.rest_length_m)),  # type: ignore[attr-defined]
        slip_m=undefined if slip is None else sum_over_limbs(slip[-1] - slip[0], limbs),
        fall_time_s=jnp.where(
            fell,
            jnp.take_along_axis(t.time_s, jnp.argmax(t.failed, axis=0)[None], axis=0)[0],
            jnp.nan,
        ),
    )


def total_mass_kg(body: Body) -> Number:
    """Return the total mass of a body [kg]: `total_mass_kg`, if its `mass_kg` is that of a leg."""
    field = "total_mass_kg" if hasattr(body, "total_mass_kg") else "mass_kg"
    return getattr(body, field)


def has_mass(body: Body) -> bool:
    """Return whether a body has a mass."""
    return hasattr(body, "total_mass_kg") or hasattr(body, "mass_kg")


def length(parts: Sequence[jax.Array]) -> jax.Array:
    """Return √(x² + y²)."""
    return jnp.sqrt(sum(part**2 for part in parts))


def sum_over_limbs(x: AnyArray, limbs: int) -> jax.Array:
    """Return the sum of a recorded quantity over the limbs, [lanes].

    Args:
        x: [limbs, lanes], or [lanes], which stays as it is.
        limbs: how many there are.
    """
    x = jnp.asarray(x)
    return x.sum(axis=0) if x.ndim == 2 and x.shape[0] == limbs else x
