"""Names of designs: `FAMILY@SYSTEM`, such as `ART-rF-tphif-w3@quadruped-c`.

FAMILY is one of

- `ARCHITECTURE[-rOBS][-gOBS][-tIN]`, the paper's architectures with a unit a leg
  (`tegotae.systems.grammar`). OBS is `F` a leg's load, `Fv` its rate, too, or `Fa` the body's
  angles, too;
- `cos`, the cosine law;
- `T-OBS`, a network a leg without oscillators;
- `W-OBS`, `Wphi-OBS` and `W+phi-OBS`, one network for the whole body, without a clock, with one,
  and added to ellipses that the clock drives;

each with `-wω` behind it for another frequency than the system's own.
"""

from __future__ import annotations

import re

from tegotae._support.errors import TegotaeError, unknown
from tegotae.systems.designs.base import Family
from tegotae.systems.designs.baselines import (
    COSINE,
    CosineLaw,
    NetworkOfBody,
    NetworkPerLeg,
)
from tegotae.systems.designs.design import Design
from tegotae.systems.designs.tegotae import TegotaeFamily
from tegotae.systems.grammar import learned_terms
from tegotae.systems.legged_systems import SYSTEMS, system

FAMILIES: tuple[Family, ...] = (
    TegotaeFamily(),
    TegotaeFamily(gain="F"),
    TegotaeFamily(action=True, reaction="F"),
    TegotaeFamily(action=True, reaction="F", actuation="phif"),
    TegotaeFamily(action=True, reaction="F", gain="F"),
    TegotaeFamily(action=True, reaction="F", gain="F", actuation="phif"),
    CosineLaw(),
    NetworkPerLeg(observation="F"),
    NetworkPerLeg(observation="Fa"),
    NetworkOfBody(observation="F"),
    NetworkOfBody(observation="Fa"),
    NetworkOfBody(observation="F", clock=True),
    NetworkOfBody(observation="Fa", clock=True),
)
"""The families that are listed; there are more by other senses."""

_NETWORK = re.compile(r"(?P<kind>T|W|Wphi|W\+phi)-(?P<observation>[A-Za-z]+)")
_OMEGA = re.compile(r"(?P<family>.+?)(?:-w(?P<omega>[0-9.]+))?")


def is_design(name: str) -> bool:
    """Whether a name is meant as a design's: it has a family and a system.

    Example:
        >>> is_design("ART@quadruped-c"), is_design("ART-rF-tphif-w8")
        (True, False)
    """
    family, at, _ = name.partition("@")
    return bool(at) and not set(family) & set("/\\:")


def design(name: str) -> Design:
    """The design of a name.

    Args:
        name: `FAMILY@SYSTEM`; the system is one of `tegotae.systems.legged_systems.SYSTEMS`, or
            `FILE.py:OBJECT`.

    Raises:
        TegotaeError: for an unknown family or system, with the nearest ones.

    Example:
        >>> design("ARG-w3@hexapod").name
        'ARG-rF-gF-w3@hexapod'
    """
    own, _, called = name.partition("@")
    parts = _OMEGA.fullmatch(own)
    if parts is None:
        raise unknown("family", own, [family.name for family in FAMILIES])
    try:
        omega = None if parts["omega"] is None else float(parts["omega"])
    except ValueError:
        raise TegotaeError(f"{name} has no frequency behind -w; write a number, as -w3") from None
    legged = system(called)
    short = called.rpartition(":")[2] or called
    return Design(family_named(parts["family"]), legged, short, omega)


def family_named(name: str) -> Family:
    """The family of a name; what its networks sense may be left out.

    Raises:
        TegotaeError: for an unknown one, or a sense of a term that is not learned.

    Example:
        >>> family_named("VG").name, family_named("W-Fa").about
        ('VG-gF', "one network for all legs, on its load and the body's pitch and roll")
    """
    if name == COSINE:
        return CosineLaw()
    if found := _NETWORK.fullmatch(name):
        if found["kind"] == "T":
            return NetworkPerLeg(observation=found["observation"])
        clock, added = "phi" in found["kind"], "+" in found["kind"]
        return NetworkOfBody(observation=found["observation"], clock=clock, added=added)
    terms = learned_terms(name)
    if terms is None:
        raise unknown("family", name, [family.name for family in FAMILIES])
    return TegotaeFamily(
        action=terms.action,
        reaction=terms.reaction,
        gain=terms.gain,
        actuation=terms.actuation,
    )


def all_designs() -> dict[str, Design]:
    """Every listed family on every named system, by name.

    Example:
        >>> "ARGT-rF-gF-tphif@plate-light-pitch" in all_designs()
        True
    """
    legged = {name: make() for name, make in SYSTEMS.items()}
    found = (Design(family, body, name) for name, body in legged.items() for family in FAMILIES)
    return {each.name: each for each in found}
