"""Phase portraits: where a gait goes from several releases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M
from tegotae.parts.bodies import Hopper
from tegotae.systems.controller_file import SavedController


@dataclass(frozen=True)
class Paths:
    """Rollouts from several releases, arrays [frames, releases]."""

    time_s: np.ndarray
    """Time [s], [frames]."""
    height_m: np.ndarray
    """Height y [m]."""
    velocity_m_per_s: np.ndarray
    """Velocity ẏ [m/s]."""
    phase_rad: np.ndarray | None
    """Phase φ modulo 2π [rad]; None without an oscillator."""
    spring_force_n: np.ndarray
    """Spring force F_k [N]."""
    actuator_force_n: np.ndarray
    """Actuator force F_a [N]."""
    feedback_rad_per_s: np.ndarray
    """Tegotae feedback f [rad/s]."""
    failed: np.ndarray
    """Who had no leg length left, and stands still from then on, [releases]."""


def check_releases(height_m: np.ndarray, duration_s: float) -> np.ndarray:
    """The heights [m], [releases]; raises `TegotaeError` for any that cannot be, or none."""
    heights = np.atleast_1d(np.asarray(height_m, float))
    if not len(heights):
        raise TegotaeError("no release is given; name at least one height")
    for height in heights:
        require_finite("height", height, above=0.0, most=MOST_M)
    require_finite("duration", duration_s, least=1.0, most=3600.0)
    return heights


def paths_of(
    saved: SavedController,
    height_m: np.ndarray,
    *,
    duration_s: float = 30.0,
) -> Paths:
    """Release a system on a hopper from several heights.

    Args:
        saved: the system and its weights.
        height_m: heights in place of the system's [m], [releases].
        duration_s: simulated time [s].

    Raises:
        TegotaeError: for a body that is no hopper, or a release that is not finite.

    Example:
        >>> from tegotae import build
        >>> saved = SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> paths_of(saved, np.array([1.1, 1.3]), duration_s=1.0).height_m.shape
        (100, 2)
    """
    if not isinstance(saved.body, Hopper):
        raise TegotaeError(f"a phase portrait needs a hopper, not a {type(saved.body).__name__}")
    heights = check_releases(height_m, duration_s)
    system = saved.system
    engine = system.engine(timing=system.timing_over(duration_s, frame_s=0.01))
    path = engine.run(saved.weights, system.scenario(height_m=heights), saved.body)
    with_phase = saved.controller.oscillator is not None
    return Paths(
        time_s=path.time_s[:, 0],
        height_m=path.height_m,
        velocity_m_per_s=path.velocity_m_per_s,
        phase_rad=path.phase_rad if with_phase else None,
        spring_force_n=path.spring_force_n,
        actuator_force_n=path.actuator_force_n,
        feedback_rad_per_s=path.feedback_rad_per_s,
        failed=path.failed[-1],
    )
