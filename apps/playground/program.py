"""The package's own closed loop as a program: its release, its tick, its record, its surface."""

from __future__ import annotations

import dataclasses
import inspect
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from apps.playground.layout import Layout, LayoutEntry, merge_layouts
from apps.playground.stopped import Stoppable
from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import ArrayTree, Weights
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.parameters import changed
from tegotae.simulation.integrators import PredictorCorrector, TickSetting
from tegotae.simulation.loop import (
    ClosedLoop,
    Lane,
    Tick,
    check_senses,
)
from tegotae.simulation.recorder import RecordedFrame, Recorder
from tegotae.simulation.world import Scenario

RELEASE = ("height_m", "velocity_m_per_s")
"""Entries of every body's release."""


class Now(NamedTuple):
    """The whole state of a lane, as arrays of one lane."""

    lane: Lane
    totals: dict[str, jax.Array]
    events: dict[str, jax.Array]


@dataclass(frozen=True)
class Program:
    """A controller on a body, with weights, numbers of the body and scenario as data.

    What runs is `ClosedLoop` under the usual integrator, and what is recorded of it are the
    channels of `Recorder`, so that a page sees what a rollout records.

    Args:
        controller: the structure, a unit for every limb of the body.
        body: the kind of body; its numbers are only those that a page begins with.

    Raises:
        TegotaeError: for a controller that does not go with the body.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> from tegotae.systems.recipe import recipe
        >>> Program(recipe("V-reflex-w8").controller(), Hopper()).layout.document()["body.mass_kg"]
        [2, 1]
    """

    controller: Controller
    body: Body

    def __post_init__(self) -> None:
        check_senses(self.controller, self.body)
        if not self.controller.actuation.commands_force:
            raise TegotaeError(
                f"a playground has bodies whose legs push; "
                f"{type(self.controller.actuation).__name__} places feet"
            )

    @property
    def limbs(self) -> int:
        """Number of limbs."""
        return self.body.limbs

    @cached_property
    def numbers(self) -> dict[str, float | tuple[float, ...]]:
        """Numbers of the body that are data, by name, without the places of its hips."""
        return {
            name: value
            for name, value in vars(self.body).items()
            if isinstance(value, (int, float)) or (value is not None and name == "present")
        }

    @cached_property
    def pose_names(self) -> tuple[str, ...]:
        """Further entries of the body's release: numbers alone, without a twist for a plate
        that has none.
        """
        takes = inspect.signature(self.body.release).parameters
        return tuple(name for name in self.body.pose_names if takes[name].default is not None)

    @cached_property
    def inputs(self) -> tuple[LayoutEntry, ...]:
        """Inputs from the page: weights, the body's numbers, frequency, world, release."""
        limbs = self.limbs
        return (
            LayoutEntry("weights", self.controller.n_weights),
            LayoutEntry("omega", limbs),
            *(LayoutEntry(f"body.{n}", np.size(value)) for n, value in self.numbers.items()),
            LayoutEntry("ground_m", 1),
            LayoutEntry("tick_s", 1),
            LayoutEntry("moving", 1),
            *(LayoutEntry(f"release.{name}", 1) for name in (*RELEASE, *self.pose_names)),
            LayoutEntry("release.phase_rad", limbs),
        )

    @cached_property
    def _recorder(self) -> Recorder:
        return Recorder.for_loop(self.controller, self.body)

    @cached_property
    def shapes(self) -> tuple[Now, dict[str, jax.Array]]:
        """A `Now`, and the channels recorded of it, as shapes."""

        def all_of(inputs: dict[str, jax.Array]) -> tuple[Now, dict[str, jax.Array]]:
            lane = self.released(inputs)
            return lane, self.recorded(inputs, jnp.asarray(0), lane)

        arrays = {e.name: jax.ShapeDtypeStruct(self.shape_of(e), jnp.float32) for e in self.inputs}
        with jax.enable_x64(False):
            return jax.eval_shape(all_of, arrays)

    def shape_of(self, entry: LayoutEntry) -> tuple[int, ...]:
        """Return the shape of a page's input, as an array of one lane."""
        if entry.name == "weights":
            return (entry.words, 1)
        if entry.name == "tick_s":
            return ()
        return (entry.words, 1) if self._is_per_limb(entry.name) else (1,)

    def _is_per_limb(self, name: str) -> bool:
        return self.limbs > 1 and name in ("omega", "release.phase_rad", "body.present")

    @cached_property
    def state(self) -> tuple[LayoutEntry, ...]:
        """State that a tick hands to the next."""
        return _entries("state", self.shapes[0])

    @cached_property
    def channels(self) -> tuple[LayoutEntry, ...]:
        """The recording of a frame."""
        return _entries("channel", self.shapes[1])

    @cached_property
    def layout(self) -> Layout:
        """The block of a lane."""
        return merge_layouts(
            (self.inputs, (LayoutEntry("ticks", 1, "int32"),), self.state, self.channels)
        )

    def _setting(
        self, inputs: dict[str, jax.Array]
    ) -> tuple[tuple[ClosedLoop, Weights], Body, Scenario, Controller]:
        """Return loop, body and scenario from the page's input."""
        controller = self.controller
        if controller.oscillator is not None:
            moving = inputs["moving"] > 0.5
            controller = dataclasses.replace(
                controller, oscillator=Stoppable(controller.oscillator, moving)
            )
        body = self.body
        for name in self.numbers:
            body = changed(body, name, lambda _, value=inputs[f"body.{name}"]: value)
        initial_pose = {name: inputs[f"release.{name}"] for name in self.pose_names}
        scenario = Scenario(
            omega=inputs["omega"],
            height_m=inputs["release.height_m"],
            velocity_m_per_s=inputs["release.velocity_m_per_s"],
            phase_rad=inputs["release.phase_rad"],
            drop_m=-inputs["ground_m"],
            drop_time_s=jnp.zeros((1,), jnp.float32),
            initial_pose=initial_pose,
        )
        loop = ClosedLoop(controller, PredictorCorrector())
        weights, scenario = loop.spread(list(inputs["weights"]), scenario)
        return (loop, weights), body, scenario, controller

    def released(self, inputs: dict[str, jax.Array]) -> Now:
        """Return the lane at its release, with zero totals."""
        (loop, weights), body, scenario, _ = self._setting(inputs)
        lane = loop.start(weights, body, scenario, inputs["tick_s"])

        def tick() -> Tick:
            index = jnp.asarray(0)
            return loop.tick(weights, body, scenario, lane, index, inputs["tick_s"])[1]

        return Now(lane, *self._recorder.empty(tick))

    def ticked(self, inputs: dict[str, jax.Array], index: jax.Array, state: Now) -> Now:
        """Return the lane a control tick later."""
        (loop, weights), body, scenario, _ = self._setting(inputs)
        lane, output = loop.tick(weights, body, scenario, state.lane, index, inputs["tick_s"])
        record = self._recorder
        return Now(lane, record.add(state.totals, output), record.update(state.events, output))

    def recorded(
        self, inputs: dict[str, jax.Array], ticks: jax.Array, state: Now
    ) -> dict[str, jax.Array]:
        """Return the channels of a lane."""
        _, body, _, controller = self._setting(inputs)
        time = ticks.astype(jnp.float32) * inputs["tick_s"]
        frame = RecordedFrame(time, state.lane, inputs["ground_m"], controller, body)
        return dict(self._recorder.frame(frame, state.totals, state.events).channels)

    def answer(
        self, inputs: dict[str, jax.Array], phase: jax.Array, spring: jax.Array, velocity: jax.Array
    ) -> jax.Array:
        """Return `analysis.actuation_surface` at one point, all legs alike and the frame level."""
        (_, weights), body, scenario, controller = self._setting(inputs)
        height = body.rest_length_m - spring / inputs["body.stiffness_n_per_m"]
        state = body.release(height, velocity)
        angle = jnp.broadcast_to(phase, (*controller.limb_shape, 1))
        rhythm = () if controller.oscillator is None else controller.oscillator.start(angle)
        ground = jnp.zeros((1,), jnp.float32)
        setting = TickSetting(controller, body, weights, scenario.omega, ground, inputs["tick_s"])
        mean = setting.push(setting.drive(state, rhythm).command, angle, angle).mean_n
        return mean if self.limbs == 1 else mean[0]


def _entries(prefix: str, tree: ArrayTree) -> tuple[LayoutEntry, ...]:
    """Return an entry for every leaf, named by its path."""

    def size(leaf: jax.Array) -> int:
        return int(np.prod(leaf.shape, dtype=int))

    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return tuple(
        LayoutEntry(".".join((prefix, *map(_key, path))), size(leaf), str(leaf.dtype))
        for path, leaf in leaves
    )


def _key(key: object) -> str:
    return str(getattr(key, "name", getattr(key, "key", getattr(key, "idx", key))))
