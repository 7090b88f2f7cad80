"""Batched rollouts: every lane its own weights, frequency, release and ground, on all cores."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, PartitionSpec

from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller, Weights
from tegotae.devices import lane_devices, loops_are_kernels, on_cpu
from tegotae.errors import TegotaeError, require_finite
from tegotae.integrators import Integrator, Moment, PredictorCorrector
from tegotae.integrators.base import drive, phase_of

LANES_PER_BLOCK = 64 if loops_are_kernels() else 512
"""Lanes advanced together on a CPU device: few enough to stay in a core's cache, and enough to be
worth the runtime's calls, of which a loop that is one kernel needs few. Always so many, the last
ones filled up, so that a lane's arithmetic depends neither on its neighbours nor on how many
devices share the work."""
MOST_TICKS = 2**24
"""Control ticks of the longest rollout: up to here float32 counts them exactly."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """How long a rollout lasts and how finely it is advanced and recorded.

    Raises:
        TegotaeError: for a period that is not positive and finite, a frame that is no multiple of
            the tick, or a duration shorter than a frame or longer than 2^24 ticks.
    """

    duration_s: float = 20.0
    """Simulated time [s]; rounded to whole frames."""
    tick_s: float = 0.001
    """Control period [s]."""
    frame_s: float = 0.02
    """Recording period [s], a whole multiple of the tick."""

    def __post_init__(self) -> None:
        for name in ("duration_s", "tick_s", "frame_s"):
            require_finite(name, getattr(self, name), above=0.0)
        if self.duration_s / self.tick_s > MOST_TICKS:
            raise TegotaeError(
                f"duration_s is {self.duration_s:g}; at {self.tick_s:g} s per control tick it must "
                f"be at most {MOST_TICKS * self.tick_s:g}"
            )
        ratio = self.frame_s / self.tick_s
        if abs(ratio - round(ratio)) > 1e-6 or round(ratio) < 1:
            raise TegotaeError(
                f"frame_s is {self.frame_s:g}; it must be a whole multiple of tick_s "
                f"({self.tick_s:g})"
            )
        if self.n_frames < 1:
            raise TegotaeError(
                f"duration_s is {self.duration_s:g}; it must be at least one frame "
                f"({self.frame_s:g} s)"
            )

    @property
    def ticks_per_frame(self) -> int:
        """Control ticks per recorded frame."""
        return round(self.frame_s / self.tick_s)

    @property
    def n_frames(self) -> int:
        """Number of recorded frames."""
        return round(self.duration_s / self.frame_s)


class Scenario(NamedTuple):
    """What a lane meets: each entry a number, or an array of shape [lanes]."""

    omega: Any
    """Prescribed frequency ω [rad/s]."""
    height_m: Any = 1.2
    """Release height [m]."""
    velocity_m_per_s: Any = 0.0
    """Release velocity [m/s]."""
    phase_rad: Any = 0.0
    """Oscillator phase at release [rad]."""
    drop_m: Any = 0.0
    """How far the ground drops [m]."""
    drop_time_s: Any = math.inf
    """When it drops [s]; at the first control tick not earlier."""


class Trajectory(NamedTuple):
    """What was recorded: arrays of shape [frames, lanes], each frame at its end.

    Totals are running sums from the release on; events are NaN in frames without one, and the
    last of its kind in frames with several.
    """

    time_s: Any
    """Time [s]."""
    height_m: Any
    """Height y [m]."""
    velocity_m_per_s: Any
    """Velocity ẏ [m/s]."""
    phase_rad: Any
    """Phase φ [rad] in [0, 2π); zero without an oscillator."""
    spring_force_n: Any
    """Spring force F_k [N]."""
    feedback_rad_per_s: Any
    """Tegotae feedback f [rad/s]."""
    actuator_force_n: Any
    """Mean actuator force over the frame's last tick [N]; zero in flight."""
    ground_m: Any
    """Ground height h [m]."""
    energy_j: Any
    """Mechanical energy [J]."""
    impulse_ns: Any
    """Total of the actuator's impulse ∫ F_a dt [N s]."""
    work_absolute_j: Any
    """Total of ∫ |F_a ẏ| dt [J]."""
    work_positive_j: Any
    """Total of ∫ max(0, F_a ẏ) dt [J]."""
    work_net_j: Any
    """Total of ∫ F_a ẏ dt [J]."""
    climb_flight_m: Any
    """Total of heights climbed in flight [m]."""
    climb_m: Any
    """Total of heights climbed, in flight and in stance [m]."""
    apex_time_s: Any
    """Time of a flight apex [s]."""
    apex_height_m: Any
    """Height of that apex [m]."""
    apex_phase_rad: Any
    """Phase at that apex [rad]."""
    touchdown_time_s: Any
    """Time of a touchdown [s]."""
    failed: Any
    """True from the frame on in which the lane failed; its state then stands still."""


class _Totals(NamedTuple):
    impulse: jax.Array
    positive: jax.Array
    net: jax.Array
    climb_flight: jax.Array
    climb: jax.Array


class _Events(NamedTuple):
    apex_time: jax.Array
    apex_height: jax.Array
    apex_phase: jax.Array
    touchdown_time: jax.Array


class _Lane(NamedTuple):
    moment: Moment
    totals: _Totals
    force: jax.Array
    failed: jax.Array


def whole_trajectory(
    trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
) -> Trajectory:
    """The trajectory as it is: the summary that keeps everything."""
    return trajectory


Summary = Callable[[Trajectory, Scenario, Body, Timing], Any]


@dataclass(frozen=True, kw_only=True)
class Engine:
    """How lanes are advanced: the static part of a compiled program.

    Args:
        controller: what drives the body.
        integrator: how controller and body advance by one tick.
        timing: duration, control period, recording period.
        summary: function of (trajectory, scenario, body, timing) to a pytree of arrays, lanes last,
            run on the device block by block: only what it returns is kept, so memory does not grow
            with lanes x frames. It must be hashable (a function, or a frozen dataclass).

    Example:
        >>> from tegotae.models import build
        >>> engine = Engine(controller=build("V-reflex-w8"))
        >>> out = engine.run(np.array([[2.0], [3.0]]), Scenario(omega=8.0))
        >>> out.height_m.shape
        (1000, 2)
    """

    controller: Controller
    integrator: Integrator = dataclasses.field(default_factory=PredictorCorrector)
    timing: Timing = dataclasses.field(default_factory=Timing)
    summary: Summary = whole_trajectory

    def run(
        self,
        weights: Any,
        scenario: Scenario,
        body: Body | None = None,
        *,
        dtype: str = "float32",
    ) -> Any:
        """Roll out every lane, and return the summary as NumPy arrays, lanes last.

        Args:
            weights: shape [lanes, n_weights] or [n_weights].
            scenario: numbers, or arrays of shape [lanes].
            body: the body; the paper's hopper by default.
            dtype: "float32" or "float64".

        Raises:
            TegotaeError: for weights or a scenario of the wrong shape, or a tick too long for
                the body.
        """
        body = Hopper() if body is None else body
        if dtype not in ("float32", "float64"):
            raise TegotaeError(f"dtype is {dtype!r}; it must be 'float32' or 'float64'")
        body.check_tick(self.timing.tick_s)
        check_senses(self.controller, body)
        with jax.enable_x64(dtype == "float64"):
            weights, scenario = _as_lanes(self.controller, weights, scenario, dtype)
            body = jax.tree.map(lambda x: jnp.asarray(x, dtype), body)
            return jax.tree.map(np.asarray, _run(self, weights, scenario, body))

    def trace(
        self,
        weights: jax.Array,
        scenario: Scenario,
        body: Body,
        wanted: jax.Array | int | None = None,
    ) -> Any:
        """The same, for use inside a compiled program: weights [n_weights, lanes], arrays only.

        Args:
            weights: shape [n_weights, lanes].
            scenario: arrays of shape [lanes].
            body: the body.
            wanted: how many of the lanes are wanted, from the first on; all by default. Blocks of
                others cost nothing, and their summary is zero.
        """
        n_lanes = weights.shape[-1]
        devices = lane_devices()
        per_device = -(-n_lanes // len(devices))
        block = LANES_PER_BLOCK if on_cpu() else per_device
        blocks = -(-per_device // block)
        total = block * blocks * len(devices)

        def dealt(x: jax.Array) -> jax.Array:
            """Whole blocks, dealt out to the devices in turn."""
            fill = jnp.broadcast_to(x[..., -1:], (*x.shape[:-1], total - n_lanes))
            x = jnp.concatenate([x, fill], axis=-1)
            x = x.reshape(*x.shape[:-1], blocks, len(devices), block)
            return x.swapaxes(-2, -3).reshape(*x.shape[:-3], total)

        def gathered(x: jax.Array) -> jax.Array:
            x = x.reshape(*x.shape[:-1], len(devices), blocks, block).swapaxes(-2, -3)
            return x.reshape(*x.shape[:-3], total)[..., :n_lanes]

        def on_device(weights: jax.Array, scenario: Scenario, wanted: jax.Array, body: Body) -> Any:
            def lanes_of(x: jax.Array, at: jax.Array) -> jax.Array:
                return jax.lax.dynamic_slice_in_dim(x, at * block, block, axis=-1)

            def advance(at: jax.Array, done: Any) -> Any:
                of_block = partial(lanes_of, at=at)
                part = _advance_block(
                    self, of_block(weights), jax.tree.map(of_block, scenario), body
                )
                return jax.tree.map(partial(put, at=at), done, part)

            def put(all_lanes: jax.Array, part: jax.Array, at: jax.Array) -> jax.Array:
                return jax.lax.dynamic_update_slice_in_dim(all_lanes, part, at * block, axis=-1)

            nothing = jax.tree.map(
                lambda s: jnp.zeros((*s.shape[:-1], blocks * block), s.dtype), shapes
            )
            # That the count is not known beforehand also keeps XLA from compiling a single block
            # in another way than one of many.
            ahead = jax.lax.axis_index("lanes") * block
            mine = jnp.clip(-(-(wanted - ahead) // (len(devices) * block)), 0, blocks)
            return jax.lax.fori_loop(0, mine, advance, nothing)

        lanes_last = (PartitionSpec(None, "lanes"), PartitionSpec("lanes"), PartitionSpec())
        shapes = jax.eval_shape(
            partial(_advance_block, self),
            jax.ShapeDtypeStruct((weights.shape[0], block), weights.dtype),
            jax.tree.map(lambda x: jax.ShapeDtypeStruct((block,), x.dtype), scenario),
            body,
        )
        out_specs = jax.tree.map(
            lambda s: PartitionSpec(*[None] * (len(s.shape) - 1), "lanes"), shapes
        )
        sharded = jax.shard_map(
            on_device,
            mesh=Mesh(np.array(devices), ("lanes",)),
            in_specs=(*lanes_last, PartitionSpec()),
            out_specs=out_specs,
            check_vma=False,
        )
        count = jnp.asarray(n_lanes if wanted is None else wanted, "int32")
        result = sharded(dealt(weights), jax.tree.map(dealt, scenario), count, body)
        return jax.tree.map(gathered, result)


@partial(jax.jit, static_argnums=0)
def _run(engine: Engine, weights: jax.Array, scenario: Scenario, body: Body) -> Any:
    return engine.trace(weights, scenario, body)


def check_senses(controller: Controller, body: Body) -> None:
    """Raise `TegotaeError` if a term reads a signal that nothing provides."""
    known = set(body.SENSES)
    if controller.oscillator is not None:
        known |= {"sin_phase", "cos_phase"}
    for role, term in controller.terms.items():
        available = known | ({"feedback"} if role == "actuation" else set())
        for name in term.reads:
            if name not in available:
                raise TegotaeError(
                    f"the {role} term reads {name!r}, which nothing provides; "
                    f"known here: {', '.join(sorted(available))}"
                )


def _as_lanes(
    controller: Controller, weights: Any, scenario: Scenario, dtype: str
) -> tuple[jax.Array, Scenario]:
    """Weights [n_weights, lanes] and a scenario of arrays [lanes]."""
    weights = np.asarray(weights, dtype)
    if weights.ndim == 1:
        weights = weights[None, :]
    if weights.ndim != 2 or weights.shape[1] != controller.n_weights:
        raise TegotaeError(
            f"weights have shape {weights.shape}; this controller needs "
            f"[lanes, {controller.n_weights}]"
        )
    entries = [np.asarray(value, dtype) for value in scenario]
    try:
        (lanes,) = np.broadcast_shapes((len(weights),), *(entry.shape for entry in entries))
    except ValueError:
        shapes = ", ".join(str(entry.shape) for entry in entries)
        raise TegotaeError(
            f"weights for {len(weights)} lanes do not go with scenario entries of shapes {shapes}; "
            "each must be a number or have one entry per lane"
        ) from None
    columns = np.broadcast_to(weights, (lanes, weights.shape[1])).T
    return (
        jnp.asarray(np.ascontiguousarray(columns)),
        Scenario(*(jnp.asarray(np.broadcast_to(entry, (lanes,))) for entry in entries)),
    )


def _outside_of_kernels(index: jax.Array) -> jax.Array:
    """The same index, in a way that keeps a loop over it from becoming one CPU kernel.

    XLA makes one kernel of a small loop and all loops in it. That is what the ticks of a frame
    need; the loop over frames as one kernel would copy the record of all frames in each. XLA has no
    word for "not this one", but a sort cannot be part of such a kernel.
    """
    return jnp.sort(jnp.stack([index, index]))[0]


def _advance_block(engine: Engine, weights: jax.Array, scenario: Scenario, body: Body) -> Any:
    """Roll out one block: weights [n_weights, block], scenario of [block] arrays."""
    controller, timing = engine.controller, engine.timing
    dtype = weights.dtype
    rows = cast(Weights, weights)  # an array is a sequence of its rows
    tick_s = jnp.asarray(timing.tick_s, dtype)
    zero = jnp.zeros_like(scenario.omega)
    drop_tick = jnp.ceil(scenario.drop_time_s / tick_s - 1e-3)

    def ground_at(tick: jax.Array) -> jax.Array:
        return jnp.where(tick.astype(dtype) >= drop_tick, -scenario.drop_m, 0.0)

    def tick(lane_events: tuple[_Lane, _Events], index: jax.Array):
        lane, events = lane_events
        ground = ground_at(index)
        moment, contact, push = engine.integrator.tick(
            controller, body, rows, scenario.omega, lane.moment, ground, tick_s
        )
        phase = phase_of(controller, lane.moment.oscillator, zero)
        travel = phase_of(controller, moment.oscillator, zero) - phase
        if controller.oscillator is not None:
            moment = moment._replace(oscillator=controller.oscillator.settle(moment.oscillator))
        sound = ~lane.failed & ~body.failed(moment.body, ground)
        sound &= jnp.isfinite(body.height(moment.body)) & jnp.isfinite(travel)

        force = push.mean_n * contact.stance_share
        work = contact.work_j
        gains = _Totals(
            force * tick_s,
            jnp.maximum(work, 0.0),
            work,
            contact.climb_flight_m,
            contact.climb_m,
        )
        at = index.astype(dtype)
        apex = sound & ~jnp.isnan(contact.apex_share)
        touchdown = sound & ~jnp.isnan(contact.touchdown_share)
        events = _Events(
            jnp.where(apex, (at + contact.apex_share) * tick_s, events.apex_time),
            jnp.where(apex, contact.apex_height_m, events.apex_height),
            jnp.where(apex, phase + contact.apex_share * travel, events.apex_phase),
            jnp.where(touchdown, (at + contact.touchdown_share) * tick_s, events.touchdown_time),
        )
        advanced = _Lane(
            moment,
            jax.tree.map(jnp.add, lane.totals, gains),
            force,
            lane.failed,
        )
        # A lane that fails stands still from its last sound tick on.
        kept = jax.tree.map(lambda new, old: jnp.where(sound, new, old), advanced, lane)
        return (kept._replace(failed=~sound), events), None

    def frame(lane: _Lane, index: jax.Array):
        if on_cpu() and loops_are_kernels():
            index = _outside_of_kernels(index)
        none = jnp.full_like(zero, jnp.nan)
        first = index * timing.ticks_per_frame
        (lane, events), _ = jax.lax.scan(
            tick,
            (lane, _Events(none, none, none, none)),
            first + jnp.arange(timing.ticks_per_frame),
        )
        ground = ground_at(first + timing.ticks_per_frame - 1)
        moment, totals = lane.moment, lane.totals
        sensed = body.sense(moment.body, ground).values
        recorded = Trajectory(
            time_s=jnp.broadcast_to(
                (first + timing.ticks_per_frame).astype(dtype) * tick_s, zero.shape
            ),
            height_m=body.height(moment.body),
            velocity_m_per_s=body.velocity(moment.body),
            phase_rad=phase_of(controller, moment.oscillator, zero),
            spring_force_n=sensed.get("spring_force", zero),
            feedback_rad_per_s=moment.drive.feedback,
            actuator_force_n=lane.force,
            ground_m=ground,
            energy_j=body.energy(moment.body, ground),
            impulse_ns=totals.impulse,
            work_absolute_j=2.0 * totals.positive - totals.net,  # |x| = 2 max(0, x) - x
            work_positive_j=totals.positive,
            work_net_j=totals.net,
            climb_flight_m=totals.climb_flight,
            climb_m=totals.climb,
            apex_time_s=events.apex_time,
            apex_height_m=events.apex_height,
            apex_phase_rad=events.apex_phase,
            touchdown_time_s=events.touchdown_time,
            failed=lane.failed,
        )
        return lane, recorded

    start = body.release(scenario.height_m, scenario.velocity_m_per_s)
    oscillator = (
        () if controller.oscillator is None else controller.oscillator.start(scenario.phase_rad)
    )
    said = drive(
        controller, body, rows, scenario.omega, start, oscillator, ground_at(jnp.asarray(0))
    )
    lane = _Lane(
        Moment(start, oscillator, said, said),
        _Totals(zero, zero, zero, zero, zero),
        zero,
        ~jnp.isfinite(scenario.height_m + scenario.velocity_m_per_s + scenario.omega),
    )
    _, trajectory = jax.lax.scan(frame, lane, jnp.arange(timing.n_frames))
    return engine.summary(trajectory, scenario, body, timing)
