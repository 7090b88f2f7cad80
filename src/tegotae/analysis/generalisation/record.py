"""The record of one set of controllers: a file that is complete or absent."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tegotae._support.arrays import read_arrays, write_arrays
from tegotae._support.documents import Document, parse
from tegotae._support.engines import OF_EARLIER_FILES, require_engine, selected
from tegotae._support.errors import TegotaeError
from tegotae._support.part_code import code_of
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.trial import Retention, Tested
from tegotae.systems.descriptions import describe
from tegotae.systems.registry import CODE

FORMAT = 2
"""Changed whenever the same configuration would give other numbers."""
SUFFIX = ".trial.npz"
_MOST_BYTES = 2**28
_KINDS = {"ForcePulse": "Push", "ReleaseHeight": "Release"}
"""What records call a kind of disturbance, where that is not its class."""


def configuration(tested: Tested, disturbances: Sequence[Disturbance]) -> Document:
    """All that decides what is found, as JSON values; what cannot be applied decides nothing."""
    applied = [each for each in disturbances if not tested.lacks(each)]
    document = {
        "format": FORMAT,
        "name": tested.name,
        "weights": hashlib.sha256(np.asarray(tested.weights, "float32").tobytes()).hexdigest(),
        "runs": len(tested.weights),
        "disturbances": [_described(each) for each in applied],
        **tested.document,
    }
    return json.loads(json.dumps(document))


def _described(disturbance: Disturbance) -> Document:
    code = code_of(type(disturbance))
    noted = {} if code is None else {CODE: code}
    name = type(disturbance).__name__
    return {"kind": _KINDS.get(name, name), **noted, **describe(disturbance)}


def place(folder: Path, document: Document) -> Path:
    """Where the record of a configuration is or will be."""
    digest = hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()
    return folder / f"{Path(document['name']).name}-{digest[:12]}{SUFFIX}"


def write(path: Path, document: Document, outcome: Retention) -> None:
    """Write a record.

    Raises:
        TegotaeError: if it cannot be written.
    """
    header = json.dumps(
        {"configuration": document, "left_out": outcome.left_out, "engine": selected()}
    )
    write_arrays(path, {"header": np.array(header), **_narrow(outcome.columns)})


def read(path: Path, document: Document) -> Retention | None:
    """The record at a place; None if there is none, or none of this configuration that is whole.

    Raises:
        TegotaeError: if it cannot be opened, such as without permission, or is of another
            engine.
    """
    try:
        arrays = read_arrays(path, _MOST_BYTES)
        header = parse(str(arrays.pop("header")))
        if header["configuration"] != document:
            return None
        made_by = header.get("engine", OF_EARLIER_FILES)
        found = Retention(arrays, header["left_out"])
    except FileNotFoundError:
        return None
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
    remedy = "choose another folder with --out, or start again with --anew"
    require_engine(made_by, f"{path.parent.parent} holds records", remedy)
    return found


def _narrow(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {
        name: x.astype("float32") if name in ("efficiency", "speed") else x
        for name, x in columns.items()
    }
