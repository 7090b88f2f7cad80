"""A short training of a user's own parts."""

from typing import Any

from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run


def run_of(parts: Any, generations: int = 3) -> Run[Any]:
    """The run, of two seeds, under the module's own experiment and algorithm."""
    return Run(
        experiment=parts.experiment,
        seeds=(0, 1),
        learner=Evolution(algorithm=parts.Climb(), stopping=Stopping.after(generations)),
    )
