"""Kinds of disturbance: blows, other bodies, other ground, worse signals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance, release_of
from tegotae.measures.gaits.summary import has_mass, total_mass_kg
from tegotae.simulation.world import Staircase, Step


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


@dataclass(frozen=True, kw_only=True)
class Frequency(Disturbance):
    """Another frequency ω: that of the training times the level.

    Raises:
        TegotaeError: for a level that is not positive.
    """

    neutral: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, above=0.0)

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return "" if tested.omega is not None else "it has no oscillator"

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"omega": tested.omega * level}


@dataclass(frozen=True, kw_only=True)
class Scaled(Disturbance):
    """Numbers of the body times the level, from the release on.

    A leg of another length is released as high over where it touches the ground.
    """

    fields: tuple[str, ...]
    """Names of which the body has at least one; all that it has are scaled."""
    neutral: float = 1.0

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        own = self._own(tested)
        if not own:
            return f"a {type(tested.unwrapped).__name__} has no {' or '.join(self.fields)}"
        if not any(np.any(np.asarray(tested.usual(name))) for name in own):
            return f"its {self.fields[0]} is 0, and so is any share of it"
        return ""

    def _own(self, tested: ControllersUnderTest) -> list[str]:
        return list(filter(tested.has_field, self.fields))

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        changes = {name: _times(tested.usual(name), level) for name in self._own(tested)}
        if "rest_length_m" in self.fields:
            longer = (level - 1.0) * float(tested.body.rest_length_m)
            changes["height_m"] = tested.height_m + longer
        return changes


def _times(usual, level):
    """A number of the body, or the legs' numbers [limbs, 1], times levels [lanes]."""
    usual = np.asarray(usual, float)
    return usual[:, None] * level if usual.ndim else usual * level


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
