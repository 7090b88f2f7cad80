"""The hopper and its controllers once more, for the tests: adaptive, float64, events located.

Written from the equations alone, in NumPy and SciPy; nothing of the package's physics is used.
Between events the right-hand side is smooth but for the clipping of the force, which an adaptive
step copes with. Events are touchdown and lift-off, the edges of the sector, the drop of the ground,
a leg of no length, and (recorded, without effect) the apex of a flight.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, inf, pi, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from solutions import kept

PERTURBATION = 1e-7
MOST_CHANGE_M = 3e-6
"""A rollout is non-chaotic if neither a release 1e-7 m higher nor an oscillator faster by a share
of 1e-7 moves any of its apexes by more than 3e-6 m.

The first alone is not enough: a rollout may forget its release and still magnify every error made
on the way. Rollouts near a limit cycle amplify the two by less than 25 within 20 s, most by less
than 6; chaotic ones, and those that pass close to a bifurcation, by 40 to more than 1e6.
"""


@dataclass(frozen=True)
class Leg:
    """The hopper's parameters, in SI units."""

    m: float = 0.1
    k: float = 5.0
    c: float = 0.2
    rest: float = 1.0
    g: float = 9.81
    most_force: float = 4.0
    flight_c: float = 0.0


@dataclass(frozen=True)
class Law:
    """A controller: feedback f(phase, F_k, v), force F(phase, f, F_k, v), sector of full force."""

    name: str
    """It and its numbers: what is solved is kept under it."""
    feedback: Callable[[float, float, float], float] = field(repr=False)
    force: Callable[[float, float, float, float], float] = field(repr=False)
    sector: tuple[float, float] | None = None


@dataclass(frozen=True)
class Flown:
    """Apexes and touchdowns of a rollout; arrays with an entry per event."""

    apex_time: np.ndarray
    apex_height: np.ndarray
    apex_phase: np.ndarray
    touchdown_time: np.ndarray
    failed: bool
    """True if the leg's length reached zero, which ends the rollout."""


def vanilla(sigma: float, actuation: str) -> Law:
    """f = -sigma cos(phase) F_k; actuation is "sector", "reflex" or "both"."""
    return Law(
        f"vanilla {actuation} {sigma!r}",
        feedback=lambda phase, spring, v: -sigma * cos(phase) * spring,
        force=lambda phase, f, spring, v: -min(0.0, f) if actuation != "sector" else 0.0,
        sector=(1.75 * pi, 1.85 * pi) if actuation != "reflex" else None,
    )


def network(weights: np.ndarray, inputs: tuple[float, ...]) -> float:
    """Sum of v tanh(w x + b) over the neurons, each a run of weights w, b, v."""
    neurons = weights.reshape(-1, len(inputs) + 2)
    return float(neurons[:, -1] @ np.tanh(neurons[:, :-2] @ np.array(inputs) + neurons[:, -2]))


def learned_art(weights: np.ndarray, neurons: tuple[int, int, int], leg: Leg) -> Law:
    """f = sigma A(phase) R(F_k) with force T(phase, f): weights of A, R, sigma, T in that order."""
    for_a, for_r, _ = neurons
    a, r, sigma, t = np.split(weights, np.cumsum([4 * for_a, 3 * for_r, 1]))
    assert len(t) == 5 * neurons[2]
    weight, rate = leg.m * leg.g, sqrt(leg.g / leg.rest)

    def feedback(phase: float, spring: float, v: float) -> float:
        action = network(a, (sin(phase), cos(phase)))
        return float(sigma[0]) * action * network(r, (spring / weight,))

    def force(phase: float, f: float, spring: float, v: float) -> float:
        return network(t, (sin(phase), cos(phase), f / rate))

    return Law(f"ART {leg} {neurons} {weights.tolist()}", feedback, force)


def learned_single(weights: np.ndarray, leg: Leg) -> Law:
    """The single network without oscillator, T(F_k, v)."""
    weight, speed = leg.m * leg.g, sqrt(leg.g * leg.rest)
    return Law(
        f"single network {leg} {weights.tolist()}",
        feedback=lambda phase, spring, v: 0.0,
        force=lambda phase, f, spring, v: network(weights, (spring / weight, v / speed)),
    )


@kept
def fly(
    law: Law,
    *,
    omega: float,
    duration: float,
    height: float = 1.2,
    velocity: float = 0.0,
    phase: float = 0.0,
    drop: float = 0.0,
    drop_time: float = inf,
    leg: Leg | None = None,
    rtol: float = 1e-10,
) -> Flown:
    """Solve the hybrid system over `duration` seconds."""
    leg = leg or Leg()
    apexes: list[tuple[float, float, float]] = []
    touchdowns: list[float] = []
    t, state, touchdown = 0.0, np.array([height, velocity, phase]), leg.rest
    stance = height < touchdown
    failed = False
    for segment in itertools.count():
        if t >= duration - 1e-12:
            break
        if segment > 4000:
            raise RuntimeError(f"contacts pile up at {t} s")
        dropped = t >= drop_time
        touchdown = leg.rest - drop * dropped
        on = law.sector is not None and _inside(law.sector, state[2])
        rate = _rate(law, leg, omega, touchdown, stance, on)
        solved = solve_ivp(
            rate,
            (t, duration if dropped else min(duration, drop_time)),
            state,
            method="DOP853",
            events=_events(law, leg, touchdown, stance),
            rtol=rtol,
            atol=1e-12,
            max_step=0.03,
        )
        contact, apex, no_leg, *edges = solved.t_events
        if not stance:
            rising = [(at, *y[[0, 2]]) for at, y in zip(apex, solved.y_events[1], strict=True)]
            apexes += [entry for entry in rising if entry[0] > t]
        t, state = solved.t[-1], solved.y[:, -1].copy()
        if len(no_leg):
            failed = True
            break
        if len(contact):
            touchdowns += [] if stance else [t]
            stance, state[0] = not stance, touchdown
        elif any(len(edge) for edge in edges):
            # Clear of the edge, or rounding might find it again.
            state[2] += 1e-11 * np.sign(rate(t, state)[2])
        elif t == drop_time:
            stance = state[0] < leg.rest - drop
    columns = np.array(apexes).reshape(-1, 3).T
    return Flown(*columns, np.array(touchdowns), failed)


def is_non_chaotic(law: Law, flown: Flown, *, omega: float, height: float = 1.2, **how) -> bool:
    """True if small errors of release and frequency leave every apex of `flown` where it was."""
    return all(
        np.shape(other.apex_height) == np.shape(flown.apex_height)
        and np.all(np.abs(other.apex_height - flown.apex_height) <= MOST_CHANGE_M)
        for other in (
            fly(law, omega=omega, height=height + PERTURBATION, **how),
            fly(law, omega=omega * (1.0 + PERTURBATION), height=height, **how),
        )
    )


def _rate(law: Law, leg: Leg, omega: float, touchdown: float, stance: bool, on: bool):
    def rate(t, state):
        y, v, phase = state.tolist()
        spring = leg.k * (touchdown - y) if stance else 0.0
        f = law.feedback(phase, spring, v)
        if not stance:
            return [v, -leg.g - leg.flight_c / leg.m * v, omega + f]
        force = law.force(phase, f, spring, v)
        force = leg.most_force if on else min(max(force, 0.0), leg.most_force)
        return [v, (spring - leg.c * v + force) / leg.m - leg.g, omega + f]

    return rate


def _events(law: Law, leg: Leg, touchdown: float, stance: bool) -> list[Callable]:
    def contact(t, state):
        return state[0] - touchdown

    def apex(t, state):
        return state[1]

    def no_leg(t, state):
        return state[0] - (touchdown - leg.rest)

    contact.terminal, contact.direction = True, 1 if stance else -1
    apex.direction = -1
    no_leg.terminal = True
    events = [contact, apex, no_leg]
    for edge in law.sector or ():

        def crosses(t, state, edge=edge):
            return sin(0.5 * (state[2] - edge))

        crosses.terminal = True
        events.append(crosses)
    return events


def _inside(sector: tuple[float, float], phase: float) -> bool:
    start, stop = sector
    return bool((phase - start) % (2 * pi) < stop - start)
