"""An entry's scores; code of its author's runs in a process of its own, which may end or not."""

from __future__ import annotations

import time
from concurrent.futures import TimeoutError as NotDoneError
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.workers import Workers, WorkersDied
from tegotae_robots.benchmark.entries import is_program, read_entry
from tegotae_robots.benchmark.subject import Subject

MOST_WALL_S = 7200.0
"""Longest time that code of an entry's author may take on a track, its compilation included [s]."""


def scored(place: Any, subject: Subject, track: str) -> tuple[np.ndarray, float]:
    """Return the scores of an entry, [conditions, starts], and the time of a core that they took
    [s].

    Args:
        place: of the entry (`read_entry`). An object runs here; code and networks that are named
            run in a process of their own.
        subject: what it drives.
        track: what it senses.

    Raises:
        TegotaeError: for an entry that cannot be read, fails, ends its process, or takes too long.
    """
    if not is_program(place):
        return _scored(place, subject, track)
    try:
        with Workers(1) as workers:
            return workers.give(_scored, place, subject, track).result(MOST_WALL_S)
    except NotDoneError:
        raise TegotaeError(f"the entry took more than {MOST_WALL_S:g} s") from None
    except WorkersDied:
        raise TegotaeError("the entry ended its process; an entry returns actions") from None


def _scored(place: Any, subject: Subject, track: str) -> tuple[np.ndarray, float]:
    begun_s = time.process_time()
    return subject.scores(read_entry(place, subject, track), track), time.process_time() - begun_s
