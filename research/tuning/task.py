"""Task that settings are evaluated on: experiments, seeds, and a budget of simulated time."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.limits import MOST_SEEDS
from tegotae.systems.experiment import Experiment

FIRST_SEED = 10_000
"""The first seed of a tuning: far from those that trainings start at, so that settings are not
chosen for the initial weights that they are used on later."""

_MOST_S = 1e9
"""Largest budget of one training [s]: thirty years."""

BUDGET_S = 61_440.0
"""Simulated time of one training [s]: 80 generations of 32 episodes of 24 s."""


@dataclass(frozen=True, kw_only=True)
class TuningTask:
    """The trainings that a setting has to do well in: every experiment with every seed.

    Every training may simulate for `budget_s`, whatever its algorithm and its settings: a larger
    population has fewer generations. Episodes that only evaluate what was learned are not counted.

    Args:
        experiments: what is trained.
        seeds: how many trainings of each.
        first_seed: the first of their seeds.
        budget_s: simulated time that one training may spend [s].

    Raises:
        TegotaeError: for a number out of its range, no experiment or one given twice, or one with
            nothing to train.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> experiments = recipe("ART").experiment(), recipe("AR").experiment()
        >>> TuningTask(experiments=experiments).instances
        8
    """

    experiments: tuple[Experiment, ...]
    seeds: int = 4
    first_seed: int = FIRST_SEED
    budget_s: float = BUDGET_S

    def __post_init__(self) -> None:
        require_count("seeds", self.seeds, most=MOST_SEEDS)
        require_count("first_seed", self.first_seed, least=0, most=2**31 - 1 - self.seeds)
        require_finite("budget_s", self.budget_s, above=0.0, most=_MOST_S)
        names = [experiment.name for experiment in self.experiments]
        if not names:
            raise TegotaeError("no models to tune for; name at least one")
        if len(set(names)) < len(names):
            raise TegotaeError(f"models are {', '.join(names)}; each may be given only once")
        for experiment in self.experiments:
            if experiment.is_searched:
                raise TegotaeError(
                    f"{experiment.name} has no network to train, so there are no settings to tune; "
                    "choose a model that learns, such as ART"
                )
            experiment.check()

    @property
    def instances(self) -> int:
        """Trainings per setting."""
        return len(self.experiments) * self.seeds

    def episodes(self, experiment: Experiment, minimum: int) -> int:
        """Return the number of episodes of an experiment within the budget.

        Raises:
            TegotaeError: if these are fewer than `least`.
        """
        duration_s = experiment.timing.duration_s * experiment.episodes
        episodes = int(self.budget_s / duration_s + 1e-9)
        if episodes < minimum:
            raise TegotaeError(
                f"a budget of {self.budget_s:g} s is {episodes} episodes of {duration_s:g} s; "
                f"at least {minimum} are needed, {minimum * duration_s:g} s"
            )
        return episodes

    def jobs(self, at_once: int) -> list[tuple[int, tuple[int, ...]]]:
        """Return the trainings in the order in which they are made: indices of experiments and
        seeds.

        A few seeds of each in turn, so that bad settings are found out on all of them early.
        """
        blocks = [
            tuple(range(self.seeds))[first : first + at_once]
            for first in range(0, self.seeds, at_once)
        ]
        return [(index, block) for block in blocks for index in range(len(self.experiments))]

    @property
    def configuration(self) -> JsonObject:
        """All settings that determine a setting's value, as JSON values."""
        return {
            "experiments": [experiment.document for experiment in self.experiments],
            "seeds": self.seeds,
            "first_seed": self.first_seed,
            "budget_s": self.budget_s,
        }
