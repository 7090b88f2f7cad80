"""Readings of a whole study, by name or from a file: values of options of its command."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

from tegotae._support import documents
from tegotae._support.errors import TegotaeError, unknown
from tegotae.cli.options import ExperimentOptions

STUDY, CALIBRATED = "study", "calibrated"
NAMES = (STUDY, CALIBRATED)
"""The study's own reading, and the one that docs/reproduction/calibration.md chooses."""


def reading_named(name: str) -> ExperimentOptions:
    """The options that a reading stands for.

    Args:
        name: of `NAMES`, or of a JSON file with an entry per option.

    Raises:
        TegotaeError: for an unknown name, or a file that is not one of options.

    Example:
        >>> reading_named("calibrated").mass
        0.06861
    """
    if name == STUDY:
        return ExperimentOptions()
    if name not in NAMES and not name.endswith(".json"):
        raise unknown("reading", name, (*NAMES, "FILE.json"))
    file = Path(__file__).with_name("calibrated.json") if name == CALIBRATED else Path(name)
    try:
        values = documents.fitted(documents.read(file), dict)
        options = [field.name for field in fields(ExperimentOptions)]
        for option in values:
            if option not in options:
                raise unknown("option", option, options)
        return documents.fitted(values, ExperimentOptions)
    except FileNotFoundError:
        raise TegotaeError(f"cannot read the reading {name}: there is no such file") from None
    except TegotaeError as error:
        raise TegotaeError(f"cannot read the reading {name}: {error}") from None
