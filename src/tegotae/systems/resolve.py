"""Resolution of names: decided here, and nowhere else, for every command.

A name is one of

- a recipe (`tegotae.systems.recipe`), on the paper's hopper or on legs: `ART-rF-tphif-w8`, `ART`,
  `ART+hopf`, `latch-w4`, `AR@quadruped-c`;
- a legged system: `quadruped-c`, or a walker's own file (.toml), such as a template of a robot;
- a law on a robot's file: `zoo:AR-rF+range@go1.toml`;
- a preset of a hopper with a vanilla controller, whose actuation and oscillator may be others:
  `paper`, `paper-reflex`, `pyTegotaeCPG-both+matsuoka`, `paper+FILE.py:OBJECT`;
- a trained controller of the zoo, or all runs of one: `zoo:ART-rF-tphif-w8/3`;
- a walker of a kept front: `front:quadruped-c/0.4`;
- a controller file (.json), a folder of them, or a study's folder;
- a file (.json) of documents of experiments, such as a study's;
- `FILE.py:OBJECT` or `MODULE:OBJECT`: an Experiment or a list of them, a SavedController or a
  Legged.

A folder that is called as a recipe is, and holds controllers, has their weights.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
import reprlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeGuard, cast

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.files import require_short
from tegotae.parts.oscillators import PHASE
from tegotae.systems import controller_file, zoo
from tegotae.systems.controller_file import (
    SavedController,
    controller_files,
    controllers_of_study,
    is_study,
)
from tegotae.systems.env_documents import is_robot_file, robot_document
from tegotae.systems.experiment import Experiment
from tegotae.systems.legged import Legged, settling
from tegotae.systems.parts_by_name import oscillator_called
from tegotae.systems.recipe import architectures, find_recipe, study_recipes
from tegotae.systems.registry import is_reference, load_object
from tegotae.systems.term_sets import BUDGET, LAWS
from tegotae.systems.tuned import front_walker, is_front_name
from tegotae.systems.vanilla import PRESETS, SYSTEMS, is_walker_file, legged_named, preset
from tegotae.systems.zoo import is_zoo_name


class Resolved(ABC):
    """Meaning of a name: `Trained` or `Untrained`.

    Args:
        name: as it was given.
    """

    name: str

    @abstractmethod
    def weighted(self) -> tuple[tuple[Path, SavedController], ...]:
        """Return the controllers with their weights and sources.

        Raises:
            TegotaeError: if there are none, with what has some.
        """

    @abstractmethod
    def experiment(self) -> Experiment:
        """Return the one experiment.

        Raises:
            TegotaeError: if it says nothing of what is to be trained, or of several.
        """

    def controller(self) -> SavedController:
        """Return the one controller.

        Raises:
            TegotaeError: if there is none, or there are several.
        """
        (path, saved), *further = self.weighted()
        if further:
            such = "a file of one" if path.suffix == ".npz" else f"one of them, such as {path}"
            raise TegotaeError(f"{self.name} holds {1 + len(further)} controllers; name {such}")
        return saved

    def legs(self) -> Legged:
        """Return the one legged system with its weights and a duration in which it settles from any
        release.

        Raises:
            TegotaeError: if it has one leg, no weights, or several.
        """
        saved = self.controller()
        return settling(saved.system, saved.weights, saved.name or Path(self.name).stem)


@dataclass(frozen=True)
class Trained(Resolved):
    """Systems with weights.

    Args:
        name: as it was given.
        controllers: systems with their weights, and where each is from.
        legged: of a legged system by name, or of a user's own, whose legs it names.
    """

    name: str
    controllers: tuple[tuple[Path, SavedController], ...]
    legged: Legged | None = None

    def weighted(self) -> tuple[tuple[Path, SavedController], ...]:
        """Return the controllers."""
        return self.controllers

    def experiment(self) -> Experiment:
        """Return the experiment that all of them were trained in."""
        trained = [saved.experiment for _, saved in self.controllers]
        first = trained[0]
        if first is not None and all(experiment == first for experiment in trained):
            return first
        if self.legged is None:
            raise TegotaeError(
                f"{self.name} is no experiment: it is a controller, which does not say what is to "
                "be trained; name a model such as ART, or an Experiment, FILE.py:OBJECT"
            )
        raise TegotaeError(
            f"{self.name} is no experiment: it is a legged system, which has nothing to learn; "
            f"name terms upon it, such as AR@{self.name}"
        )

    def legs(self) -> Legged:
        """Return the legged system of its name, or that of its controller."""
        return super().legs() if self.legged is None else self.legged


@dataclass(frozen=True)
class Untrained(Resolved):
    """Experiments without weights, which can be trained.

    Args:
        name: as it was given.
        experiments: the experiments.
    """

    name: str
    experiments: tuple[Experiment, ...]

    def weighted(self) -> tuple[tuple[Path, SavedController], ...]:
        """Raise `TegotaeError`, and name what has weights."""
        name = self.experiments[0].name
        files = is_reference(self.name) or is_walker_file(self.name)
        trained = self.name if files else name
        ready = f"{zoo.PREFIX}{name}"
        remedy = f"take {ready}, or train it" if ready in zoo.zoo_names() else "first"
        raise TegotaeError(
            f"{name} has weights to train and no file was given; "
            f"{remedy}: tegotae train {trained} --out FOLDER"
        )

    def experiment(self) -> Experiment:
        """Return the one experiment."""
        first, *further = self.experiments
        if further:
            raise TegotaeError(f"{self.name} holds {1 + len(further)} experiments; name one")
        return first


def resolve(name: str | Path | Named) -> Trained | Untrained:
    """Resolve a name.

    Args:
        name: see this module; or an object such as it can mean.

    Raises:
        TegotaeError: for a name that means nothing, with the nearest ones; a file that is damaged
            or not ours; a folder without controllers; or another object.

    Example:
        >>> resolve("ART").experiment().name, resolve("quadruped-c").legs().names
        ('ART-rF-tphif-w8', ('LF', 'RF', 'LH', 'RH'))
        >>> resolve("paper").controller().omega
        5.0
    """
    if not isinstance(name, (str, Path)):
        if not isinstance(cast(object, name), _KINDS):
            raise TegotaeError(
                f"name is {reprlib.repr(name)}; it must be a text or an object with weights"
            )
        return _from_object(getattr(name, "name", None) or "mine", name)
    name = str(name)
    if (on_robot := law_on_robot(name)) is not None:
        return _from_robot(name, *on_robot)
    if (specification := find_recipe(name)) is not None:
        if Path(name).is_dir() and (controllers := _controllers_in(Path(name))):
            return Trained(name, controllers)
        return Untrained(name, (specification.experiment(),))
    if is_zoo_name(name):
        return _from_zoo(name)
    if is_front_name(name):
        return _from_object(name, front_walker(name))
    if name in SYSTEMS or is_walker_file(name):
        return _from_object(name, legged_named(name))
    path = Path(name)
    if is_vanilla(name) and not path.exists():
        return _from_object(name, vanilla(name))
    if is_reference(name):
        return _from_object(name, load_object(name, _KINDS, "controller or experiment"))
    require_short(path)
    if path.is_dir():
        return _from_folder(name, path)
    if path.exists() or path.suffix or os.sep in name:
        return _from_file(name, path)
    names = [*architectures(), *study_recipes(), *LAWS, *SYSTEMS, *PRESETS]
    raise unknown("model or system", name, names)


_WALKER = "quadruped-c"
"""Walker whose laws fit on legs without more words."""


def law_on_robot(name: str) -> tuple[str, str] | None:
    """Return the law and the robot's file of a name `LAW@FILE.toml`; None for another name.

    Raises:
        TegotaeError: for a robot's file without a law, or one that is missing or damaged.

    Example:
        >>> law_on_robot("AR@quadruped-c") is None
        True
    """
    law, _, file = name.rpartition("@")
    if not is_robot_file(file):
        if law and file.endswith(".toml") and not (os.path.exists(file) or os.path.exists(name)):
            raise TegotaeError(f"there is no file {file}")
        return None
    on_legs = robot_document(file).on_legs
    if not law:
        such_as = "AR" if on_legs else "ART"
        raise TegotaeError(
            f"{file} is a robot, without a law; name one on it, such as {such_as}@{file}"
        )
    if not on_legs and f"{law}@{_WALKER}" in zoo.zoo_names():
        raise TegotaeError(
            f"{law} commands feet, and the wiring of {file} drives joints; give every leg three "
            "driven joints and the trunk a free one, or write the file with --settings legs=true"
        )
    has_body = "@" in law or law in SYSTEMS or is_front_name(law) or os.path.exists(law)
    if on_legs and not has_body and (is_zoo_name(law) or not is_reference(law)):
        law = f"{law}@{_WALKER}"
    return law, file


def experiment_of(name: str | Path | Named, budget: int | None = None) -> Experiment:
    """Return the experiment of a name; of a recipe also where a folder of this name has weights.

    Args:
        name: as of `resolve`.
        budget: largest number of trained parameters, of a recipe; the paper's by default.

    Raises:
        TegotaeError: for a name that says nothing of what is to be trained, or a budget for what
            has a controller of its own.
    """
    if isinstance(name, (str, Path)) and law_on_robot(str(name)) is None:
        if (specification := find_recipe(str(name))) is not None:
            return specification.experiment(budget=BUDGET if budget is None else budget)
        if budget is not None:
            raise TegotaeError(
                f"--budget sizes the networks of the paper's models; {name} has a controller of "
                "its own"
            )
    return resolve(name).experiment()


def legged_system(name: str) -> Legged:
    """Return the legged system of a name, with weights: one by name, a user's own, or a controller
    file.

    Raises:
        TegotaeError: for a name that means nothing, a body of one leg, or what has no weights.

    Example:
        >>> legged_system("bar-light").body.inertia_ratio, legged_system("quadruped-c").names
        (0.6, ('LF', 'RF', 'LH', 'RH'))
    """
    return resolve(name).legs()


def is_vanilla(name: str) -> bool:
    """Return whether a name is a preset's, perhaps with another actuation or oscillator.

    Example:
        >>> is_vanilla("paper-reflex+hopf"), is_vanilla("quadruped-c")
        (True, False)
    """
    return name.partition("+")[0].partition("-")[0] in PRESETS


def vanilla(name: str) -> SavedController:
    """Return a vanilla controller on its preset's hopper, with the preset's release.

    Args:
        name: `PRESET[-ACTUATION][+OSCILLATOR]`, such as `paper-reflex+hopf`; the oscillator may be
            a user's own, `FILE.py:OBJECT`.

    Raises:
        TegotaeError: for an unknown preset, actuation or oscillator.

    Example:
        >>> type(vanilla("paper-reflex").controller.actuation).__name__
        'Reflex'
    """
    base, _, of_oscillator = name.partition("+")
    preset_name, _, actuation = base.partition("-")
    source, oscillator = preset(preset_name), oscillator_called(of_oscillator or PHASE)
    # A trained oscillator's weights are zero where it is the one that it starts from.
    weights = np.array([source.sigma, *[0.0] * oscillator.n_weights])
    return SavedController(source.system(actuation or source.actuation, oscillator), weights, name)


Named = SavedController | Experiment | Legged | Sequence[Experiment]
"""Objects that a name in a user's own file can refer to."""
_KINDS = (SavedController, Experiment, Legged, list, tuple)


def _from_object(name: str, value: object) -> Trained | Untrained:
    if isinstance(value, Legged):
        saved = SavedController(value.system, np.array(value.weights), name)
        return Trained(name, ((Path(name), saved),), value)
    if isinstance(value, SavedController):
        value = dataclasses.replace(value, name=value.name or name.rpartition(":")[2])
        return Trained(name, ((Path(name), value),))
    experiments: list[Experiment] = []
    for item in [value] if isinstance(value, Experiment) else cast(Iterable[object], value):
        if not isinstance(item, Experiment):
            raise TegotaeError(f"{name} holds a {type(item).__name__}, which is no experiment")
        experiments.append(item)
    if not experiments:
        raise TegotaeError(f"{name} holds no experiments")
    return Untrained(name, tuple(experiments))


def _from_robot(name: str, law: str, robot: str) -> Trained | Untrained:
    """Return a controller from elsewhere on a robot; a package above this one reads its file."""
    saved = dataclasses.replace(resolve(law), name=name).controller()
    transfer = importlib.import_module("tegotae.training.environments.transfer")
    return _from_object(name, transfer.on_robot(saved, robot))


def _from_zoo(name: str) -> Trained:
    controllers = [
        (Path(place), controller_file.restored(document, place))
        for place, document in zoo.documents(name)
    ]
    return Trained(name, tuple(controllers))


def _from_folder(name: str, folder: Path) -> Trained | Untrained:
    if is_study(folder):
        return Trained(name, controllers_of_study(folder))
    if controllers := _controllers_in(folder):
        return Trained(name, controllers)
    if is_vanilla(name):
        return _from_object(name, vanilla(name))
    raise TegotaeError(f"{folder} holds no controller files")


def _controllers_in(folder: Path) -> tuple[tuple[Path, SavedController], ...]:
    return tuple((file, controller_file.load(file)) for file in controller_files(folder))


def _from_file(name: str, path: Path) -> Trained | Untrained:
    try:
        experiments = _experiments_in(path)
    except DamagedDocumentError as error:
        ours = controller_file.begins_as_ours(path)
        complaint = "is damaged" if ours else f"{controller_file.NOT_OURS}, nor of experiments"
        raise TegotaeError(f"{path} {complaint}: {error}") from None
    if experiments is not None:
        return Untrained(name, experiments)
    return Trained(name, ((path, controller_file.load(path)),))


def _experiments_in(path: Path) -> tuple[Experiment, ...] | None:
    """Return the experiments of a document, a list of them, or a study, or None if it is none of
    these.
    """
    if not path.is_file():
        return None  # as loading it says
    document = documents.read(path)
    study = document.get("experiments") if isinstance(document, dict) else None
    if isinstance(study, dict):
        document = list(study.values())
    listed = document if isinstance(document, list) else [document]
    if not listed or not all(map(_is_experiment, listed)):
        return None
    try:
        return tuple(Experiment.from_document(cast(JsonObject, entry)) for entry in listed)
    except TegotaeError as error:
        raise TegotaeError(f"{path}: {error}") from None


def _is_experiment(document: Json) -> TypeGuard[JsonObject]:
    if not isinstance(document, Mapping) or "format" in document:
        return False
    return "name" in document and "system" in document
