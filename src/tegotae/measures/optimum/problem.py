"""The problem: which force makes the hopper climb most for its work, and its closed forms.

Heights are `x = y - l0 <= 0` in stance, per unit of mass

    ẍ = F/m - g - (k/m) x - (c/m) ẋ,   0 <= F <= α.

A stance starts at x = 0 with the touchdown's velocity and ends at x = 0 with the lift-off's. A
flight that leaves at v lasts 2 v/g, climbs v²/2g, and lands at -v.
"""

from __future__ import annotations

import math
from typing import Any

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.hopping.efficiency import check_work
from tegotae.measures.hopping.hopping import HOP_CLEARANCE
from tegotae.parts.bodies import Body, Hopper

_TAYLOR_ORDER = 8


def check(body: Body, omega: float | None = None, work: str = "absolute") -> Hopper:
    """The body, if the problem is defined for it.

    Args:
        body: a hopper, with a largest force above its weight and no damping in flight.
        omega: prescribed hop frequency ω [rad/s]; None for none.
        work: definition of work, one of "absolute", "positive", "net".

    Raises:
        TegotaeError: for another body, a force limit that does not exceed the weight, damping in
            flight, a frequency that is not positive, or an unknown definition of work.
    """
    if not isinstance(body, Hopper):
        raise TegotaeError(f"the optimum is known for Hopper; the body is a {type(body).__name__}")
    if not body.max_force_n > body.weight_n:
        raise TegotaeError(
            f"max_force_n is {body.max_force_n:g}; the optimum needs a largest force above the "
            f"weight of {body.weight_n:g} N"
        )
    if body.flight_damping_ns_per_m != 0.0:
        raise TegotaeError(
            f"flight_damping_ns_per_m is {body.flight_damping_ns_per_m:g}; the optimum is known "
            "for ballistic flight, 0"
        )
    if omega is not None:
        require_finite("omega", omega, above=0.0)
    check_work(work)
    return body


def flow(body: Hopper, x: Any, v: Any, force_n: Any, time_s: Any) -> tuple[Any, Any]:
    """Height over touchdown [m] and velocity [m/s] after `time_s` of stance under a held force.

    The Taylor series of the exact motion, as in `Hopper.advance`: exact to rounding for times of a
    few percent of 1/ω_n. Works on numbers, arrays and symbols alike.

    Args:
        body: the hopper.
        x: height over touchdown [m].
        v: velocity [m/s].
        force_n: actuator force, held [N].
        time_s: how long [s].
    """
    stiffness = body.stiffness_n_per_m / body.mass_kg
    damping = body.damping_ns_per_m / body.mass_kg
    push = force_n / body.mass_kg - body.gravity_m_per_s2
    terms = [x, v, push - stiffness * x - damping * v]
    for _ in range(_TAYLOR_ORDER - 2):
        terms.append(-stiffness * terms[-2] - damping * terms[-1])
    x1 = v1 = terms[-1]
    for n in range(_TAYLOR_ORDER, 0, -1):
        x1 = terms[n - 1] + time_s / n * x1
    for n in range(_TAYLOR_ORDER - 1, 0, -1):
        v1 = terms[n] + time_s / n * v1
    return x1, v1


def least_lift_off(body: Hopper) -> float:
    """Lift-off velocity of the lowest flight that counts as a hop, √(2 g · 0.01 l0) [m/s]."""
    return math.sqrt(2.0 * body.gravity_m_per_s2 * HOP_CLEARANCE * body.rest_length_m)


def most_lift_off(body: Hopper) -> float:
    """No lift-off is faster than this [m/s]: full force from a leg of no length, undamped.

    `½ m v² = (α - m g) l0 + ½ k l0²`.
    """
    leg = body.rest_length_m
    energy = (body.max_force_n - body.weight_n) * leg + 0.5 * body.stiffness_n_per_m * leg**2
    return math.sqrt(2.0 * energy / body.mass_kg)


def most_speed(body: Hopper) -> float:
    """No speed in stance is larger than this [m/s].

    Rising, `most_lift_off`. Falling, the spring and gravity add at most ½ m² g²/k of energy.
    """
    return math.hypot(
        most_lift_off(body),
        body.gravity_m_per_s2 * math.sqrt(body.mass_kg / body.stiffness_n_per_m),
    )


def small_hop_limit(body: Body, work: str = "absolute") -> float:
    """Largest CoT⁻¹ of hops so low that spring and damper do not matter [m/J].

    To stop a fall from v²/2g within the depth d and throw the mass up again takes the kinetic
    energy and `m g d` twice; d is least under full force, `d = v² / (2 (α/m - g))`. So

        absolute: CoT⁻¹ = (1 - m g/α) / (2 m g),   positive: twice that,   net: no limit.

    Args:
        body: the hopper.
        work: definition of work, one of "absolute", "positive", "net".

    Source: this project. Absolute and positive work are bounded by it however fast the hops.

    Raises:
        TegotaeError: for what `check` refuses.

    Example:
        >>> from tegotae import Hopper
        >>> f"{small_hop_limit(Hopper()):.4f} m/J"
        '0.3847 m/J'
    """
    body = check(body, work=work)
    if work == "net":
        return math.inf
    both = (1.0 - body.weight_n / body.max_force_n) / (2.0 * body.weight_n)
    return both if work == "absolute" else 2.0 * both
