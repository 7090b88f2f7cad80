"""Fitness of an episode in an environment."""

from __future__ import annotations

import reprlib
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, SupportsFloat, cast

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, other_code
from tegotae.envs.wiring import Wiring
from tegotae.measures.hopping.recording import from_samples
from tegotae.measures.hopping.signals import check_work
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.objective import FAILED_FITNESS, Scores
from tegotae.measures.robots import EnvEpisode
from tegotae.parts.bodies import Body, Interface
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import Scenario
from tegotae.systems.registry import load_object, source_of


@dataclass(frozen=True)
class EpisodeBatch:
    """Episodes side by side."""

    step_s: float
    """Time of a step [s]."""
    names: tuple[str, ...]
    """Names of the observation's entries."""
    observation: np.ndarray
    """[steps, lanes, entries]; a lane's last one again after it has ended."""
    action: np.ndarray
    """[steps, lanes, entries]."""
    reward: np.ndarray
    """[steps, lanes]; 0 after a lane has ended."""
    phase_rad: np.ndarray
    """[steps, limbs, lanes]."""
    ended: np.ndarray
    """Steps that a lane lasted, [lanes]."""
    steps: int
    """Steps of the longest episode."""
    sound: np.ndarray
    """The lanes that ran to their end without a fault, [lanes]; others have no episode."""
    completed: np.ndarray
    """True where the time alone ended the episode, [lanes]."""

    @property
    def lasted(self) -> np.ndarray:
        """Share of the longest episode that each lane lasted, [lanes]."""
        return self.ended / self.steps

    def entry(self, name: str) -> np.ndarray:
        """Return the observation's entry of that name, [steps, lanes]."""
        return self.observation[:, :, self.names.index(name)]

    def episode(self, lane: int) -> EnvEpisode:
        """Return one lane's episode."""
        last = int(self.ended[lane])
        return EnvEpisode(
            time_s=self.step_s * np.arange(1, last + 1),
            observation=self.observation[:last, lane],
            names=self.names,
            action=self.action[:last, lane],
            reward=self.reward[:last, lane],
            phase_rad=self.phase_rad[:last, :, lane],
            lasted=float(self.lasted[lane]),
        )


_FRAME_S = 0.02
ENTRY_OF_WORK = {"absolute": "work", "positive": "work_positive", "net": "work_net"}
"""Entries of a wiring that name the observation of the work, by definition of work."""


class EnvObjective(ABC):
    """The measure of an episode: a frozen dataclass of its settings."""

    NAME: ClassVar[str]
    """Name in files."""

    def entries(self, wiring: Wiring) -> tuple[str, ...] | None:
        """Return the entries of the observation that it reads; None for all, with actions and
        phases."""
        return ()

    def check(self, wiring: Wiring, duration_s: float) -> None:  # noqa: B027 - optional
        """Raise `TegotaeError` where it cannot be computed."""

    @property
    def file(self) -> Path | None:
        """The user's file that it comes from, if any."""
        return None

    @abstractmethod
    def score(self, record: EpisodeBatch, wiring: Wiring) -> Scores:
        """Return the scores of every lane."""


@dataclass(frozen=True)
class Return(EnvObjective):
    """The sum of the environment's own rewards."""

    NAME = "Return"

    def score(self, record: EpisodeBatch, wiring: Wiring) -> Scores:
        """Return the scores of every lane; an early end of an episode is no failure."""
        total = record.reward.sum(axis=0)
        return Scores(total, np.full(total.shape, np.nan), np.zeros(total.shape, bool))


@dataclass(frozen=True, kw_only=True)
class Hopping(EnvObjective):
    """CoT⁻¹ + ΔΩ of a body whose height and work are observed: the hopper's own fitness.

    The episode becomes a recording (`tegotae.measures.hopping.recording.from_samples`), and is
    evaluated by `tegotae.measures.objectives.fitness.Fitness` as an episode of the engine is.

    Args:
        settle_s: time at the start of an episode that does not count [s].
        follow_omega: subtract ΔΩ.
        work: definition of work, one of "absolute", "positive", "net"; the wiring names the entry
            of the observation that measures it.

    Raises:
        TegotaeError: for an unknown definition of work.
    """

    NAME = "Hopping"

    settle_s: float = 12.0
    follow_omega: bool = True
    work: str = "absolute"

    def __post_init__(self) -> None:
        check_work(self.work)

    def check(self, wiring: Wiring, duration_s: float) -> None:
        """Raise `TegotaeError` without height, work or the height of touchdown."""
        self._require_measured(wiring)
        self._fitness.check(Timing(duration_s=duration_s, frame_s=_FRAME_S, tick_s=_FRAME_S))

    def _require_measured(self, wiring: Wiring) -> None:
        counted = "" if self.work == "absolute" else f"{self.work} "
        for name, quantity in (
            ("height", "the observation entry that is the body's height"),
            (
                ENTRY_OF_WORK[self.work],
                f"the observation entry that is the {counted}work since the reset",
            ),
            ("rest_length_m", "the height at which the feet touch the ground [m]"),
        ):
            if getattr(wiring, name) is None:
                raise TegotaeError(
                    f"CoT⁻¹ cannot be measured: the wiring does not say {name}, {quantity}; "
                    "name it, or use --fitness return"
                )

    def entries(self, wiring: Wiring) -> tuple[str, ...]:
        """Return the names of height and work."""
        work = (getattr(wiring, entry) for entry in ENTRY_OF_WORK.values())
        return tuple(filter(None, (wiring.height, *work)))

    @property
    def _fitness(self) -> Fitness:
        return Fitness(settle_s=self.settle_s, follow_omega=self.follow_omega, work=self.work)

    def score(self, record: EpisodeBatch, wiring: Wiring) -> Scores:
        """Return the scores of every lane.

        Raises:
            TegotaeError: for what is not measured.
        """
        self._require_measured(wiring)
        assert wiring.height is not None
        assert wiring.rest_length_m is not None
        rest_length = wiring.rest_length_m
        time = record.step_s * np.arange(1, record.steps + 1)
        height = record.entry(wiring.height).astype(float)
        frame_s = max(_FRAME_S, record.step_s)
        lanes = [
            from_samples(time, column, rest_length_m=rest_length, frame_s=frame_s)
            for column in height.T
        ]
        names = ("time_s", "height_m", "ground_m", "apex_height_m", "climb_flight_m", "climb_m")
        channels = {
            n: np.concatenate([getattr(trajectory, n) for trajectory in lanes], 1) for n in names
        }
        frames_s = channels["time_s"][:, 0] + time[0]
        for kind, entry in ENTRY_OF_WORK.items():
            name = getattr(wiring, entry)
            work = np.full(height.shape, np.nan) if name is None else record.entry(name)
            work = work.astype(float)
            spent = [np.interp(frames_s, time, lane - lane[0]) for lane in work.T]
            channels[f"work_{kind}_j"] = np.stack(spent, axis=1)
        begun = record.step_s * record.ended
        fell = record.ended < record.steps
        channels["failed"] = fell & (channels["time_s"] > begun)
        channels["failed"][-1] |= fell
        timing = Timing(duration_s=len(frames_s) * frame_s, frame_s=frame_s, tick_s=frame_s)
        body = Interface(rest_length_m=rest_length)
        scenario = Scenario.at_frequency(wiring.omega)
        outcome = _as_rollout(self._fitness, timing, channels, scenario, body)
        return Scores(*(np.asarray(outcome[name]) for name in Scores._fields))


@partial(jax.jit, static_argnums=(0, 1))
def _as_rollout(
    fitness: Fitness,
    timing: Timing,
    channels: dict[str, np.ndarray],
    scenario: Scenario,
    body: Interface,
) -> dict[str, jax.Array]:
    arrays = {name: jnp.asarray(x) for name, x in channels.items()}
    # Of a body, the fitness reads nothing but its rest length.
    return fitness(Trajectory(**arrays), scenario, cast(Body, body), timing)


@dataclass(frozen=True)
class UserObjective(EnvObjective):
    """A function of your own of an `EnvEpisode`: `FILE.py:FUNCTION` or `MODULE:FUNCTION`."""

    NAME = "UserObjective"

    function: str

    @property
    def file(self) -> Path | None:
        """File of the function."""
        return source_of(self.function)

    def entries(self, wiring: Wiring) -> None:
        """Return None: the objective reads all entries of the observation."""

    def check(self, wiring: Wiring, duration_s: float) -> None:
        """Raise `TegotaeError` if there is no such function."""
        load_object(self.function, type(lambda: None), "fitness")

    def score(self, record: EpisodeBatch, wiring: Wiring) -> Scores:
        """Return the scores of every lane; one without an episode has failed.

        Raises:
            TegotaeError: if the function fails, or returns no number.
        """
        score = load_object(self.function, type(lambda: None), "fitness")
        fitness = np.full(record.sound.shape, FAILED_FITNESS)
        for lane in map(int, np.flatnonzero(record.sound)):
            fitness[lane] = self._score_of(score, record.episode(lane))
        failed = ~(record.sound & np.isfinite(fitness))
        return Scores(fitness, np.full(fitness.shape, np.nan), failed)

    def _score_of(self, score: Callable[[EnvEpisode], SupportsFloat], episode: EnvEpisode) -> float:
        steps = len(episode.time_s)
        with other_code(f"the fitness {self.function} failed on an episode of {steps} steps"):
            value = score(episode)
        try:
            return float(value)
        except (TypeError, ValueError):
            raise TegotaeError(
                f"{self.function} returned {reprlib.repr(value)}; it must return one number"
            ) from None


def env_objective_named(name: str, **settings: Any) -> EnvObjective:
    """Return an objective by its name on the command line: `hopping`, `return`, or a function's
    reference.

    Raises:
        TegotaeError: for another name.

    Example:
        >>> env_objective_named("return")
        Return()
    """
    if ":" in name:
        return UserObjective(name)
    if name == "return":
        return Return()
    if name == "hopping":
        return Hopping(**settings)
    raise TegotaeError(
        f"no fitness is called {name!r}; it is hopping, return, FILE.py:FUNCTION or MODULE:FUNCTION"
    )
