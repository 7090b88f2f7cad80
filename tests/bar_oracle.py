"""Hopper legs under a bar once more, for the tests: adaptive, float64, events located.

Written from the equations alone, in NumPy and SciPy; nothing of the package's physics is used. The
legs are driven by vanilla controllers, each by its own spring force.
"""

from __future__ import annotations

import itertools
from math import pi

import numpy as np
from scipy.integrate import solve_ivp

from oracle import Leg

SECTOR = (1.75 * pi, 1.85 * pi)


def fly(
    *,
    hips: tuple[float, ...],
    inertia_ratio: float,
    sigma: float,
    omega: float,
    phases: tuple[float, ...],
    duration: float,
    height: float = 1.2,
    pitch: float = 0.0,
    reflex: bool = False,
    leg: Leg | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Times and heights of the bar's apexes in flight (no leg on the ground)."""
    leg = leg or Leg()
    n = len(hips)
    at = np.array(hips)
    mass = n * leg.m
    inertia = inertia_ratio * mass * (0.5 * (at.max() - at.min())) ** 2
    t, state = 0.0, np.array([height, 0.0, pitch, 0.0, *phases])
    stance = height + at * pitch < leg.rest
    apexes: list[tuple[float, float]] = []

    for segment in itertools.count():
        if t >= duration - 1e-12:
            break
        assert segment < 5000, f"contacts pile up at {t} s"
        on = np.array([not reflex and (p - SECTOR[0]) % (2 * pi) < 0.1 * pi for p in state[4:]])

        def rate(t, s, stance=stance, on=on):
            y, v, turn, w = s[:4]
            phi = s[4:]
            spring = np.where(stance, leg.k * (leg.rest - y - at * turn), 0.0)
            f = -sigma * np.cos(phi) * spring
            push = np.clip(-np.minimum(f, 0.0), 0.0, leg.most_force) if reflex else 0.0
            push = np.where(on, leg.most_force, push)
            force = np.where(stance, spring - leg.c * (v + at * w) + push, 0.0)
            lift, tilt = force.sum() / mass - leg.g, (at * force).sum() / inertia
            return [v, lift, w, tilt, *(omega + f)]

        events = []
        for i in range(n):

            def touches(t, s, i=i):
                return s[0] + at[i] * s[2] - leg.rest

            touches.terminal, touches.direction = True, 1 if stance[i] else -1
            events.append(touches)
        for i, edge in itertools.product(range(0 if reflex else n), SECTOR):

            def crosses(t, s, i=i, edge=edge):
                return np.sin(0.5 * (s[4 + i] - edge))

            crosses.terminal = True
            events.append(crosses)

        def top(t, s):
            return s[1]

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
            found = zip(solved.t_events[-1], solved.y_events[-1], strict=True)
            apexes += [(when, y[0]) for when, y in found if when > t]
        t, state = solved.t[-1], solved.y[:, -1].copy()
        landed = [i for i in range(n) if len(solved.t_events[i])]
        for i in landed:
            stance = stance.copy()
            stance[i] = not stance[i]
        if not landed:
            # Clear of the edge, or rounding might find it again.
            state[4:] += 1e-11
    times, heights = np.array(apexes).reshape(-1, 2).T
    return times, heights
