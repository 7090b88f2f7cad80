"""Names of gaits: the nearest of the field's patterns of lags, or none.

A name is a label on a continuum; the lags beside it are what was found.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.summary import Coordination

TOLERANCE = 0.1
"""How far the lag between any two legs may be from a pattern's [cycles]."""

RUNNING_TOLERANCE = 0.2
"""The same of gallops and canter, whose lags vary more among animals [cycles]."""
MOST_DUTY = 0.5
"""Mean share of the stride in stance below which legs run, as gallop and canter have it."""
LEAST_FLIGHT = 0.05
"""Share of the time without a foot on the ground from which on a gallop has a flight."""

IN_BETWEEN = "in between"
"""Locked, and like no pattern."""
AS_RELEASED = "as released"
"""The lags never moved from those of the release: nothing synchronised."""
NOT_LOCKED = "not locked"
"""The lags do not stay where they are."""
STANDING = "standing"
"""The rhythm of the reference leg stands still."""
FALLEN = "fallen"
"""The body fell."""
NO_GAIT = (IN_BETWEEN, AS_RELEASED, NOT_LOCKED, STANDING, FALLEN)
"""All of them."""

UNMOVED = 1e-3
"""Lags that were never farther than this from those of the release have not moved [cycles]."""

_CANTER = "canter"
_RUNNING = ("transverse gallop", "rotary gallop", _CANTER)
_HILDEBRAND = "Hildebrand, Science 150 (1965)"
_ALEXANDER = "Alexander, Int. J. Robotics Research 3 (1984)"
_COLLINS = "Collins and Stewart, J. Nonlinear Science 3 (1993)"
_COLLINS_INSECTS = "Collins and Stewart, Biological Cybernetics 68 (1993)"


@dataclass(frozen=True)
class Pattern:
    """A gait of the field: when each leg steps, in cycles, by the legs' names."""

    name: str
    lags: Mapping[str, float]
    """Cycles after any common start."""
    source: str

    def mirrored(self) -> Pattern:
        """The same with left and right exchanged."""
        sides = str.maketrans("LR", "RL")
        return Pattern(
            self.name, {leg.translate(sides): lag for leg, lag in self.lags.items()}, self.source
        )


def _of_four(name: str, lh: float, lf: float, rh: float, rf: float, source: str) -> Pattern:
    return Pattern(name, {"LH": lh, "LF": lf, "RH": rh, "RF": rf}, source)


def _of_six(name: str, left: tuple[float, ...], right: tuple[float, ...], source: str) -> Pattern:
    """Lags of hind, middle and fore legs, left and right."""
    legs = ("LH", "LM", "LF", "RH", "RM", "RF")
    return Pattern(name, dict(zip(legs, (*left, *right), strict=True)), source)


_THIRD, _SIXTH = 1 / 3, 1 / 6

PATTERNS: tuple[Pattern, ...] = (
    Pattern("in phase", {"H": 0, "F": 0}, _COLLINS),
    Pattern("antiphase", {"H": 0, "F": 0.5}, _COLLINS),
    Pattern("in phase", {"L": 0, "R": 0}, _COLLINS),
    Pattern("antiphase", {"L": 0, "R": 0.5}, _COLLINS),
    _of_four("pronk", 0, 0, 0, 0, _COLLINS),
    _of_four("bound", 0, 0.5, 0, 0.5, _ALEXANDER),
    _of_four("pace", 0, 0, 0.5, 0.5, _HILDEBRAND),
    _of_four("trot", 0, 0.5, 0.5, 0, _HILDEBRAND),
    _of_four("lateral-sequence walk", 0, 0.25, 0.5, 0.75, _HILDEBRAND),
    _of_four("diagonal-sequence walk", 0, 0.75, 0.5, 0.25, _HILDEBRAND),
    # Of galloping animals these lags vary more than those above. The hind legs step shortly after
    # one another, then the fore legs: in the same order, or in the opposite one.
    _of_four("transverse gallop", 0, 0.5, 0.1, 0.6, _COLLINS),
    _of_four("rotary gallop", 0, 0.6, 0.1, 0.5, _COLLINS),
    # Three beats: a hind leg, the other one with the fore leg diagonal to it, the other fore leg.
    _of_four(_CANTER, 0, 0.3, 0.3, 0.7, _ALEXANDER),
    _of_six("pronk", (0, 0, 0), (0, 0, 0), _COLLINS_INSECTS),
    _of_six("tripod", (0, 0.5, 0), (0.5, 0, 0.5), _COLLINS_INSECTS),
    _of_six("tetrapod", (0, _THIRD, 2 * _THIRD), (_THIRD, 2 * _THIRD, 0), _COLLINS_INSECTS),
    _of_six(
        "metachronal wave",
        (0, _SIXTH, 2 * _SIXTH),
        (3 * _SIXTH, 4 * _SIXTH, 5 * _SIXTH),
        _COLLINS_INSECTS,
    ),
)
"""The patterns with names; of those with a left and a right, their mirror images too."""


def patterns_for(legs: Sequence[str]) -> tuple[Pattern, ...]:
    """The patterns of legs with these names, each with its mirror image.

    Of legs that no pattern knows there is one: all of them in phase.

    Example:
        >>> [pattern.name for pattern in patterns_for(("H", "F"))]
        ['in phase', 'antiphase']
    """
    found: list[Pattern] = []
    for pattern in PATTERNS:
        if set(pattern.lags) == set(legs):
            mirror = pattern.mirrored()
            same = distance(_row(pattern, legs), _row(mirror, legs))[0] < 1e-9
            found += [pattern] if same else [pattern, mirror]
    return tuple(found) or (Pattern("in phase", dict.fromkeys(legs, 0.0), _COLLINS),)


def distance(lag: ArrayLike, pattern: ArrayLike) -> np.ndarray:
    """How far lags are from a pattern: that of the two legs that differ most, [lanes] [cycles].

    `max_ij |(lag_i - lag_j) - (p_i - p_j)|` the short way round, so that neither a reference leg
    nor a common shift counts.

    Args:
        lag: [limbs, lanes].
        pattern: [limbs, lanes], or [limbs, 1].

    Example:
        >>> distance([[0.0], [0.45]], [[0.5], [0.0]]).round(6).tolist()
        [0.05]
    """
    off = np.asarray(lag, float) - np.asarray(pattern, float)
    between = (off[:, None] - off[None, :] + 0.5) % 1.0 - 0.5
    return np.abs(between).max(axis=(0, 1))


def named(lag: ArrayLike, legs: Sequence[str], tolerance: float = TOLERANCE) -> np.ndarray:
    """The name of the nearest pattern, or "in between", [lanes].

    Args:
        lag: behind any leg, [limbs, lanes] [cycles]; NaN where undefined, which is in between.
        legs: their names (`tegotae.measures.gaits.places`), [limbs].
        tolerance: how far the lag between any two legs may be from the pattern's [cycles].

    Raises:
        TegotaeError: for lags of another number of legs, or a tolerance out of (0, 0.5].

    Example:
        >>> named([[0, 0, 0], [0.48, 0.97, 0.25]], ("H", "F")).tolist()
        ['antiphase', 'in phase', 'in between']
    """
    lag = np.asarray(lag, float)
    if lag.ndim != 2 or len(lag) != len(legs):
        raise TegotaeError(
            f"lags have shape {lag.shape}; of {len(legs)} legs they must be [{len(legs)}, lanes]"
        )
    require_finite("tolerance", tolerance, above=0.0, most=0.5)
    return _nearest(lag, legs, patterns_for(legs), tolerance)


def _nearest(
    lag: ArrayLike, legs: Sequence[str], patterns: Sequence[Pattern], tolerance: float
) -> np.ndarray:
    """The name of the nearest of some patterns, or "in between", [lanes]."""
    off = np.stack([distance(lag, _row(pattern, legs)) for pattern in patterns])
    off = np.where(np.isfinite(off), off, np.inf)
    nearest = np.array([pattern.name for pattern in patterns], object)[off.argmin(axis=0)]
    # What is at the border, as near as floats can resolve, is within it.
    return np.where(off.min(axis=0) <= tolerance + 1e-9, nearest, IN_BETWEEN).astype(str)


def gait_of(
    found: Coordination,
    legs: Sequence[str],
    tolerance: float = TOLERANCE,
) -> np.ndarray:
    """What every lane does: the name of its gait, or why it has none (`NO_GAIT`), [lanes].

    Lags alone do not make a gallop: it runs, with a duty factor below `MOST_DUTY`, and flies, for
    `LEAST_FLIGHT` of the time at least. A canter runs. Both may be `RUNNING_TOLERANCE` from their
    pattern, if no other one is nearer than the tolerance.

    Args:
        found: the coordination of the legs.
        legs: their names.
        tolerance: as for `named`.

    Example:
        >>> import numpy as np
        >>> values = {name: np.zeros(2) for name in Coordination._fields}
        >>> values |= dict(lag=np.array([[0, 0], [0.5, 0.5]]), moved=np.array([0.2, 0.0]))
        >>> values |= dict(fall_time_s=np.full(2, np.nan), cycle_frequency_hz=np.ones(2))
        >>> gait_of(Coordination(**values), ("H", "F")).tolist()
        ['antiphase', 'as released']
    """
    name = named(found.lag, legs, tolerance).astype(object)
    patterns = tuple(p for p in patterns_for(legs) if p.name in _RUNNING)
    if patterns:
        wide = max(tolerance, RUNNING_TOLERANCE)
        free = np.isin(name, (IN_BETWEEN, *_RUNNING))
        name = np.where(free, _nearest(found.lag, legs, patterns, wide), name)
        runs = np.mean(found.duty_factor, axis=0) < MOST_DUTY
        flies = np.asarray(found.flight_share) >= LEAST_FLIGHT
        holds = runs & (flies | (name == _CANTER))
        name = np.where(np.isin(name, _RUNNING) & ~holds, IN_BETWEEN, name)
    name = np.where(np.isfinite(found.lock_time_s), name, NOT_LOCKED)
    name = np.where(np.asarray(found.moved) <= UNMOVED, AS_RELEASED, name)
    name = np.where(np.asarray(found.cycle_frequency_hz) > 0.0, name, STANDING)
    return np.where(np.isfinite(found.fall_time_s), FALLEN, name).astype(str)


def _row(pattern: Pattern, legs: Sequence[str]) -> np.ndarray:
    return np.array([[pattern.lags[leg]] for leg in legs])
