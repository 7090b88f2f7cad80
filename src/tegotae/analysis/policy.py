"""What anyone's policy does: its surface, its rollouts, its limit cycle, its metrics."""

from __future__ import annotations

import numpy as np

from tegotae.analysis.orbit import NoLimitCycleError, Orbit, Paths, check_releases
from tegotae.analysis.surface import Surface, surface_of
from tegotae.envs.core import TELEMETRY, Hoppers
from tegotae.envs.policies.base import Policy
from tegotae.measures.hopping import measure
from tegotae.measures.hopping.measured import Measured
from tegotae.parts.terms import Signals


def policy_surface(
    policy: Policy,
    spring_force_n: np.ndarray,
    *,
    columns: int = 200,
    velocity_m_per_s: float = 0.0,
    velocity_range_m_per_s: tuple[float, float] = (-4.0, 4.0),
) -> Surface:
    """The actuator force of a policy over phase and spring force, or velocity and spring force.

    What it observes beside these is that of a leg which this spring force compresses.

    Args:
        policy: the policy.
        spring_force_n: spring forces F_k [N], not negative, shape [rows].
        columns: how many phases, from 0 to 2π (or velocities).
        velocity_m_per_s: the velocity that a policy with a phase is shown [m/s].
        velocity_range_m_per_s: range of velocities where they make the columns [m/s].

    Raises:
        TegotaeError: for what `actuation_surface` refuses, or a policy that fails.

    Example:
        >>> from tegotae.envs.policies import Meaning, from_function
        >>> def reflex(phase_rad, spring_force_n):
        ...     return np.maximum(0.0, 2.0 * np.cos(phase_rad) * spring_force_n)
        >>> found = policy_surface(from_function(reflex), np.array([0.0, 1.0]), columns=3)
        >>> found.actuator_force_n[1].round(5)  # φ = 0, π, 2π
        array([2., 0., 2.])
    """
    settings = policy.meaning.settings

    def weights_at(seen: Signals) -> list[np.ndarray]:
        read = seen.dimensionless if settings.dimensionless else seen.__getitem__
        observed = np.stack([np.asarray(read(name)) for name in settings.observed], axis=-1)
        return [policy.actions(observed) * settings.action_scale]

    return surface_of(
        settings.controller,
        settings.body,
        policy.meaning.omega if policy.meaning.with_phase else None,
        weights_at,
        spring_force_n,
        columns=columns,
        velocity_m_per_s=velocity_m_per_s,
        velocity_range_m_per_s=velocity_range_m_per_s,
    )


def policy_paths(
    policy: Policy,
    height_m: np.ndarray,
    *,
    phase_rad: float = 0.0,
    duration_s: float = 30.0,
) -> Paths:
    """Release the hopper from several heights under a policy, which acts every `step_s`.

    Args:
        policy: the policy.
        height_m: heights, at rest [m], [releases].
        phase_rad: phase at release [rad], where there is one.
        duration_s: simulated time [s].

    Returns:
        The rollouts, from the release on; a leg without length left stays where it is.

    Raises:
        TegotaeError: for a release that is not finite, or a policy that fails.
    """
    heights = check_releases(height_m, duration_s)
    settings, body = policy.meaning.settings, policy.meaning.body
    with_phase = policy.meaning.with_phase
    phase = {"phase_rad": phase_rad} if with_phase else {}
    hoppers = Hoppers(settings, len(heights))
    step = hoppers.reset(
        [settings.scenario(None, {"height_m": float(y), **phase}) for y in heights]
    )
    telemetry = [step.telemetry]
    for _ in range(round(duration_s / settings.step_s)):
        step = hoppers.step(policy.actions(step.observation))
        telemetry.append(step.telemetry)
    column = dict(zip(TELEMETRY, np.moveaxis(np.asarray(telemetry, float), -1, 0), strict=True))
    compressed = body.rest_length_m - (column["height_m"] - column["ground_m"])
    return Paths(
        time_s=np.arange(len(telemetry)) * settings.step_s,
        height_m=column["height_m"],
        velocity_m_per_s=column["velocity_m_per_s"],
        phase_rad=column["phase_rad"] if with_phase else None,
        spring_force_n=body.stiffness_n_per_m * np.maximum(compressed, 0.0),
        actuator_force_n=column["actuator_force_n"],
        feedback_rad_per_s=column["feedback_rad_per_s"],
        failed=step.terminated,
    )


def measured_policy(policy: Policy, paths: Paths, release: int = 0) -> Measured:
    """The metrics of one of a policy's rollouts, with the reason of each that is undefined.

    Args:
        policy: the policy.
        paths: of `policy_paths`.
        release: which.
    """
    body = policy.meaning.body
    return measure(
        paths.time_s,
        paths.height_m[:, release],
        rest_length_m=float(body.rest_length_m),
        phase_rad=None if paths.phase_rad is None else paths.phase_rad[:, release],
        omega=policy.meaning.omega if policy.meaning.with_phase else None,
        force_n=paths.actuator_force_n[:, release],
        max_force_n=float(body.max_force_n),
        body=body,
    )


def policy_orbit(paths: Paths, measured: Measured, release: int = 0) -> Orbit:
    """The last turn of the limit cycle of one of a policy's rollouts.

    Args:
        paths: of `policy_paths`.
        measured: its metrics.
        release: which of them.

    Raises:
        NoLimitCycleError: if it does not settle; says why.
    """
    if paths.failed[release]:
        raise NoLimitCycleError("the gait has no limit cycle: the leg has no length left")
    if not np.isfinite(measured.limit_cycle_period):
        raise NoLimitCycleError(
            f"the gait has no limit cycle: {measured.reasons['limit_cycle_period']}"
        )
    table, k = measured.hops, int(measured.limit_cycle_period)
    start_s, end_s = table.time_s[-1 - k], table.time_s[-1]
    turn = (paths.time_s >= start_s) & (paths.time_s <= end_s)
    height = paths.height_m[turn, release]
    phase = np.zeros_like(height) if paths.phase_rad is None else paths.phase_rad[turn, release]
    return Orbit(
        hops=k,
        period_s=float(end_s - start_s),
        apex_height_m=np.asarray(table.height_m[-1 - k : -1]),
        apex_phase_rad=np.asarray(table.phase_rad[-1 - k : -1]),
        time_s=paths.time_s[turn] - start_s,
        height_m=height,
        velocity_m_per_s=paths.velocity_m_per_s[turn, release],
        phase_rad=phase % (2.0 * np.pi),
        spring_force_n=paths.spring_force_n[turn, release],
        feedback_rad_per_s=paths.feedback_rad_per_s[turn, release],
        actuator_force_n=paths.actuator_force_n[turn, release],
    )
