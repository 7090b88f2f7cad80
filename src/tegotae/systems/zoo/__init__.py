"""Trained controllers that come with the package, by name: no training before the first picture."""

from tegotae.systems.zoo.file import MOST_BYTES, SELECTION, SUFFIX, Zoo, ZooEntry, open_zoo, write
from tegotae.systems.zoo.names import (
    ALL,
    PREFIX,
    ZooName,
    documents,
    is_zoo_name,
    names,
    stem,
    studies,
    study_of,
)

__all__ = [
    "ALL",
    "MOST_BYTES",
    "PREFIX",
    "SELECTION",
    "SUFFIX",
    "Zoo",
    "ZooEntry",
    "ZooName",
    "documents",
    "is_zoo_name",
    "names",
    "open_zoo",
    "stem",
    "studies",
    "study_of",
    "write",
]
