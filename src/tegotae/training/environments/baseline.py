"""The vanilla baseline on an environment: the gain σ and the frequency ω, swept together."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.measures.objectives.objective import Scores
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.evaluator import gains_tried


@dataclass(frozen=True, eq=False)
class VanillaSweep:
    """What a vanilla controller reaches on an environment, over σ and ω."""

    sigma: np.ndarray
    """Gains [rad/(s N)], the first of them 0: the bare rhythm. Shape [gains]."""
    omega: np.ndarray
    """Frequencies [rad/s], [frequencies]."""
    fitness: np.ndarray
    """The experiment's objective, [gains, frequencies]."""
    cot_inverse: np.ndarray
    """CoT⁻¹ [m/J], NaN where it is not measured, likewise."""
    failed: np.ndarray
    """Whether an episode failed, likewise."""

    @property
    def best(self) -> tuple[int, int]:
        """Where the fitness is highest: indices of σ and ω."""
        row, column = np.unravel_index(int(np.argmax(self.fitness)), self.fitness.shape)
        return int(row), int(column)


def sweep_vanilla(
    experiment: EnvExperiment, omega: Sequence[float], workers: int | None = None
) -> VanillaSweep:
    """Try a constant gain at several frequencies; deterministic.

    Args:
        experiment: of a model whose only weight is σ, such as V-sector-w8; tried are σ = 0 and its
            `gains`.
        omega: frequencies [rad/s].
        workers: worker processes, where the environment is no MuJoCo model.

    Raises:
        TegotaeError: for a model with more to learn, or a frequency that is none.
    """
    if not experiment.is_searched:
        raise TegotaeError(
            f"{experiment.name} has more to learn than a gain; a baseline takes a pure V model, "
            "such as V-sector-w8"
        )
    among = max(1, len(experiment.omegas))
    at_omega = [
        dataclasses.replace(
            experiment,
            wiring=dataclasses.replace(experiment.wiring, omega=float(one)),
            omegas=(),
            episodes=experiment.episodes // among,
            evaluation_episodes=experiment.evaluation_episodes // among,
        )
        for one in omega
    ]
    gains = np.concatenate([[0.0], experiment.gains])
    tried: list[Scores] = []
    with reporting(f"{experiment.name} on {experiment.spec.env}", len(omega)) as reporter:
        for there in at_omega:
            tried.append(gains_tried(there, gains, workers))
            best = f"ω {there.omega:g} rad/s  fitness {tried[-1].fitness.max():+.3f}"
            reporter.update(len(tried), best)
    columns = (np.stack(column, axis=1) for column in zip(*tried, strict=True))
    return VanillaSweep(gains, np.asarray(omega, float), *columns)
