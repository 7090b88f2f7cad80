"""The multiverse as two small tables: the readings, and every claim's parts under each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder
from tegotae.measures.hopping.statistics import Interval
from tegotae.studies.paper.claims import Part, Verdict
from tegotae.studies.paper.multiverse.designs import (
    cells_of,
    choices_of,
    design_of,
    reading_of,
)
from tegotae.studies.paper.multiverse.readings import Reading
from tegotae.studies.paper.multiverse.verdicts import VerdictsByReading, claimed

READINGS, VERDICTS = "readings.csv", "verdicts.csv"
"""Names of the tables."""

_HEAD = (
    *("reading", "omega_t", "claim", "verdict", "part", "part_verdict", "what"),
    *("mean", "std", "low", "high", "count", "undefined", "above", "below", "unit"),
)
_DIGITS = 6
_KIND = "table that tegotae study multiverse export wrote"


def write_tables(readings: Sequence[Reading], verdicts: VerdictsByReading, folder: Path) -> None:
    """Write both tables to a folder. Parts that are for information alone are left out.

    Raises:
        TegotaeError: if they cannot be written.
    """
    choices = choices_of(readings)
    names = [choice.name for choice in choices]
    rows = [[i, *cells_of(reading, choices)] for i, reading in enumerate(readings)]
    parts = [
        [
            *(reading, omega, v.number, v.verdict, i, p.verdict, p.what),
            *(*_numbers(p.effect), p.effect.count, p.effect.undefined, p.low, p.high, p.unit),
        ]
        for reading, by_omega in verdicts.items()
        for omega, found in by_omega.items()
        for v in found
        for i, p in enumerate(claimed(v))
    ]
    output_folder(folder)
    tables.write_csv(folder / READINGS, _columns(["reading", *names], rows))
    tables.write_csv(folder / VERDICTS, _columns(_HEAD, parts))


def read_tables(folder: Path) -> tuple[list[Reading], VerdictsByReading]:
    """What `write_tables` wrote: the readings, and the verdicts made of the parts.

    Raises:
        TegotaeError: if a table cannot be read or is none.
    """
    readings = [_reading(row, folder) for row in _rows(folder / READINGS)]
    parts: dict[int, dict[str, dict[int, list[Part]]]] = {}
    for row in _rows(folder / VERDICTS):
        try:
            mean, std, low, high = (float(row[name]) for name in ("mean", "std", "low", "high"))
            effect = Interval(mean, std, low, high, int(row["count"]), int(row["undefined"]))
            part = Part(row["what"], effect, float(row["above"]), float(row["below"]), row["unit"])
            by_omega = parts.setdefault(int(row["reading"]), {})
            by_omega.setdefault(row["omega_t"], {}).setdefault(int(row["claim"]), []).append(part)
        except (KeyError, ValueError, TypeError):
            raise _no_table(folder / VERDICTS) from None
    if not parts or max(parts) >= len(readings):
        raise _no_table(folder / VERDICTS)
    return readings, {
        reading: {
            omega: [Verdict(number, "", tuple(each)) for number, each in claims.items()]
            for omega, claims in by_omega.items()
        }
        for reading, by_omega in parts.items()
    }


def _numbers(effect: Interval) -> list[str]:
    return [f"{x:.{_DIGITS}g}" for x in (effect.mean, effect.std, effect.low, effect.high)]


def _reading(row: dict[str, str], folder: Path) -> Reading:
    if (design := design_of(row)) is None:
        raise _no_table(folder / READINGS)
    try:
        return reading_of(row, design.choices)
    except ValueError:
        raise _no_table(folder / READINGS) from None


def _rows(path: Path) -> list[dict[str, str]]:
    cells = tables.read_csv(path, kind=_KIND)
    return [dict(zip(cells, row, strict=True)) for row in zip(*cells.values(), strict=True)]


def _no_table(path: Path) -> TegotaeError:
    return TegotaeError(f"{path} is no {_KIND}")


def _columns(head: Sequence[str], rows: Sequence[Sequence[object]]) -> dict[str, list[str]]:
    return {name: [str(row[i]) for row in rows] for i, name in enumerate(head)}
