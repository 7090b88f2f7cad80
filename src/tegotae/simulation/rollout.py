"""Batched rollouts: every lane its own weights, frequency, release and ground, on all cores."""

from __future__ import annotations

import dataclasses
import math
import reprlib
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import numpy as np

from tegotae._support.engines import NATIVE, XLA, selected
from tegotae._support.errors import TegotaeError, require_kind
from tegotae._support.limits import require_memory
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.controller import Controller
from tegotae.parts.fields import path_of
from tegotae.simulation import native, xla
from tegotae.simulation.draws import check_scenario
from tegotae.simulation.episode import EpisodeProgram, LaneInputs
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.loop import ClosedLoop, check_senses
from tegotae.simulation.schedules import mapped_change
from tegotae.simulation.summaries import KeptChannels, Summary, whole_trajectory
from tegotae.simulation.timing import Timing
from tegotae.simulation.world import GROUND, OMEGA, Scenario


@dataclass(frozen=True, kw_only=True)
class Rollout:
    """Rollout of many lanes: the static part of the compiled program that advances them.

    Args:
        controller: what drives the body.
        integrator: how controller and body advance by one tick.
        timing: duration, control period, recording period.
        summary: function of (trajectory, scenario, body, timing) to a pytree of arrays, lanes last,
            run on the device block by block: only what it returns is kept, so memory does not grow
            with lanes x frames. It must be hashable (a function, or a frozen dataclass), and may
            say in `needs` which channels it reads; others are then not computed.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> rollout = Rollout(controller=recipe("V-reflex-w8").controller())
        >>> out = rollout.run(np.array([[2.0], [3.0]]), Scenario(omega=8.0))
        >>> out.height_m.shape
        (1000, 2)
    """

    controller: Controller
    integrator: Integrator = dataclasses.field(default_factory=PredictorCorrector)
    timing: Timing = dataclasses.field(default_factory=Timing)
    summary: Summary = whole_trajectory

    @property
    def program(self) -> EpisodeProgram:
        """The parts of the rollout that shape the code of a tick."""
        needs = getattr(self.summary, "needs", None)
        loop = ClosedLoop(self.controller, self.integrator)
        return EpisodeProgram(loop, None if needs is None else tuple(needs))

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
        body = Hopper() if body is None else body
        if dtype not in ("float32", "float64"):
            raise TegotaeError(f"dtype is {dtype!r}; it must be 'float32' or 'float64'")
        require_kind("body", body, Body, "a Body, such as Hopper()")
        body.check_tick(self.timing.tick_s)
        check_senses(self.controller, body)
        check_scenario(scenario, body, self.controller.oscillator, self.timing)
        self.program.recorder(body)
        lanes = as_lanes(self.controller, body, weights, scenario, dtype)
        _require_room(self, body, lanes.weights)
        return self.run_lanes(lanes, body)

    def run_lanes(self, lanes: LaneInputs, body: Body) -> Any:
        """Roll out checked arrays, or those that a program makes, lanes last.

        Args:
            lanes: NumPy arrays of one type, float32 or float64; of each as many lanes.
            body: the body.
        """
        dtype = lanes.weights.dtype
        body = native.with_numpy_numbers(body, dtype)
        inputs = self.program, self.timing, self.summary, lanes, body
        if self.runs_on(lanes, body) == NATIVE:
            return native.roll_out_native(*inputs)
        with jax.enable_x64(dtype == "float64"):
            return xla.roll_out_xla(*inputs)

    def runs_on(self, lanes: LaneInputs, body: Body) -> str:
        """Return the engine that runs it: "native", "xla", or "native, xla for OPERATION".

        The latter is XLA where native code is asked for, and there is none for an operation of the
        program; it is warned of once.

        Args:
            lanes: such as it is run with; how many there are does not matter.
            body: the body.
        """
        if selected() != NATIVE:
            return selected()
        operation = native.cannot_lower(self.program, lanes, body)
        return f"{NATIVE}, {XLA} for {operation}" if operation else NATIVE


def _require_room(rollout: Rollout, body: Body, weights: np.ndarray) -> None:
    """Raise `TegotaeError` if a rollout needs more memory than there is.

    The few numbers of a summary are not counted; whole trajectories are, and with XLA once more
    while they are gathered.
    """
    lanes, timing = weights.shape[-1], rollout.timing
    limbs = math.prod(rollout.controller.limb_shape)
    frame = float(weights.itemsize) * len(rollout.program.recorder(body).channels) * limbs
    recorded_lanes = lanes if isinstance(rollout.summary, KeptChannels) else 0
    if selected() != NATIVE:
        recorded_lanes = 2 * recorded_lanes + xla.lanes_of_a_block(lanes)
    require_memory(
        recorded_lanes * timing.n_frames * frame,
        f"a rollout of {lanes} lanes and {timing.n_frames} frames",
    )


def as_lanes(
    controller: Controller, body: Body, weights: Any, scenario: Scenario, dtype: str
) -> LaneInputs:
    """Return weights [n_weights, lanes] and a scenario of arrays [lanes], its changes named by
    paths.

    Args:
        controller: whose weights.
        body: the body.
        weights: shape [lanes, n_weights] or [n_weights].
        scenario: numbers, or arrays of shape [lanes] or [limbs, lanes].
        dtype: the type of all arrays.

    Raises:
        TegotaeError: for what is no number, of another shape, or of another number of lanes.
    """
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
        _path(body, name): mapped_change(partial(entry, name), change)
        for name, change in dict(scenario.changes).items()
    }
    combined = Scenario(
        **entries, initial_pose=initial_pose, oscillator_state=oscillator_state, changes=changes
    )
    sizes = [x.shape[-1:] for x in jax.tree.leaves(combined)]
    try:
        (lanes,) = np.broadcast_shapes((len(weights),), *sizes)
    except ValueError:
        shapes = ", ".join(str(x.shape) for x in jax.tree.leaves(combined))
        raise TegotaeError(
            f"weights for {len(weights)} lanes do not go with scenario entries of shapes {shapes}; "
            "each must be a number or have one entry per lane"
        ) from None
    columns = np.broadcast_to(weights, (lanes, weights.shape[1])).T

    def of_lanes(x: np.ndarray) -> np.ndarray:
        return np.broadcast_to(x, (*x.shape[:-1], lanes))

    return LaneInputs(columns, jax.tree.map(of_lanes, combined))


def _path(body: Body, name: str) -> str:
    """Return the path of a change in a compiled program."""
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
    """Return an entry of a scenario as an array whose last axis is that of the lanes."""
    entry = _numbers(name, value, dtype)
    by_limb = name not in _OF_BODY and limb_shape == entry.shape[:-1]
    if entry.ndim > 1 and not by_limb:
        limbs = f" or [{limb_shape[0]}, lanes]" if limb_shape else ""
        raise TegotaeError(f"{name} has shape {entry.shape}; it must be a number, [lanes]{limbs}")
    return entry if entry.ndim else entry[None]
