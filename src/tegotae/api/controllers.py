"""Loading controllers by name: on a body with one leg, with several, or in another simulator."""

from __future__ import annotations

import contextlib
import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from tegotae._support.errors import MissingExtraError, TegotaeError, require_all
from tegotae.api.controller import LoadedController, Subject
from tegotae.parts.bodies import Body, Interface
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.env_documents import extras_of
from tegotae.systems.legged import Legged, settling
from tegotae.systems.parts_by_name import body_called
from tegotae.systems.resolve import Trained, resolve
from tegotae.training.collection import named_sets, sets_of

if TYPE_CHECKING:
    from tegotae.api.environment import EnvironmentController
    from tegotae.api.hopping import HopperController
    from tegotae.api.walking import WalkerController

C = TypeVar("C", bound=LoadedController)
NAMES = (
    "A name is a controller file, a folder of them, a trained controller such as zoo:ART, a "
    "vanilla one such as V-sector-w4, paper-reflex or pyTegotaeCPG+hopf, a legged system such as "
    "quadruped-c or FILE.toml, or FILE.py:OBJECT."
)
"""Meaning of a name, for help."""
HopperName = Literal[
    "V",
    "V-both-w4",
    "V-both-w8",
    "V-reflex-w4",
    "V-reflex-w8",
    "V-sector-w4",
    "V-sector-w8",
    "paper",
    "paper-both",
    "paper-reflex",
    "paper-sector",
    "pyTegotaeCPG",
    "pyTegotaeCPG-both",
    "pyTegotaeCPG-reflex",
    "pyTegotaeCPG-sector",
    "zoo:A",
    "zoo:AG",
    "zoo:AGT",
    "zoo:AR",
    "zoo:ARG",
    "zoo:ARGT",
    "zoo:ART",
    "zoo:AT",
    "zoo:R",
    "zoo:RG",
    "zoo:RGT",
    "zoo:RT",
    "zoo:T",
    "zoo:V",
    "zoo:VG",
    "zoo:VGT",
    "zoo:VT",
]
"""Hoppers that a type checker knows by name."""
WalkerName = Literal[
    "bar-heavy",
    "bar-light",
    "biped",
    "hexapod",
    "plate-heavy",
    "plate-light-both",
    "plate-light-pitch",
    "plate-light-roll",
    "plate-light-twist",
    "quadruped-a",
    "quadruped-c",
    "quadruped-g",
]
"""Legged systems that a type checker knows by name."""


@overload
def load(name: HopperName, *, body: str | Body | None = None) -> HopperController: ...
@overload
def load(name: WalkerName, *, body: str | Body | None = None) -> WalkerController: ...
@overload
def load(name: Subject, kind: type[C], *, body: str | Body | None = None) -> C: ...
@overload
def load(name: Subject | LoadedController, *, body: str | Body | None = None) -> Any: ...
def load(name: Any, kind: Any = LoadedController, *, body: str | Body | None = None) -> Any:
    """Load the controllers of a name; their methods simulate, evaluate, compare and explain them.

    Args:
        name: a trained controller (zoo:ART), a vanilla one (V-sector-w4, paper-reflex), a legged
            system (quadruped-c, FILE.toml), a controller file, a folder of one training,
            FILE.py:OBJECT, or an object with weights.
        kind: class that they must have, such as `HopperController`. A type checker takes it as the
            class of names that it does not know, such as files and runs.
        body: another body: an object, FILE.toml, FILE.py:OBJECT or MODULE:OBJECT.

    Raises:
        TegotaeError: for a name that means nothing or has no weights, a folder of several
            trainings, or another class.

    Example:
        >>> load("paper").name, load("quadruped-c").description
        ('paper', 'walks on several legs')
    """
    first, *further = load_all(name, body=body)
    if further:
        raise TegotaeError(
            f"{name} holds {1 + len(further)} sets of controllers, such as {first.name}; "
            "load_all loads them all"
        )
    return first.require(kind, f"a {kind.__name__} is expected")


def load_all(
    *names: Subject | LoadedController, body: str | Body | None = None
) -> list[HopperController | WalkerController | EnvironmentController]:
    """Load the controllers of several names, or of a folder of several trainings.

    Args:
        names: as of `load`, or controllers that are loaded already.
        body: another body for all of them.

    Raises:
        TegotaeError: for a name that means nothing or has no weights, or runs that two names hold.

    Example:
        >>> [controller.name for controller in load_all("paper", "quadruped-c")]
        ['paper', 'quadruped-c']
    """
    loaded: Any = [name for name in names if isinstance(name, LoadedController)]
    if len(loaded) < len(names) or not names:
        loaded = _loaded(names)
    if body is None:
        return loaded
    new = body_called(body) if isinstance(body, str) else body
    return [controller.on(new) for controller in loaded]


def _loaded(names: Sequence[Any]) -> list[LoadedController]:
    sets: list[tuple[str, ControllerSet]] = []
    legs: dict[str, Legged | None] = {}
    for name in names:
        if isinstance(name, LoadedController | ControllerSet):
            runs = name.runs if isinstance(name, LoadedController) else name
            place = getattr(name, "source", "") or name.name
            sets.append((place, runs))
            legs[place] = getattr(name, "legged", None)
            continue
        subject = resolve(name)
        controllers = subject.controllers if isinstance(subject, Trained) else ()
        for environment in [saved.task.env for _, saved in controllers if saved.task]:
            require_all(extras_of(environment))
        sets += [(subject.name, runs) for runs in sets_of(subject)]
        legs[subject.name] = subject.legged if isinstance(subject, Trained) else None
    return [
        _controller(runs, legs[place], place)
        for place, runs in _with_distinct_names(named_sets(sets))
    ]


def _with_distinct_names(
    sets: Sequence[tuple[str, ControllerSet]],
) -> list[tuple[str, ControllerSet]]:
    """Return the sets under distinct names: those of one name with their places or numbers."""
    names = [runs.name for _, runs in sets]
    for by_place in (True, False):
        counts, occurrences = Counter(names), Counter[str]()
        for i, name in enumerate(names):
            occurrences[name] += 1
            if counts[name] > 1:
                names[i] = f"{name} ({sets[i][0] if by_place else f'no. {occurrences[name]}'})"
    return [
        (place, dataclasses.replace(runs, name=name))
        for name, (place, runs) in zip(names, sets, strict=True)
    ]


def _controller(runs: ControllerSet, legged: Legged | None, source: str) -> LoadedController:
    """Return the controllers as one of the three classes.

    Args:
        runs: the controllers.
        legged: legged system by name, whose legs it names.
        source: name that they were loaded by.

    Raises:
        TegotaeError: for limbs of another simulator of which no environment is known.
    """
    if runs.task is not None:
        from tegotae.api.environment import EnvironmentController

        return EnvironmentController(runs, source=source)
    if isinstance(runs.system.body, Interface):
        raise TegotaeError(
            f"{runs.name} drives the limbs of another simulator, whose mechanics are not here; "
            "tegotae train --env says where"
        )
    if runs.body.limbs > 1:
        from tegotae.api.walking import WalkerController

        legged = legged or settling(runs.system, runs.weights[0], runs.name)
        return WalkerController(runs, legged, source=source)
    from tegotae.api.hopping import HopperController

    return HopperController(runs, source=source)


def kinds() -> Mapping[str, tuple[type[LoadedController], str]]:
    """Return the classes of controllers that can be imported, each with an example's name."""
    from tegotae.api.hopping import HopperController
    from tegotae.api.walking import WalkerController

    classes: dict[str, tuple[type[LoadedController], str]] = {
        "One leg, such as paper": (HopperController, "paper"),
        "Several legs, such as quadruped-c": (WalkerController, "quadruped-c"),
    }
    with contextlib.suppress(MissingExtraError):
        from tegotae.api.environment import EnvironmentController

        classes["Trained in another simulator"] = (EnvironmentController, "")
    return classes
