"""The clock with balance on Go1's feet, tuned under disturbances: eight numbers.

    python studies/go1_tuned.py                         # half an hour of one core

CMA-ES from the walker's ellipse without balance. A candidate's score is the share of its lanes that
do not fall, less 0.3 |v / v* - 1| and 0.05 CoT, over pushes, blocks and any phases at three
commands, from starts and pushes of its generation. Written is
`docs/_static/go1_feet/clock-tuned-SEED.json`, the mean of the distribution at the end.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import tyro

from go1_feet import SETTINGS, Condition, judged
from go1_laws import FOLDER, WIRING, open_loop, wanted_m_per_s
from tegotae.cli.console import exit_status
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wiring import load_wiring
from tegotae.systems.controller_file import SavedController, save
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment

OMEGAS = (10.0, 16.0, 24.0)
SECONDS = 8.0
MET = (
    Condition(push_m_per_s=1.0),
    Condition(blocks_m=0.04),
    Condition(random_phases=True, delay_s=0.02),
)
"""What every candidate meets; a push is to the left in all, and the law is mirrored."""


@dataclass(frozen=True)
class Tuned:
    """One tuning."""

    seed: int = 0
    """Of the search, and of its starts."""
    generations: int = 25
    """Of CMA-ES."""
    population: int = 12
    """Candidates of each."""

    def run(self) -> None:
        """Tune, and write the law."""
        (base,) = open_loop(0.25)()
        wiring = load_wiring(WIRING).holding(base)
        n_weights, algorithm = len(base.weights), CMAES(population=self.population, std=0.08)
        search, parameters = algorithm.strategy(n_weights), algorithm.parameters(n_weights)
        state = algorithm.start(jax.random.key(self.seed), jnp.asarray(base.weights, "float32"))
        for generation in range(self.generations):
            keys = jax.random.split(jax.random.fold_in(jax.random.key(self.seed), generation))
            candidates, state = search.ask(keys[0], state, parameters)
            start = 10_000 * (1 + self.seed) + generation
            scores = scored(wiring, np.asarray(candidates, float), start)
            state, _ = search.tell(keys[1], candidates, jnp.asarray(-scores), state, parameters)
            mean = np.asarray(search.get_mean(state), float)
            print(
                generation,
                np.round([scores.mean(), scores.max()], 3),
                np.round(mean, 3),
                flush=True,
            )
            keep(wiring, mean, self.seed)


def scored(wiring: Any, candidates: np.ndarray, start: int) -> np.ndarray:
    """Of every candidate, [candidates]."""
    weights = np.repeat(candidates, len(OMEGAS), axis=0)
    omegas = np.tile(OMEGAS, len(candidates))
    wanted = [
        wanted_m_per_s(dataclasses.replace(wiring, weights=own), omega)
        for own, omega in zip(weights, omegas, strict=True)
    ]
    total = np.zeros(len(weights))
    for condition in MET:
        found = judged(wiring, weights, omegas, [start] * len(weights), condition, SECONDS)
        off = np.minimum(np.abs(np.nan_to_num(found.speed_m_per_s) / wanted - 1.0), 1.0)
        cost = np.minimum(np.nan_to_num(found.cost_of_transport, nan=8.0), 8.0)
        total += ~found.fell - 0.3 * off - 0.05 * cost
    return total.reshape(-1, len(OMEGAS)).mean(axis=1) / len(MET)


def keep(wiring: Any, weights: np.ndarray, seed: int) -> None:
    """Write the law with its robot."""
    settings = {
        field.name: getattr(SETTINGS, field.name)
        for field in dataclasses.fields(SETTINGS)
        if getattr(SETTINGS, field.name) != field.default and field.name != "model"
    }
    experiment = EnvExperiment(
        name="clock-b-tuned",
        spec=EnvSpec(env=str(SETTINGS.model), settings=tuple(settings.items())),
        wiring=dataclasses.replace(wiring, weights=None),
    )
    saved = SavedController(
        experiment.system,
        weights,
        name="clock-b-tuned",
        task=experiment.task,
        training={"seed": seed},
    )
    save(saved, FOLDER / f"clock-tuned-{seed}.json")


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Tuned, description=__doc__).run()))
