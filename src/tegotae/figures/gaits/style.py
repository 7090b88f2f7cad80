"""Colours and labels of gaits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tegotae.analysis.gaits.map import OMEGA, SIGMA, Axis
from tegotae.figures.style import COLOURS, literal_text
from tegotae.measures.gaits.names import (
    AS_RELEASED,
    FALLEN,
    IN_BETWEEN,
    NOT_LOCKED,
    PATTERNS,
    STANDING,
)
from tegotae.systems.legged import Legged

_NAMED = tuple(dict.fromkeys(pattern.name for pattern in PATTERNS))
_GREYS = {
    IN_BETWEEN: "0.45",
    NOT_LOCKED: "0.65",
    AS_RELEASED: "0.75",
    STANDING: "0.83",
    FALLEN: "0.9",
}
_ORDER = {"in phase": 0, "antiphase": 1, "pronk": 0, "bound": 1, "pace": 4, "trot": 5}
_ORDER |= {"lateral-sequence walk": 3, "diagonal-sequence walk": 6, "transverse gallop": 7}
_ORDER |= {"rotary gallop": 2, "canter": 8, "tripod": 5, "tetrapod": 4, "metachronal wave": 3}

_COLOURS = (*COLOURS, "#8C510A")

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
"""Markers of gaits or legs, for readers who do not distinguish colours."""
HATCHES = {
    IN_BETWEEN: ".....",
    "diagonal-sequence walk": "/////",
    "lateral-sequence walk": "\\\\\\\\\\",
}
"""Hatches of gaits whose colours are as light as that of a trot: printed in grey they differ by
this."""
HATCHED: Any = {"edgecolor": "0.3", "lw": 0}
"""Style of hatched areas."""


def gait_colour(name: str) -> str:
    """Return the colour of a gait, or grey for one without a name."""
    return _GREYS[name] if name in _GREYS else _COLOURS[_ORDER[name]]


def gait_marker(name: str) -> str:
    """Return the marker of a gait, or a point for one without a name."""
    return "." if name in _GREYS else MARKERS[_NAMED.index(name) % len(MARKERS)]


def by_side(legs: Sequence[str]) -> list[int]:
    """Return the legs in Hildebrand's order from the top: left hind to fore, right fore to hind.

    Example:
        >>> by_side(("LF", "RF", "LH", "RH")), by_side(("H", "F"))
        ([2, 0, 1, 3], [1, 0])
    """
    order = ("LH", "LM", "LF", "L", "F", "M", "H", "R", "RF", "RM", "RH")
    if not set(legs) <= set(order):
        return list(range(len(legs)))
    return sorted(range(len(legs)), key=lambda leg: order.index(legs[leg]))


_FIELDS = {
    "com_x_m": ("centre of mass, forward", "m"),
    "com_y_m": ("centre of mass, to the left", "m"),
    "com_z_m": ("centre of mass, upward", "m"),
    "inertia_ratio": ("inertia ratio", ""),
    "mass_kg": ("mass", "kg"),
    "stiffness_n_per_m": ("stiffness", "N/m"),
    "damping_ns_per_m": ("damping", "N s/m"),
    "rest_length_m": ("leg length", "m"),
}
"""Fields of bodies in words, and their units."""


def label(axis: Axis, legged: Legged) -> str:
    """Return the label of a parameter at an axis."""
    if axis.name == OMEGA:
        return f"frequency ω [rad/{legged.units[1]}]"
    if axis.name == SIGMA:
        return "gain σ"
    per_leg = isinstance(getattr(legged.body, axis.name), tuple)
    words, unit = _FIELDS.get(axis.name, (axis.name, ""))
    if unit == "m" and legged.dimensionless:
        unit = "l0"
    unit = "times usual" if per_leg else unit
    return literal_text(f"{words} [{unit}]" if unit else words)


def in_words(field: str) -> str:
    """Return the name of a body's field for a title.

    Example:
        >>> in_words("inertia_ratio"), in_words("my_field")
        ('inertia ratio', 'my_field')
    """
    return _FIELDS.get(field, (field, ""))[0]
