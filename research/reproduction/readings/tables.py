"""The multiverse as two small tables: the readings, and every claim's effect under each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from research.reproduction.calibration.prior import PRIOR
from research.reproduction.cells import require_once, whole_number
from research.reproduction.claims.counting import Count
from research.reproduction.claims.estimates import EffectEstimate
from research.reproduction.claims.findings import Finding
from research.reproduction.readings.designs import cells_of, reading_of
from research.reproduction.readings.readings import Reading
from research.reproduction.readings.verdicts import CLAIMS, FindingsByReading
from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder

READINGS, EFFECTS = "readings.csv", "effects.csv"
"""Names of the tables."""

_NUMBERS = ("effect", "low", "high", "size")
_HEAD = ("reading", "omega_t", "claim", "run", *_NUMBERS, "verdict")
_DIGITS = 6
_KIND = "table that python -m research.reproduction readings export wrote"


def write_multiverse_tables(
    readings: Sequence[Reading], by_reading: FindingsByReading, folder: Path
) -> None:
    """Write both tables to a folder.

    Raises:
        TegotaeError: if they cannot be written.
    """
    names = [choice.name for choice in PRIOR]
    rows = [[i, *cells_of(reading)] for i, reading in enumerate(readings)]
    effects = [
        [
            *(reading, omega, finding.claim.name, count.run),
            *(f"{getattr(effect, name):.{_DIGITS}g}" for name in _NUMBERS),
            finding.outcome,
        ]
        for reading, by_omega in by_reading.items()
        for omega, findings in by_omega.items()
        for finding in findings
        for count, effect in finding.by_count.items()
    ]
    output_folder(folder)
    tables.write_csv(folder / READINGS, _columns(["reading", *names], rows))
    tables.write_csv(folder / EFFECTS, _columns(_HEAD, effects))


def read_tables(folder: Path) -> tuple[list[Reading], FindingsByReading]:
    """Read the readings, and the findings of every claim under each, from their tables.

    Raises:
        TegotaeError: if a table cannot be read, is none, or has a row twice.
    """
    readings = [_reading(row, folder) for row in _rows(folder / READINGS, "reading")]
    claims = {claim.name: claim for claim in CLAIMS}
    by_reading: dict[int, dict[str, list[Finding]]] = {}
    for row in _rows(folder / EFFECTS, "reading", "omega_t", "claim"):
        try:
            effect = EffectEstimate(*(tables.parse_number(row[name]) for name in _NUMBERS))
            count = Count(run=row["run"], omega_t=row["omega_t"])
            finding = Finding(claims[row["claim"]], {count: effect})
            by_omega = by_reading.setdefault(whole_number(row["reading"]), {})
            by_omega.setdefault(row["omega_t"], []).append(finding)
        except (KeyError, ValueError, TypeError):
            raise _no_table(folder / EFFECTS) from None
    if not by_reading or max(by_reading) >= len(readings):
        raise _no_table(folder / EFFECTS)
    return readings, by_reading


def _reading(row: dict[str, str], folder: Path) -> Reading:
    try:
        return reading_of(row)
    except (KeyError, ValueError):
        raise _no_table(folder / READINGS) from None


def _rows(path: Path, *names: str) -> list[dict[str, str]]:
    """Return the rows of a table, after a check that their naming columns differ."""
    cells = tables.read_csv(path, names, kind=_KIND)
    require_once(path, {name: cells[name] for name in names})
    return [dict(zip(cells, row, strict=True)) for row in zip(*cells.values(), strict=True)]


def _no_table(path: Path) -> TegotaeError:
    return TegotaeError(f"{path} is no {_KIND}")


def _columns(head: Sequence[str], rows: Sequence[Sequence[object]]) -> dict[str, list[str]]:
    return {name: [str(row[i]) for row in rows] for i, name in enumerate(head)}
