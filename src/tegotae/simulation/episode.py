"""An episode as three functions of the lanes: the one program that every engine runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp

from tegotae._support.transforms import jit_with_static
from tegotae.parts._shapes import Index, Weights
from tegotae.parts.bodies import Body
from tegotae.simulation.loop import ClosedLoop, Lane, Tick
from tegotae.simulation.recorder import RecordedFrame, Recorder, Trajectory
from tegotae.simulation.world import Scenario, ground_m, whole_run


class LaneInputs(NamedTuple):
    """Inputs of each lane: arrays, lanes last."""

    weights: Any
    """[n_weights, lanes]."""
    scenario: Scenario
    """Entries of shape [lanes] or [limbs, lanes]."""


class Shared(NamedTuple):
    """Inputs that all lanes share."""

    body: Body
    """The body, a pytree of numbers."""
    tick_s: Any
    """The control period [s]."""


class LoopState(NamedTuple):
    """State carried from one control tick to the next."""

    lane: Lane
    totals: dict[str, jax.Array]
    """Totals since the release."""
    events: dict[str, jax.Array]
    """The last of their kind in the frame; NaN before it."""


@dataclass(frozen=True)
class EpisodeProgram:
    """A controller, its integrator and the recorded channels: all that shapes the code of a tick.

    How many ticks and frames there are does not.

    Args:
        loop: controller and body, and how both advance by a tick.
        needs: the channels that are recorded; all if None.
    """

    loop: ClosedLoop
    needs: tuple[str, ...] | None

    def recorder(self, body: Body) -> Recorder:
        """Return the recorder of the channels on a body.

        Raises:
            TegotaeError: for a channel that is needed and not declared.
        """
        return Recorder.for_loop(self.loop.controller, body, self.needs)

    def start(self, lanes: LaneInputs, shared: Shared) -> LoopState:
        """Release the lanes, with nothing recorded."""
        rows, body, scenario = _spread(self.loop, lanes, shared)
        lane = self.loop.start(rows, body, scenario, shared.tick_s)
        inputs = rows, body, scenario, lane, jnp.int32(0), shared.tick_s
        return LoopState(lane, *self.recorder(body).empty(lambda: _tick(self.loop, *inputs)[1]))

    def tick(self, lanes: LaneInputs, shared: Shared, state: LoopState, index: Index) -> LoopState:
        """Return the lanes after a control tick, with its additions to the totals, and its
        events.
        """
        rows, body, scenario = _spread(self.loop, lanes, shared)
        lane, output = _tick(self.loop, rows, body, scenario, state.lane, index, shared.tick_s)
        recorder = self.recorder(body)
        totals = recorder.add(state.totals, output)
        return LoopState(lane, totals, recorder.update(state.events, output))

    def frame(
        self, lanes: LaneInputs, shared: Shared, state: LoopState, last: Index
    ) -> tuple[LoopState, Trajectory]:
        """Return the recording of the frame that ends with tick `last`, and the state to continue
        from.
        """
        _, body, scenario = _spread(self.loop, lanes, shared)
        ground = ground_m(scenario, last, shared.tick_s)
        meanwhile, _ = self.loop.meets(body, scenario, last, shared.tick_s)
        time = (last + 1).astype(shared.tick_s.dtype) * shared.tick_s
        time = jnp.broadcast_to(time, scenario.height_m.shape)
        moment = RecordedFrame(time, state.lane, ground, self.loop.controller, meanwhile)
        recorded = self.recorder(body).frame(moment, state.totals, state.events)
        none = {name: jnp.full_like(x, jnp.nan) for name, x in state.events.items()}
        return state._replace(events=none), recorded


def _spread(loop: ClosedLoop, lanes: LaneInputs, shared: Shared) -> tuple[Weights, Body, Scenario]:
    """Return weights limb by limb, the body with the changes of the whole run, and the scenario."""
    body, changes = whole_run(shared.body, dict(lanes.scenario.changes))
    # An array is a sequence of its rows.
    weights, scenario = cast(Weights, lanes.weights), lanes.scenario._replace(changes=changes)
    weights, scenario = loop.spread(weights, scenario)
    return weights, body, scenario


def _advanced(loop: ClosedLoop, *inputs: Any) -> tuple[Lane, Tick]:
    return loop.tick(*inputs)


_tick = jit_with_static(_advanced, (0,), inline=True)
"""`ClosedLoop.tick`, traced once for all programs of a loop, and part of each as it is."""
