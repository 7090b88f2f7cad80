"""The hopper in an environment: steps, apexes, episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_count
from tegotae.envs.settings import HopperSettings, HopReward
from tegotae.measures.hopping.hopping import dies_out, hop_height_m, left_out
from tegotae.measures.hopping.signals import cot_inverse
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import Hold, phase_of, signals
from tegotae.simulation.loop import ClosedLoop, Lane, keep
from tegotae.simulation.world import Scenario, ground_m


class Apexes(NamedTuple):
    """Totals at the apexes of hops so far, from which CoT⁻¹ over whole hops is computed.

    The same hops count as in a recording of the same frames
    (`tegotae.measures.hopping.hopping.whole_hops`).

    Example:
        >>> apexes = Apexes.none(jnp.zeros(1))
        >>> for time_s in jnp.array([[1.0], [2.0], [3.0]]):
        ...     apexes = apexes.updated(time_s > 0.0, time_s, 0.5 * time_s, 2.0 * time_s)
        >>> apexes.cot_inverse(jnp.array([3.2])).tolist()
        [0.25]
    """

    n_apexes: jax.Array
    """Number of apexes, [lanes]."""
    first: jax.Array
    """Climbed height [m] and work [J] at the first, [2, lanes]."""
    second: jax.Array
    """The same at the second."""
    last: jax.Array
    """The same at the last."""
    last_s: jax.Array
    """Time of the last [s], [lanes]; minus infinity before any."""

    @classmethod
    def none(cls, like: jax.Array) -> Apexes:
        """Return the record before any apex, of the shape of an array."""
        zeros = jnp.zeros((2, *like.shape), like.dtype)
        count = jnp.zeros(like.shape, jnp.int32)
        return cls(count, zeros, zeros, zeros, jnp.full_like(like, -jnp.inf))

    def updated(
        self, apex: jax.Array, time_s: jax.Array, climb_m: jax.Array, work_j: jax.Array
    ) -> Apexes:
        """Return the totals after a tick.

        Args:
            apex: where the tick has the apex of a hop, [lanes].
            time_s: time at the tick's end [s], [lanes].
            climb_m: height climbed in flight since the release [m], [lanes].
            work_j: work since the release [J], [lanes].
        """
        values = jnp.stack([climb_m, work_j])
        return Apexes(
            jnp.where(apex, self.n_apexes + 1, self.n_apexes),
            jnp.where(apex & (self.n_apexes == 0), values, self.first),
            jnp.where(apex & (self.n_apexes == 1), values, self.second),
            jnp.where(apex, values, self.last),
            jnp.where(apex, time_s, self.last_s),
        )

    def cot_inverse(self, now_s: jax.Array) -> jax.Array:
        """Return CoT⁻¹ over whole hops [m/J], [lanes]: 0 without any, or where hopping has died
        out.
        """
        hops = self.n_apexes - 1
        begin = jnp.where(left_out(hops) > 0, self.second, self.first)
        climb_m, work_j = self.last - begin
        goes_on = (hops > 0) & ~dies_out(self.last_s, now_s)
        return jnp.where(goes_on, cot_inverse(climb_m, work_j), 0.0)


_SENSE_BOUND = 1e3
"""Observations are clipped to this many times their scale, far beyond what a leg survives."""

TELEMETRY = (
    "time_s",
    "height_m",
    "velocity_m_per_s",
    "ground_m",
    "phase_rad",
    "feedback_rad_per_s",
    "actuator_force_n",
    "work_j",
    "climb_flight_m",
    "cot_inverse",
    "hops",
)
"""Entries of `info`, in this order: position of the hopper, quantities of the last tick, totals of
the episode, and `cot_inverse`, over the whole hops of the episode's second half up to now: 0 before
there is one, and for a gait that has died out. `hops` is the number of rewarded hops."""


class _Ledger(NamedTuple):
    """Sums kept for the reward, each of shape [lanes]."""

    climb: jax.Array
    work: jax.Array
    energy: jax.Array
    total_climb: jax.Array
    total_work: jax.Array
    total_reward: jax.Array
    hops: jax.Array
    apexes: Apexes


class Episodes(NamedTuple):
    """State of every lane's episode."""

    lane: Lane
    scenario: Scenario
    tick: jax.Array
    ledger: _Ledger


class _Numbers(NamedTuple):
    """The settings that are arguments of the compiled program."""

    body: Body
    tick_s: jax.Array
    decimation: jax.Array
    n_ticks: jax.Array
    action_scale: jax.Array


@dataclass(frozen=True)
class _CompiledSettings:
    """The settings that shape the compiled program."""

    controller: Controller
    observed: tuple[str, ...]
    dimensionless: bool
    reward: HopReward

    @property
    def loop(self) -> ClosedLoop:
        """Controller and body; the controller is sampled and held."""
        return ClosedLoop(self.controller, Hold())


class EnvStep(NamedTuple):
    """Result of a step of the agent, NumPy arrays with lanes first."""

    observation: np.ndarray
    """Shape [lanes, entries]."""
    reward: np.ndarray
    """Shape [lanes]."""
    terminated: np.ndarray
    """True where the leg has no length left, shape [lanes]."""
    truncated: np.ndarray
    """True where the time is up, shape [lanes]."""
    telemetry: np.ndarray
    """Shape [lanes, len(TELEMETRY)]."""

    def info(self, lane: int) -> dict[str, float]:
        """Return the telemetry of a lane, by name."""
        return dict(zip(TELEMETRY, self.telemetry[lane].tolist(), strict=True))


class Hoppers:
    """A batch of hopper environments, without any interface.

    Lane i seeded with s draws what a single environment draws that was reset with seed s: a batch
    is so many single environments, to the last random number.

    Args:
        settings: what the environments are.
        lanes: how many.

    Raises:
        TegotaeError: for a number of lanes below one.

    Example:
        >>> hoppers = Hoppers(HopperSettings(), lanes=2)
        >>> hoppers.reset(options={"height_m": [1.1, 1.3]}).observation.shape
        (2, 2)
        >>> hoppers.step(np.zeros((2, 1))).truncated
        array([False, False])
    """

    def __init__(self, settings: HopperSettings, lanes: int) -> None:
        require_count("num_envs", lanes)
        self.settings, self.lanes = settings, lanes
        self.random: list[np.random.Generator | None] = [None] * lanes
        """What each lane draws its episodes with; None for one that is yet to be seeded."""
        self._fixed = None if settings.draws else settings.scenario(None)
        self._program = _CompiledSettings(
            settings.controller, settings.observed, settings.dimensionless, settings.reward
        )
        self._numbers = _Numbers(
            jax.tree.map(_single, settings.body),
            _single(settings.tick_s),
            jnp.asarray(settings.decimation, jnp.int32),
            jnp.asarray(settings.n_steps * settings.decimation, jnp.int32),
            _single(settings.action_scale),
        )
        self._episodes: Episodes | None = None

    def seed(
        self, seed: int | Sequence[int | None] | None, where: np.ndarray | None = None
    ) -> None:
        """Seed lane i with `seed + i`, or each with its own; None leaves a lane as it is.

        Raises:
            TegotaeError: for a list of seeds that has not one per lane.
        """
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + i for i in range(self.lanes)]
        else:
            seeds = seed
        if len(seeds) != self.lanes:
            raise TegotaeError(
                f"there are {len(seeds)} seeds for {self.lanes} lanes; give one per lane"
            )
        if self._fixed is not None:
            return
        for lane, number in enumerate(seeds):
            if number is not None and (where is None or where[lane]):
                self.random[lane], _ = seeding.np_random(number)

    def reset(
        self,
        where: np.ndarray | None = None,
        options: Mapping[str, ArrayLike] | None = None,
    ) -> EnvStep:
        """Start new episodes in all lanes, or in those of the mask `where`; other lanes draw no
        numbers.

        What it returns speaks of all lanes, as they now are; there are no rewards in it.

        Args:
            where: which lanes begin an episode, [lanes]; all by default, and of the first one.
            options: numbers by name, or arrays of shape [lanes], that stand for these episodes.

        Raises:
            TegotaeError: for an option that is no setting of an episode, or of another shape.
        """
        scenarios = self._scenarios(where, options or {})
        arrays = jax.tree.map(lambda *entries: np.array(entries, np.float32), *scenarios)
        arrays = jax.tree.map(lambda x: np.broadcast_to(x, (self.lanes,)), arrays)
        if self._episodes is None or where is None:
            self._episodes, packed = _start(self._program, self._numbers, arrays)
        else:
            self._episodes, packed = _restart(
                self._program, self._numbers, arrays, self._episodes, where
            )
        return self._unpack(packed)

    def _scenarios(
        self, where: np.ndarray | None, options: Mapping[str, ArrayLike]
    ) -> list[Scenario]:
        """Draw the scenario of each lane's next episode."""
        if self._fixed is not None and not options:
            return [self._fixed] * self.lanes
        columns: dict[str, list[float]] = {}
        for name, value in options.items():
            array = np.asarray(value)
            if array.shape not in ((), (self.lanes,)):
                raise TegotaeError(
                    f"option {name} has shape {array.shape}; it must be a number or have shape "
                    f"({self.lanes},)"
                )
            columns[name] = np.broadcast_to(array, (self.lanes,)).tolist()
        scenarios = [self._fixed or Scenario(omega=0.0)] * self.lanes
        for lane in range(self.lanes) if where is None else np.flatnonzero(where).tolist():
            if self._fixed is None and self.random[lane] is None:
                self.random[lane], _ = seeding.np_random()
            of_lane = {name: column[lane] for name, column in columns.items()}
            scenarios[lane] = self.settings.scenario(self.random[lane], of_lane)
        return scenarios

    def step(self, actions: np.ndarray) -> EnvStep:
        """Hold the actions, shape [lanes, 1], for one step of the agent.

        Raises:
            TegotaeError: before the first `reset`, or for actions of another shape or that are not
                finite.
        """
        actions = np.asarray(actions, np.float32)
        if actions.shape != (self.lanes, 1):
            raise TegotaeError(
                f"the actions have shape {actions.shape}; they must be ({self.lanes}, 1)"
            )
        if self._episodes is None:
            raise TegotaeError("the environment has no episode yet; call reset() before step()")
        if not np.isfinite(actions).all():
            raise TegotaeError("an action is not finite; actions are numbers in [-1, 1]")
        self._episodes, packed = _advance(
            self._program, self._numbers, self._episodes, actions[:, 0]
        )
        return self._unpack(packed)

    def _unpack(self, packed: jax.Array) -> EnvStep:
        rows = np.asarray(packed)
        n = len(self._program.observed)
        return EnvStep(
            rows[:n].T.copy(),
            rows[n].copy(),
            rows[n + 1] > 0.0,
            rows[n + 2] > 0.0,
            rows[n + 3 :].T,
        )


def action_space() -> Box:
    """Return the space of actions: one number in [-1, 1]."""
    return Box(-1.0, 1.0, (1,), np.float32)


def observation_space(settings: HopperSettings) -> Box:
    """Return the space of observations: the observed entries within their bounds."""
    body = settings.body
    at_rest = body.release(jnp.ones(()), jnp.zeros(()))
    scales = {} if settings.dimensionless else body.sense(at_rest, jnp.zeros(())).scales
    largest = {name: _SENSE_BOUND * float(scales.get(name, 1.0)) for name in settings.observed}
    largest |= dict.fromkeys(largest.keys() & {"sin_phase", "cos_phase"}, 1.0)
    bounds = np.array([largest[name] for name in settings.observed], np.float32)
    # A little more than what is clipped to, and than the rounded sine of a right angle.
    bounds *= np.float32(1.0 + 1e-6)
    one_sided = np.array([name == "spring_force" for name in settings.observed])
    return Box(np.where(one_sided, np.float32(0.0), -bounds), bounds, dtype=np.float32)


def _single(value: ArrayLike) -> jax.Array:
    return jnp.asarray(value, jnp.float32)


_compiled = partial(jax.jit, static_argnums=0)
"""Functions of a program are shared by all environments that are alike."""


@_compiled
def _start(
    program: _CompiledSettings, numbers: _Numbers, scenario: Scenario
) -> tuple[Episodes, jax.Array]:
    """Start new episodes in every lane."""
    body = numbers.body
    scenario = jax.tree.map(jnp.asarray, scenario)
    zero = jnp.zeros_like(scenario.omega)
    lane = program.loop.start((zero,), body, scenario, numbers.tick_s)
    ground = ground_m(scenario, jnp.asarray(0), numbers.tick_s)
    energy = body.energy(lane.moment.body, ground)
    episodes = Episodes(
        lane._replace(failed=body.failed(lane.moment.body, ground)),
        scenario,
        jnp.zeros(zero.shape, jnp.int32),
        _Ledger(zero, zero, energy, zero, zero, zero, zero, Apexes.none(zero)),
    )
    return episodes, _report(program, numbers, episodes, zero)


@_compiled
def _restart(
    program: _CompiledSettings,
    numbers: _Numbers,
    scenario: Scenario,
    episodes: Episodes,
    where: jax.Array,
) -> tuple[Episodes, jax.Array]:
    """Start new episodes in the lanes of a mask."""
    fresh, _ = _start(program, numbers, scenario)
    merged = jax.tree.map(lambda new, old: jnp.where(where, new, old), fresh, episodes)
    return merged, _report(program, numbers, merged, jnp.zeros_like(merged.lane.force_n))


@_compiled
def _advance(
    program: _CompiledSettings, numbers: _Numbers, episodes: Episodes, actions: jax.Array
) -> tuple[Episodes, jax.Array]:
    """Advance one step of the agent, whose action is held for `decimation` ticks."""
    command = jnp.clip(actions, -1.0, 1.0) * numbers.action_scale

    def tick(_, carry: tuple[Episodes, jax.Array]) -> tuple[Episodes, jax.Array]:
        return _tick(program, numbers, command, *carry)

    paid = jnp.zeros_like(episodes.lane.force_n)
    episodes, paid = jax.lax.fori_loop(0, numbers.decimation, tick, (episodes, paid))
    ledger = episodes.ledger
    ends = (episodes.tick >= numbers.n_ticks) & ~episodes.lane.failed
    mean = ledger.total_reward / jnp.maximum(ledger.hops, 1.0)
    return episodes, _report(program, numbers, episodes, paid + jnp.where(ends, mean, 0.0))


def _tick(
    program: _CompiledSettings,
    numbers: _Numbers,
    command: jax.Array,
    episodes: Episodes,
    paid: jax.Array,
) -> tuple[Episodes, jax.Array]:
    """Advance one control tick; return also its share of the reward."""
    body, ledger = numbers.body, episodes.ledger
    lane, output = program.loop.tick(
        (command,), body, episodes.scenario, episodes.lane, episodes.tick, numbers.tick_s
    )
    sound, contact, ground = output.sound, output.contact, output.ground_m

    work = program.reward.counted(contact.work_j)
    climb_hop, work_hop = ledger.climb + contact.climb_flight_m, ledger.work + work
    energy = body.energy(output.end.body, ground)
    # A comparison with the NaN of a tick without apex is false.
    hop = sound & (contact.apex_height_m >= hop_height_m(body.rest_length_m, ground))
    value, counts = program.reward.of_hop(
        climb_m=climb_hop, work_j=work_hop, lost_j=ledger.energy - energy
    )
    gain = jnp.where(hop, value, 0.0)
    total_climb = ledger.total_climb + contact.climb_flight_m
    total_work = ledger.total_work + work
    tick = episodes.tick + 1
    late = 2 * tick > numbers.n_ticks
    now_s = tick.astype(total_work.dtype) * numbers.tick_s
    earned = _Ledger(
        jnp.where(hop, 0.0, climb_hop),
        jnp.where(hop, 0.0, work_hop),
        jnp.where(hop, energy, ledger.energy),
        total_climb,
        total_work,
        ledger.total_reward + gain,
        ledger.hops + jnp.where(hop & counts, 1.0, 0.0),
        ledger.apexes.updated(hop & late, now_s, total_climb, total_work),
    )
    # As in the engine, a lane that fails stands still from its last sound tick on.
    ledger = jax.tree.map(partial(keep, sound), earned, ledger)
    tick = keep(sound, tick, episodes.tick)
    return Episodes(lane, episodes.scenario, tick, ledger), paid + gain


def _report(
    program: _CompiledSettings, numbers: _Numbers, episodes: Episodes, reward: jax.Array
) -> jax.Array:
    """Return everything that leaves the device, one row per quantity: one transfer instead of a
    dozen.
    """
    controller, body, moment = program.controller, numbers.body, episodes.lane.moment
    ledger = episodes.ledger
    like = reward
    ground = ground_m(episodes.scenario, episodes.tick, numbers.tick_s)
    sensed = signals(controller, body, moment.body, moment.oscillator, ground)
    observation = []
    for name in program.observed:
        value, scale = sensed.dimensionless(name), 1.0
        if not program.dimensionless:
            value, scale = sensed[name], sensed.scales.get(name, 1.0)
        observation.append(jnp.clip(value, -_SENSE_BOUND * scale, _SENSE_BOUND * scale))
    time_s = episodes.tick.astype(like.dtype) * numbers.tick_s
    truncated = ~episodes.lane.failed & (episodes.tick >= numbers.n_ticks)
    telemetry = {
        "time_s": time_s,
        "height_m": body.height(moment.body),
        "velocity_m_per_s": body.velocity(moment.body),
        "ground_m": ground,
        "phase_rad": phase_of(controller, moment.oscillator, like),
        "feedback_rad_per_s": moment.drive.feedback,
        "actuator_force_n": episodes.lane.force_n,
        "work_j": ledger.total_work,
        "climb_flight_m": ledger.total_climb,
        "cot_inverse": ledger.apexes.cot_inverse(time_s),
        "hops": ledger.hops,
    }
    rows = [
        *observation,
        reward,
        episodes.lane.failed.astype(like.dtype),
        truncated.astype(like.dtype),
        *(telemetry[name] for name in TELEMETRY),
    ]
    return jnp.stack([jnp.broadcast_to(row, like.shape) for row in rows])
