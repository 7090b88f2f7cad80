"""Fields that say what they may be: what is not so is refused in one line, by the field's name."""

import dataclasses
import math

import pytest

from tegotae import TegotaeError
from tegotae.parts.bodies import Actuators, Bar, Blows, Hopper, Plate, Sensors, Walker
from tegotae.parts.couplings import Neighbours
from tegotae.parts.oscillators import PLANAR, AdaptiveHopf, Matsuoka, VanDerPol
from tegotae.parts.terms import (
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
    Network,
    SectorAndReflex,
    TunedFoot,
    WholeBodyFoot,
)
from tegotae.parts.terrains import Rough, Slope, SplitGrip, Steps, Sum

PARTS = (
    *(Hopper(), Bar(), Plate(), Walker(), Actuators(), Sensors(), Blows()),
    *PLANAR.values(),
    *(SectorAndReflex(), EllipticFoot(), LearnedFoot(("phase",), 2), Network(("phase",), 2)),
    *(WholeBodyFoot(("spring_force",), (), 2, 2), LearnedActuation(("phase",), 2), TunedFoot()),
    *(Slope(), Steps(), Rough(), SplitGrip(), Sum(), Neighbours(((0, 1),), 1.0)),
)
CHECKED = [
    pytest.param(part, field.name, id=f"{type(part).__name__}.{field.name}")
    for part in PARTS
    for field in dataclasses.fields(part)
    if "check" in field.metadata
]


def refused(part, name, value) -> str:
    """Return the reason why a part cannot have this value."""
    with pytest.raises(TegotaeError) as raised:
        dataclasses.replace(part, **{name: value})
    assert "\n" not in str(raised.value)
    return str(raised.value)


@pytest.mark.parametrize(("part", "name"), CHECKED)
def test_what_no_field_can_be_is_refused_by_its_name(part, name):
    default = getattr(part, name)
    for value in (math.nan, math.inf, -math.inf, "heavy", None):
        if value is not None or default is not None:
            assert refused(part, name, value).startswith(f"{name} is ")


@pytest.mark.parametrize(
    ("part", "name", "value", "message"),
    [
        *((Hopper(), name, 0.0, "greater than 0") for name in ("mass_kg", "max_force_n")),
        *((Walker(), name, 0.0, "greater than 0") for name in ("mass_kg", "damping_xy_ns_per_m")),
        (Hopper(), "flight_damping_ns_per_m", -0.1, "at least 0"),
        (Plate(), "damping_ns_per_m", -0.1, "at least 0"),
        (Plate(), "pitch_inertia_ratio", 0.0, "greater than 0"),
        (Plate(twist_inertia_ratio=1.0), "twist_inertia_ratio", -1.0, "greater than 0"),
        (Plate(), "twist_stiffness_nm_per_rad", -1.0, "at least 0"),
        (Sensors(), "noise", -1.0, "at least 0"),
        (Sensors(), "most_ticks", 0, "whole number of at least 1"),
        (Actuators(), "lag_s", -1.0, "at least 0"),
        (SectorAndReflex(), "width_rad", -0.1, "at least 0"),
        (SectorAndReflex(), "newtons_per_feedback", 0.0, "greater than 0"),
        *((Network(("phase",), 2), "hidden", n, "whole number") for n in (0, 2.5, True)),
        (VanDerPol(), "mu", 6.0, "at most 5"),
        (AdaptiveHopf(), "pace", 0.0, "greater than 0"),
        (Matsuoka(), "slowness", 12.0, "at most 2.5"),
    ],
)
def test_what_is_out_of_bounds_is_refused_with_what_would_be_right(part, name, value, message):
    assert message in refused(part, name, value)
