"""What anyone's policy does: its rollouts, its limit cycle, its metrics."""

from __future__ import annotations

import numpy as np

from tegotae.analysis.orbit import SIGNALS, NoLimitCycleError, Orbit, Paths, check_releases
from tegotae.envs.core import TELEMETRY, Hoppers
from tegotae.envs.policies import Policy
from tegotae.measures.hopping import measure
from tegotae.measures.hopping.gait import Measured
from tegotae.parts.maths import TWO_PI


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
    step = hoppers.reset(options={"height_m": heights, **phase})
    telemetry = [step.telemetry]
    for _ in range(round(duration_s / settings.step_s)):
        step = hoppers.step(policy.actions(step.observation)[:, None])
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
    path = {name: getattr(paths, name)[turn, release] for name in SIGNALS}
    phase = 0.0 * path["height_m"] if paths.phase_rad is None else paths.phase_rad[turn, release]
    return Orbit(
        hops=k,
        period_s=float(end_s - start_s),
        apex_height_m=np.asarray(table.height_m[-1 - k : -1]),
        apex_phase_rad=np.asarray(table.phase_rad[-1 - k : -1]),
        time_s=paths.time_s[turn] - start_s,
        phase_rad=phase % TWO_PI,
        **path,
    )
