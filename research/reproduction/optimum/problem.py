"""The problem: which force makes the hopper climb most for its work, and its closed forms.

Heights are `x = y - l0 <= 0` in stance, per unit of mass

    ẍ = F/m - g - (k/m) x - (c/m) ẋ,   0 <= F <= α.

A stance starts at x = 0 with the touchdown's velocity and ends at x = 0 with the lift-off's. A
flight that leaves at v lasts 2 v/g, climbs v²/2g, and lands at -v. With damping in flight,
ẍ = -g - d ẋ, it lands at a lower speed u, lasts (u + v)/g, and climbs (v - g t)/d, where
t = log(1 + d v/g)/d is the time to its apex (`climb`, `flight_mismatch`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from scipy.optimize import brentq

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.measures.hopping.hopping import HOP_CLEARANCE
from tegotae.measures.hopping.signals import check_work
from tegotae.parts.bodies import Body, Hopper

_TAYLOR_ORDER = 8


def check(body: Body, omega: float | None = None, work: str = "absolute") -> Hopper:
    """Return the body if the problem is defined for it.

    Args:
        body: a hopper, with a largest force above its weight.
        omega: prescribed hop frequency ω [rad/s]; None for none.
        work: definition of work, one of "absolute", "positive", "net".

    Raises:
        TegotaeError: for another body, a force limit that does not exceed the weight, a frequency
            that is not positive, or an unknown definition of work.
    """
    if not (isinstance(body, Hopper) and body.is_linear):
        raise TegotaeError(
            f"the optimum is known for a Hopper on its linear spring; the body is a "
            f"{type(body).__name__}"
        )
    if not body.max_force_n > body.weight_n:
        raise TegotaeError(
            f"max_force_n is {body.max_force_n:g}; the optimum needs a largest force above the "
            f"weight of {body.weight_n:g} N"
        )
    if body.leg_friction_n != 0.0:
        raise TegotaeError(
            f"leg_friction_n is {body.leg_friction_n:g}; the optimum is known without it, 0"
        )
    if omega is not None:
        require_finite("omega", omega, above=0.0)
    check_work(work)
    return body


def check_ballistic(body: Body, omega: float | None = None, work: str = "absolute") -> Hopper:
    """Return the body if bounds can be proved for it: `check`, and no damping in flight.

    Args:
        body: a hopper, with a largest force above its weight and no damping in flight.
        omega: prescribed hop frequency ω [rad/s]; None for none.
        work: definition of work, one of "absolute", "positive", "net".

    Raises:
        TegotaeError: for what `check` refuses, or damping in flight.
    """
    body = check(body, omega, work)
    if body.flight_damping_ns_per_m != 0.0:
        raise TegotaeError(
            f"flight_damping_ns_per_m is {body.flight_damping_ns_per_m:g}; bounds are known for "
            "ballistic flight, 0"
        )
    return body


def flow(body: Hopper, x: Any, v: Any, force_n: Any, time_s: Any) -> tuple[Any, Any]:
    """Return height over touchdown [m] and velocity [m/s] after `time_s` of stance under a held
    force.

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


def climb(body: Hopper, lift_off: Any, log1p: Callable[[Any], Any] = np.log1p) -> Any:
    """Return the height that a flight climbs [m]: v²/2g, or (v - g t)/d with damping.

    Args:
        body: the hopper.
        lift_off: velocity of lift-off v [m/s]; a number, an array or a symbol.
        log1p: log(1 + x), of symbols their own.
    """
    gravity, damping = body.gravity_m_per_s2, body.flight_damping_ns_per_m / body.mass_kg
    if damping == 0.0:
        return lift_off**2 / (2.0 * gravity)
    rise_s = log1p(damping * lift_off / gravity) / damping
    return (lift_off - gravity * rise_s) / damping


def flight_mismatch(
    body: Hopper, lift_off: Any, landing: Any, log1p: Callable[[Any], Any] = np.log1p
) -> Any:
    """Zero where a flight that leaves at v lands at the speed u.

    u - v, or with damping the time of the flight by its two halves less (u + v)/g, which is the
    time in which gravity turns v into -u over no distance.

    Args:
        body: the hopper.
        lift_off: velocity of lift-off v [m/s]; a number, an array or a symbol.
        landing: speed of landing u [m/s], below g/d.
        log1p: log(1 + x), of symbols their own.
    """
    gravity, damping = body.gravity_m_per_s2, body.flight_damping_ns_per_m / body.mass_kg
    if damping == 0.0:
        return landing - lift_off
    halves = log1p(damping * lift_off / gravity) - log1p(-damping * landing / gravity)
    return halves / damping - (lift_off + landing) / gravity


def most_landing(body: Hopper) -> float:
    """Return a bound of the landing speed [m/s]: the terminal velocity g/d, infinite without
    damping.
    """
    damping = body.flight_damping_ns_per_m / body.mass_kg
    return body.gravity_m_per_s2 / damping if damping > 0.0 else math.inf


def least_lift_off(body: Hopper) -> float:
    """Return lift-off velocity of the lowest flight that counts as a hop [m/s].

    √(2 g · 0.01 l0) in ballistic flight.
    """
    height = HOP_CLEARANCE * body.rest_length_m
    ballistic = math.sqrt(2.0 * body.gravity_m_per_s2 * height)
    if body.flight_damping_ns_per_m == 0.0:
        return ballistic
    # Seen from the apex the speed grows by dv/dh = g/v + d: at most d h more than undamped.
    highest = ballistic + body.flight_damping_ns_per_m / body.mass_kg * height
    return cast(float, brentq(lambda v: climb(body, v) - height, ballistic, highest))


def most_lift_off(body: Hopper) -> float:
    """Return a bound of the lift-off velocity [m/s]: full force from a leg of no length, undamped.

    `½ m v² = (α - m g) l0 + ½ k l0²`.
    """
    leg = body.rest_length_m
    energy = (body.max_force_n - body.weight_n) * leg + 0.5 * body.stiffness_n_per_m * leg**2
    return math.sqrt(2.0 * energy / body.mass_kg)


def most_speed(body: Hopper) -> float:
    """Return a bound of the speed in stance [m/s].

    Rising, `most_lift_off`. Falling, the spring and gravity add at most ½ m² g²/k of energy.
    """
    return math.hypot(
        most_lift_off(body),
        body.gravity_m_per_s2 * math.sqrt(body.mass_kg / body.stiffness_n_per_m),
    )


def small_hop_limit(body: Body, work: str = "absolute") -> float:
    """Return the largest CoT⁻¹ of hops so low that spring and damper do not matter [m/J].

    To stop a fall from v²/2g within the depth d and throw the mass up again takes the kinetic
    energy and `m g d` twice; d is least under full force, `d = v² / (2 (α/m - g))`. So

        absolute: CoT⁻¹ = (1 - m g/α) / (2 m g),   positive: twice that,   net: no limit.

    Args:
        body: the hopper.
        work: definition of work, one of "absolute", "positive", "net".

    Source: this project. Absolute and positive work are bounded by it however fast the hops.

    Raises:
        TegotaeError: for what `check_ballistic` refuses.

    Example:
        >>> from tegotae import Hopper
        >>> f"{small_hop_limit(Hopper()):.4f} m/J"
        '0.3847 m/J'
    """
    body = check_ballistic(body, work=work)
    if work == "net":
        return math.inf
    absolute = (1.0 - body.weight_n / body.max_force_n) / (2.0 * body.weight_n)
    return absolute if work == "absolute" else 2.0 * absolute
