"""A vanilla controller over gain and frequency: what figures of both are made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.analysis.outcome import Outcome, OutcomeSummary
from tegotae.analysis.sweep import MAP_DURATION_S, as_maps, lanes
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.simulation.rollout import Engine, Scenario, Timing


@dataclass(frozen=True)
class GainSweep:
    """Outcomes over gain σ and frequency ω."""

    sigma: np.ndarray
    """Gains σ [rad/(s N)], shape [gains]."""
    omega: np.ndarray
    """Frequencies ω [rad/s], shape [frequencies]."""
    outcome: Outcome
    """Maps of shape [gains, frequencies]."""


def sweep_gain(
    controller: Controller,
    sigma: np.ndarray,
    omega: np.ndarray,
    body: Body | None = None,
    *,
    timing: Timing | None = None,
    work: str = "absolute",
    height_m: float = 1.2,
) -> GainSweep:
    """Roll out every pair of a gain and a frequency, as one batch.

    Args:
        controller: one whose only weight is σ, such as `V-sector-w4`.
        sigma: gains σ [rad/(s N)], shape [gains].
        omega: frequencies ω [rad/s], shape [frequencies].
        body: the paper's hopper by default.
        timing: 40 s by default. What has not settled by its end counts as without limit cycle.
        work: definition of work, one of "absolute", "positive", "net".
        height_m: height of the release [m].

    Raises:
        TegotaeError: for a controller that has other weights than σ, or an unknown work.

    Example:
        >>> from tegotae import build
        >>> sweep = sweep_gain(build("V-sector-w4"), np.array([0.0, 3.0]), np.array([5.0]))
        >>> sweep.outcome.phase_rate[0].round(3)  # σ = 0: the oscillator runs at ω
        array([5.], dtype=float32)
    """
    if controller.n_weights != 1:
        raise TegotaeError(
            f"the controller has {controller.n_weights} weights; a gain sweep needs one whose only "
            "weight is the gain σ"
        )
    engine = Engine(
        controller=controller,
        timing=timing or Timing(duration_s=MAP_DURATION_S),
        summary=OutcomeSummary(GaitSummary(work=work)),
    )
    gains, frequencies = lanes(sigma, omega)
    outcome = engine.run(gains[:, None], Scenario(omega=frequencies, height_m=height_m), body)
    return GainSweep(np.asarray(sigma), np.asarray(omega), as_maps(outcome, sigma, omega))
