"""The disturbances that are tried: data."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.tables import number
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.kinds import (
    Blow,
    ForcePulse,
    Frequency,
    Ground,
    Incline,
    Late,
    LostLeg,
    Noise,
    ReleaseHeight,
    Roughness,
    Scaled,
    Stairs,
    Strength,
)

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
