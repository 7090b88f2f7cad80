"""What settings are judged on: models, seeds, and a budget of simulated time."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from tegotae.bodies import Hopper
from tegotae.errors import TegotaeError, require_count, require_finite
from tegotae.models import BUDGET, Model
from tegotae.rollout import Timing
from tegotae.training.fitness import EPISODE, SETTLE_S, Fitness

FIRST_SEED = 10_000
"""The first seed of a tuning: far from those that trainings start at, so that settings are not
chosen for the initial weights that they are used on later."""

BUDGET_S = 61_440.0
"""Simulated time of one training [s]: 80 generations of 32 episodes of 24 s."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """The trainings that a setting has to do well in: every model with every seed.

    Every training may simulate for `budget_s`, whatever its algorithm and its settings: a larger
    population has fewer generations. Episodes that only judge what was learned are not counted.

    Args:
        models: what is trained.
        seeds: how many trainings of each.
        first_seed: the first of their seeds.
        budget_s: simulated time that one training may spend [s].
        timing: the episode.
        settle_s: time in an episode before it is judged [s].
        energy: definition of work, one of "absolute", "positive", "net".
        follow_omega: whether ΔΩ counts; not in the paper's comparison of algorithms (Fig. 3).
        budget: largest number of trained parameters.
        hopper: the body.

    Raises:
        TegotaeError: for a number out of its range, no model or one given twice, or a model with
            nothing to train.

    Example:
        >>> from tegotae.models import find
        >>> Task(models=(find("ART"), find("AR")), seeds=4).instances
        8
    """

    models: tuple[Model, ...]
    seeds: int = 4
    first_seed: int = FIRST_SEED
    budget_s: float = BUDGET_S
    timing: Timing = EPISODE
    settle_s: float = SETTLE_S
    energy: str = "absolute"
    follow_omega: bool = True
    budget: int = BUDGET
    hopper: Hopper = field(default_factory=Hopper)

    def __post_init__(self) -> None:
        require_count("seeds", self.seeds)
        require_count("first_seed", self.first_seed, least=0)
        require_finite("budget_s", self.budget_s, above=0.0)
        names = [model.name for model in self.models]
        if not names:
            raise TegotaeError("no models to tune for; name at least one")
        if len(set(names)) < len(names):
            raise TegotaeError(f"models are {', '.join(names)}; each may be given only once")
        for model in self.models:
            if not model.is_trained:
                raise TegotaeError(
                    f"{model.name} has no network to train, so there are no settings to tune; "
                    "choose a model that learns, such as ART"
                )
            model.controller(self.budget)
            self.fitness(model).check(self.timing)
        self.hopper.check_tick(self.timing.tick_s)

    @property
    def instances(self) -> int:
        """Trainings per setting."""
        return len(self.models) * self.seeds

    def fitness(self, model: Model) -> Fitness:
        """The measure of a training; a single network has no frequency to follow."""
        return Fitness(
            settle_s=self.settle_s,
            energy=self.energy,
            follow_omega=self.follow_omega and not model.is_single_network,
        )

    def episodes(self, least: int) -> int:
        """Episodes that the budget is enough for.

        Raises:
            TegotaeError: if these are fewer than `least`.
        """
        episodes = int(self.budget_s / self.timing.duration_s + 1e-9)
        if episodes < least:
            raise TegotaeError(
                f"a budget of {self.budget_s:g} s is {episodes} episodes of "
                f"{self.timing.duration_s:g} s; at least {least} are needed, "
                f"{least * self.timing.duration_s:g} s"
            )
        return episodes

    def jobs(self, at_once: int) -> list[tuple[int, tuple[int, ...]]]:
        """The trainings in the order in which they are made: indices of models and seeds.

        A few seeds of each model in turn, so that bad settings are found out on all models early.
        """
        blocks = [
            tuple(range(self.seeds))[first : first + at_once]
            for first in range(0, self.seeds, at_once)
        ]
        return [(model, block) for block in blocks for model in range(len(self.models))]

    @property
    def configuration(self) -> dict[str, Any]:
        """All that decides a setting's value, as JSON values."""
        return {
            "models": [model.name for model in self.models],
            "seeds": self.seeds,
            "first_seed": self.first_seed,
            "budget_s": self.budget_s,
            "timing": dataclasses.asdict(self.timing),
            "settle_s": self.settle_s,
            "energy": self.energy,
            "follow_omega": self.follow_omega,
            "budget": self.budget,
            "hopper": dataclasses.asdict(self.hopper),
        }
