"""Another release, and ground that moves, slopes, or is rough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import require_finite
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance, release_of
from tegotae.simulation.world import Staircase, Step


@dataclass(frozen=True, kw_only=True)
class ReleaseHeight(Disturbance):
    """A release from another height over where the leg touches the ground, in leg lengths.

    Raises:
        TegotaeError: for a level below zero, in the ground.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, least=0.0)

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return "" if tested.takes_forces else "it is released on its feet"

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        over = level * float(tested.body.rest_length_m)
        return {"height_m": float(tested.body.touching_height_m) + over}


@dataclass(frozen=True, kw_only=True)
class Ground(Disturbance):
    """The ground rises or falls once, by the level in leg lengths: at an apex, of what hops."""

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return ""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"drop_m": Step(-level * float(tested.body.rest_length_m), at_s)}


@dataclass(frozen=True, kw_only=True)
class Stairs(Disturbance):
    """The ground falls again and again by the level, in leg lengths."""

    dwell_s: float = 5.0
    """How long it stays [s], of a leg of a metre on Earth."""
    times: int = 4
    """How often it falls."""

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return ""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        down = -level * float(tested.body.rest_length_m)
        stairs = Staircase(down, self.dwell_s * tested.time_scale, float(self.times + 1))
        return {"ground_m": stairs}


@dataclass(frozen=True, kw_only=True)
class Incline(Disturbance):
    """Ground that rises forward by the level per length, or falls, from the release on."""

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return _no_terrain(tested)

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"terrain.second.first.along": level}


@dataclass(frozen=True, kw_only=True)
class Roughness(Disturbance):
    """Rough ground of this root mean square, in leg lengths; every release is elsewhere on it.

    Its typical wavelength is a leg's length, and it begins within one from the release.
    """

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return _no_terrain(tested)

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        length = float(tested.body.rest_length_m)
        fields = {"rms_m": level * length, "wavelength_m": np.full(len(level), length)}
        fields["place"] = 1.0 + release_of(tested, level)
        return {f"terrain.second.second.{field}": value for field, value in fields.items()}


def _no_terrain(tested: ControllersUnderTest) -> str:
    has = tested.has_field("terrain")
    return "" if has else f"a {type(tested.unwrapped).__name__} stays in its place, on level ground"
