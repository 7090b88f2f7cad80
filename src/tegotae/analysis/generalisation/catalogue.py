"""The disturbances that are tried: blows, other bodies, other ground, worse signals."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.tables import number
from tegotae.analysis.generalisation.disturbance import (
    Disturbance,
    LackingError,
    Tested,
    release_of,
)
from tegotae.simulation.world import Staircase, Step


@dataclass(frozen=True, kw_only=True)
class Blow(Disturbance):
    """A vertical blow that changes the velocity by the level, at an apex of what hops.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"impulse_ns": level * tested.speed_scale * tested.mass_kg, "at_s": at_s}


@dataclass(frozen=True, kw_only=True)
class ForcePulse(Disturbance):
    """A force on the centre of mass for a short time, that alone changes its velocity by the level.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    field: str
    """The body's field of the force [N]."""
    lasts_s: float = 0.1
    """How long [s], of a leg of a metre on Earth."""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        _ = tested.usual(self.field)
        lasts = self.lasts_s * tested.time_scale
        force = level * tested.speed_scale * tested.mass_kg / lasts
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

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        limbs = tested.body.limbs
        if not tested.has_field("present"):
            raise LackingError(f"a {tested.kind} cannot lose a leg")
        if max(self.levels) >= limbs:
            raise LackingError(f"it has {limbs} legs")
        first = release_of(tested, level) % limbs
        order = (np.arange(limbs)[:, None] - first[None]) % limbs
        present = np.asarray(tested.usual("present"), float)[:, None] * (order >= level[None])
        return {"present": Step(present, at_s, np.inf)}


@dataclass(frozen=True, kw_only=True)
class Frequency(Disturbance):
    """Another frequency ω: that of the training times the level.

    Raises:
        TegotaeError: for a level that is not positive.
    """

    RANGE: ClassVar = {"above": 0.0}

    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        if tested.omega is None:
            raise LackingError("it has no oscillator")
        return {"omega": tested.omega * level}


@dataclass(frozen=True, kw_only=True)
class Scaled(Disturbance):
    """Numbers of the body times the level, from the release on.

    A leg of another length is released as high over where it touches the ground.
    """

    fields: tuple[str, ...]
    """Names of which the body has at least one; all that it has are scaled."""
    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        own = {name: np.asarray(tested.usual(name), float) for name in self.fields
               if tested.has_field(name)}  # fmt: skip
        if not own:
            raise LackingError(f"a {tested.kind} has no {' or '.join(self.fields)}")
        if not any(map(np.any, own.values())):
            raise LackingError(f"its {self.fields[0]} is 0, and so is any share of it")
        # Of several legs [limbs, 1], times levels [lanes].
        changes = {name: (x[:, None] if x.ndim else x) * level for name, x in own.items()}
        if "rest_length_m" in self.fields:
            longer = (level - 1.0) * float(tested.body.rest_length_m)
            changes["height_m"] = tested.height_m + longer
        return changes


@dataclass(frozen=True, kw_only=True)
class ReleaseHeight(Disturbance):
    """A release from another height over where the leg touches the ground, in leg lengths; none is
    below zero, in the ground."""

    RANGE: ClassVar = {"least": 0.0}

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        if not tested.takes_forces:
            raise LackingError("it is released on its feet")
        over = level * float(tested.body.rest_length_m)
        return {"height_m": float(tested.body.touching_height_m) + over}


@dataclass(frozen=True, kw_only=True)
class Ground(Disturbance):
    """The ground rises or falls once, by the level in leg lengths: at an apex, of what hops."""

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

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        down = -level * float(tested.body.rest_length_m)
        stairs = Staircase(down, self.dwell_s * tested.time_scale, float(self.times + 1))
        return {"ground_m": stairs}


@dataclass(frozen=True, kw_only=True)
class Incline(Disturbance):
    """Ground that rises forward by the level per length, or falls, from the release on."""

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        _require_terrain(tested)
        return {"terrain.second.first.along": level}


@dataclass(frozen=True, kw_only=True)
class Roughness(Disturbance):
    """Rough ground of this root mean square, in leg lengths; every release is elsewhere on it.

    Its typical wavelength is a leg's length, and it begins within one from the release.
    """

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        _require_terrain(tested)
        length = float(tested.body.rest_length_m)
        fields = {"rms_m": level * length, "wavelength_m": np.full(len(level), length)}
        fields["place"] = 1.0 + release_of(tested, level)
        return {f"terrain.second.second.{field}": value for field, value in fields.items()}


def _require_terrain(tested: Tested) -> None:
    if not tested.has_field("terrain"):
        raise LackingError(f"a {tested.kind} stays in its place, on level ground")


@dataclass(frozen=True, kw_only=True)
class Strength(Disturbance):
    """Actuators that deliver this share of the force."""

    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        if not tested.takes_forces:
            raise LackingError("its actuators take places, not forces")
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

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        drawn = 1.0 + release_of(tested, level)
        return {"noise": tested.usual("noise") + level, "seed": drawn}


_BELOW = (0.85, 0.7, 0.5)
_ABOVE = (1.2, 1.5, 2.0, 3.0)

CATALOGUE: dict[str, Disturbance] = {
    each.name: each
    for each in (
        Frequency(name="omega", label="frequency ω / ω_t", levels=(*_BELOW, *_ABOVE)),
        Scaled(name="mass", label="mass", fields=("mass_kg",), levels=(*_BELOW, *_ABOVE)),
        Scaled(
            name="stiffness",
            label="stiffness",
            fields=("stiffness_n_per_m", "stiffness_z_n_per_m"),
            levels=(*_BELOW, *_ABOVE),
        ),
        Scaled(
            name="damping",
            label="damping",
            fields=("damping_ns_per_m", "damping_z_ns_per_m"),
            levels=(0.5, 0.0, 1.5, 2.5, 4.0),
        ),
        Scaled(
            name="gravity",
            label="gravity",
            fields=("gravity_m_per_s2",),
            levels=(*_BELOW, *_ABOVE),
        ),
        Scaled(
            name="leg-length",
            label="leg length",
            fields=("rest_length_m",),
            levels=(0.8, 0.5, 1.4, 2.0),
        ),
        Scaled(
            name="friction", label="friction", fields=("friction",), levels=(0.75, 0.5, 0.25, 0.1)
        ),
        ReleaseHeight(
            name="release",
            label="release over touchdown",
            unit="l0",
            neutral=0.2,
            levels=(0.05, 0.02, 0.5, 1.0, 1.5),
        ),
        Ground(
            name="step",
            label="step of the ground",
            unit="l0",
            levels=(-0.1, -0.25, -0.5, -1.0, 0.1, 0.2, 0.3),
        ),
        Stairs(
            name="drops",
            label="four drops in a row",
            unit="l0",
            levels=(0.05, 0.1, 0.2, 0.4),
        ),
        Blow(
            name="blow",
            label="vertical blow",
            unit="m/s",
            levels=(-0.5, -1.0, -2.0, -3.0, 0.5, 1.0, 2.0, 3.0),
        ),
        ForcePulse(
            name="push-ahead",
            label="push ahead",
            unit="m/s",
            field="push_x_n",
            levels=(-0.3, -0.6, -1.0, -1.5, 0.3, 0.6, 1.0, 1.5),
        ),
        ForcePulse(
            name="push-aside",
            label="push aside",
            unit="m/s",
            field="push_y_n",
            levels=(0.3, 0.6, 1.0, 1.5),
        ),
        Incline(
            name="slope", label="slope of the ground", levels=(-0.2, -0.1, -0.05, 0.05, 0.1, 0.2)
        ),
        Roughness(
            name="rough", label="roughness of the ground", unit="l0", levels=(0.01, 0.02, 0.05, 0.1)
        ),
        LostLeg(name="lost-leg", label="lost legs", unit="legs", levels=(1.0, 2.0)),
        Strength(
            name="strength",
            label="strength of the actuator",
            levels=(0.8, 0.6, 0.45, 0.3),
        ),
        Late(
            name="lag",
            label="lag of the actuator",
            unit="s",
            field="lag_s",
            levels=(0.005, 0.015, 0.04, 0.1),
        ),
        Late(
            name="delay",
            label="delay of the senses",
            unit="s",
            field="delay_s",
            levels=(0.004, 0.008, 0.016, 0.032),
        ),
        Noise(
            name="noise",
            label="noise of the senses",
            levels=(0.05, 0.1, 0.2, 0.4, 0.8),
        ),
    )
}
"""All by name."""


def disturbances_named(texts: Iterable[str]) -> tuple[Disturbance, ...]:
    """Disturbances by name, each with levels of one's own if some are written: "delay=0.01/0.02".

    Args:
        texts: names; all that there are, if there are none.

    Raises:
        TegotaeError: for an unknown name, one that is given twice, or levels that are none.

    Example:
        >>> [each.levels for each in disturbances_named(["lag=0.01/0.02", "drops"])]
        [(0.01, 0.02), (0.05, 0.1, 0.2, 0.4)]
    """
    found: dict[str, Disturbance] = {}
    for text in texts:
        name, equals, levels = text.partition("=")
        if name not in CATALOGUE:
            raise unknown("condition", name, CATALOGUE)
        if name in found:
            raise TegotaeError(f"{name} is named twice; name each condition once")
        found[name] = CATALOGUE[name]
        if equals:
            try:
                numbers = tuple(number(each) for each in levels.split("/"))
            except ValueError:
                raise TegotaeError(
                    f"{text} has no levels; write {name}=LEVEL/LEVEL, such as {name}="
                    f"{'/'.join(f'{x:g}' for x in CATALOGUE[name].levels[:2])}"
                ) from None
            found[name] = dataclasses.replace(CATALOGUE[name], levels=numbers)
    return tuple(found.values()) or tuple(CATALOGUE.values())
