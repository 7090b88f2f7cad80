"""The best gait that can be found: trajectory optimisation with CasADi and IPOPT."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from research.reproduction.optimum.problem import (
    check,
    climb,
    flight_mismatch,
    flow,
    least_lift_off,
    most_landing,
    most_lift_off,
)
from tegotae._support.errors import TegotaeError, require, require_count
from tegotae.parts.bodies import Body, Hopper


@dataclass(frozen=True)
class Stance:
    """One stance: so many swings down and up, and whether the flight after it counts as a hop.

    Args:
        swings: how often the leg is compressed and extended.
        bounce: the flight after it stays below a hop's least height, and does not count.
    """

    swings: int = 1
    bounce: bool = False


_LIMITS = {"ipopt.max_iter": 300, "ipopt.max_cpu_time": 6.0}

ONE = (
    (Stance(),),
    (Stance(2),),
    (Stance(1, bounce=True), Stance()),
    (Stance(1, bounce=True), Stance(1, bounce=True), Stance()),
)
"""Shapes of a period of one hop."""
TWO = (
    (Stance(), Stance()),
    (Stance(), Stance(2)),
    (Stance(), Stance(1, bounce=True), Stance()),
)
"""Shapes of a period of two hops."""


@dataclass(frozen=True)
class OptimalGait:
    """A gait of one cycle, physically exact: its force is constant between the times given.

    Args:
        cot_inverse: CoT⁻¹ of the heights climbed in flight [m/J]; infinite if no work is needed.
        omega: hop frequency, 2π times hops per time [rad/s].
        shape: what the cycle is made of.
        lift_off_m_per_s: lift-off velocities, [stances].
        stance_s: durations of the stances [s], [stances].
        work_j: work over the cycle [J].
        time_s: start of each interval since its stance's touchdown [s], one array a stance.
        height_m: height over touchdown there [m].
        velocity_m_per_s: velocity there [m/s].
        force_n: force in the interval that starts there [N].
        converged: how many starts ended at a gait.
    """

    cot_inverse: float
    omega: float
    shape: tuple[Stance, ...]
    lift_off_m_per_s: np.ndarray
    stance_s: np.ndarray
    work_j: float
    time_s: list[np.ndarray]
    height_m: list[np.ndarray]
    velocity_m_per_s: list[np.ndarray]
    force_n: list[np.ndarray]
    converged: int = 1

    @property
    def hops(self) -> int:
        """Hops in the cycle."""
        return sum(not stance.bounce for stance in self.shape)


def optimise(
    body: Body,
    omega: float | None = None,
    *,
    period: int = 1,
    work: str = "absolute",
    shapes: Sequence[tuple[Stance, ...]] | None = None,
    starts: int = 6,
    intervals: int = 40,
    seed: int = 0,
) -> OptimalGait:
    """Find the most efficient gait of a hopper under any force 0 <= F_a(t) <= α.

    Maximises `Σ h / ∫ |F_a ẏ| dt` over a cycle, with h the climb of a flight: v²/2g, unless it is
    damped. Direct multiple shooting: every swing up or down is a phase of its own with its duration
    free, so that |F_a ẏ| is ± F_a ẏ and smooth, and the motion between nodes is the exact solution
    under a constant force. Local optima are frequent; the best of many starts, and shapes, counts.
    At the top of an inner swing the mass can be held for any time: a force that does not move does
    no work.

    Args:
        body: the hopper.
        omega: mean hop frequency ω [rad/s], 2π times hops over time; None leaves it free.
        period: hops in a cycle, 1 or 2.
        work: definition of work, one of "absolute", "positive", "net".
        shapes: what a cycle may be made of; by default the package's list for the period.
        starts: random starts per shape.
        intervals: intervals of constant force per swing up or down.
        seed: of the starts.

    Raises:
        TegotaeError: for what `problem.check` refuses, a count below 1, a period without shapes, or
            if no start converges, as where no hop exists.
        MissingExtraError: if CasADi is not installed.

    Example:
        >>> from tegotae import Hopper
        >>> found = optimise(Hopper(), 4.0, shapes=[(Stance(),)], starts=3)
        >>> f"{found.cot_inverse:.2f} m/J"
        '1.21 m/J'
    """
    body = check(body, omega, work)
    require_count("period", period)
    require_count("starts", starts)
    require_count("intervals", intervals, least=4)
    if shapes is None:
        if period not in (1, 2):
            raise TegotaeError(f"period is {period}; give the shapes of periods other than 1 and 2")
        shapes = ONE if period == 1 else TWO
    for shape in shapes:
        if sum(not stance.bounce for stance in shape) != period:
            raise TegotaeError(f"a shape does not have {period} hops: {shape}")
    require("casadi", "optimum")
    random = np.random.default_rng(seed)
    gaits = []
    for shape in shapes:
        solve = _OptimalControl(body, omega, work, shape, intervals)
        gaits += [gait for _ in range(starts) if (gait := solve(random)) is not None]
    if not gaits:
        frequency = "" if omega is None else f" at {omega:g} rad/s"
        raise TegotaeError(
            f"no gait of period {period} was found{frequency}: none of {starts * len(shapes)} "
            "starts converged, as where no hop exists"
        )
    best = max(gaits, key=lambda gait: gait.cot_inverse)
    return OptimalGait(**{**vars(best), "converged": len(gaits)})


def highest_frequency(body: Body, *, starts: int = 4, intervals: int = 20, seed: int = 0) -> float:
    """Return the fastest hopping of period 1 with hops of the least height, 2π over its time
    [rad/s].

    There is no lowest: at the top of a swing in stance the mass can be held for ever.

    Args:
        body: the hopper.
        starts: random starts of the search.
        intervals: intervals of constant force per swing up or down.
        seed: of the starts.

    Raises:
        TegotaeError: for what `problem.check` refuses, or if no start converges.
        MissingExtraError: if CasADi is not installed.
    """
    body = check(body)
    random = np.random.default_rng(seed)
    program = _OptimalControl(body, None, "absolute", (Stance(),), intervals, fastest=True)
    gaits = [gait for _ in range(starts) if (gait := program(random)) is not None]
    if not gaits:
        raise TegotaeError(f"no fastest hop was found: none of {starts} starts converged")
    return max(gait.omega for gait in gaits)


class _OptimalControl:
    """One shape's non-linear program, solved from random starts."""

    def __init__(
        self,
        body: Hopper,
        omega: float | None,
        work: str,
        shape: tuple[Stance, ...],
        intervals: int,
        fastest: bool = False,
    ):
        casadi = require("casadi", "optimum")
        self.body, self.shape, self.intervals = body, shape, intervals
        self.cycle_s = None
        opti = casadi.Opti()
        n = intervals
        gravity = body.gravity_m_per_s2
        hops = sum(not stance.bounce for stance in shape)
        lowest, highest = least_lift_off(body), most_lift_off(body)
        lift_off, landing = opti.variable(len(shape)), opti.variable(len(shape))
        opti.subject_to(opti.bounded(0.0, landing, min(highest, 0.999 * most_landing(body))))
        opti.subject_to(flight_mismatch(body, lift_off, landing, casadi.log1p) == 0.0)
        self.phases: list[list[tuple[Any, ...]]] = []
        energy, stance_s = 0.0, 0.0
        for number, stance in enumerate(shape):
            ends = (0.0, lowest) if stance.bounce else (lowest, highest)
            opti.subject_to(opti.bounded(ends[0], lift_off[number], ends[1]))
            x_end, v_end = 0.0, -landing[number - 1]
            phases = []
            for phase in range(2 * stance.swings):
                sign = 1 if phase % 2 else -1
                last = phase == 2 * stance.swings - 1
                force, x, v = (opti.variable(n) for _ in range(3))
                duration, wait = opti.variable(), opti.variable()
                opti.subject_to(opti.bounded(0.0, force, body.max_force_n))
                opti.subject_to(opti.bounded(1e-5, duration, 4.0))
                # Only a top inside stance can be held for nothing.
                opti.subject_to(
                    opti.bounded(0.0, wait, 100.0) if sign > 0 and not last else wait == 0.0
                )
                opti.subject_to(opti.bounded(-0.999 * body.rest_length_m, x, 0.0))
                opti.subject_to(sign * v >= 0.0)
                before_x = casadi.vertcat(x_end, x[:-1])
                before_v = casadi.vertcat(v_end, v[:-1])
                following = flow(body, before_x, before_v, force, duration / n)
                opti.subject_to(following[0] == x)
                opti.subject_to(following[1] == v)
                x_end, v_end = x[-1], v[-1]
                opti.subject_to(v_end == (lift_off[number] if last else 0.0))
                if last:
                    opti.subject_to(x_end == 0.0)
                step_work = casadi.sum1(force * (x - before_x))
                counted = {"absolute": sign, "positive": max(sign, 0), "net": 1}[work]
                energy += counted * step_work
                stance_s += duration + wait
                phases.append((force, duration, wait, before_x, before_v, x, v, sign))
            self.phases.append(phases)
        cycle_s = stance_s + casadi.sum1(lift_off + landing) / gravity
        if omega is not None:
            self.cycle_s = hops * 2.0 * math.pi / omega
            opti.subject_to(cycle_s == self.cycle_s)
        climbed = casadi.sum1(climb(body, lift_off, casadi.log1p))
        opti.minimize(cycle_s if fastest else energy / climbed)
        quiet = {"print_time": False, "error_on_fail": True}
        opti.solver("ipopt", {**quiet, "ipopt.print_level": 0, "ipopt.sb": "yes", **_LIMITS})
        self.opti, self.energy, self.climb = opti, energy, climbed
        self.lift_off, self.landing = lift_off, landing
        self.total_s, self.hops, self.range = cycle_s, hops, (lowest, highest)

    def __call__(self, random: np.random.Generator) -> OptimalGait | None:
        """Find the gait from one random start, or return None if it does not converge."""
        self._start(random)
        try:
            solution = self.opti.solve()
        except RuntimeError:
            return None
        work_j = max(float(solution.value(self.energy)), 0.0)
        climb_m = float(solution.value(self.climb))
        tables = [self._stance(solution, phases) for phases in self.phases]
        time_s, height, velocity, force = (list(column) for column in zip(*tables, strict=True))
        return OptimalGait(
            cot_inverse=climb_m / work_j if work_j > 0.0 else math.inf,
            omega=2.0 * math.pi * self.hops / float(solution.value(self.total_s)),
            shape=self.shape,
            lift_off_m_per_s=np.atleast_1d(solution.value(self.lift_off)),
            stance_s=np.array([times[-1] for times in time_s]),
            work_j=work_j,
            time_s=time_s,
            height_m=height,
            velocity_m_per_s=velocity,
            force_n=force,
        )

    def _start(self, random: np.random.Generator) -> None:
        gravity, n = self.body.gravity_m_per_s2, self.intervals
        lowest, highest = self.range
        if self.cycle_s is not None:
            highest = min(highest, max(lowest, 0.5 * gravity * self.cycle_s))
        lift_off = random.uniform(lowest, highest, len(self.shape))
        if len(lift_off) > 1 and random.uniform() < 0.5:  # one high hop among low ones
            lift_off[1:] = lowest
        self.opti.set_initial(self.lift_off, lift_off)
        self.opti.set_initial(self.landing, np.minimum(lift_off, 0.9 * most_landing(self.body)))
        part = np.linspace(0.0, 1.0, n + 1)[1:]
        rate = self.body.natural_frequency_rad_per_s
        for phases in self.phases:
            for force, duration, wait, _, _, x, v, sign in phases:
                depth = random.uniform(0.05, 0.6) * self.body.rest_length_m
                self.opti.set_initial(force, random.uniform(0.0, self.body.max_force_n))
                self.opti.set_initial(duration, random.uniform(0.3, 2.5) / rate)
                self.opti.set_initial(wait, 0.0)
                self.opti.set_initial(x, -depth * (part if sign < 0 else 1.0 - part))
                self.opti.set_initial(v, sign * depth * rate * np.sin(np.pi * part))

    def _stance(self, solution: Any, phases: list[tuple[Any, ...]]) -> tuple[np.ndarray, ...]:
        """Return the times, heights, velocities and forces of a stance; the last row is the
        lift-off.
        """
        rows, start, end_v = [], 0.0, 0.0
        for force, duration, wait, before_x, before_v, x, v, _ in phases:
            length = float(solution.value(duration))
            n = self.intervals
            rows.append(
                np.array(
                    [
                        start + np.arange(n) * length / n,
                        np.ravel(solution.value(before_x)),
                        np.ravel(solution.value(before_v)),
                        np.ravel(solution.value(force)),
                    ]
                )
            )
            start += length
            held = float(solution.value(wait))
            if held > 1e-6:
                top = float(solution.value(x[-1]))
                hold = self.body.weight_n + self.body.stiffness_n_per_m * top
                rows.append(np.array([[start], [top], [0.0], [hold]]))
                start += held
            end_v = float(solution.value(v[-1]))
        rows.append(np.array([[start], [0.0], [end_v], [0.0]]))
        return tuple(np.concatenate(rows, axis=1))
