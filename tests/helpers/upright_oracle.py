"""Hopper legs under a bar or plate once more, for the tests: adaptive, float64, events located.

Written from the equations alone, in NumPy and SciPy; nothing of the package's physics is used. The
legs are driven by vanilla controllers, each by its own spring force.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from oracle import Leg

SECTOR = (1.75 * pi, 1.85 * pi)
LEG = Leg()


@dataclass(frozen=True)
class Frame:
    """Modes, heave first: hips rise by `arms` [modes, limbs], inertia and stiffness [modes]."""

    arms: np.ndarray
    inertia: np.ndarray
    stiffness: np.ndarray


class Flown(NamedTuple):
    """Apexes in flight (no leg on the ground), and where the rollout ends."""

    apex_time: np.ndarray
    apex_height: np.ndarray
    place: np.ndarray
    """Heave and angles at the end."""
    phase: np.ndarray
    """The legs' phases at the end, counted on."""


def bar(hips: Sequence[float], inertia_ratio: float) -> Frame:
    """A bar with J = j n m a², a half the distance of the outermost hips."""
    mass, a = len(hips) * LEG.m, 0.5 * (max(hips) - min(hips))
    arms = np.array([np.ones(len(hips)), hips])
    return Frame(arms, np.array([mass, inertia_ratio * mass * a**2]), np.zeros(2))


def plate(a: float, b: float, ratios: Sequence[float], stiffness: float = 0.0) -> Frame:
    """A plate on four legs at (±a, ±b): left before right, fore before hind."""
    x, z = np.array([a, a, -a, -a]), np.array([b, -b, b, -b])
    arms = np.array([np.ones(4), x, z, x * z / a])
    inertia = 4 * LEG.m * np.array([1.0, a**2, b**2, b**2])
    inertia[1 : 1 + len(ratios)] *= ratios
    modes = 1 + len(ratios)
    return Frame(arms[:modes], inertia[:modes], np.array([0.0, 0.0, 0.0, stiffness])[:modes])


def fly(
    frame: Frame,
    *,
    sigma: float,
    omega: float,
    phases: Sequence[float],
    duration: float,
    height: float = 1.2,
    turned: Sequence[float] = (),
    reflex: bool = False,
) -> Flown:
    """Solve the hybrid system over `duration` seconds, released at rest, turned by these angles."""
    leg, arms = LEG, frame.arms
    modes, n = arms.shape
    place = np.zeros(modes)
    place[: 1 + len(turned)] = height, *turned
    t, state = 0.0, np.array([*place, *np.zeros(modes), *phases])
    stance = place @ arms < leg.rest
    apexes: list[tuple[float, float]] = []
    weight = np.eye(modes)[0] * leg.g

    for segment in itertools.count():
        if t >= duration - 1e-12:
            break
        assert segment < 5000, f"contacts pile up at {t} s"
        phase = state[2 * modes :]
        on = np.array([not reflex and (p - SECTOR[0]) % (2 * pi) < 0.1 * pi for p in phase])

        def rate(t, s, stance=stance, on=on):
            q, speed, phi = s[:modes], s[modes : 2 * modes], s[2 * modes :]
            spring = np.where(stance, leg.k * (leg.rest - q @ arms), 0.0)
            f = -sigma * np.cos(phi) * spring
            push = np.clip(-np.minimum(f, 0.0), 0.0, leg.most_force) if reflex else 0.0
            push = np.where(on, leg.most_force, push)
            force = np.where(stance, spring - leg.c * (speed @ arms) + push, 0.0)
            acceleration = (arms @ force - frame.stiffness * q) / frame.inertia - weight
            return [*speed, *acceleration, *(omega + f)]

        events = []
        for i in range(n):

            def touches(t, s, i=i):
                return s[:modes] @ arms[:, i] - leg.rest

            touches.terminal, touches.direction = True, 1 if stance[i] else -1
            events.append(touches)
        for i, edge in itertools.product(range(0 if reflex else n), SECTOR):

            def crosses(t, s, i=i, edge=edge):
                return np.sin(0.5 * (s[2 * modes + i] - edge))

            crosses.terminal = True
            events.append(crosses)

        def top(t, s):
            return s[modes]

        top.direction = -1
        events.append(top)
        solved = solve_ivp(
            rate,
            (t, duration),
            state,
            "DOP853",
            events=events,
            rtol=1e-10,
            atol=1e-12,
            max_step=0.03,
        )
        if not stance.any():
            result = zip(solved.t_events[-1], solved.y_events[-1], strict=True)
            apexes += [(when, y[0]) for when, y in result if when > t]
        t, state = solved.t[-1], solved.y[:, -1].copy()
        landed = [i for i in range(n) if len(solved.t_events[i])]
        for i in landed:
            stance = stance.copy()
            stance[i] = not stance[i]
        if not landed:
            # Clear of the edge, or rounding might find it again.
            state[2 * modes :] += 1e-11
    times, heights = np.array(apexes).reshape(-1, 2).T
    return Flown(times, heights, state[:modes], state[2 * modes :])
