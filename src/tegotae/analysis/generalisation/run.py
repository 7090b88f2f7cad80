"""All controllers under all disturbances, in a folder that keeps finished ones."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tegotae._support.devices import available_cores
from tegotae._support.documents import CODE, Document
from tegotae._support.errors import TegotaeError
from tegotae._support.part_code import code_of
from tegotae._support.workplace import GENERALISATION, alone
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.trial import Retention, Tested, check_levels, tried
from tegotae.study import CellResult, Study, bundles, here, on_cores
from tegotae.systems.descriptions import describe
from tegotae.systems.registry import parts_in, register

Done = tuple[Tested, Retention]

FORMAT = 3
"""Changed whenever the same configuration would give other numbers."""


@dataclass(frozen=True)
class Trial:
    """A set of controllers under some disturbances: a cell of a study.

    Args:
        tested: the controllers.
        disturbances: under what; those that do not apply decide nothing.
    """

    tested: Tested
    disturbances: tuple[Disturbance, ...]

    @property
    def name(self) -> str:
        """The set's."""
        return self.tested.name

    @property
    def document(self) -> Document:
        """All that decides what is measured, as JSON values."""
        document = {
            "format": FORMAT,
            "name": self.name,
            "weights": hashlib.sha256(
                np.asarray(self.tested.weights, "float32").tobytes()
            ).hexdigest(),
            "runs": len(self.tested.weights),
            "disturbances": [
                _described(each) for each in self.disturbances if not self.tested.lacks(each)
            ],
            **self.tested.document,
        }
        return json.loads(json.dumps(document))

    @property
    def program(self) -> str:
        """Sets of one structure share a compiled program."""
        return repr((self.tested.controller, type(self.tested.body)))

    def prepare(self) -> None:
        """Register a user's parts."""
        for part in parts_in((self.tested.controller, self.tested.body)):
            register(part)

    def measure(self) -> CellResult:
        """What the controllers retain."""
        outcome = tried(self.tested, self.disturbances)
        arrays = {
            name: values.astype("float32") if name in ("efficiency", "speed") else values
            for name, values in outcome.columns.items()
        }
        left_out = {"left_out": np.array(json.dumps(outcome.left_out))}
        return CellResult(self.document, {}, arrays | left_out)


def generalise(
    controllers: Sequence[Tested],
    disturbances: Sequence[Disturbance],
    out: Path,
    *,
    anew: bool = False,
) -> list[Done]:
    """Test all controllers under all disturbances, or continue, in the folder `out`.

    Each set has a record; stopped and called again it continues from there, and ends in the
    same numbers. Sets of the same structure share a compiled program.

    Args:
        controllers: those to be tested.
        disturbances: under what.
        out: the folder.
        anew: whether what is there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: for no controllers, two sets of the same name, none that can meet any of the
            disturbances, a level that makes no body, or a folder that cannot be written to.
        KeyboardInterrupt: after Ctrl-C; it says what is kept.
    """
    _check(controllers, disturbances)
    trials = [Trial(tested, tuple(disturbances)) for tested in controllers]
    remedy = "choose another folder with --out, or start again with --anew"
    with alone(out, GENERALISATION, anew=anew):
        study = Study(out / "records", trials, "generalise", "controllers", ".trial.npz", remedy)
        cores = min(available_cores(), len(bundles(trials)))
        study.run(here if cores <= 1 else on_cores)
        return [
            (trial.tested, _retention(result))
            for trial, result in zip(trials, study.results(), strict=True)
        ]


def _retention(result: CellResult) -> Retention:
    columns = dict(result.arrays)
    return Retention(columns, json.loads(str(columns.pop("left_out"))))


def _described(disturbance: Disturbance) -> Document:
    code = code_of(type(disturbance))
    noted = {} if code is None else {CODE: code}
    return {"kind": type(disturbance).__name__, **noted, **describe(disturbance)}


def _check(controllers: Sequence[Tested], disturbances: Sequence[Disturbance]) -> None:
    if not controllers:
        raise TegotaeError("there are no controllers to test")
    names = [each.name for each in controllers]
    for name in names:
        if names.count(name) > 1:
            raise TegotaeError(
                f"{names.count(name)} sets of controllers are called {name}; try them one by one"
            )
    able = 0
    for tested in controllers:
        meets = [each for each in disturbances if not tested.lacks(each)]
        if meets:
            able += 1
            check_levels(tested, meets)
    if not able:
        first = controllers[0]
        why = "; ".join(f"{each.name}: {first.lacks(each)}" for each in disturbances)
        raise TegotaeError(f"{first.name} can meet none of these conditions: {why}")
