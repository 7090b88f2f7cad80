"""Names of legs and of gaits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.gaits.summary import Coordination
from tegotae.parts.bodies import Body
from tegotae.parts.fields import unwrapped
from tegotae.simulation.recorder import Trajectory

_ROWS = {1: ("",), 2: ("H", "F"), 3: ("H", "M", "F")}


def names_of(forward_m: ArrayLike, left_m: ArrayLike) -> tuple[str, ...]:
    """Return the names of legs from the places of their hips, after Hildebrand: LH, LF, RH, RF.

    L and R are left and right, H, M and F hind, middle and fore. Without a left and a right, as on
    a bar, or without hind and fore, as on a biped, that letter is left out. Legs that such letters
    do not distinguish are numbered from 1 on, in their order.

    Args:
        forward_m: how far forward of the middle each hip is, [limbs].
        left_m: how far to the left, [limbs].

    Raises:
        TegotaeError: for places that are not as many.

    Source:
        Hildebrand, Symmetrical gaits of horses, Science 150 (1965).

    Example:
        >>> names_of((-1, -1, 1, 1), (1, -1, 1, -1))
        ('LH', 'RH', 'LF', 'RF')
        >>> names_of((-0.5, 0.5), (0, 0)), names_of((0, 0), (0.1, -0.1))
        (('H', 'F'), ('L', 'R'))
        >>> names_of((-1, -0.3, 0.3, 1), (0, 0, 0, 0))
        ('1', '2', '3', '4')
    """
    forward, leftward = np.asarray(forward_m, float), np.asarray(left_m, float)
    if forward.ndim != 1 or forward.shape != leftward.shape:
        raise TegotaeError(
            f"hips have {forward.size} places along the body and {leftward.size} across it; each "
            "needs one of both"
        )
    rows = np.unique(forward.round(6))
    sides = np.sign(leftward.round(6)).astype(int)
    row_names = _ROWS.get(len(rows), ("",) * len(rows))
    names = [
        ("", "L", "R")[side] + row_names[int(np.searchsorted(rows, position))]
        for side, position in zip(sides, forward.round(6), strict=True)
    ]
    if len(set(names)) == len(forward) and all(names):
        return tuple(names)
    return tuple(str(leg) for leg in range(1, len(forward) + 1))


def reference_leg(names: Sequence[str]) -> int:
    """Return the leg from which lags are measured: the left hind leg, or the first if there is
    none.

    Example:
        >>> reference_leg(("LF", "RF", "LH", "RH")), reference_leg(("H", "F"))
        (2, 0)
    """
    return list(names).index("LH") if "LH" in names else 0


def leg_names(body: Body) -> tuple[str, ...]:
    """Return the names of a body's legs, from its hips, or numbers if it has no places of hips.

    Hips are `hips_x_m`, forward, and `hips_y_m`, to the left (or `hips_z_m`, on a plate); or
    `hips_m` along a bar.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> leg_names(Bar())
        ('H', 'F')
    """
    body = unwrapped(body)
    forward = getattr(body, "hips_x_m", getattr(body, "hips_m", None))
    if forward is None:
        return tuple(str(leg) for leg in range(1, body.limbs + 1))
    leftward = getattr(body, "hips_y_m", getattr(body, "hips_z_m", np.zeros(len(forward))))
    return names_of(forward, leftward)


HEADING = ("time_s", "x_m", "y_m", "yaw_rad")
"""The channels from which it follows."""


def speed_ahead_m_per_s(trajectory: Trajectory, first: int) -> jax.Array:
    """Return the mean speed from a frame on, along the body's heading at each frame [m/s], [lanes].

    `v = Σ (Δx cos ψ + Δy sin ψ) / T`, frame by frame: of who walks backwards it is negative, and
    who walks in a circle is as fast as who walks straight.

    Args:
        trajectory: which has the channels `HEADING`, [frames, lanes].
        first: the frame.

    Example:
        >>> there = {"x_m": jnp.array([[0.0], [2.0]]), "y_m": jnp.zeros((2, 1))}
        >>> back = {"time_s": jnp.array([[0.0], [4.0]]), "yaw_rad": jnp.full((2, 1), jnp.pi)}
        >>> speed_ahead_m_per_s(Trajectory(**there, **back), 0).tolist()
        [-0.5]
    """
    time, x, y, looks = (jnp.asarray(getattr(trajectory, name))[first:] for name in HEADING)
    ahead = jnp.diff(x, axis=0) * jnp.cos(looks[:-1]) + jnp.diff(y, axis=0) * jnp.sin(looks[:-1])
    return ahead.sum(axis=0) / (time[-1] - time[0])


def speed_along_heading_m_per_s(trajectory: Trajectory, first: int) -> jax.Array:
    """Return the mean speed from a frame on, along the body's heading at that frame [m/s], [lanes].

    `v = (Δx cos ψ + Δy sin ψ) / T` with ψ at that frame: who turns or drifts is slower.

    Args:
        trajectory: which has the channels `HEADING`, [frames, lanes].
        first: the frame.

    Example:
        >>> there = {"x_m": jnp.array([[0.0], [2.0]]), "y_m": jnp.zeros((2, 1))}
        >>> late = {"time_s": jnp.array([[0.0], [4.0]]), "yaw_rad": jnp.array([[0.0], [3.0]])}
        >>> speed_along_heading_m_per_s(Trajectory(**there, **late), 0).tolist()
        [0.5]
    """
    time, x, y, looks = (jnp.asarray(getattr(trajectory, name))[first:] for name in HEADING)
    ahead = (x[-1] - x[0]) * jnp.cos(looks[0]) + (y[-1] - y[0]) * jnp.sin(looks[0])
    return ahead / (time[-1] - time[0])


TOLERANCE = 0.1
"""Largest difference of a lag between two legs from a pattern's [cycles]."""

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
        """Return this pattern with left and right exchanged."""
        sides = str.maketrans("LR", "RL")
        return Pattern(
            self.name, {leg.translate(sides): lag for leg, lag in self.lags.items()}, self.source
        )


_QUADRUPED, _HEXAPOD = ("LH", "LF", "RH", "RF"), ("LH", "LM", "LF", "RH", "RM", "RF")


def _patterns(legs: tuple[str, ...], *rows: tuple[str, tuple[float, ...], str]) -> list[Pattern]:
    """Return patterns of these legs, each from its name, the legs' lags and its source."""
    return [
        Pattern(name, dict(zip(legs, lags, strict=True)), source) for name, lags, source in rows
    ]


PATTERNS: tuple[Pattern, ...] = (
    *_patterns(("H", "F"), ("in phase", (0, 0), _COLLINS), ("antiphase", (0, 0.5), _COLLINS)),
    *_patterns(("L", "R"), ("in phase", (0, 0), _COLLINS), ("antiphase", (0, 0.5), _COLLINS)),
    *_patterns(
        _QUADRUPED,
        ("pronk", (0, 0, 0, 0), _COLLINS),
        ("bound", (0, 0.5, 0, 0.5), _ALEXANDER),
        ("pace", (0, 0, 0.5, 0.5), _HILDEBRAND),
        ("trot", (0, 0.5, 0.5, 0), _HILDEBRAND),
        ("lateral-sequence walk", (0, 0.25, 0.5, 0.75), _HILDEBRAND),
        ("diagonal-sequence walk", (0, 0.75, 0.5, 0.25), _HILDEBRAND),
        # Of galloping animals these lags vary more than those above. The hind legs step shortly
        # after one another, then the fore legs: in the same order, or in the opposite one.
        ("transverse gallop", (0, 0.5, 0.1, 0.6), _COLLINS),
        ("rotary gallop", (0, 0.6, 0.1, 0.5), _COLLINS),
        # Three beats: a hind leg, the other one with the fore leg diagonal to it, the other fore
        # leg.
        (_CANTER, (0, 0.3, 0.3, 0.7), _ALEXANDER),
    ),
    *_patterns(
        _HEXAPOD,
        ("pronk", (0, 0, 0, 0, 0, 0), _COLLINS_INSECTS),
        ("tripod", (0, 0.5, 0, 0.5, 0, 0.5), _COLLINS_INSECTS),
        ("tetrapod", (0, 1 / 3, 2 / 3, 1 / 3, 2 / 3, 0), _COLLINS_INSECTS),
        ("metachronal wave", (0, 1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6), _COLLINS_INSECTS),
    ),
)
"""The patterns with names; of those with a left and a right, their mirror images too."""


def patterns_for(legs: Sequence[str]) -> tuple[Pattern, ...]:
    """Return the patterns of legs with these names, each with its mirror image.

    Of legs that no pattern knows there is one: all of them in phase.

    Example:
        >>> [pattern.name for pattern in patterns_for(("H", "F"))]
        ['in phase', 'antiphase']
    """
    matches: list[Pattern] = []
    for pattern in PATTERNS:
        if set(pattern.lags) == set(legs):
            mirror = pattern.mirrored()
            symmetric = distance(_row(pattern, legs), _row(mirror, legs))[0] < 1e-9
            matches += [pattern] if symmetric else [pattern, mirror]
    return tuple(matches) or (Pattern("in phase", dict.fromkeys(legs, 0.0), _COLLINS),)


def distance(lag: ArrayLike, pattern: ArrayLike) -> np.ndarray:
    """Return the distance of lags from a pattern: that of the two legs that differ most, [lanes]
    [cycles].

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


def nearest_pattern(
    lag: ArrayLike, legs: Sequence[str], tolerance: float = TOLERANCE
) -> np.ndarray:
    """Return the name of the nearest pattern, or "in between", [lanes].

    Args:
        lag: behind any leg, [limbs, lanes] [cycles]; NaN where undefined, which is in between.
        legs: their names (`tegotae.measures.gaits.names`), [limbs].
        tolerance: how far the lag between any two legs may be from the pattern's [cycles].

    Raises:
        TegotaeError: for lags of another number of legs, or a tolerance out of (0, 0.5].

    Example:
        >>> nearest_pattern([[0, 0, 0], [0.48, 0.97, 0.25]], ("H", "F")).tolist()
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
    """Return the name of the nearest of some patterns, or "in between", [lanes]."""
    off = np.stack([distance(lag, _row(pattern, legs)) for pattern in patterns])
    off = np.where(np.isfinite(off), off, np.inf)
    nearest = np.array([pattern.name for pattern in patterns], object)[off.argmin(axis=0)]
    # What is at the border, as near as floats can resolve, is within it.
    return np.where(off.min(axis=0) <= tolerance + 1e-9, nearest, IN_BETWEEN).astype(str)


def gait_of(
    gait: Coordination,
    legs: Sequence[str],
    tolerance: float = TOLERANCE,
) -> np.ndarray:
    """Return the name of every lane's gait, or the reason why it has none (`NO_GAIT`), [lanes].

    Lags alone do not make a gallop: it runs, with a duty factor below `MOST_DUTY`, and flies, for
    `LEAST_FLIGHT` of the time at least. A canter runs. Both may be `RUNNING_TOLERANCE` from their
    pattern, if no other one is nearer than the tolerance.

    Args:
        gait: the coordination of the legs.
        legs: their names.
        tolerance: as for `nearest_pattern`.

    Example:
        >>> import numpy as np
        >>> values = {name: np.zeros(2) for name in Coordination._fields}
        >>> values |= dict(lag=np.array([[0, 0], [0.5, 0.5]]), moved=np.array([0.2, 0.0]))
        >>> values |= dict(fall_time_s=np.full(2, np.nan), cycle_frequency_hz=np.ones(2))
        >>> gait_of(Coordination(**values), ("H", "F")).tolist()
        ['antiphase', 'as released']
    """
    name = nearest_pattern(gait.lag, legs, tolerance).astype(object)
    patterns = tuple(p for p in patterns_for(legs) if p.name in _RUNNING)
    if patterns:
        wide = max(tolerance, RUNNING_TOLERANCE)
        free = np.isin(name, (IN_BETWEEN, *_RUNNING))
        name = np.where(free, _nearest(gait.lag, legs, patterns, wide), name)
        runs = np.mean(gait.duty_factor, axis=0) < MOST_DUTY
        flies = np.asarray(gait.flight_share) >= LEAST_FLIGHT
        holds = runs & (flies | (name == _CANTER))
        name = np.where(np.isin(name, _RUNNING) & ~holds, IN_BETWEEN, name)
    name = np.where(np.isfinite(gait.lock_time_s), name, NOT_LOCKED)
    name = np.where(np.asarray(gait.moved) <= UNMOVED, AS_RELEASED, name)
    name = np.where(np.asarray(gait.cycle_frequency_hz) > 0.0, name, STANDING)
    return np.where(np.isfinite(gait.fall_time_s), FALLEN, name).astype(str)


def _row(pattern: Pattern, legs: Sequence[str]) -> np.ndarray:
    return np.array([[pattern.lags[leg]] for leg in legs])
