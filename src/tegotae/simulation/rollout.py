"""Batched rollouts: every lane its own weights, frequency, release and ground, on all cores."""

from __future__ import annotations

import dataclasses
import math
import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, PartitionSpec

from tegotae._support.devices import (
    lane_devices,
    loops_are_kernels,
    on_cpu,
    set_up,
)
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import require_memory
from tegotae.lowering.tracing import traced
from tegotae.parts._shapes import Index, WeightMatrix, Weights
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.controller import Controller
from tegotae.parts.fields import path_of
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.loop import (
    ClosedLoop,
    Lane,
    Tick,
    check_senses,
)
from tegotae.simulation.recorder import RecordedFrame, Recorder, Trajectory
from tegotae.simulation.world import (
    Scenario,
    ground_m,
    map_change,
    whole_run,
)
from tegotae.simulation.world.changes import GROUND, OMEGA
from tegotae.simulation.world.checks import (
    check_changes,
    check_initial_pose,
    check_oscillator_state,
)

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


def whole_trajectory(
    trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
) -> Trajectory:
    """The trajectory as it is: the summary that keeps everything.

    Args:
        trajectory: what was recorded.
        scenario: the world of every lane.
        body: the body.
        timing: duration and periods.
    """
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
            with lanes x frames. It must be hashable (a function, or a frozen dataclass), and may
            say in `needs` which channels it reads; others are then not computed.

    Example:
        >>> from tegotae.systems.models import build
        >>> engine = Engine(controller=build("V-reflex-w8"))
        >>> out = engine.run(np.array([[2.0], [3.0]]), Scenario(omega=8.0))
        >>> out.height_m.shape
        (1000, 2)
    """

    controller: Controller
    integrator: Integrator = dataclasses.field(default_factory=PredictorCorrector)
    timing: Timing = dataclasses.field(default_factory=Timing)
    summary: Summary = whole_trajectory

    def recorder(self, body: Body) -> Recorder:
        """What is recorded on this body: what the summary says it needs, else everything.

        Raises:
            TegotaeError: if the summary needs a channel that nobody declares.
        """
        return Recorder.of(self.controller, body, getattr(self.summary, "needs", None))

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
            scenario: numbers, or arrays of shape [lanes] or [limbs, lanes] (`Scenario`).
            body: the body; the paper's hopper by default. Numbers of it that differ from lane to
                lane are the scenario's `changes`.
            dtype: "float32" or "float64".

        Raises:
            TegotaeError: for weights or a scenario of the wrong type or shape, a body that is
                none or does not go with the controller, a tick too long for it, a summary that
                needs an unknown channel, or more memory than there is.
        """
        set_up()
        body = Hopper() if body is None else body
        if dtype not in ("float32", "float64"):
            raise TegotaeError(f"dtype is {dtype!r}; it must be 'float32' or 'float64'")
        if not isinstance(body, Body):
            raise TegotaeError(f"body is {body!r}; it must be a Body, such as Hopper()")
        body.check_tick(self.timing.tick_s)
        check_senses(self.controller, body)
        check_initial_pose(body, scenario)
        check_changes(body, scenario, self.timing.tick_s, self.timing.duration_s)
        check_oscillator_state(
            self.controller.oscillator, scenario, self.timing.tick_s, self.timing.duration_s
        )
        self.recorder(body)
        with jax.enable_x64(dtype == "float64"):
            weights, scenario = _as_lanes(self.controller, body, weights, scenario, dtype)
            lanes = weights.shape[-1]
            _require_room(self, body, lanes, weights.dtype.itemsize)
            # Whole blocks: any other number of lanes that fills as many has the same program.
            given = jax.tree.map(partial(_filled, lanes=_Deal.of(lanes).total), (weights, scenario))
            body = jax.tree.map(lambda x: jnp.asarray(x, dtype), body)
            found = _run(self, *jax.tree.map(jnp.asarray, given), body, np.int32(lanes))
            return jax.tree.map(partial(_lanes_of, at=_Deal.of(lanes).place[:lanes]), found)

    def trace(
        self,
        weights: WeightMatrix,
        scenario: Scenario,
        body: Body,
        wanted: jax.Array | int | None = None,
    ) -> Any:
        """The same, for use inside a compiled program: weights [n_weights, lanes], arrays only.

        Args:
            weights: shape [n_weights, lanes].
            scenario: arrays of shape [lanes], or [limbs, lanes] (`Scenario`).
            body: the body.
            wanted: how many of the lanes are wanted, from the first on; all by default. Blocks of
                others cost nothing, and their summary is zero.
        """
        n_lanes = weights.shape[-1]
        deal = _Deal.of(n_lanes)

        def gathered(x: jax.Array) -> jax.Array:
            x = x.reshape(*x.shape[:-1], deal.devices, deal.blocks, deal.block).swapaxes(-2, -3)
            return x.reshape(*x.shape[:-3], deal.total)[..., :n_lanes]

        return jax.tree.map(gathered, self._dealt(weights, scenario, body, wanted))

    def _dealt(
        self,
        weights: WeightMatrix,
        scenario: Scenario,
        body: Body,
        wanted: jax.Array | int | None = None,
    ) -> Any:
        """As `trace`, but the lanes are as they were dealt out to the devices, and fill blocks."""
        n_lanes = weights.shape[-1]
        deal = _Deal.of(n_lanes)
        devices, blocks, block = lane_devices(), deal.blocks, deal.block

        def dealt(x: jax.Array) -> jax.Array:
            """Whole blocks, dealt out to the devices in turn."""
            fill = jnp.broadcast_to(x[..., -1:], (*x.shape[:-1], deal.total - n_lanes))
            x = jnp.concatenate([x, fill], axis=-1)
            x = x.reshape(*x.shape[:-1], blocks, len(devices), block)
            return x.swapaxes(-2, -3).reshape(*x.shape[:-3], deal.total)

        def on_device(weights: jax.Array, scenario: Scenario, wanted: jax.Array, body: Body) -> Any:
            def lanes_of(x: jax.Array, at: jax.Array) -> jax.Array:
                return jax.lax.dynamic_slice_in_dim(x, at * block, block, axis=-1)

            def advance(at: jax.Array, done: Any) -> Any:
                of_block = partial(lanes_of, at=at)
                part = advance_block(of_block(weights), jax.tree.map(of_block, scenario), body)
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

        def lanes_last(x: Any) -> PartitionSpec:
            return PartitionSpec(*[None] * (len(x.shape) - 1), "lanes")

        def of_a_block(x: jax.Array) -> jax.ShapeDtypeStruct:
            return jax.ShapeDtypeStruct((*x.shape[:-1], block), x.dtype)

        given = (weights, scenario)
        advance_block, shapes = traced(
            partial(_advance_block, self), *jax.tree.map(of_a_block, given), body
        )
        sharded = jax.shard_map(
            on_device,
            mesh=Mesh(np.array(devices), ("lanes",)),
            in_specs=(*jax.tree.map(lanes_last, given), PartitionSpec(), PartitionSpec()),
            out_specs=jax.tree.map(lanes_last, shapes),
            check_vma=False,
        )
        count = jnp.asarray(n_lanes if wanted is None else wanted, "int32")
        return sharded(dealt(weights), jax.tree.map(dealt, scenario), count, body)


@partial(jax.jit, static_argnums=0)
def _run(
    engine: Engine, weights: jax.Array, scenario: Scenario, body: Body, wanted: jax.Array
) -> Any:
    return engine._dealt(weights, scenario, body, wanted)


class _Deal(NamedTuple):
    """How lanes are dealt out: whole blocks in turn, as many to each device."""

    devices: int
    blocks: int
    """Blocks of a device."""
    block: int
    """Lanes of a block."""

    @classmethod
    def of(cls, lanes: int) -> _Deal:
        devices = len(lane_devices())
        per_device = -(-lanes // devices)
        block = _lanes_per_block() if on_cpu() else per_device
        return cls(devices, -(-per_device // block), block)

    @property
    def total(self) -> int:
        """Lanes with those that fill up blocks."""
        return self.devices * self.blocks * self.block

    @property
    def place(self) -> np.ndarray:
        """Where each lane is after it was dealt out, [total]."""
        places = np.arange(self.total).reshape(self.devices, self.blocks, self.block)
        return places.swapaxes(0, 1).reshape(self.total)


def _lanes_of(x: jax.Array, at: np.ndarray) -> np.ndarray:
    """Some lanes of an array that lies on several devices; no others are copied."""
    found = np.empty((*x.shape[:-1], len(at)), x.dtype)
    for shard in x.addressable_shards:
        first, last, _ = shard.index[-1].indices(x.shape[-1])
        here = (first <= at) & (at < last)
        if shard.replica_id == 0:
            found[..., here] = np.asarray(shard.data)[..., at[here] - first]
    return found


def _filled(x: np.ndarray, lanes: int) -> np.ndarray:
    """The same, with its last lane again until there are so many."""
    more = np.broadcast_to(x[..., -1:], (*x.shape[:-1], lanes - x.shape[-1]))
    return np.concatenate([x, more], axis=-1)


def _lanes_per_block() -> int:
    """Lanes advanced together on a CPU device.

    Few enough to stay in a core's cache, and enough to be worth the runtime's calls, of which a
    loop that is one kernel needs few. Always so many, the last ones filled up, so that a lane's
    arithmetic depends neither on its neighbours nor on how many devices share the work.
    """
    return 64 if loops_are_kernels() else 512


def _require_room(engine: Engine, body: Body, lanes: int, itemsize: int) -> None:
    """Raise `TegotaeError` if a rollout needs more memory than there is.

    Every device records the frames of the block that it is at. The few numbers of a summary are not
    counted; whole trajectories are, twice, while they are gathered.
    """
    limbs = math.prod(engine.controller.limb_shape)
    frame = float(itemsize) * len(engine.recorder(body).channels) * limbs
    deal = _Deal.of(lanes)
    at_work = deal.block * min(deal.devices, -(-lanes // deal.block))
    kept = 2 * deal.total if engine.summary is whole_trajectory else 0
    require_memory(
        (at_work + kept) * engine.timing.n_frames * frame,
        f"a rollout of {lanes} lanes and {engine.timing.n_frames} frames",
    )


def _as_lanes(
    controller: Controller, body: Body, weights: Any, scenario: Scenario, dtype: str
) -> tuple[np.ndarray, Scenario]:
    """Weights [n_weights, lanes] and a scenario of arrays [lanes], its changes named by paths."""
    weights = _numbers("weights", weights, dtype)
    if weights.ndim == 1:
        weights = weights[None, :]
    if weights.ndim != 2 or weights.shape[1] != controller.n_weights:
        raise TegotaeError(
            f"weights have shape {weights.shape}; this controller needs "
            f"[lanes, {controller.n_weights}]"
        )
    shape = controller.limb_shape

    def entry(name: str, value: Any) -> np.ndarray:
        return _entry(name, value, shape, dtype)

    entries = {name: entry(name, x) for name, x in scenario._asdict().items() if name not in _MORE}
    initial_pose = {name: entry(name, x) for name, x in dict(scenario.initial_pose).items()}
    oscillator_state = {name: entry(name, x) for name, x in dict(scenario.oscillator_state).items()}
    changes = {
        _path(body, name): map_change(partial(entry, name), change)
        for name, change in dict(scenario.changes).items()
    }
    whole = Scenario(
        **entries, initial_pose=initial_pose, oscillator_state=oscillator_state, changes=changes
    )
    sizes = [x.shape[-1:] for x in jax.tree.leaves(whole)]
    try:
        (lanes,) = np.broadcast_shapes((len(weights),), *sizes)
    except ValueError:
        shapes = ", ".join(str(x.shape) for x in jax.tree.leaves(whole))
        raise TegotaeError(
            f"weights for {len(weights)} lanes do not go with scenario entries of shapes {shapes}; "
            "each must be a number or have one entry per lane"
        ) from None
    columns = np.broadcast_to(weights, (lanes, weights.shape[1])).T

    def of_lanes(x: np.ndarray) -> np.ndarray:
        return np.broadcast_to(x, (*x.shape[:-1], lanes))

    return columns, jax.tree.map(of_lanes, whole)


def _path(body: Body, name: str) -> str:
    """What a change is called in a compiled program."""
    return name if name in (GROUND, OMEGA) else path_of(body, name)


_MORE = ("initial_pose", "oscillator_state", "changes")
"""Entries of a scenario that are made of several."""
_OF_BODY = ("height_m", "velocity_m_per_s", "drop_m", "drop_time_s")
"""Entries of which a body has one, however many limbs."""


def _numbers(name: str, value: Any, dtype: str) -> np.ndarray:
    try:
        return np.asarray(value, dtype)
    except (TypeError, ValueError):
        raise TegotaeError(
            f"{name} is {reprlib.repr(value)}; it must be a number or an array of numbers"
        ) from None


def _entry(name: str, value: Any, limb_shape: tuple[int, ...], dtype: str) -> np.ndarray:
    """An entry of a scenario as an array whose last axis is that of the lanes."""
    entry = _numbers(name, value, dtype)
    by_limb = name not in _OF_BODY and limb_shape == entry.shape[:-1]
    if entry.ndim > 1 and not by_limb:
        limbs = f" or [{limb_shape[0]}, lanes]" if limb_shape else ""
        raise TegotaeError(f"{name} has shape {entry.shape}; it must be a number, [lanes]{limbs}")
    return entry if entry.ndim else entry[None]


def _outside_of_kernels(index: jax.Array) -> jax.Array:
    """The same index, in a way that keeps a loop over it from becoming one CPU kernel.

    XLA makes one kernel of a small loop and all loops in it. That is what the ticks of a frame
    need; the loop over frames as one kernel would copy the record of all frames in each. XLA has no
    word for "not this one", but a sort cannot be part of such a kernel.
    """
    return jnp.sort(jnp.stack([index, index]))[0]


@partial(jax.jit, static_argnums=0, inline=True)
def _tick(loop: ClosedLoop, *given: Any) -> tuple[Lane, Tick]:
    """`ClosedLoop.tick`, traced once for all programs of a loop, and part of each as it is."""
    return loop.tick(*given)


def _advance_block(engine: Engine, weights: WeightMatrix, scenario: Scenario, body: Body) -> Any:
    """Roll out one block: weights [n_weights, block], scenario of [..., block] arrays."""
    timing, recorder = engine.timing, engine.recorder(body)
    loop = ClosedLoop(engine.controller, engine.integrator)
    dtype = weights.dtype
    body, changes = whole_run(body, dict(scenario.changes))
    steady = scenario._replace(changes=changes)
    tick_s = jnp.asarray(timing.tick_s, dtype)
    # An array is a sequence of its rows.
    rows, spread = loop.spread(cast(Weights, weights), steady)

    def tick(carry: Any, index: Index) -> Any:
        lane, totals, events = carry
        lane, output = _tick(loop, rows, body, spread, lane, index, tick_s)
        return (lane, recorder.add(totals, output), recorder.update(events, output)), None

    def frame(carry: Any, index: Index) -> Any:
        if on_cpu() and loops_are_kernels():
            index = _outside_of_kernels(index)
        lane, totals = carry
        first = index * timing.ticks_per_frame
        (lane, totals, events), _ = jax.lax.scan(
            tick, (lane, totals, no_events), first + jnp.arange(timing.ticks_per_frame)
        )
        last = first + timing.ticks_per_frame - 1
        ground = ground_m(scenario, last, tick_s)
        meanwhile, _ = loop.meets(body, spread, last, tick_s)
        time = (first + timing.ticks_per_frame).astype(dtype) * tick_s
        time = jnp.broadcast_to(time, scenario.height_m.shape)
        now = RecordedFrame(time, lane, ground, engine.controller, meanwhile)
        return (lane, totals), recorder.frame(now, totals, events)

    lane = loop.start(rows, body, spread, tick_s)
    no_totals, no_events = recorder.nothing(
        lambda: _tick(loop, rows, body, spread, lane, jnp.int32(0), tick_s)[1]
    )
    _, trajectory = jax.lax.scan(frame, (lane, no_totals), jnp.arange(timing.n_frames))
    return engine.summary(trajectory, scenario, body, timing)
