"""Trained controllers that come with the package, by name: no training before the first picture."""

from tegotae.systems.zoo.file import (
    ALL,
    MOST_BYTES,
    PREFIX,
    SELECTION,
    SUFFIX,
    Zoo,
    ZooEntry,
    ZooName,
    documents,
    is_zoo_name,
    names,
    open_zoo,
    stem,
    studies,
    study_of,
    write,
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
