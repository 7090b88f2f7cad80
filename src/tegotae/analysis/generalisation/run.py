"""All controllers under all disturbances, in a folder that keeps finished ones."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from pathlib import Path

from tegotae._support.devices import available_cores
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder
from tegotae._support.progress import reporting
from tegotae._support.workers import Workers, WorkersDied
from tegotae._support.workplace import GENERALISATION, alone
from tegotae.analysis.generalisation.disturbance import Disturbance
from tegotae.analysis.generalisation.record import (
    configuration,
    place,
    read,
    write,
)
from tegotae.analysis.generalisation.trial import Retention, Tested, check_levels, tried
from tegotae.simulation.native import forget_programs
from tegotae.systems.registry import parts_in, register

Done = tuple[Tested, Retention]


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
    with alone(out, GENERALISATION, anew=anew):
        folder = output_folder(out / "records")
        documents = [configuration(each, disturbances) for each in controllers]
        places = [place(folder, document) for document in documents]
        found = [read(path, each) for path, each in zip(places, documents, strict=True)]
        missing = [i for i, outcome in enumerate(found) if outcome is None]
        try:
            with reporting("generalise", len(controllers)) as reporter:
                done = len(controllers) - len(missing)
                reporter.update(done, "done before" if done else "")
                bundled = _bundles([(i, controllers[i]) for i in missing])
                with closing(_worked(bundled, disturbances)) as outcomes:
                    for number, outcome in outcomes:
                        write(places[number], documents[number], outcome)
                        found[number] = outcome
                        done += 1
                        reporter.update(done, controllers[number].name)
        except KeyboardInterrupt:
            kept = sum(outcome is not None for outcome in found)
            raise KeyboardInterrupt(
                f"interrupted; {out} keeps {kept} of {len(controllers)} controllers; the same "
                "command continues from there"
            ) from None
    return [(each, x) for each, x in zip(controllers, found, strict=True) if x is not None]


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


Numbered = tuple[int, Tested]

_BUNDLES_KEPT = 10
"""After so many bundles compiled programs are forgotten: a hundred of them are GiB."""


def _bundles(controllers: Sequence[Numbered]) -> list[list[Numbered]]:
    """Sets in groups that share a compiled program."""
    groups: dict[str, list[Numbered]] = {}
    for number, tested in controllers:
        groups.setdefault(repr((tested.controller, type(tested.body))), []).append((number, tested))
    return list(groups.values())


def _worked(
    bundles: Sequence[list[Numbered]], disturbances: Sequence[Disturbance]
) -> Generator[tuple[int, Retention], None, None]:
    """The outcomes of bundles, as they come: on all cores if there are several of both."""
    cores = min(available_cores(), len(bundles))
    if cores <= 1:
        for done, bundle in enumerate(bundles, 1):
            for number, tested in bundle:
                yield number, tried(tested, disturbances)
            if done % _BUNDLES_KEPT == 0:
                forget_programs()
        return
    with Workers(cores, 1) as pool:
        pending = [pool.give(_bundle, bundle, disturbances) for bundle in bundles]
        for future in as_completed(pending):
            try:
                yield from future.result()
            except WorkersDied:
                raise TegotaeError(
                    "a worker died; is there enough memory? Finished work is kept, the same "
                    "command continues from there"
                ) from None


def _bundle(
    bundle: list[Numbered], disturbances: Sequence[Disturbance]
) -> list[tuple[int, Retention]]:
    """A bundle, by a worker: a process of its own."""
    for part in parts_in(tuple((each.controller, each.body) for _, each in bundle)):
        register(part)
    try:
        return [(number, tried(tested, disturbances)) for number, tested in bundle]
    finally:
        forget_programs()
