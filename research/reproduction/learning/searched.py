"""Short laws searched as V is: by differential evolution to a stated end, with CMA-ES beside it.

V's gain is the best of a fixed grid. A law has two to five numbers, and its trainings often fail;
so both are searched for the same fitness, from the same release, before they are compared:

- SciPy's differential evolution begins with a Sobol sequence over `BOX`, which has every place and
  width of the push, and σ up to the end of V's grid. It ends when the population's fitness spreads
  by less than `TOLERANCE` of its mean, or after `GENERATIONS`.
- CMA-ES begins at the initial weights of each training seed, under the study's stopping rule.

The law that is compared is chosen among the searched ones like any other run: on the first half of
the common releases.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, differential_evolution

from research.reproduction.learning.judged import judge_runs
from tegotae._support.documents import Document
from tegotae.study import CellResult
from tegotae.systems.experiment import Experiment
from tegotae.training.algorithms import CMAES
from tegotae.training.evolution import Evolution, Progress
from tegotae.training.run import Run

BOX = {
    "start_rad": (0.0, 2.0 * np.pi),
    "width_rad": (0.0, np.pi),
    "offset": (-1.5, 1.5),
    "per_load": (0.0, 3.0),
    "newtons_per_feedback": (0.0, 2.0),
}
"""Ranges of a law's weights by name; σ has V's range [rad/(s N)]."""
POPULATION = 64
"""Members of a population per weight."""
GENERATIONS = 200
TOLERANCE = 0.005
"""Spread of fitness in a population at which a search has converged, over its mean."""
SEEDS = 15
"""Starts of CMA-ES."""
DE, CMA = "DE", "CMA-ES"


def trained(run: Run[Evolution]) -> Progress:
    """Train to the end of all seeds, and return the state there."""
    begun = run.learner.start(run.experiment, run.seeds)
    *_, (progress, _) = run.learner.evolve(run.experiment, run.seeds, begun)
    return progress


@dataclass(frozen=True)
class SearchedLaw:
    """A short law at one ω_t, searched and evaluated from the common releases.

    Args:
        experiment: the law's training.
    """

    experiment: Experiment

    @property
    def name(self) -> str:
        """Name of the law and its frequency."""
        return self.experiment.name

    @property
    def document(self) -> Document:
        """Return the experiment and the settings of the searches."""
        return {
            "experiment": self.experiment.document,
            "box": {name: list(ends) for name, ends in BOX.items()},
            "population": POPULATION,
            "generations": GENERATIONS,
            "tolerance": TOLERANCE,
            "seeds": SEEDS,
        }

    @property
    def program(self) -> Hashable:
        """Laws of one form share a program."""
        return repr(self.experiment.controller)

    def prepare(self) -> None:
        """Prepare nothing: the package has all that it needs."""

    def measure(self) -> CellResult:
        """Search, and evaluate the law of differential evolution first, then those of CMA-ES."""
        run = Run(
            experiment=self.experiment,
            learner=Evolution(algorithm=CMAES(population=16)),
            seeds=tuple(range(SEEDS)),
        )
        progress = trained(run)
        evolved = self.evolved()
        weights = np.vstack([evolved.x, np.asarray(progress.best_weights)]).astype("float32")
        arrays = judge_runs(self.experiment, weights)
        arrays["weights"] = weights
        arrays["best_fitness"] = np.append(-evolved.fun, progress.best_fitness)
        arrays["generations"] = np.append(evolved.nit, progress.generation)
        return CellResult(self.document, run.software, arrays)

    def evolved(self) -> OptimizeResult:
        """Search by differential evolution: weights `x`, and `fun`, minus their fitness."""
        gains = self.experiment.gains
        box = BOX | {"sigma": (0.0, float(gains.max()))}
        bounds = [box[str(name[-1])] for name in self.experiment.controller.weight_names]
        with self.experiment.evaluator() as evaluator:
            return differential_evolution(
                lambda columns: -evaluator.alike(np.atleast_2d(columns.T)).fitness,
                bounds, vectorized=True, updating="deferred", init="sobol", popsize=POPULATION,
                maxiter=GENERATIONS, tol=TOLERANCE, atol=0, polish=False, rng=0,
            )  # fmt: skip
