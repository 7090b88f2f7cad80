"""When a training has come to its end: a rule that is fixed before anyone looks at a result."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite

_NEVER = 2**31

RUNNING, PLATEAU, CAP = "", "plateau", "cap"
"""Why a run ended; the first if it has not."""

SEARCH = "search"
"""The end of what is not trained but searched for: a pure V model's σ."""


@dataclass(frozen=True, kw_only=True)
class Stopping:
    """Stop a run once its fitness is on a plateau, or at a cap.

    With b(g) the best fitness of the distribution's mean over the first g generations, a run is on
    a plateau after g generations if

        b(g) - b(g - ⌈share · g⌉) <= tolerance   and   g >= least.

    The wait grows with the training, so that a run which found something late is given its time
    again. A jump that comes after a longer wait than this is missed. Each run is decided alone.

    Args:
        generations: the cap: no run has more generations.
        least: generations before which no plateau is seen.
        share: of the training so far, in which nothing may be gained.
        tolerance: what counts as nothing, in units of the fitness [m/J].

    Raises:
        TegotaeError: for a count below one, a share that is not between 0 and 1, or a negative
            tolerance.

    Example:
        >>> rule = Stopping(generations=100, least=10, share=0.5, tolerance=0.01)
        >>> [rule.reason(np.minimum(np.arange(n), 8.0)) for n in (10, 17, 18)]
        ['', '', 'plateau']
    """

    generations: int = 480
    least: int = 240
    share: float = 0.5
    tolerance: float = 0.02

    def __post_init__(self) -> None:
        require_count("generations", self.generations)
        require_count("least", self.least)
        require_finite("share", self.share, above=0.0)
        require_finite("tolerance", self.tolerance, least=0.0)
        if self.share >= 1.0:
            raise TegotaeError(
                f"share is {self.share:g}; it must be less than 1: the part of a training that "
                "gives no gain"
            )

    @classmethod
    def after(cls, generations: int) -> Stopping:
        """Exactly so many generations, plateau or not."""
        return cls(generations=generations, least=_NEVER)

    @property
    def rule(self) -> dict[str, float]:
        """All but the cap: a training can go on under a higher cap, but not under another rule."""
        return {"least": self.least, "share": self.share, "tolerance": self.tolerance}

    def reason(self, fitness: np.ndarray) -> str:
        """Why a run ends after these generations, or the empty string if it goes on.

        Args:
            fitness: of the distribution's mean, generation by generation, shape [generations].
        """
        done = len(fitness)
        before = done - math.ceil(self.share * done)
        if done >= self.least and before >= 1:
            gain = np.max(fitness) - np.max(fitness[:before])
            if gain <= self.tolerance:
                return PLATEAU
        return CAP if done >= self.generations else RUNNING

    def reasons(self, curves: np.ndarray) -> list[str]:
        """The same for runs side by side; a run's curve ends in NaN where it has ended.

        Args:
            curves: shape [generations, runs].
        """
        curves = np.asarray(curves, float)
        return [self.reason(run[~np.isnan(run)]) for run in curves.T]
