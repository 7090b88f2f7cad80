"""Senses that are late or noisy, and actuators that are weak or late."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.analysis.generalisation.disturbance import Disturbance, release_of


@dataclass(frozen=True, kw_only=True)
class Strength(Disturbance):
    """Actuators that deliver this share of the force."""

    neutral: float = 1.0

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return "" if tested.takes_forces else "its actuators take places, not forces"

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"strength": tested.usual("strength") * level}


@dataclass(frozen=True, kw_only=True)
class Late(Disturbance):
    """Actuators that lag, or senses that are late, by the level more [s].

    As much later for a body whose √(l0 / g) is larger.
    """

    field: str

    @property
    def longest_delay_s(self) -> float:
        """See `Disturbance.longest_delay_s`."""
        return max(self.levels) if self.field == "delay_s" else 0.0

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return ""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {self.field: tested.usual(self.field) + level * tested.time_scale}


@dataclass(frozen=True, kw_only=True)
class Noise(Disturbance):
    """White noise on the senses, a number a control tick, as a share of their scale.

    Every release meets another one.

    Under noise no hop is as the last: what counts is that there are hops.
    """

    measure: str = "moves"

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return ""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        drawn = 1.0 + release_of(tested, level)
        return {"noise": tested.usual("noise") + level, "seed": drawn}
