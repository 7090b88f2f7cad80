"""The search for a vanilla controller's best gain, on the engine or an environment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.measures.objectives.objective import Scores
from tegotae.systems.experiment import Trainable

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment


def best_gain(experiment: Trainable, workers: int | None = None) -> tuple[float, float]:
    """Return the σ of highest fitness on a fixed grid, and that fitness; the search is
    deterministic.

    Of several frequencies (`Trainable.searched_in`) it is the mean fitness that counts.

    Under changing conditions every σ meets the same episodes, the evaluation set.

    Args:
        experiment: one whose controller's only weight is σ.
        workers: worker processes, where episodes are not the engine's.
    """
    gains = experiment.gains
    tried = [gains_tried(place, gains, workers).fitness for place in experiment.searched_in]
    fitness = np.mean(tried, axis=0)
    best = int(np.argmax(fitness))
    return float(gains[best]), float(fitness[best])


def gains_tried(experiment: Trainable, gains: np.ndarray, workers: int | None = None) -> Scores:
    """Return the scores of values of σ, [gains] each, all in the same episodes.

    Args:
        experiment: one whose controller's only weight is σ.
        gains: what is tried [rad/(s N)], [gains].
        workers: worker processes, where episodes are not the engine's.
    """
    with experiment.evaluator(workers) as evaluator:
        return evaluator.alike(gains[:, None])


@dataclass(frozen=True, eq=False)
class VanillaSweep:
    """Results of a vanilla controller on an environment, over σ and ω."""

    sigma: np.ndarray
    """Gains [rad/(s N)], the first of them 0: the bare rhythm. Shape [gains]."""
    omega: np.ndarray
    """Frequencies [rad/s], [frequencies]."""
    fitness: np.ndarray
    """The experiment's objective, [gains, frequencies]."""
    cot_inverse: np.ndarray
    """CoT⁻¹ [m/J], NaN where it is not measured, likewise."""
    failed: np.ndarray
    """True where an episode failed, likewise."""

    @property
    def best(self) -> tuple[int, int]:
        """Return the indices of σ and ω with the highest fitness."""
        row, column = np.unravel_index(int(np.argmax(self.fitness)), self.fitness.shape)
        return int(row), int(column)

    def table(self) -> pd.DataFrame:
        """Return the results, one row per gain and frequency."""
        sigma, omega = np.meshgrid(self.sigma, self.omega, indexing="ij")
        columns = {"sigma_rad_per_s_n": sigma, "omega_rad_per_s": omega, "fitness": self.fitness}
        columns |= {"cot_inverse_m_per_j": self.cot_inverse, "failed": self.failed.astype(int)}
        return pd.DataFrame({name: values.ravel() for name, values in columns.items()})

    def best_gains(self) -> pd.DataFrame:
        """Return the best gain of each frequency, for people."""
        best = np.argmax(self.fitness, axis=0)
        columns = {
            "ω [rad/s]": [f"{omega:g}" for omega in self.omega],
            "best σ": [f"{sigma:.3g}" for sigma in self.sigma[best]],
            "fitness": [f"{fitness:.4f}" for fitness in self.fitness.max(axis=0)],
            "fitness at σ = 0": [f"{fitness:.4f}" for fitness in self.fitness[0]],
            "failed": [f"{share:.0%}" for share in self.failed.mean(axis=0)],
        }
        return pd.DataFrame(columns).set_index("ω [rad/s]")

    def advice(self) -> list[str]:
        """Return remedies where feedback does not help."""
        row, column = self.best
        sentences = []
        if np.isfinite(self.cot_inverse).any() and not np.nanmax(self.cot_inverse) > 0.0:
            sentences.append(
                "Nothing hops: CoT⁻¹ is 0 everywhere. Enlarge the pushes, release it higher "
                "(--settings release_m=0.1), or use --fitness return."
            )
        if row == 0:
            sentences.append(
                "No gain is better than zero: feedback does not help the bare rhythm. Check rests "
                "and pushes of the wiring first."
            )
        elif column in (0, len(self.omega) - 1) and len(self.omega) > 1:
            sentences.append(
                "The best ω is the last one tried: --frequencies beyond it may do better."
            )
        return sentences


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
            wiring=dataclasses.replace(experiment.wiring, omega=float(frequency)),
            omegas=(),
            episodes=experiment.episodes // among,
            evaluation_episodes=experiment.evaluation_episodes // among,
        )
        for frequency in omega
    ]
    gains = np.concatenate([[0.0], experiment.gains])
    tried: list[Scores] = []
    with reporting(f"{experiment.name} on {experiment.spec.env}", len(omega)) as reporter:
        for experiment_there in at_omega:
            tried.append(gains_tried(experiment_there, gains, workers))
            best = f"ω {experiment_there.omega:g} rad/s  fitness {tried[-1].fitness.max():+.3f}"
            reporter.update(len(tried), best)
    columns = (np.stack(column, axis=1) for column in zip(*tried, strict=True))
    return VanillaSweep(gains, np.asarray(omega, float), *columns)
