"""The episodes of a training under changing conditions: who meets what, generation by generation.

All candidates of a generation and seed meet the same episodes, so that they differ by their weights
and not by their luck; the next generation meets new ones. The centre of a distribution, by which
the best one is chosen and a plateau is seen, meets the same episodes in every generation and with
every seed, the evaluation set: else the luckiest generation would be kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tegotae.parts.bodies import Body
from tegotae.simulation.world import Condition, Scenario
from tegotae.simulation.world.draws import applied, draw

LEAST_EVALUATION_SET = 4
"""Episodes of the evaluation set at least: what is best under one draw may be so by luck."""
_EVALUATION_SET = (0,)
_GENERATIONS = 1  # keys of draws begin with it, the evaluation set's with another number


@dataclass(frozen=True)
class Randomization:
    """What the episodes of a training have in common, and in what they differ.

    Args:
        conditions: in what they differ; of none, every episode is the scenario itself.
        body: what is driven.
        scenario: numbers, or arrays of shape [limbs, 1].
    """

    conditions: tuple[Condition, ...]
    body: Body
    scenario: Scenario

    def repeats(self, episodes: int) -> int:
        """How often what is held against the evaluation set meets so many episodes, that they are
        `LEAST_EVALUATION_SET` together."""
        return -(-LEAST_EVALUATION_SET // episodes) if self.conditions else 1

    def evaluation_set(self, candidates: int, episodes: int) -> Scenario:
        """The same episodes for everyone, one after the other: [candidates x episodes]."""
        drawn = draw(self.conditions, self.body, episodes, _EVALUATION_SET)
        values = {name: np.tile(x, candidates) for name, x in drawn.items()}
        return applied(self.conditions, values, self.scenario, self.body)

    def generation(
        self, seeds: Sequence[int], number: int, population: int, episodes: int, centre: int
    ) -> Scenario:
        """The episodes of a generation: seed by seed, candidate by candidate, the centre last.

        Args:
            seeds: of the runs; what one meets does not depend on which others there are.
            number: of the generation, from 0 on.
            population: candidates a seed beside the centre.
            episodes: of each candidate.
            centre: episodes of the centre, those of the evaluation set.

        Returns:
            The scenario, with one entry for each episode, [seeds x (population x episodes +
            centre)], in what is varied.
        """
        always = draw(self.conditions, self.body, centre, _EVALUATION_SET)
        parts: dict[str, list[np.ndarray]] = {name: [] for name in always}
        for seed in seeds:
            drawn = draw(self.conditions, self.body, episodes, (_GENERATIONS, seed, number))
            for name, values in drawn.items():
                parts[name] += [np.tile(values, population), always[name]]
        values = {name: np.concatenate(each, axis=-1) for name, each in parts.items()}
        return applied(self.conditions, values, self.scenario, self.body)
