"""The subjects that this package simulates: the hopper, and a quadruped that walks."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.transforms import jit_with_static
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.retention import EVENT_SHARE
from tegotae.measures.objectives.fitness import EPISODE, Fitness, HopOutcome
from tegotae.measures.objectives.walking import Walking, WalkOutcome
from tegotae.parts.bodies import Body, Hopper, Walker
from tegotae.parts.channels import FOOT
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace
from tegotae.parts.terms.actuation import CommandedForce
from tegotae.parts.terrains import Flat, Slope, Sum
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, LoopState, Shared
from tegotae.simulation.integrators import Hold
from tegotae.simulation.loop import ClosedLoop
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.world import ground_m, whole_run
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.system import usual_system
from tegotae_robots.benchmark.subject import TRACKS, Driver, Entry, Subject, of_limbs, of_walk


@dataclass(frozen=True)
class CommandedFoot(CommandedForce):
    """A place of the foot from elsewhere: its weights are forward and up [m]."""

    COMMANDS = FOOT


@dataclass(frozen=True)
class SimulatedSubject(Subject):
    """A body of this package under commands that are held for a control tick.

    Observations are the body's senses, sense by sense and leg by leg; actions are its commands,
    command by command and leg by leg.
    """

    BODY: ClassVar[Any]
    """The body."""
    ACTUATION: ClassVar[CommandedForce]
    SENSES: ClassVar[Mapping[str, tuple[str, ...]]]
    """Names of the senses, by the track."""
    RELEASES: ClassVar[Mapping[str, tuple[float, float]]]
    """Ranges from which numbers of the release are drawn; a height is over the default one."""
    TIMING: ClassVar[Timing]
    """Timing of an episode."""
    OBJECTIVE: ClassVar[Any]
    """Objective of an episode, from the time at which it has settled on."""
    RANGE: ClassVar[tuple[float, float]]
    """Least and largest command."""

    @property
    def senses(self) -> Mapping[str, tuple[str, ...]]:
        return {x: of_limbs(self.SENSES[x], self.BODY.limbs) for x in TRACKS}

    @property
    def commands(self) -> tuple[str, ...]:
        return of_limbs(self.BODY.COMMANDS, self.BODY.limbs)

    @property
    def bounds(self) -> np.ndarray:
        return np.array(self.RANGE)[:, None]

    @property
    def step_s(self) -> float:
        return self.TIMING.tick_s

    @cached_property
    def tested(self) -> ControllersUnderTest:
        """The body under commands, as `tegotae robustness` tests it."""
        limbs = self.BODY.limbs
        sets = None if limbs == 1 else tuple(range(limbs))
        controller = Controller(self.ACTUATION, limbs=limbs, sharing=sets)
        default = usual_system(controller, self.BODY, None)
        system = dataclasses.replace(default, integrator=Hold(), timing=self.TIMING)
        runs = ControllerSet(self.NAME, system, np.zeros((1, controller.n_weights)), ("entry",))
        return ControllersUnderTest(runs, starts=self.starts, looked_at=self.TIMING)

    @property
    def simulated(self) -> Body:
        """The body inside the wrappers whose numbers conditions change."""
        return self.tested.prepared

    @abstractmethod
    def worth(self, outcome: Any, weight: np.ndarray) -> ArrayLike:
        """Return the score of every lane that did not fall, [lanes].

        Args:
            outcome: of the objective.
            weight: of the body over the usual one, [lanes].
        """

    def _release(self, scenario: Scenario) -> Scenario:
        """Return the scenario of its starts; a start is the same in all conditions."""
        drawn = np.random.default_rng(0).uniform(size=(len(self.RELEASES), self.starts))
        again, entries = np.shape(scenario.height_m)[-1] // self.starts, {}
        for (name, (low, high)), share in zip(self.RELEASES.items(), drawn, strict=True):
            value = np.float32(low + (high - low) * share)
            entries[name] = np.tile(value, again)
        height_m = scenario.height_m + entries.pop("height_m")
        velocity = entries.pop("velocity_m_per_s", scenario.velocity_m_per_s)
        return scenario._replace(height_m=height_m, velocity_m_per_s=velocity, initial_pose=entries)

    def scores(self, entry: Entry, track: str) -> np.ndarray:
        tested, timing, objective = self.tested, self.TIMING, self.OBJECTIVE
        event_s = np.full(self.starts, EVENT_SHARE * timing.duration_s)
        met = self.disturbances
        encounters = [tested.undisturbed(met), *tested.disturbed(met, event_s)]
        scenario = self._release(tested.scenario(met, encounters))
        count = np.shape(scenario.height_m)[-1]
        shared = Shared(self.simulated, np.float32(timing.tick_s))
        program = EpisodeProgram(ClosedLoop(tested.controller, Hold()), objective.needs)
        sensed, drive = self.SENSES[track], Driver(self, entry, count)
        alive = np.ones(count, bool)
        inputs = LaneInputs(np.zeros((tested.controller.n_weights, count), np.float32), scenario)
        # Feet begin where they are first commanded to be.
        observed, _ = _felt(sensed, inputs, shared, _begun(program, inputs, shared), np.int32(0))
        inputs = inputs._replace(weights=self._weights(drive(np.asarray(observed).T)))
        state, frames = _begun(program, inputs, shared), []
        for index in range(timing.n_frames * timing.ticks_per_frame):
            if index:
                inputs = inputs._replace(
                    weights=self._weights(drive(np.asarray(observed).T, alive))
                )
            tick: Any = np.int32(index)
            state = _ticked(program, inputs, shared, state, tick)
            observed, failed = _felt(sensed, inputs, shared, state, tick + np.int32(1))
            alive = ~np.asarray(failed)
            if (index + 1) % timing.ticks_per_frame == 0:
                state, frame = _recorded(program, inputs, shared, state, tick)
                frames.append(jax.tree.map(np.asarray, frame))
        path = jax.tree.map(lambda *x: np.stack(x), *frames)
        outcome = objective.outcome(path, scenario, self.simulated, timing)
        worth = self.worth(outcome, tested.weight_ratio(encounters))
        return np.where(alive, np.nan_to_num(worth), np.nan).reshape(-1, self.starts)

    def _weights(self, actions: np.ndarray) -> np.ndarray:
        """Return the actions [lanes, commands · limbs] as weights, set by set, [n_weights,
        lanes].
        """
        lanes, limbs = len(actions), self.BODY.limbs
        by_limb = np.reshape(actions, (lanes, -1, limbs)).swapaxes(1, 2)
        return np.ascontiguousarray(by_limb.reshape(lanes, -1).T, np.float32)


def _sense(
    names: tuple[str, ...], inputs: LaneInputs, shared: Shared, state: LoopState, index: Any
) -> tuple[jax.Array, jax.Array]:
    """Return the sensed values, [entries, lanes], and a mask of the lanes that have failed."""
    scenario, lane = inputs.scenario, state.lane
    body, _ = whole_run(shared.body, dict(scenario.changes))
    sensed = body.sense(lane.moment.body, ground_m(scenario, index, shared.tick_s)).values
    felt = jnp.stack([sensed[name] for name in names])
    return felt.reshape(-1, felt.shape[-1]), lane.failed


_begun = jit_with_static(EpisodeProgram.start, (0,))
_ticked = jit_with_static(EpisodeProgram.tick, (0,))
_recorded = jit_with_static(EpisodeProgram.frame, (0,))
_felt = jit_with_static(_sense, (0,))


_LOAD = ("spring_force",)


@dataclass(frozen=True)
class HopperSubject(SimulatedSubject):
    """The paper's hopper. The score of an episode is its efficiency, m g Σh / E: the weight times
    the height climbed in flight over the actuator's |work|, of the late whole hops."""

    NAME = "hopper"
    CONDITIONS = ("mass=0.7/1.5", "step=-0.5/0.2", "blow=-2/2", "delay=0.016", "noise=0.2")
    BODY: ClassVar = Hopper()
    TIMING = EPISODE
    OBJECTIVE = Fitness(settle_s=15.0)
    RANGE = (0.0, BODY.max_force_n)
    ACTUATION = CommandedForce()
    SENSES: ClassVar = {"load": _LOAD, "load+imu": (*_LOAD, "velocity"), "all": Hopper.SENSES}
    RELEASES: ClassVar = {"height_m": (-0.1, 0.3), "velocity_m_per_s": (-0.5, 0.5)}

    def worth(self, outcome: HopOutcome, weight: np.ndarray) -> ArrayLike:
        return np.asarray(outcome.cot_inverse[0]) * self.BODY.weight_n * weight


_TILT = ("pitch", "roll", "pitch_rate", "roll_rate", "side_roll", "side_roll_rate", "end_pitch")


@dataclass(frozen=True)
class QuadrupedSubject(SimulatedSubject):
    """The walker `quadruped-c`. The score of an episode is that of a walk (`of_walk`), at a wanted
    speed of 0.25 √(g l0)."""

    NAME = "quadruped"
    CONDITIONS = (
        *("mass=0.7/1.5", "friction=0.25", "slope=-0.1/0.1"),
        *("push-ahead=-0.6/0.6", "push-aside=0.6"),
    )
    BODY: ClassVar = Walker()
    TIMING = Timing(duration_s=100.0, tick_s=0.008, frame_s=0.08)
    SPEED: ClassVar[float] = 0.25
    OBJECTIVE = Walking(speed_m_per_s=SPEED, settle_s=62.48)
    RANGE = (-BODY.rest_length_m, BODY.rest_length_m)
    ACTUATION = CommandedFoot()
    SENSES: ClassVar = {"load": _LOAD, "load+imu": (*_LOAD, *_TILT), "all": Walker.SENSES}
    RELEASES: ClassVar = {
        "height_m": (0.0, 0.05),
        "roll_rad": (-0.05, 0.05),
        "pitch_rad": (-0.05, 0.05),
        "speed_m_per_s": (0.0, 0.2),
    }

    @property
    def simulated(self) -> Body:
        # Rough ground, which is not met here, would take nine tenths of the time.
        ground = Sum(first=Flat(), second=Sum(first=Slope(), second=Flat()))
        return replace(super().simulated, {"terrain": ground})

    def worth(self, outcome: WalkOutcome, weight: np.ndarray) -> ArrayLike:
        return of_walk(outcome.cot_inverse, outcome.speed_m_per_s, self.SPEED)
