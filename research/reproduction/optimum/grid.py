"""The second method: dynamic programming over height, velocity and time in stance."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import map_coordinates

from research.reproduction.optimum.problem import check, flow
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.parts.bodies import Body


def least_work(
    body: Body,
    lift_off_m_per_s: float,
    stance_s: float,
    *,
    points: int = 120,
    levels: int = 9,
    work: str = "absolute",
) -> float:
    """Return the least work from touchdown at -v to lift-off at +v after a given time of stance
    [J].

    Bellman's equation, backwards in time from the end, on a grid of heights and velocities:

        J(t, x, v) = min over F of  ∫ |F v| dt + J(t + dt, x', v'),

    the motion exact under a held force, J interpolated by cubic splines. What is missed at the end
    costs as much as lifting and throwing the mass there twice over. Shares nothing with trajectory
    optimisation, and knows no local optima; interpolation smears J, so the result tends to the
    truth as the grid is refined.

    Args:
        body: the hopper.
        lift_off_m_per_s: velocity of lift-off v [m/s].
        stance_s: time of stance [s].
        points: grid points over height; twice as many over velocity, a quarter as many steps
            of time.
        levels: forces tried at each step, from 0 to the largest.
        work: definition of work, one of "absolute", "positive", "net".

    Raises:
        TegotaeError: for what `problem.check` refuses, a velocity or time that is not positive, too
            few points, or if the end cannot be reached.
    """
    body = check(body, work=work)
    require_finite("lift_off_m_per_s", lift_off_m_per_s, above=0.0)
    require_finite("stance_s", stance_s, above=0.0)
    require_count("points", points, least=10)
    require_count("levels", levels, least=2)
    mass, gravity = body.mass_kg, body.gravity_m_per_s2
    speed = lift_off_m_per_s
    fastest = 1.3 * math.hypot(speed, gravity * math.sqrt(mass / body.stiffness_n_per_m))
    deepest = min(body.rest_length_m, fastest * stance_s)
    x = np.linspace(-deepest, 0.0, points + 1)
    v = np.linspace(-fastest, fastest, 2 * points + 1)
    dx, dv = x[1] - x[0], v[1] - v[0]
    steps = max(10, points // 4)
    x_grid, v_grid = np.meshgrid(x, v, indexing="ij")
    miss_v, miss_x = 2.0 * mass * fastest, 2.0 * body.max_force_n
    value = miss_x * np.abs(x_grid) + miss_v * np.abs(v_grid - speed)
    transitions = []
    for force in np.linspace(0.0, body.max_force_n, levels):
        x_next, v_next = flow(body, x_grid, v_grid, force, stance_s / steps)
        moved = x_next - x_grid
        counted = {"absolute": np.abs(moved), "positive": np.maximum(moved, 0.0), "net": moved}
        # Outside of the leg's range the motion costs what is missed.
        outside = np.maximum(x_next, 0.0) + np.maximum(-deepest - x_next, 0.0)
        outside_v = np.maximum(np.abs(v_next) - fastest, 0.0)
        cost = force * counted[work] + miss_x * outside + miss_v * outside_v
        transitions.append((cost, np.array([(x_next + deepest) / dx, (v_next + fastest) / dv])))
    for _ in range(steps):
        value = np.min(
            [
                cost + map_coordinates(value, place, order=3, mode="nearest")
                for cost, place in transitions
            ],
            axis=0,
        )
    work_j = map_coordinates(value, [[points], [(fastest - speed) / dv]], order=1)
    if not work_j[0] < miss_v * 0.1 * speed + body.max_force_n * deepest:
        raise TegotaeError(
            f"no stance of {stance_s:g} s leads from -{speed:g} to {speed:g} m/s on this grid"
        )
    return float(work_j[0])
