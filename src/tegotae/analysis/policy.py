"""Rollouts, limit cycles and metrics of policies of any origin."""

from __future__ import annotations

import numpy as np

from tegotae.analysis.orbit import SIGNALS, NoLimitCycleError, Orbit, check_heights
from tegotae.envs.core import TELEMETRY, Hoppers
from tegotae.envs.policies import Policy
from tegotae.measures.hopping import measure
from tegotae.measures.hopping.gait import Measured
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.recorder import Trajectory


def policy_paths(
    policy: Policy,
    height_m: np.ndarray,
    *,
    phase_rad: float = 0.0,
    duration_s: float = 30.0,
) -> Trajectory:
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
    heights = check_heights(height_m, duration_s)
    settings, body = policy.meaning.settings, policy.meaning.body
    with_phase = policy.meaning.with_phase
    phase = {"phase_rad": phase_rad} if with_phase else {}
    hoppers = Hoppers(settings, len(heights))
    step = hoppers.reset(options={"height_m": heights, **phase})
    telemetry = [step.telemetry]
    for _ in range(round(duration_s / settings.step_s)):
        step = hoppers.step(policy.actions(step.observation)[:, None])
        telemetry.append(step.telemetry)
    numbers = np.moveaxis(np.asarray(telemetry, float), -1, 0)
    column: dict[str, np.ndarray] = dict(zip(TELEMETRY, numbers, strict=True))
    compressed = body.rest_length_m - (column["height_m"] - column["ground_m"])
    column["spring_force_n"] = np.asarray(body.spring(np.maximum(compressed, 0.0)))
    time = np.arange(len(telemetry)) * settings.step_s
    channels = (*SIGNALS, *(("phase_rad",) if with_phase else ()))
    return Trajectory(
        time_s=np.broadcast_to(time[:, None], compressed.shape),
        **{name: column[name] for name in channels},
        failed=np.broadcast_to(step.terminated, compressed.shape),
    )


def measured_policy(policy: Policy, paths: Trajectory) -> Measured:
    """Return the metrics of a policy's first rollout, with the reason of each that is undefined.

    Args:
        policy: the policy.
        paths: of `policy_paths`.
    """
    body, with_phase = policy.meaning.body, policy.meaning.with_phase
    return measure(
        paths.time_s[:, 0],
        paths.height_m[:, 0],
        rest_length_m=float(body.rest_length_m),
        phase_rad=paths.phase_rad[:, 0] if with_phase else None,
        omega=policy.meaning.omega if with_phase else None,
        force_n=paths.actuator_force_n[:, 0],
        max_force_n=float(body.max_force_n),
        body=body,
    )


def policy_orbit(paths: Trajectory, measured: Measured) -> Orbit:
    """Return the last turn of the limit cycle of a policy's first rollout.

    Args:
        paths: of `policy_paths`.
        measured: its metrics.

    Raises:
        NoLimitCycleError: if it does not settle; says why.
    """
    if paths.failed[-1, 0]:
        raise NoLimitCycleError("the gait has no limit cycle: the leg has no length left")
    if not np.isfinite(measured.limit_cycle_period):
        raise NoLimitCycleError(
            f"the gait has no limit cycle: {measured.reasons['limit_cycle_period']}"
        )
    table, k = measured.hops, int(measured.limit_cycle_period)
    start_s, end_s = table.time_s[-1 - k], table.time_s[-1]
    time = paths.time_s[:, 0]
    turn = (time >= start_s) & (time <= end_s)
    path = {name: x[turn, 0] for name, x in paths.channels.items()}
    phase = path.get("phase_rad", 0.0 * path["height_m"])
    return Orbit(
        hops=k,
        period_s=float(end_s - start_s),
        apex_height_m=np.asarray(table.height_m[-1 - k : -1]),
        apex_phase_rad=np.asarray(table.phase_rad[-1 - k : -1]),
        time_s=path["time_s"] - start_s,
        phase_rad=phase % TWO_PI,
        **{name: path[name] for name in SIGNALS},
    )
