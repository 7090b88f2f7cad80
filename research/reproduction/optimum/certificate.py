"""The upper bound: no force does better, shown by a function that can only fall along any gait.

Let V(x, ẋ) be continuous, λ >= 0 and μ numbers such that

    in stance, for every force:  dV/dt + μ <= λ |F_a ẋ|,
    over a flight that leaves at v:  V(0, -v) - V(0, v) + v²/2g + μ (2 v/g - T [it is a hop]) <= 0.

Summed over the cycle of any gait, V drops out: `climb + μ (time - hops · T) <= λ work`. So a gait
whose hops take the time T on average has CoT⁻¹ <= λ (weak duality). With V a piecewise polynomial
and the force at either end (the condition is convex in it), both conditions are polynomials of a
cell, linear in V's coefficients, and hold where their Bernstein coefficients do. The least λ is a
linear program. Its conditions are tightened by more than the solver's tolerance, and checked
afterwards in float64; `research.reproduction.optimum.exact` checks them in rational arithmetic,
without rounding.
"""

from __future__ import annotations

import contextlib
import heapq
import math
from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np
from scipy import sparse

from research.reproduction.optimum.problem import (
    check_ballistic,
    least_lift_off,
    most_lift_off,
    most_speed,
)
from tegotae._support.errors import TegotaeError, require, require_count
from tegotae.parts.bodies import Body, Hopper

_DEGREE = 2
_GRADING = 1.5  # cells are finer near touchdown and near rest
_MARGIN = 1e-6  # by how much conditions are tightened, over their largest coefficient
_LARGEST = 100.0  # of V, over the highest hop
_ATTEMPTS = (0, -1, 1, -2, 2)  # other grids, where the solver does not converge
_OUTWARDS = 1e-15  # by how much roots are rounded to the safe side: more than they may be off
LONGEST_S = 60.0
"""Time of a hop that "any frequency" stands for: at least one hop a minute [s]."""


@dataclass(frozen=True)
class Certificate:
    """A bound and its proof.

    Args:
        bound: λ: no gait of its kind has a larger CoT⁻¹ [m/J]. Zero if there is no such gait.
        time_price: μ [m/s]. It cannot be positive, as the mass can be held in stance for nothing;
            so the bound holds for all faster hops, too.
        heights_m: knots of V over the height over touchdown x [m].
        speeds_m_per_s: knots of V over the velocity [m/s].
        coefficients: Bernstein coefficients of V [m], neighbouring cells share those of their edge.
        omega: mean hop frequency that it is made for [rad/s]; None for any, of a hop a minute.
        lift_off: lift-off velocities of the hops that it speaks of [m/s].
        work: definition of work.
    """

    bound: float
    time_price: float
    heights_m: np.ndarray
    speeds_m_per_s: np.ndarray
    coefficients: np.ndarray
    omega: float | None = None
    lift_off: tuple[float, float] = (0.0, math.inf)
    work: str = "absolute"


def certify(
    body: Body,
    omega: float | None = None,
    *,
    lift_off: tuple[float, float] | None = None,
    work: str = "absolute",
    cells: int = 8,
) -> Certificate:
    """Compute an upper bound of CoT⁻¹ over gaits of any period.

    Args:
        body: the hopper.
        omega: mean hop frequency ω [rad/s], 2π times hops over time; None for any, of at
            least one hop a minute.
        lift_off: lift-off velocities of the hops lie in this range [m/s]; None for any. Flights too
            low to count as hops are allowed in any case.
        work: definition of work, one of "absolute", "positive", "net".
        cells: cells of V over the leg's length, and over the velocities of either sign.

    Raises:
        TegotaeError: for what `problem.check_ballistic` refuses, or if the linear program does not
            end at a bound that its own conditions confirm.
        MissingExtraError: if CasADi is not installed.

    Example:
        >>> from tegotae import Hopper
        >>> f"{certify(Hopper(), 4.0, cells=6).bound:.1f} m/J"
        '1.3 m/J'
    """
    body = check_ballistic(body, omega, work)
    require_count("cells", cells, least=2)
    lowest_speed, highest_speed = _lift_offs(body)
    low, high = lift_off or (lowest_speed, highest_speed)
    if not lowest_speed <= low < high:
        raise TegotaeError(
            f"lift_off is ({low:g}, {high:g}); it must be a range, from {lowest_speed:.3g} m/s on"
        )
    # Lower flights are no hops. Where hops begin higher, so that both end there, it is rounded up.
    lowest = (1.0 + 2.0 * _OUTWARDS) * lowest_speed
    low, lowest = (lowest_speed, lowest_speed) if low <= lowest else (low, lowest)
    hop_s = 2.0 * math.pi / omega if omega is not None else LONGEST_S
    for increment in _ATTEMPTS:
        heights, speeds = _knots(body, max(2, cells + increment), (lowest, low, high))
        matrix, limit = _join(
            _stance(body, heights, speeds, work),
            _flight(body, heights, speeds, hop_s, (lowest, low, high)),
        )
        scale = np.asarray(abs(matrix).max(axis=1).todense()).ravel()
        largest = _LARGEST * highest_speed**2 / (2.0 * body.gravity_m_per_s2)
        solution = _minimise(matrix, limit - _MARGIN * scale, largest)
        if solution is None or np.any(matrix @ solution > limit + 1e-15):
            continue
        value, price = map(float, solution[-2:])
        if price > 0.0:
            continue  # rounding: it would not hold for faster hops
        shape = (len(heights) - 1) * _DEGREE + 1, (len(speeds) - 1) * _DEGREE + 1
        coefficients = solution[:-2].reshape(shape)
        value = max(value, 0.0)
        return Certificate(value, price, heights, speeds, coefficients, omega, (low, high), work)
    frequency = "any frequency" if omega is None else f"{omega:g} rad/s"
    raise TegotaeError(
        f"no upper bound was found at {frequency}: the linear program did not converge; try other "
        f"cells than {cells}"
    )


def upper_bound(
    body: Body,
    omega: float | None = None,
    *,
    best: float = 0.0,
    work: str = "absolute",
    cells: int = 8,
    programs: int = 16,
) -> float:
    """Compute an upper bound of CoT⁻¹ over gaits of period 1 [m/J]: every hop alike.

    The largest bound of `upper_certificates`, whose errors it has; zero if no hop is so fast.

    Args:
        body: the hopper.
        omega: hop frequency ω [rad/s]; None for any.
        best: CoT⁻¹ of a gait that is known [m/J].
        work: definition of work, one of "absolute", "positive", "net".
        cells: as in `certify`.
        programs: how many linear programs to solve at most.
    """
    options = {"best": best, "work": work, "cells": cells, "programs": programs}
    return max(
        (certificate.bound for certificate in upper_certificates(body, omega, **options)),
        default=0.0,
    )


def upper_certificates(
    body: Body,
    omega: float | None = None,
    *,
    best: float = 0.0,
    work: str = "absolute",
    cells: int = 8,
    programs: int = 16,
) -> list[Certificate]:
    """Return certificates that bound CoT⁻¹ together, over gaits of period 1: every hop alike.

    Branch and bound on the lift-off velocity: the range whose bound is largest is halved, until it
    is so narrow, or so near the best gait that is known, that more would not show.

    Args:
        body: the hopper.
        omega: hop frequency ω [rad/s]; None for any.
        best: CoT⁻¹ of a gait that is known [m/J].
        work: definition of work, one of "absolute", "positive", "net".
        cells: as in `certify`.
        programs: how many linear programs to solve at most.

    Returns:
        certificates whose lift-off velocities cover all that are possible; none if no hop is so
        fast.

    Raises:
        TegotaeError: for what `certify` refuses.
        MissingExtraError: if CasADi is not installed.
    """
    body = check_ballistic(body, omega, work)
    require_count("programs", programs)
    low, high = _lift_offs(body)
    if omega is not None:  # the flight is at most the whole period
        high = min(high, (1.0 + _OUTWARDS) * math.pi * body.gravity_m_per_s2 / omega)
    if high <= low:
        return []

    def bounded(low: float, high: float) -> Certificate:
        return certify(body, omega, lift_off=(low, high), work=work, cells=cells)

    def entry(proof: Certificate, low: float, high: float) -> tuple[float, float, float, int]:
        proofs.append(proof)
        return -proof.bound, low, high, len(proofs) - 1

    proofs: list[Certificate] = []
    open_ranges = [entry(bounded(low, high), low, high)]
    for _ in range((programs - 1) // 2):
        largest, low, high, number = open_ranges[0]
        if -largest <= 1.005 * best or high - low < 0.01 * high:
            break
        heapq.heappop(open_ranges)
        middle = 0.5 * (low + high)
        for half in ((low, middle), (middle, high)):
            # What bounds the whole bounds its parts, should their program fail.
            proof = proofs[number]
            with contextlib.suppress(TegotaeError):
                proof = min(proof, bounded(*half), key=lambda certificate: certificate.bound)
            heapq.heappush(open_ranges, entry(proof, *half))
    unique = {id(proofs[number]): proofs[number] for *_, number in open_ranges}
    return list(unique.values())


def _lift_offs(body: Hopper) -> tuple[float, float]:
    """Return the least and the largest lift-off velocity of a hop [m/s], rounded outwards."""
    return (1.0 - _OUTWARDS) * least_lift_off(body), (1.0 + _OUTWARDS) * most_lift_off(body)


def _knots(body: Hopper, cells: int, speeds: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the knots of V over heights and velocities; zero and the given speeds are among
    them.
    """
    part = np.linspace(0.0, 1.0, cells + 1) ** _GRADING
    heights = -body.rest_length_m * part[::-1]
    fastest = (1.0 + _OUTWARDS) * most_speed(body)
    ends = np.array([0.0, *sorted(set(speeds)), fastest])
    positive: list[float] = []
    for start, end in pairwise((ends / fastest) ** (1.0 / _GRADING)):
        pieces = max(1, round(cells * (end - start)))
        positive += list(fastest * np.linspace(start, end, pieces + 1)[1:] ** _GRADING)
        positive[-1] = ends[np.abs(ends - positive[-1]).argmin()]  # to the last digit
    return heights, np.concatenate([-np.array(positive[::-1]), [0.0], positive])


# Bernstein polynomials of one variable on a cell: maps of their coefficients.


def _derivative(degree: int) -> np.ndarray:
    """Return the matrix from degree n to n - 1, per length of the cell."""
    return degree * (np.eye(degree, degree + 1, 1) - np.eye(degree, degree + 1))


def _raised(degree: int, times: int = 1) -> np.ndarray:
    """Return the polynomial as one of a higher degree."""
    product = np.eye(degree + 1)
    for n in range(degree, degree + times):
        product = _times_line(n, 1.0, 1.0) @ product
    return product


def _times_line(degree: int, start: float, end: float) -> np.ndarray:
    """Multiply by the line from `start` to `end`: from degree n to n + 1."""
    map_ = np.zeros((degree + 2, degree + 1))
    for i in range(degree + 1):
        map_[i, i] += start * comb(degree, i) / comb(degree + 1, i)
        map_[i + 1, i] += end * comb(degree, i) / comb(degree + 1, i + 1)
    return map_


class _Rows:
    """Inequalities on (V's coefficients, λ, μ), collected block by block."""

    def __init__(self, unknowns: int):
        self.unknowns = unknowns
        self.entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self.limits: list[np.ndarray] = []
        self.count = 0

    def add(self, columns: np.ndarray, block: np.ndarray, value, price, limit) -> None:
        """Add `block V[columns] + value λ + price μ <= limit`, one row per row of the block."""
        rows = self.count + np.arange(len(block))
        self.entries.append(
            (np.repeat(rows, len(columns)), np.tile(columns, len(rows)), block.ravel())
        )
        for column, entry in ((self.unknowns, value), (self.unknowns + 1, price)):
            filled = np.broadcast_to(np.asarray(entry, float), rows.shape)
            self.entries.append((rows, np.full(len(rows), column), filled))
        self.limits.append(np.broadcast_to(np.asarray(limit, float), rows.shape))
        self.count += len(rows)

    def matrix(self) -> tuple[sparse.csr_matrix, np.ndarray]:
        """Return the rows as matrix and limits."""
        row, column, entry = (np.concatenate(part) for part in zip(*self.entries, strict=True))
        shape = (self.count, self.unknowns + 2)
        return sparse.csr_matrix((entry, (row, column)), shape), np.concatenate(self.limits)


def _stance(body: Hopper, heights: np.ndarray, speeds: np.ndarray, work: str) -> _Rows:
    """Add `V_x v + V_v a + μ - λ |F v| <= 0` on every cell, without force and with the largest."""
    n = _DEGREE
    per_row = (len(speeds) - 1) * n + 1
    rows = _Rows(((len(heights) - 1) * n + 1) * per_row)
    local = np.arange(n + 1)
    spring = body.stiffness_n_per_m / body.mass_kg
    damper = body.damping_ns_per_m / body.mass_kg
    raised, slope = _raised(n), _raised(n - 1, 2) @ _derivative(n)
    along = np.arange(n + 2) / (n + 1)  # Bernstein coefficients of the cell's own line
    for i in range(len(heights) - 1):
        x0, x1 = heights[i : i + 2]
        for j in range(len(speeds) - 1):
            v0, v1 = speeds[j : j + 2]
            columns = ((i * n + local)[:, None] * per_row + j * n + local).ravel()
            moving = np.kron(slope / (x1 - x0), _times_line(n, v0, v1))
            braking = _times_line(n - 1, -damper * v0, -damper * v1) @ _derivative(n) / (v1 - v0)
            damped = np.kron(raised, raised @ braking)
            sign = {"absolute": 1 if v0 >= 0.0 else -1, "positive": int(v0 >= 0.0), "net": 1}[work]
            rate = np.tile(sign * (v0 + (v1 - v0) * along), n + 2)
            for force in (0.0, body.max_force_n):
                push = force / body.mass_kg - body.gravity_m_per_s2
                held = _times_line(n, push - spring * x0, push - spring * x1)
                pushed = np.kron(held, slope / (v1 - v0))
                rows.add(columns, moving + pushed + damped, -force * rate, 1.0, 0.0)
    return rows


def _flight(
    body: Hopper,
    heights: np.ndarray,
    speeds: np.ndarray,
    hop_s: float,
    lift_off: tuple[float, float, float],
) -> _Rows:
    """Add `V(0, -v) - V(0, v) + v²/2g + μ (2 v/g - T) <= 0` over the lift-off velocities.

    Those of the lowest hop, and of the range that hops are in.
    """
    n, gravity = _DEGREE, body.gravity_m_per_s2
    per_row = (len(speeds) - 1) * n + 1
    top = (len(heights) - 1) * n * per_row
    rows = _Rows(top + per_row)
    lowest, low, high = lift_off
    for j in range(len(speeds) // 2, len(speeds) - 1):
        v0, v1 = speeds[j : j + 2]
        hops = v0 >= lowest
        if hops and not (low <= v0 and v1 <= high):
            continue
        up = j * n + np.arange(n + 1)
        down = per_row - 1 - up
        columns = top + np.concatenate([down, up])
        block = np.hstack([np.eye(n + 1), -np.eye(n + 1)])
        climb = _raised(2, n - 2) @ (_times_line(1, v0, v1) @ [v0, v1]) / (2.0 * gravity)
        time_s = _raised(1, n - 1) @ [v0, v1] * 2.0 / gravity
        rows.add(columns, block, 0.0, time_s - (hop_s if hops else 0.0), -climb)
    return rows


def _join(*parts: _Rows) -> tuple[sparse.csr_matrix, np.ndarray]:
    matrices, limits = zip(*(part.matrix() for part in parts), strict=True)
    joined = sparse.csr_matrix(sparse.vstack(matrices))
    joined.data[np.abs(joined.data) < 1e-12] = 0.0  # rounding of what cancels
    joined.eliminate_zeros()
    return joined, np.concatenate(limits)


def _minimise(matrix: sparse.csr_matrix, limit: np.ndarray, largest: float) -> np.ndarray | None:
    """Return the unknowns of least λ within the inequalities, or None if the solver fails.

    V stays below `largest`: where it does not matter, it would grow until rounding does.
    """
    casadi = require("casadi", "optimum")
    scale = np.asarray(abs(matrix).max(axis=1).todense()).ravel()
    scale = np.where(scale > 0.0, scale, 1.0)
    scaled = sparse.csc_matrix(sparse.diags(1.0 / scale) @ matrix)
    scaled.sort_indices()
    rows, columns = len(limit), scaled.indptr.size - 1
    pattern = casadi.Sparsity(rows, columns, scaled.indptr.tolist(), scaled.indices.tolist())
    cost = np.zeros(columns)
    cost[-2] = 1.0
    lowest, highest = np.full(columns, -largest), np.full(columns, largest)
    lowest[0] = highest[0] = 0.0  # V is known up to a constant
    lowest[-2:], highest[-2:] = (0.0, -np.inf), np.inf
    settings = {"solver": "ipm", "run_crossover": "off", "output_flag": False, "threads": 1}
    solver = casadi.conic(
        "bound",
        "highs",
        {"h": casadi.Sparsity(columns, columns), "a": pattern},
        {"highs": settings, "error_on_fail": False},
    )
    result = solver(
        g=cost,
        a=casadi.DM(pattern, scaled.data),
        lba=-np.inf,
        uba=limit / scale,
        lbx=lowest,
        ubx=highest,
    )
    solution = np.asarray(result["x"]).ravel()
    return solution if np.isfinite(solution).all() else None
