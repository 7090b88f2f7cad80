"""What an agent is paid, step by step, for an experiment that is judged episode by episode."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.envs.pilot import Pilot
from tegotae.envs.settings import HopReward
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import ENTRY_OF_WORK, EpisodeBatch, Hopping, Return

_CLEARS = 1.01
"""Height of an apex over the rest length from which a flight is a hop."""


class StepReward(ABC):
    """Rewards of lanes that are stepped together."""

    @abstractmethod
    def begin(self, seen: np.ndarray, where: np.ndarray) -> None:
        """New episodes of some lanes.

        Args:
            seen: what is observed at their start, [lanes, entries].
            where: which lanes, [lanes].
        """

    @abstractmethod
    def of_step(
        self, seen: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        """The rewards of a step of the environment, [lanes].

        Args:
            seen: what is observed after it, [lanes, entries].
            action: what was done, [lanes, entries].
            paid: the environment's own rewards, [lanes].
            alive: whose episode goes on or ends with this step, [lanes]; others stand still.
        """

    @abstractmethod
    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        """What lanes whose episode is over get besides, [lanes]; 0 elsewhere."""


class OwnReward(StepReward):
    """The environment's own reward: its sum is the return."""

    def begin(self, seen: np.ndarray, where: np.ndarray) -> None:
        """Nothing is kept."""

    def of_step(
        self, seen: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        """As it is."""
        return paid

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        """Nothing."""
        return np.zeros(len(over))


class PerHop(StepReward):
    """The paper's: CoT⁻¹ of each hop at its apex, and their mean at the end (`HopReward`).

    Args:
        experiment: whose wiring names height and work.
        lanes: how many.
        reward: which hops are paid.
    """

    def __init__(self, experiment: EnvExperiment, lanes: int, reward: HopReward) -> None:
        wiring, names = experiment.wiring, experiment.wires.observed
        work = getattr(wiring, ENTRY_OF_WORK[reward.work])
        assert wiring.height is not None
        assert wiring.rest_length_m is not None
        self._height, self._work = names.index(wiring.height), names.index(work)
        self._rest_m, self._reward = float(wiring.rest_length_m), reward
        self._was, self._spent_at = np.zeros(lanes), np.zeros(lanes)
        self._rises = np.zeros(lanes, bool)
        self._sum, self._hops = np.zeros(lanes), np.zeros(lanes)

    def begin(self, seen: np.ndarray, where: np.ndarray) -> None:
        """No hop yet."""
        self._was = np.where(where, seen[:, self._height], self._was)
        self._spent_at = np.where(where, seen[:, self._work], self._spent_at)
        self._rises = self._rises & ~where
        self._sum, self._hops = (np.where(where, 0.0, x) for x in (self._sum, self._hops))

    def of_step(
        self, seen: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        """0 but at apexes."""
        height, work = seen[:, self._height], seen[:, self._work]
        rises = height > self._was
        apex = alive & self._rises & ~rises & (self._was > _CLEARS * self._rest_m)
        climb = self._was - self._rest_m
        self._was, self._rises = height, rises
        if not apex.any():
            return np.zeros(len(apex))
        value, counts = map(
            np.asarray,
            self._reward.of_hop(climb_m=climb, work_j=work - self._spent_at, lost_j=0.0),
        )
        rewarded = apex & counts
        found = np.where(rewarded, value, 0.0)
        self._spent_at = np.where(apex, work, self._spent_at)
        self._sum, self._hops = self._sum + found, self._hops + rewarded
        return found

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        """The mean of the rewarded hops."""
        return np.where(over, self._sum / np.maximum(self._hops, 1.0), 0.0)


class OnceAtTheEnd(StepReward):
    """The fitness of the episode, at its end: for a function of your own.

    Args:
        experiment: by whose objective.
        lanes: how many.
        steps: of the longest episode.
        pilot: whose phases the episode has.
    """

    def __init__(self, experiment: EnvExperiment, lanes: int, steps: int, pilot: Pilot) -> None:
        self._experiment, self._pilot, self._steps = experiment, pilot, steps
        self._kept: list[list[tuple[np.ndarray, ...]]] = [[] for _ in range(lanes)]

    def begin(self, seen: np.ndarray, where: np.ndarray) -> None:
        """An empty record."""
        for lane in np.flatnonzero(where):
            self._kept[lane] = []

    def of_step(
        self, seen: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        """Nothing yet."""
        phase = self._pilot.phase
        for lane in np.flatnonzero(alive):
            own = seen[lane], action[lane], paid[lane], phase[:, lane].copy()
            self._kept[lane].append(own)
        return np.zeros(len(paid))

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        """The fitness of each episode."""
        found = np.zeros(len(over))
        for lane in np.flatnonzero(over & np.array([bool(kept) for kept in self._kept])):
            found[lane] = self._of(self._kept[lane])
        return found

    def _of(self, kept: list[tuple[np.ndarray, ...]]) -> float:
        own = self._experiment
        seen, action, paid, phase = (np.stack(each)[:, None] for each in zip(*kept, strict=True))
        record = EpisodeBatch(
            own.wires.step_s,
            own.wires.observed,
            seen,
            action,
            paid,
            np.swapaxes(phase, 1, 2),
            np.array([len(kept)]),
            self._steps,
            np.ones(1, bool),
        )
        value = float(np.asarray(own.objective.score(record, own.wiring).fitness)[0])
        return value if np.isfinite(value) else 0.0


def step_reward(
    experiment: EnvExperiment,
    lanes: int,
    steps: int,
    pilot: Pilot,
    *,
    least_work_j: float,
    charge_stored: bool,
) -> StepReward:
    """The rewards whose sum an agent makes large, for an experiment's objective.

    Raises:
        TegotaeError: for stored energy, which environments do not observe.
    """
    if charge_stored:
        raise TegotaeError(
            "charge_stored needs the body's energy, which environments do not observe; leave it out"
        )
    if isinstance(experiment.objective, Return):
        return OwnReward()
    if isinstance(experiment.objective, Hopping):
        reward = HopReward(work=experiment.objective.work, least_work_j=least_work_j)
        return PerHop(experiment, lanes, reward)
    return OnceAtTheEnd(experiment, lanes, steps, pilot)
