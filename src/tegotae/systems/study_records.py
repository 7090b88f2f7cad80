"""Controllers in a study's folder: the weights of every seed, in the records of its units."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np

from tegotae._support import documents
from tegotae._support.arrays import checksum, read_arrays
from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError
from tegotae.systems.controller_file import SavedController
from tegotae.systems.experiment import Experiment

DESCRIPTION = "study.json"
"""What a study's folder has, and says what the study is."""
RECORDS = "records"
"""The folder in it that has the records."""
SUFFIX = ".record.npz"
"""How a record's name ends."""
MOST_BYTES = 2**28
"""What a record may unpack to [bytes]; those of the study have about a megabyte."""

NOT_OF_THE_TRAINING = frozenset({"format", "experiment", "seeds", "budgets", "metrics"})
"""Entries of a record's configuration that say nothing of how was trained."""


class DamagedRecordError(TegotaeError):
    """A record that cannot be read, or does not hold what it says."""


def header_and_arrays(path: Path) -> tuple[Document, dict[str, np.ndarray]]:
    """A record's configuration and software, and its arrays by name.

    Raises:
        DamagedRecordError: if it is no record, is cut short, or its checksum is wrong.
        TegotaeError: if it cannot be opened, such as without permission.
    """
    try:
        stream = path.open("rb")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    try:
        with stream:
            arrays = read_arrays(stream, MOST_BYTES)
        text, noted = str(arrays.pop("header")), str(arrays.pop("checksum"))
        if noted != checksum(text, arrays):
            raise ValueError("its checksum is wrong")
        header: Document = cast(Document, documents.parse(text))
        return header, arrays
    except Exception as error:  # a flipped bit in a zip archive may raise nearly anything
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise DamagedRecordError(f"{path.name} is damaged: {why}") from None


def is_study(folder: Path) -> bool:
    """Whether a folder is a study's."""
    return (folder / DESCRIPTION).exists()


def controllers_of_study(folder: Path) -> tuple[tuple[Path, SavedController], ...]:
    """The controllers of a study's whole records, seed by seed.

    Raises:
        TegotaeError: if it has no whole record, a description that is damaged, or a part that is
            not registered.
    """
    described = documents.read(folder / DESCRIPTION)
    experiments = described.get("experiments") if isinstance(described, dict) else None
    found: list[tuple[Path, SavedController]] = []
    damaged: list[str] = []
    for path in sorted((folder / RECORDS).glob(f"*{SUFFIX}")):
        try:
            header, arrays = header_and_arrays(path)
        except DamagedRecordError as error:
            damaged.append(str(error))
            continue
        configuration = header["configuration"]
        document = configuration["experiment"]
        if isinstance(experiments, dict) and document["name"] not in experiments:
            continue  # of another study that was here
        experiment = Experiment.of(document)
        training = {n: x for n, x in configuration.items() if n not in NOT_OF_THE_TRAINING}
        found += [
            (
                path,
                SavedController(
                    experiment.system,
                    np.asarray(weights, float),
                    experiment.name,
                    experiment,
                    training={**training, "seed": seed},
                    software=header["software"],
                ),
            )
            for seed, weights in zip(configuration["seeds"], arrays["weights"], strict=True)
        ]
    if not found:
        raise TegotaeError(f"{folder} has no record that is whole: {'; '.join(damaged) or 'none'}")
    return tuple(found)
