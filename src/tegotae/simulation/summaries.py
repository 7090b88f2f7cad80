"""Summaries of a rollout: functions of its recording, of which only the results are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.timing import Timing
from tegotae.simulation.world import Scenario

Summary = Callable[[Trajectory, Scenario, Body, Timing], Any]
"""Function of a block's trajectory, scenario, body and timing to a pytree of arrays, lanes last."""


@dataclass(frozen=True)
class KeptChannels:
    """The summary that keeps the recording unchanged.

    Args:
        needs: the channels that are recorded; all by default.
    """

    needs: tuple[str, ...] | None = None

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Trajectory:
        """Return these channels of the trajectory."""
        return trajectory.only(self.needs)


whole_trajectory = KeptChannels()
"""The summary that keeps everything."""


@dataclass(frozen=True)
class Together:
    """The summary that returns the results of several summaries of the same lanes, as a tuple.

    Args:
        parts: the summaries.
    """

    parts: tuple[Summary, ...]

    @property
    def needs(self) -> tuple[str, ...] | None:
        """The channels that are recorded for them; None for all."""
        channels: dict[str, None] = {}
        for part in self.parts:
            names: tuple[str, ...] | None = getattr(part, "needs", None)
            if names is None:
                return None
            channels |= dict.fromkeys(names)
        return tuple(channels)

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[Any, ...]:
        """Return each summary's result."""
        return tuple(part(trajectory, scenario, body, timing) for part in self.parts)
