"""Scores of many readings, in a table that grows: stopped, the same call goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from research.reproduction.calibration.measure import CalibrationGrid, measure_reading
from research.reproduction.calibration.prior import PRIOR, candidates
from research.reproduction.calibration.scores import SCORES, VanillaScores
from research.reproduction.cells import whole_number
from research.reproduction.readings.readings import Reading
from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting

_KIND = "table of a calibration"
_NAMES = tuple(choice.name for choice in PRIOR)
_HEAD = ("body", *_NAMES, *SCORES)
_DIGITS = 4
_AT_ONCE = 5
"""Readings between two writings of the table."""
_MOST_BODIES = 10**6

Scorer = Callable[[Reading], VanillaScores]


def calibrate(
    path: Path,
    bodies: Sequence[int],
    grid: CalibrationGrid | None = None,
    scorer: Scorer | None = None,
) -> np.ndarray:
    """Calculate the scores of some readings of the prior, [readings, scores].

    Those that the table has are kept; others are measured and added.

    Args:
        path: the table (.csv).
        bodies: numbers of the readings in the prior, each once.
        grid: how finely each is looked at.
        scorer: how scores are found; `measure_reading` by default.

    Raises:
        TegotaeError: if the table holds something else, or cannot be written.
    """
    rows = read_scores(path) if path.exists() else {}
    readings = candidates(max(bodies) + 1)
    missing = sorted((body for body in bodies if body not in rows), key=lambda b: _key(readings[b]))
    scorer = scorer or (lambda reading: measure_reading(reading, grid))
    with reporting("calibration", len(bodies)) as reporter:
        try:
            for count, body in enumerate(missing, start=1):
                rows[body] = list(scorer(readings[body]))
                if count % _AT_ONCE == 0:
                    _write(path, rows)
                reporter.update(len(bodies) - len(missing) + count, f"body {body}")
        finally:  # what is done is kept
            if rows:
                _write(path, rows)
    return np.array([rows[body] for body in bodies], float)


def read_scores(path: Path) -> dict[int, list[float]]:
    """Return the scores that a table holds, by the number of the reading in the prior.

    Raises:
        TegotaeError: if it cannot be read or holds something else.
    """
    cells = tables.read_csv(path, _HEAD, kind=_KIND)
    try:
        bodies = [whole_number(cell) for cell in cells["body"]]
        rows = np.stack([tables.parse_numbers(cells[name]) for name in SCORES], axis=1)
    except ValueError:
        raise TegotaeError(f"{path} is no {_KIND}: a score or a body is no number") from None
    if min(bodies) < 0 or max(bodies) > _MOST_BODIES:
        raise TegotaeError(f"{path} is no {_KIND}: bodies go from 0 to {_MOST_BODIES}")
    readings = candidates(max(bodies) + 1)
    for name in _NAMES:
        if [_cell(getattr(readings[body], name)) for body in bodies] != cells[name].tolist():
            raise TegotaeError(f"{path} holds a calibration of other readings: its {name} differs")
    return dict(zip(bodies, rows.tolist(), strict=True))


def _key(reading: Reading) -> tuple[str, ...]:
    """Return a sort key that groups the readings of one compiled program."""
    return tuple(_cell(getattr(reading, name)) for name in ("sector_s", "sector_start", "work"))


def _write(path: Path, rows: dict[int, list[float]]) -> None:
    readings = candidates(max(rows) + 1)
    columns: dict[str, list] = {"body": sorted(rows)}
    for name in _NAMES:
        columns[name] = [_cell(getattr(readings[body], name)) for body in sorted(rows)]
    for i, name in enumerate(SCORES):
        columns[name] = [rows[body][i] for body in sorted(rows)]
    tables.write_csv(path, columns, digits=_DIGITS)


def _cell(value: object) -> str:
    """Return a value of a choice as a cell: numbers that a reader can copy."""
    if isinstance(value, tuple):
        return " ".join(f"{number:g}" for number in value)
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
