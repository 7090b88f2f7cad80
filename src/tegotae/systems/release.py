"""The release: how a body is let go, and where its oscillators start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.oscillators import Oscillator
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import Scenario
from tegotae.simulation.world.checks import check_initial_pose, check_oscillator_state

RELEASE_M = 1.2
"""Height of the paper's release [m]."""


@dataclass(frozen=True, kw_only=True)
class Release:
    """How an episode begins: one number each, or one a limb.

    Args:
        height_m: height of the body [m].
        velocity_m_per_s: its vertical velocity [m/s].
        phase_rad: phase of the oscillators [rad], one for all or one a limb.
        initial_pose: further numbers that the body's release takes, pairs of name and number, such
            as (("pitch_rad", 0.1),) for a bar.
        oscillator_state: the oscillators' state beside the phase, such as (("radius", 0.5),).

    Raises:
        TegotaeError: for a height that is not positive, or a number that is not finite.

    Example:
        >>> Release(height_m=1.1).scenario(8.0).height_m
        1.1
    """

    height_m: float = RELEASE_M
    velocity_m_per_s: float = 0.0
    phase_rad: float | tuple[float, ...] = 0.0
    initial_pose: tuple[tuple[str, float], ...] = ()
    oscillator_state: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        require_finite("the release's height_m", self.height_m, above=0.0, most=MOST_M)
        require_finite("the release's velocity_m_per_s", self.velocity_m_per_s)
        for phase in np.atleast_1d(np.asarray(self.phase_rad, object)):
            require_finite("the release's phase_rad", phase)
        for name, value in (*self.initial_pose, *self.oscillator_state):
            require_finite(f"the release's {name}", value)

    def check(
        self, body: Body, oscillator: Oscillator | None, omega: float | None, episode: Timing
    ) -> None:
        """Raise `TegotaeError` unless this body and these oscillators can be released so.

        Args:
            body: the body.
            oscillator: of the controller.
            omega: ω [rad/s].
            episode: its duration and tick (`Timing`).
        """
        if isinstance(self.phase_rad, tuple) and not 1 < body.limbs == len(self.phase_rad):
            raise TegotaeError(
                f"the release has {len(self.phase_rad)} phases, one a limb; the body has "
                f"{body.limbs} limb{'s' if body.limbs > 1 else ''}"
            )
        scenario = self.scenario(omega)
        check_initial_pose(body, scenario)
        check_oscillator_state(oscillator, scenario, episode.tick_s, episode.duration_s)

    def scenario(self, omega: float | None, **entries: LaneNumbers) -> Scenario:
        """The scenario of a lane that is released so.

        Args:
            omega: ω [rad/s]; None without an oscillator.
            entries: entries of the scenario in place of the release's.
        """
        by_limb = isinstance(self.phase_rad, tuple)
        own = {
            "height_m": self.height_m,
            "velocity_m_per_s": self.velocity_m_per_s,
            "phase_rad": np.array(self.phase_rad)[:, None] if by_limb else self.phase_rad,
            "initial_pose": dict(self.initial_pose),
            "oscillator_state": dict(self.oscillator_state),
        }
        return Scenario.of(omega, **{**own, **entries})
