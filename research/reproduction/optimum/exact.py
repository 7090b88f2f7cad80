"""Checking a certificate of the upper bound in rational arithmetic: nothing is rounded.

Numbers of the body are taken as they are written (0.1 is a tenth), those of the certificate as the
dyadic fractions that their floats are. All conditions are polynomials over boxes, and hold where
the Bernstein coefficients over each box do. Three quantities are irrational: the least and largest
lift-off velocity and the largest speed are roots, which are compared by their squares; and the time
of a hop has π, for which a larger fraction stands, since μ <= 0 makes that the harder condition.

The conditions are written anew here, not taken from what makes certificates
(`research.reproduction.optimum.certificate`), and no solver is needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from research.reproduction.optimum.certificate import LONGEST_S, Certificate
from research.reproduction.optimum.problem import check_ballistic
from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.hopping import HOP_CLEARANCE
from tegotae.parts.bodies import Body, Hopper

PI_ABOVE = Fraction(314159265358979323846264338328, 10**29)
"""π, rounded up at its thirtieth digit."""

Bernstein = list[Fraction]
"""Bernstein coefficients of a polynomial of one variable over an interval."""


@dataclass(frozen=True)
class ExactNumbers:
    """The body's numbers as fractions, and the squares of its irrational numbers."""

    leg: Fraction
    """Rest length l0 [m]."""
    gravity: Fraction
    """g [m/s²]."""
    spring: Fraction
    """k/m [1/s²]."""
    damper: Fraction
    """c/m [1/s]."""
    force: Fraction
    """α [N]."""
    push: Fraction
    """α/m [m/s²]."""

    @classmethod
    def from_body(cls, body: Hopper) -> ExactNumbers:
        """Return the body's numbers as they are written."""
        mass = decimal_fraction(body.mass_kg)
        return cls(
            leg=decimal_fraction(body.rest_length_m),
            gravity=decimal_fraction(body.gravity_m_per_s2),
            spring=decimal_fraction(body.stiffness_n_per_m) / mass,
            damper=decimal_fraction(body.damping_ns_per_m) / mass,
            force=decimal_fraction(body.max_force_n),
            push=decimal_fraction(body.max_force_n) / mass,
        )

    @property
    def least_squared(self) -> Fraction:
        """The lowest hop's lift-off velocity, squared: 2 g · 0.01 l0."""
        return 2 * self.gravity * decimal_fraction(HOP_CLEARANCE) * self.leg

    @property
    def most_squared(self) -> Fraction:
        """Bound of the squared lift-off velocity: 2 (α/m - g) l0 + k/m l0²."""
        return 2 * (self.push - self.gravity) * self.leg + self.spring * self.leg**2

    @property
    def speed_squared(self) -> Fraction:
        """Bound of the squared speed in stance: while falling, the spring and gravity add g²
        m/k.
        """
        return self.most_squared + self.gravity**2 / self.spring


def verify(certificate: Certificate, body: Body) -> Fraction:
    """Return λ if the certificate proves it: no gait of its kind has a larger CoT⁻¹ [m/J].

    Its kind are gaits whose hops leave the ground within `lift_off`, at a mean frequency of `omega`
    or a higher one.

    Args:
        certificate: what is to be checked.
        body: the hopper that it speaks of.

    Raises:
        TegotaeError: for what `problem.check_ballistic` refuses, or the first condition that does
            not hold.

    Example:
        >>> from tegotae import Hopper
        >>> from research.reproduction.optimum import certify
        >>> proof = certify(Hopper(), 4.0, cells=3)
        >>> float(verify(proof, Hopper())) == proof.bound
        True
    """
    body = check_ballistic(body, certificate.omega, certificate.work)
    exact = ExactNumbers.from_body(body)
    heights, speeds = (
        [Fraction(float(x)) for x in _finite(knots)] for knots in _knots(certificate)
    )
    value, price = _numbers(certificate.bound, certificate.time_price)
    if value < 0 or price > 0:
        raise _fails(f"λ is {float(value):g} and μ {float(price):g}; 0 <= λ and μ <= 0 is needed")
    _check_grid(exact, heights, speeds)
    degree = 2
    shape = degree * (len(heights) - 1) + 1, degree * (len(speeds) - 1) + 1
    if np.shape(certificate.coefficients) != shape:
        raise _fails(f"V has {np.shape(certificate.coefficients)} coefficients, not {shape}")
    table = [[Fraction(float(x)) for x in row] for row in _finite(certificate.coefficients)]
    for i, x in enumerate(pairwise(heights)):
        for j, v in enumerate(pairwise(speeds)):
            patch = [
                row[degree * j : degree * (j + 1) + 1]
                for row in table[degree * i : degree * (i + 1) + 1]
            ]
            sign = _sign(certificate.work, v)
            for push, force in ((Fraction(0), Fraction(0)), (exact.push, exact.force)):
                price_of_work = -value * force * sign
                worst = _largest(_rate(exact, patch, x, v, push, price, price_of_work))
                if worst > 0:
                    raise _fails(
                        f"in stance, with x in [{float(x[0]):.4g}, {float(x[1]):.4g}] m, ẋ in "
                        f"[{float(v[0]):.4g}, {float(v[1]):.4g}] m/s and a force of "
                        f"{float(force):g} N, the condition is missed by {float(worst):.2g}"
                    )
    _check_flights(exact, certificate, speeds, table[-1], price)
    return value


def covers(certificates: Iterable[Certificate], body: Body, omega: float | None) -> bool:
    """Return whether the lift-off velocities of certificates cover all that a hop of period 1 can
    have.

    Args:
        certificates: each for this frequency or a lower one.
        body: the hopper.
        omega: hop frequency ω [rad/s]; None for any. A hop's flight is at most its period.

    Raises:
        TegotaeError: for what `problem.check_ballistic` refuses.
    """
    body = check_ballistic(body, omega)
    exact = ExactNumbers.from_body(body)
    fastest = None if omega is None else PI_ABOVE * exact.gravity / decimal_fraction(omega)
    reached: Fraction | None = None
    for low, high in sorted(_numbers(*certificate.lift_off) for certificate in certificates):
        if low**2 > exact.least_squared and (reached is None or low > reached):
            return False
        reached = high if reached is None else max(reached, high)
    if reached is None:
        return fastest is not None and fastest**2 < exact.least_squared
    return reached**2 >= exact.most_squared or (fastest is not None and reached >= fastest)


def decimal_fraction(value: float) -> Fraction:
    """Return the exact fraction of a float's shortest decimal.

    Example:
        >>> decimal_fraction(0.1)
        Fraction(1, 10)
    """
    return Fraction(repr(float(value)))


def _check_grid(exact: ExactNumbers, heights: list[Fraction], speeds: list[Fraction]) -> None:
    """Raise unless the cells cover all states of stance, and flights lead from v to -v."""
    if any(b <= a for knots in (heights, speeds) for a, b in pairwise(knots)):
        raise _fails("its knots do not rise")
    if heights[0] > -exact.leg or heights[-1] != 0:
        raise _fails("its heights do not reach from -l0 to 0")
    if 0 not in speeds or any(a != -b for a, b in zip(speeds, reversed(speeds), strict=True)):
        raise _fails("its speeds are not the same in both directions")
    if speeds[-1] ** 2 < exact.speed_squared:
        raise _fails(f"its speeds end at {float(speeds[-1]):.6g} m/s, and faster ones are possible")


def _rate(
    exact: ExactNumbers,
    patch: list[Bernstein],
    x: tuple[Fraction, Fraction],
    v: tuple[Fraction, Fraction],
    push: Fraction,
    price: Fraction,
    price_of_work: Fraction,
) -> list[Bernstein]:
    """Return the Bernstein coefficients of V_x v + V_v a + μ - λ |F v| on a cell, of degree 3 in x
    and in v.

    a = push - g - (k/m) x - (c/m) v.
    """
    # Lists run over x, their rows over v.
    along_x = [
        [(b - a) * 2 / (x[1] - x[0]) for a, b in zip(*rows, strict=True)]
        for rows in pairwise(patch)
    ]
    along_x = _transposed([_raised(_raised(list(r))) for r in _transposed(along_x)])
    moving = [_times_line(row, *v) for row in along_x]
    along_v = [[(b - a) * 2 / (v[1] - v[0]) for a, b in pairwise(row)] for row in patch]
    free = push - exact.gravity
    held = [free - exact.spring * end for end in x]
    pushed = _transposed([_times_line(list(r), *held) for r in _transposed(along_v)])
    pushed = [_raised(_raised(row)) for row in pushed]
    damped = [_raised(_times_line(row, *(-exact.damper * end for end in v))) for row in along_v]
    damped = _transposed([_raised(list(r)) for r in _transposed(damped)])
    effort = [price + price_of_work * (v[0] + (v[1] - v[0]) * Fraction(n, 3)) for n in range(4)]
    return [
        [sum(parts, Fraction(0)) for parts in zip(*rows, effort, strict=True)]
        for rows in zip(moving, pushed, damped, strict=True)
    ]


def _check_flights(
    exact: ExactNumbers,
    certificate: Certificate,
    speeds: list[Fraction],
    touchdown: Bernstein,
    price: Fraction,
) -> None:
    """Raise unless V(0, -v) - V(0, v) + v²/2g + μ (2 v/g - T [it is a hop]) <= 0 over flights.

    With μ <= 0, what holds for a hop holds for a lower flight too.
    """
    low, high = _numbers(*certificate.lift_off)
    omega = certificate.omega
    hop_s = decimal_fraction(LONGEST_S) if omega is None else 2 * PI_ABOVE / decimal_fraction(omega)
    middle = len(speeds) // 2
    for j, (a, b) in enumerate(pairwise(speeds[middle:]), start=middle):
        hops = b**2 > exact.least_squared and b > low and a < high
        if not hops and a**2 >= exact.least_squared:
            continue  # no flight leaves at such a speed
        up = touchdown[2 * j : 2 * j + 3]
        down = touchdown[::-1][2 * j : 2 * j + 3]
        climb = [x / (2 * exact.gravity) for x in (a * a, a * b, b * b)]
        time_s = [2 * x / exact.gravity - (hop_s if hops else 0) for x in (a, (a + b) / 2, b)]
        worst = max(
            d - u + h + price * t for d, u, h, t in zip(down, up, climb, time_s, strict=True)
        )
        if worst > 0:
            raise _fails(
                f"over flights that leave at [{float(a):.4g}, {float(b):.4g}] m/s, the condition "
                f"is missed by {float(worst):.2g} m"
            )


def _sign(work: str, v: tuple[Fraction, Fraction]) -> int:
    """Return the sign of the velocity in a cell's work per force."""
    if work == "net" or v[0] >= 0:
        return 1
    return -1 if work == "absolute" else 0


def _raised(row: Bernstein) -> Bernstein:
    """Return the polynomial as one of the next degree."""
    return _times_line(row, Fraction(1), Fraction(1))


def _times_line(row: Bernstein, start: Fraction, end: Fraction) -> Bernstein:
    """Multiply by the line from `start` to `end` over the interval: to degree n + 1."""
    n = len(row)  # the new degree
    product = [Fraction(0)] * (n + 1)
    for i, x in enumerate(row):
        product[i] += x * start * Fraction(n - i, n)
        product[i + 1] += x * end * Fraction(i + 1, n)
    return product


def _transposed(rows: Sequence[Sequence[Fraction]]) -> list[Bernstein]:
    return [list(column) for column in zip(*rows, strict=True)]


def _largest(rows: list[Bernstein]) -> Fraction:
    return max(map(max, rows))


def _knots(certificate: Certificate) -> tuple[np.ndarray, np.ndarray]:
    return np.ravel(certificate.heights_m), np.ravel(certificate.speeds_m_per_s)


def _numbers(*values: float) -> tuple[Fraction, ...]:
    return tuple(Fraction(float(value)) for value in _finite(np.array(values, float)))


def _finite(values: np.ndarray) -> np.ndarray:
    if not np.isfinite(values).all():
        raise _fails("a number of it is not finite")
    return values


def _fails(reason: str) -> TegotaeError:
    return TegotaeError(f"the certificate does not hold: {reason}")
