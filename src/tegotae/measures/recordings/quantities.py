"""What may be recorded, and in which units: names of columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

_LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "MN": 1e6}


@dataclass(frozen=True)
class Quantity:
    """Something that may be recorded.

    Args:
        names: by which its column is known, without the unit.
        units: how much each unit is of the SI's, the SI's first.
        about: its meaning.
    """

    names: tuple[str, ...]
    units: Mapping[str, float]
    about: str

    def of(self, unit: str) -> float | None:
        """How much a unit is of the SI's; None if it is no unit of this.

        Capitals count only where they distinguish two units, as those of mN and MN do.
        """
        alike = [known for known in self.units if known.lower() == unit.lower()]
        if len(alike) > 1:
            alike = [known for known in alike if known[0] == unit[0]]
        return self.units[alike[0]] if alike else None


QUANTITIES = {
    "time": Quantity(("time", "t"), {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}, "when"),
    "height": Quantity(("height", "y"), _LENGTH, "height of the centre of mass"),
    "ground": Quantity(("ground",), _LENGTH, "height of the ground"),
    "phase": Quantity(("phase",), {"rad": 1.0, "deg": np.pi / 180.0}, "phase of the oscillator"),
    "force": Quantity(("actuator_force", "force"), _FORCE, "actuator force"),
    "work": Quantity(
        ("work",), {"J": 1.0, "kJ": 1e3, "mJ": 1e-3, "MJ": 1e6}, "running total of the work"
    ),
    "climb_flight": Quantity(
        ("climb_flight",), _LENGTH, "running total of the heights climbed in flight"
    ),
    "climb": Quantity(("climb",), _LENGTH, "running total of all heights climbed"),
}
"""What can be measured, by the name that it has on the command line."""


def split(column: str) -> tuple[str, str]:
    """A column's name in small letters, and its unit, if its name has one.

    Example:
        >>> split("Height (mm)"), split("height_mm"), split("height")
        (('height', 'mm'), ('height', 'mm'), ('height', ''))
    """
    name, unit = in_brackets(column)
    plain = re.sub(r"\W+", "_", name.strip()).strip("_")
    if unit:
        return plain.lower(), unit
    stem, _, ending = plain.rpartition("_")
    return (stem.lower(), ending) if stem else (plain.lower(), "")


def in_brackets(text: str) -> tuple[str, str]:
    """What stands before brackets at the end of a text, and in them."""
    match = re.fullmatch(r"(.*?)\s*[\[(](\w*)[\])]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, "")
