"""Approximate Bayesian computation: the readings whose scores are nearest to what was said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from research.reproduction.calibration.scores import VanillaScores
from tegotae._support.errors import TegotaeError


@dataclass(frozen=True)
class Strictness:
    """Thresholds above which each statement counts as met.

    Args:
        name: what tables call it.
        levels: the least score that meets a statement.
    """

    name: str
    levels: VanillaScores

    @property
    def target(self) -> np.ndarray:
        """The levels as an array, [scores]."""
        return np.array(self.levels)


def _short(t0_s: float, t1_s: float) -> tuple[float, float]:
    """Return the scores of mean transients of these lengths, in an evaluation of 30 and 20 s."""
    return 1.0 - t0_s / 30.0, 1.0 - t1_s / 20.0


STRICTNESS = (
    Strictness("lenient", VanillaScores(0.8, *_short(10.0, 8.0), 0.8, 0.05, 0.4, 0.4, 0.2)),
    Strictness("middle", VanillaScores(0.9, *_short(6.0, 5.0), 0.9, 0.15, 0.6, 0.6, 0.4)),
    Strictness("strict", VanillaScores(1.0, *_short(3.0, 2.5), 1.0, 0.3, 0.8, 0.8, 0.6)),
)
"""The paper sets no thresholds. Three of them show what turns with these."""


@dataclass(frozen=True)
class CalibrationPosterior:
    """The readings that agree best, a weighted sample of the posterior.

    Args:
        accepted: their numbers, the nearest first, [accepted].
        weights: what each counts for, of sum 1, [accepted].
        distance: of all readings, [readings].
        threshold: the distance at which a reading counts no more.
    """

    accepted: np.ndarray
    weights: np.ndarray
    distance: np.ndarray
    threshold: float

    @property
    def effective(self) -> float:
        """Effective number of readings: readings of equal weight that would be as certain."""
        return float(1.0 / np.sum(self.weights**2))


def distances(scores: np.ndarray, target: np.ndarray | None = None) -> np.ndarray:
    """Return the distance of each reading's scores from a target, [readings].

    The root of the mean square; an undefined score is as far off as a score can be, and one that
    the target does not define counts for none.

    Args:
        scores: [readings, scores], from 0 to 1.
        target: [scores]; 1 each by default, which is what the paper says.
    """
    scores = np.asarray(scores, float)
    target = np.ones(scores.shape[1]) if target is None else np.asarray(target, float)
    is_scored = np.isfinite(target)
    off = np.where(np.isfinite(scores[:, is_scored]), scores[:, is_scored] - target[is_scored], 1.0)
    return np.sqrt(np.mean(off**2, axis=1))


def shortfalls(scores: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return the shortfall of each reading's scores below levels, [readings].

    The root of the mean square of the missing share of each level. More than a level is as good as
    the level: the paper calls transients short, and not shorter than that.

    Args:
        scores: [readings, scores], from 0 to 1; an undefined one lacks all of its level.
        levels: [scores].

    Example:
        >>> shortfalls(np.array([[0.5, 1.0], [0.2, 0.4]]), np.array([0.4, 0.8])).round(2).tolist()
        [0.0, 0.5]
    """
    missing = np.clip(1.0 - np.nan_to_num(np.asarray(scores, float)) / levels, 0.0, 1.0)
    return np.sqrt(np.mean(missing**2, axis=1))


def posterior(distance: np.ndarray, share: float = 0.05) -> CalibrationPosterior:
    """Return the nearest share of the readings, weighted by Epanechnikov's kernel of their
    distance.

    Args:
        distance: of all readings, [readings], by `distances` or `shortfalls`.
        share: how many are accepted; several shares show what the threshold does.

    Raises:
        TegotaeError: for a share that accepts none, or more than all.

    Source: M. A. Beaumont, W. Zhang and D. J. Balding, Approximate Bayesian computation in
    population genetics, Genetics 162 (2002), on the kernel.

    Example:
        >>> posterior(np.array([0.8, 0.1, 0.5]), share=0.4).accepted.tolist()
        [1]
    """
    distance = np.asarray(distance, float)
    count = round(share * len(distance))
    if not 0.0 < share <= 1.0 or count < 1:
        raise TegotaeError(
            f"share is {share:g} of {len(distance)} readings; it must accept at least one, and be "
            "at most 1"
        )
    order = np.argsort(distance, kind="stable")
    accepted = order[:count]
    # The first that is left out marks where a reading counts no more.
    threshold = float(distance[order[min(count, len(order) - 1)]])
    weight = 1.0 - (distance[accepted] / threshold) ** 2 if threshold > 0.0 else np.ones(count)
    weight = weight if weight.sum() > 0.0 else np.ones(count)
    return CalibrationPosterior(accepted, weight / weight.sum(), distance, threshold)


def met(scores: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return a mask of the statements that each reading meets, [readings, scores]."""
    return np.nan_to_num(np.asarray(scores, float)) >= levels


def meeting_ratio(scores: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return the frequency of meeting two statements together, over that by chance.

    1 where one says nothing about the other, 0 where they exclude each other; NaN where one is
    never met. [scores, scores].
    """
    is_met = met(scores, levels).astype(float)
    joint = is_met.T @ is_met / len(is_met)
    by_chance = np.outer(is_met.mean(axis=0), is_met.mean(axis=0))
    return np.divide(joint, by_chance, out=np.full(joint.shape, np.nan), where=by_chance > 0.0)


def narrowed(coordinates: np.ndarray, posterior: CalibrationPosterior) -> np.ndarray:
    """Return the spread of each choice among the accepted readings over that of all, [choices].

    About 1 where the scores say nothing about a choice: it remains undetermined.

    Args:
        coordinates: of all readings, [readings, choices].
        posterior: the accepted, with their weights.
    """
    spread = coordinates.std(axis=0)
    accepted = coordinates[posterior.accepted]
    mean = posterior.weights @ accepted
    inside = np.sqrt(posterior.weights @ (accepted - mean) ** 2)
    return inside / np.where(spread > 0.0, spread, 1.0)


def representative(
    posterior: CalibrationPosterior, coordinates: np.ndarray, count: int, tries: int = 4000
) -> np.ndarray:
    """Return different readings that stand for a posterior: their numbers in rising order, [count].

    Of many draws by the weights the one whose energy distance to the posterior is least.

    Args:
        posterior: the posterior.
        coordinates: where all readings lie, [readings, choices].
        count: how many.
        tries: how many draws are compared.

    Raises:
        TegotaeError: for more than were accepted with a weight.

    Source: G. J. Székely and M. L. Rizzo, Energy statistics: a class of statistics based on
    distances, Journal of Statistical Planning and Inference 143 (2013), on the distance.
    """
    weighty = int((posterior.weights > 0.0).sum())
    if not 0 < count <= weighty:
        raise TegotaeError(f"{count} readings cannot be drawn of {weighty} that were accepted")
    accepted = coordinates[posterior.accepted]
    pairwise = np.linalg.norm(accepted[:, None] - accepted[None], axis=-1)
    to_all = pairwise @ posterior.weights
    draw = np.random.default_rng(0)
    best, lowest = np.arange(count), np.inf
    for _ in range(tries):
        some = draw.choice(len(accepted), size=count, replace=False, p=posterior.weights)
        energy = 2.0 * to_all[some].mean() - pairwise[np.ix_(some, some)].mean()
        if energy < lowest:
            best, lowest = some, energy
    return np.sort(posterior.accepted[best])
