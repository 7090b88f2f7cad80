"""Recorded channels of a rollout, each declared by its part; only those requested."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, TypeVar

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_known
from tegotae._support.transforms import shapes_of
from tegotae.parts._shapes import MaskPerLane, PerCommand, PerLane, PerLimb
from tegotae.parts.bodies import Body
from tegotae.parts.channels import (
    Channel,
    Combined,
    Latest,
    State,
    Total,
)
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import phase_of, to_units
from tegotae.simulation.loop import (
    Lane,
    Tick,
    keep,
    over_limbs,
)


class RecordedFrame(NamedTuple):
    """A lane at the end of a frame, from which a `State` channel reads."""

    time_s: PerLane
    """Time [s], [lanes]."""
    lane: Lane
    """The lane."""
    ground_m: PerLane
    """Height of the ground [m], [lanes]."""
    controller: Controller
    """The controller."""
    body: Body
    """The body."""


Recorded: TypeAlias = Any
"""Recording of a channel: an array of JAX, of NumPy once a rollout is over, or an abstract value in
a trace."""
C = TypeVar("C", bound=Channel)
S = TypeVar("S")


@jax.tree_util.register_pytree_node_class
class Trajectory:
    """The recording of a rollout: one attribute per channel, each frame at its end.

    Arrays are of shape [frames, lanes]. What belongs to a limb is [frames, limbs, lanes] on bodies
    with several. Totals are running sums from the release on; events are NaN in frames without one,
    and the last of their kind in frames with several. It is a pytree: `jax.tree.map` goes through
    its channels.

    Of every body there are `COMMON`'s channels; bodies and oscillators declare more.

    Raises:
        AttributeError: for a channel that was not recorded; names those that were.

    Example:
        >>> path = Trajectory(time_s=jnp.zeros((3, 1)), height_m=jnp.ones((3, 1)))
        >>> path.height_m.shape, list(path.channels)
        ((3, 1), ['time_s', 'height_m'])
    """

    __slots__ = ("channels",)

    channels: Mapping[str, Recorded]
    """The recorded arrays by name."""

    def __init__(self, **channels: Recorded) -> None:
        self.channels = channels

    def __getattr__(self, name: str) -> Recorded:
        if name.startswith("_") or name == "channels":
            raise AttributeError(name)
        try:
            return self.channels[name]
        except KeyError:
            raise AttributeError(
                f"{name!r} was not recorded; recorded are {', '.join(self.channels)}"
            ) from None

    def __repr__(self) -> str:
        return f"Trajectory({', '.join(self.channels)})"

    def only(self, names: Iterable[str] | None) -> Trajectory:
        """Return these channels; all if None."""
        if names is None:
            return self
        return Trajectory(**{name: self.channels[name] for name in names})

    def tree_flatten(self) -> tuple[tuple[Recorded, ...], tuple[str, ...]]:
        """Return the arrays, and their names."""
        return tuple(self.channels.values()), tuple(self.channels)

    @classmethod
    def tree_unflatten(cls, names: tuple[str, ...], arrays: Iterable[Recorded]) -> Trajectory:
        """Rebuild a trajectory from its arrays and their names."""
        return cls(**dict(zip(names, arrays, strict=True)))


def _spring_force(frame: RecordedFrame) -> PerLimb:
    sensed = frame.body.sense(frame.lane.moment.body, frame.ground_m).values
    if "spring_force" not in sensed:
        return jnp.zeros_like(frame.lane.force_n)
    return to_units(frame.controller, sensed["spring_force"])


def _limbs_sum(x: PerLimb, tick: Tick) -> PerLane:
    return over_limbs(jnp.sum, x, tick.body)


def _per_limb(x: PerCommand, tick: Tick) -> PerLimb:
    return jnp.broadcast_to(x, jnp.shape(tick.phase_rad))


def _apex(tick: Tick) -> MaskPerLane:
    return ~jnp.isnan(tick.contact.apex_share)


def _time_at(tick: Tick, share: PerLimb) -> PerLimb:
    """Return the time at a share of a tick [s]."""
    return (tick.number.astype(share.dtype) + share) * tick.tick_s


def _absolute(positive: PerLane, net: PerLane) -> PerLane:
    return 2.0 * positive - net  # |x| = 2 max(0, x) - x


COMMON: tuple[Channel, ...] = (
    State("time_s", "Time [s].", lambda f: f.time_s),
    State("height_m", "Height y [m].", lambda f: f.body.height(f.lane.moment.body)),
    State("velocity_m_per_s", "Velocity ẏ [m/s].", lambda f: f.body.velocity(f.lane.moment.body)),
    State(
        "phase_rad",
        "Phase φ [rad] in [0, 2π), a limb; zero without an oscillator.",
        lambda f: phase_of(f.controller, f.lane.moment.oscillator, f.lane.force_n),
    ),
    State(
        "spring_force_n",
        "Spring force F_k [N], a limb; zero on bodies that do not sense it.",
        _spring_force,
    ),
    State(
        "feedback_rad_per_s",
        "Tegotae feedback f [rad/s], a limb.",
        lambda f: f.lane.moment.drive.feedback,
    ),
    State(
        "actuator_force_n",
        "Mean actuator force over the frame's last tick [N], a limb; zero in flight.",
        lambda f: f.lane.force_n,
    ),
    State("ground_m", "Ground height h [m].", lambda f: f.ground_m),
    State(
        "energy_j",
        "Mechanical energy [J].",
        lambda f: f.body.energy(f.lane.moment.body, f.ground_m),
    ),
    Total(
        "impulse_ns",
        "Total of the actuators' impulse ∫ F_a dt [N s].",
        lambda t: _limbs_sum(t.force_n * t.tick_s, t),
    ),
    Combined(
        "work_absolute_j",
        "Total of ∫ |F_a ẏ| dt [J].",
        _absolute,
        ("work_positive_j", "work_net_j"),
    ),
    Total(
        "work_positive_j",
        "Total of ∫ max(0, F_a ẏ) dt [J], each limb's added up.",
        lambda t: _limbs_sum(jnp.maximum(t.contact.work_j, 0.0), t),
    ),
    Total("work_net_j", "Total of ∫ F_a ẏ dt [J].", lambda t: _limbs_sum(t.contact.work_j, t)),
    Total(
        "climb_flight_m",
        "Total of heights climbed in flight [m].",
        lambda t: t.contact.climb_flight_m,
    ),
    Total(
        "climb_m",
        "Total of heights climbed, in flight and in stance [m].",
        lambda t: t.contact.climb_m,
    ),
    Latest(
        "apex_time_s",
        "Time of a flight apex [s].",
        _apex,
        lambda t: _time_at(t, t.contact.apex_share),
    ),
    Latest("apex_height_m", "Height of that apex [m].", _apex, lambda t: t.contact.apex_height_m),
    Latest(
        "apex_phase_rad",
        "Phase at that apex [rad], a limb.",
        _apex,
        lambda t: t.phase_rad + _per_limb(t.contact.apex_share, t) * t.travel_rad,
    ),
    Latest(
        "touchdown_time_s",
        "Time of a touchdown [s], a limb.",
        lambda t: ~jnp.isnan(t.contact.touchdown_share),
        lambda t: _time_at(t, t.contact.touchdown_share),
    ),
    Total(
        "stance_time_s",
        "Total of the time in stance [s], a limb.",
        lambda t: t.contact.stance_share * t.tick_s,
    ),
    State(
        "failed",
        "True from the frame on in which the lane failed; its state then stands still.",
        lambda f: f.lane.failed,
    ),
)
"""The channels of every body, in this order."""


def declared(controller: Controller, body: Body) -> dict[str, Channel]:
    """Return all that can be recorded of a controller on a body, by name.

    Args:
        controller: whose oscillator declares channels.
        body: the body, which does, too.

    Raises:
        TegotaeError: for two channels of one name.
    """
    rhythm = () if controller.oscillator is None else controller.oscillator.channels
    channels: dict[str, Channel] = {}
    for channel in (*COMMON, *body.channels, *rhythm):
        if channel.name in channels:
            raise TegotaeError(
                f"{channel.name} is recorded already; give the channel of "
                f"{type(body).__name__} or its controller another name"
            )
        channels[channel.name] = channel
    return channels


def needing(*names: str) -> Callable[[S], S]:
    """Declare which channels a summary needs; others are not computed for it.

    Example:
        >>> @needing("height_m")
        ... def highest(trajectory, scenario, body, timing):
        ...     return trajectory.height_m.max(axis=0)
        >>> highest.needs
        ('height_m',)
    """

    def declare(summary: S) -> S:
        vars(summary)["needs"] = names
        return summary

    return declare


@dataclass(frozen=True)
class Recorder:
    """Channels of a controller on a body, recorded during a rollout.

    Args:
        channels: what to record, by name.
        recorded: the names of those that are wanted; the others only serve them.
    """

    channels: Mapping[str, Channel]
    recorded: tuple[str, ...]

    @classmethod
    def for_loop(
        cls, controller: Controller, body: Body, names: Iterable[str] | None = None
    ) -> Recorder:
        """Return a recorder of the channels named, or of all.

        Raises:
            TegotaeError: for an undeclared name.
        """
        channels = declared(controller, body)
        recorded = tuple(channels) if names is None else tuple(names)
        for name in recorded:
            require_known("channel", name, channels)
        served = [n for name in recorded for n in getattr(channels[name], "needs", ())]
        return cls({name: channels[name] for name in (*recorded, *served)}, recorded)

    def _channels_of(self, kind: type[C]) -> dict[str, C]:
        return {name: c for name, c in self.channels.items() if isinstance(c, kind)}

    def empty(self, tick: Callable[[], Tick]) -> tuple[dict[str, jax.Array], dict[str, jax.Array]]:
        """Return zero totals and no events, in the shapes of a tick, which is traced once."""

        def zeros() -> tuple[dict[str, jax.Array], dict[str, jax.Array]]:
            output = tick()
            totals = {
                name: channel.gain(output) for name, channel in self._channels_of(Total).items()
            }
            return totals, {
                name: channel.value(output) for name, channel in self._channels_of(Latest).items()
            }

        totals, events = shapes_of(zeros)
        return (
            {name: jnp.zeros(s.shape, s.dtype) for name, s in totals.items()},
            {name: jnp.full(s.shape, jnp.nan, s.dtype) for name, s in events.items()},
        )

    def add(self, totals: dict[str, jax.Array], tick: Tick) -> dict[str, jax.Array]:
        """Return the totals after a tick; those of a failed lane do not change."""
        added = {
            name: totals[name] + channel.gain(tick)
            for name, channel in self._channels_of(Total).items()
        }
        return {name: keep(tick.sound, x, totals[name]) for name, x in added.items()}

    def update(self, events: dict[str, jax.Array], tick: Tick) -> dict[str, jax.Array]:
        """Return the events after a tick; a failed lane has none."""
        updated: dict[str, jax.Array] = {}
        for name, channel in self._channels_of(Latest).items():
            value, happens = channel.value(tick), channel.when(tick)
            happens = jnp.broadcast_to(happens, value.shape)
            happens &= jnp.broadcast_to(tick.sound, value.shape)
            updated[name] = jnp.where(happens, value, events[name])
        return updated

    def frame(
        self, frame: RecordedFrame, totals: dict[str, jax.Array], events: dict[str, jax.Array]
    ) -> Trajectory:
        """Return the recording of a frame."""
        recorded = {}
        for name in self.recorded:
            channel = self.channels[name]
            if isinstance(channel, State):
                recorded[name] = channel.of(frame)
            elif isinstance(channel, Combined):
                recorded[name] = channel.of(*(totals[need] for need in channel.needs))
            else:
                recorded[name] = (totals if isinstance(channel, Total) else events)[name]
        return Trajectory(**recorded)
