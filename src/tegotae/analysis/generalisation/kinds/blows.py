"""What strikes the body at a time: blows, pushes, a lost leg."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance, release_of
from tegotae.measures.gaits.summary import has_mass, total_mass_kg
from tegotae.simulation.world import Step


@dataclass(frozen=True, kw_only=True)
class Blow(Disturbance):
    """A vertical blow that changes the velocity by the level, at an apex of what hops.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return _no_mass(tested)

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        impulse = level * tested.speed_scale * float(total_mass_kg(tested.unwrapped))
        return {"impulse_ns": impulse, "at_s": at_s}


@dataclass(frozen=True, kw_only=True)
class ForcePulse(Disturbance):
    """A force on the centre of mass for a short time, that alone changes its velocity by the level.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    field: str
    """The body's field of the force [N]."""
    lasts_s: float = 0.1
    """How long [s], of a leg of a metre on Earth."""

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        if not tested.has_field(self.field):
            return f"a {type(tested.unwrapped).__name__} has no {self.field}"
        return _no_mass(tested)

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        lasts = self.lasts_s * tested.time_scale
        force = level * tested.speed_scale * float(total_mass_kg(tested.unwrapped)) / lasts
        return {self.field: Step(force, at_s, at_s + lasts)}


@dataclass(frozen=True, kw_only=True)
class LostLeg(Disturbance):
    """So many legs are lost at once; which ones differs from release to release.

    A gait of fewer legs is another one: what counts is that it walks on.

    Raises:
        TegotaeError: for a level that is no number of legs.
    """

    measure: str = "moves"

    def __post_init__(self) -> None:
        super().__post_init__()
        for level in self.levels:
            if level < 1.0 or not float(level).is_integer():
                raise TegotaeError(
                    f"{self.name}={level:g} is no number of legs; write whole ones, such as 1/2"
                )

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        if not tested.has_field("present"):
            return f"a {type(tested.unwrapped).__name__} cannot lose a leg"
        if max(self.levels) >= tested.body.limbs:
            return f"it has {tested.body.limbs} legs"
        return ""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        limbs = tested.body.limbs
        first = release_of(tested, level) % limbs
        order = (np.arange(limbs)[:, None] - first[None]) % limbs
        present = np.asarray(tested.usual("present"), float)[:, None] * (order >= level[None])
        return {"present": Step(present, at_s, np.inf)}


def _no_mass(tested: ControllersUnderTest) -> str:
    return (
        "" if has_mass(tested.unwrapped) else f"a {type(tested.unwrapped).__name__} has no mass_kg"
    )
