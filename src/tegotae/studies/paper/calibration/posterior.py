"""Approximate Bayesian computation: the readings whose scores are nearest to what was said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError


@dataclass(frozen=True)
class CalibrationPosterior:
    """The readings that agree best, a sample of the posterior.

    Args:
        accepted: their numbers, the nearest first, [accepted].
        distance: of all readings, [readings].
        threshold: the largest distance among the accepted.
    """

    accepted: np.ndarray
    distance: np.ndarray
    threshold: float


def distances(scores: np.ndarray, target: np.ndarray | None = None) -> np.ndarray:
    """How far each reading's scores are from a target, [readings].

    The root of the mean square; an undefined score is as far off as a score can be, and one that
    the target does not define counts for none.

    Args:
        scores: [readings, scores], from 0 to 1.
        target: [scores]; 1 each by default, which is what the paper says.
    """
    scores = np.asarray(scores, float)
    target = np.ones(scores.shape[1]) if target is None else np.asarray(target, float)
    asked = np.isfinite(target)
    off = np.where(np.isfinite(scores[:, asked]), scores[:, asked] - target[asked], 1.0)
    return np.sqrt(np.mean(off**2, axis=1))


def posterior(
    scores: np.ndarray, share: float = 0.05, target: np.ndarray | None = None
) -> CalibrationPosterior:
    """The nearest share of the readings.

    Args:
        scores: [readings, scores].
        share: how many are accepted; several shares show what the threshold does.
        target: as for `distances`.

    Raises:
        TegotaeError: for a share that accepts none, or more than all.

    Example:
        >>> import numpy as np
        >>> posterior(np.array([[0.2], [0.9], [0.5]]), share=0.4).accepted.tolist()
        [1]
    """
    far = distances(scores, target)
    count = round(share * len(far))
    if not 0.0 < share <= 1.0 or count < 1:
        raise TegotaeError(
            f"share is {share:g} of {len(far)} readings; it must accept at least one, and be at "
            "most 1"
        )
    accepted = np.argsort(far, kind="stable")[:count]
    return CalibrationPosterior(accepted, far, float(far[accepted[-1]]))


def narrowed(coordinates: np.ndarray, accepted: np.ndarray) -> np.ndarray:
    """How narrow each choice is among the accepted: their spread over that of all, [choices].

    About 1 where the scores say nothing about a choice: it remains undetermined.

    Args:
        coordinates: of all readings, [readings, choices].
        accepted: numbers of the accepted.
    """
    spread = coordinates.std(axis=0)
    return coordinates[accepted].std(axis=0) / np.where(spread > 0.0, spread, 1.0)
