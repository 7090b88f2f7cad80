"""Walkers of the kept fronts by name: `front:SYSTEM/FAMILY/SPEED`.

`front:quadruped-c/vanilla/0.4` is the cheapest walker found near a speed of 0.4 √(g l0) with
vanilla feedback; `front:quadruped-c/0.4` is the same.
"""

from __future__ import annotations

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.tables import number
from tegotae.measures.fronts import front
from tegotae.measures.fronts.table import NEAR
from tegotae.systems.legged import Legged
from tegotae.systems.legged_systems import system
from tegotae.systems.tuned import family

PREFIX = "front:"
"""How every such name begins."""
USUAL = "vanilla"
"""The family of a name without one."""


def is_front_name(name: str) -> bool:
    """Whether a name is meant to be a walker of a front."""
    return name.startswith(PREFIX)


def front_walker(name: str) -> Legged:
    """The walker of a kept front nearest to a speed.

    Args:
        name: `front:SYSTEM/FAMILY/SPEED`, or without the family.

    Raises:
        TegotaeError: for a system or family without a front, or a speed that is none, or
            that no walker of the front has.

    Example:
        >>> found = front_walker("front:quadruped-c/0.4")
        >>> found.names, len(found.weights)
        (('LF', 'RF', 'LH', 'RH'), 5)
    """
    parts = name.removeprefix(PREFIX).split("/")
    if len(parts) not in (2, 3):
        raise TegotaeError(f"{name} names no walker; write front:SYSTEM/FAMILY/SPEED")
    body, kind = parts[0], parts[1] if len(parts) == 3 else USUAL
    try:
        speed = number(parts[-1])
    except ValueError:
        raise TegotaeError(f"{name}: {parts[-1]!r} is no speed; write such as 0.4") from None
    require_finite("the speed of a front", speed, above=0.0)
    found = front(body, kind)
    if not found.reaches(speed):
        near = found.nearest(speed)["speed"]
        raise TegotaeError(
            f"{name}: this front has no walker within {NEAR:g} of that speed; the nearest has "
            f"{near:.2f}"
        )
    point = found.nearest(speed)
    legged = system(body)
    return family(legged, kind).walker(legged, point)
