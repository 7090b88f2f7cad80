"""The readings of a multiverse: those that a calibration on V chose."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from research.reproduction.calibration.prior import PRIOR
from research.reproduction.calibration.scores import EVALUATED_AS
from research.reproduction.readings.readings import AnalysisChoice, Reading
from tegotae._support import tables
from tegotae._support.errors import TegotaeError, require_count
from tegotae.parts.bodies import Hopper

CALIBRATED_TABLE = Path(__file__).with_name("calibrated.csv")
"""Readings that stand for those under which V does what the paper says of it."""

_KIND = "table of readings"


def calibrated_readings(count: int) -> list[Reading]:
    """Return the first readings of the calibrated sample.

    Raises:
        TegotaeError: for more than it has.

    Example:
        >>> len(calibrated_readings(24))
        24
    """
    require_count("readings", count)
    readings = _calibrated()
    if count > len(readings):
        raise TegotaeError(f"readings is {count}; the calibrated sample has {len(readings)}")
    return list(readings[:count])


@cache
def _calibrated() -> tuple[Reading, ...]:
    cells = tables.read_csv(CALIBRATED_TABLE, [choice.name for choice in PRIOR], kind=_KIND)
    return tuple(
        reading_of(dict(zip(cells, row, strict=True))) for row in zip(*cells.values(), strict=True)
    )


def selecting(readings: Iterable[Reading]) -> frozenset[str]:
    """Return the claims that some readings were chosen to agree with: those on V, or none."""
    return _ON_V if set(readings) <= set(_calibrated()) else frozenset()


def selecting_body(body: object) -> frozenset[str]:
    """Return the claims that a body was chosen to agree with, if it is that of a calibrated
    reading.

    A body whose numbers are rounded to five digits is one, too.

    Example:
        >>> from tegotae import Hopper
        >>> sorted(selecting_body(Hopper()))
        []
    """
    numbers = dataclasses.astuple(body) if type(body) is Hopper else ()
    bodies = (dataclasses.astuple(reading.hopper) for reading in _calibrated())
    is_one = any(
        np.allclose(numbers, candidate, rtol=1e-4, atol=0.0) for candidate in bodies if numbers
    )
    return _ON_V if is_one else frozenset()


_ON_V = frozenset(EVALUATED_AS.values())


def cells_of(reading: Reading) -> list[str]:
    """Return a reading as the cells of a table, exact to the last bit."""
    return [str(getattr(reading, choice.name)) for choice in PRIOR]


def reading_of(row: Mapping[str, str]) -> Reading:
    """Return the reading of a table's row.

    Raises:
        ValueError: for a cell that no value of the choice is written as.
        TegotaeError: for what no reading is.
    """
    return Reading(**{choice.name: _value(choice, row[choice.name]) for choice in PRIOR})


def _value(choice: AnalysisChoice, cell: str) -> Any:
    if not choice.levels:
        return tables.parse_number(cell)
    for value in choice.values:
        if str(value) == cell:
            return value
    raise ValueError(f"{choice.name} is never {cell!r}")
