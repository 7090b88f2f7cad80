"""Scores of many readings, in a table that grows: stopped, the same call goes on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.studies.paper.calibration.measure import CalibrationGrid, measure
from tegotae.studies.paper.calibration.prior import PRIOR, candidates
from tegotae.studies.paper.calibration.scores import SCORES, VanillaScores
from tegotae.studies.paper.multiverse.readings import Reading

_KIND = "table of a calibration"
_NAMES = tuple(choice.name for choice in PRIOR)
_HEAD = ("body", *_NAMES, *SCORES)

Scorer = Callable[[Reading], VanillaScores]


def calibrate(
    path: Path, count: int, grid: CalibrationGrid | None = None, scorer: Scorer | None = None
) -> np.ndarray:
    """The scores of the first readings of the prior, [readings, scores].

    Those that the table has are kept, others are measured and added one by one.

    Args:
        path: the table (.csv).
        count: how many readings.
        grid: how finely each is looked at.
        scorer: how scores are found; `measure` by default.

    Raises:
        TegotaeError: if the table holds something else, or cannot be written.
    """
    readings = candidates(count)
    rows = _read(path, readings) if path.exists() else []
    scorer = scorer or (lambda reading: measure(reading, grid))
    with reporting("calibration", count) as reporter:
        for number, reading in enumerate(readings[len(rows) :], start=len(rows)):
            rows.append(list(scorer(reading)))
            _write(path, readings, rows)
            reporter.update(number + 1, f"body {number}")
    return np.array(rows[:count], float)


def read_scores(path: Path) -> np.ndarray:
    """The scores that a table holds, [readings, scores].

    Raises:
        TegotaeError: if it cannot be read or holds something else.
    """
    cells = tables.read_csv(path, _HEAD, kind=_KIND)
    return np.array(_read(path, candidates(len(cells["body"]))), float)


def _read(path: Path, readings: list[Reading]) -> list[list[float]]:
    cells = tables.read_csv(path, _HEAD, kind=_KIND)
    try:
        rows = np.stack([tables.numbers(cells[name]) for name in SCORES], axis=1)
    except ValueError:
        raise TegotaeError(f"{path} is no {_KIND}: a score is no number") from None
    known = min(len(rows), len(readings))
    wanted = _columns(readings[:known], rows[:known].tolist())
    for name in _NAMES:
        if [str(x) for x in wanted[name]] != cells[name].tolist()[:known]:
            raise TegotaeError(f"{path} holds a calibration of other readings: its {name} differs")
    return rows.tolist()


def _write(path: Path, readings: list[Reading], rows: list[list[float]]) -> None:
    tables.write_csv(path, _columns(readings[: len(rows)], rows))


def _columns(readings: list[Reading], rows: list[list[float]]) -> dict[str, list]:
    columns: dict[str, list] = {"body": list(range(len(rows)))}
    for name in _NAMES:
        columns[name] = [_written(getattr(reading, name)) for reading in readings]
    for i, name in enumerate(SCORES):
        columns[name] = [row[i] for row in rows]
    return columns


def _written(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
