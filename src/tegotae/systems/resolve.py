"""Resolution of names: decided here, and nowhere else, for every command.

A name is one of

- a model of the paper, an architecture, or either with an oscillator: `ART-rF-tphif-w8`, `ART`,
  `ART+hopf`;
- a design for a body with legs: `AR@quadruped-c`;
- a legged system: `quadruped-c`, or a walker's own file (.toml), such as a template of a robot;
- a law on a robot's file: `zoo:AR-rF+range@go1.toml`;
- a preset of a hopper with a vanilla controller, whose actuation and oscillator may be others:
  `paper`, `paper-reflex`, `pyTegotaeCPG-both+matsuoka`, `paper+FILE.py:OBJECT`;
- a trained controller of the zoo, or all runs of one: `zoo:ART-rF-tphif-w8/3`;
- a walker of a kept front: `front:quadruped-c/0.4`;
- a controller file (.json), a folder of them, or a study's folder;
- a file (.json) of documents of experiments, such as a study's;
- `FILE.py:OBJECT` or `MODULE:OBJECT`: a System, an Experiment or a list of them, a SavedController
  or a Legged.

A folder that is called as a model or a design is, and holds controllers, has their weights.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeGuard, cast

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.files import require_short
from tegotae._support.workplace import is_earlier
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.oscillators import PHASE, Oscillator, oscillator_named
from tegotae.systems import controller_file, zoo
from tegotae.systems.controller_file import SavedController
from tegotae.systems.designs import Design, design, is_design
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.laws import LAWS, ShortLaw, short_law
from tegotae.systems.legged import (
    SYSTEMS,
    Legged,
    is_walker_file,
    require_legs,
    settling,
    system as legged_by_name,
)
from tegotae.systems.models import PRESETS, Model, all_models, at_another_omega, find, preset
from tegotae.systems.robot_file import law_on_robot
from tegotae.systems.study_records import controllers_of_study, is_study
from tegotae.systems.system import Release, System
from tegotae.systems.tuned import front_walker, is_front_name
from tegotae.systems.user_objects import is_reference, load_object
from tegotae.systems.zoo import is_zoo_name


@dataclass(frozen=True, kw_only=True)
class Resolved:
    """Resolved name: systems with weights, or experiments without.

    Args:
        name: as it was given.
        controllers: systems with their weights, and where each is from.
        experiments: what can be trained by this name.
        legged: of a legged system by name, or of a user's own, whose legs it names.
        system: of a user's System alone, which has no weights.
    """

    name: str
    controllers: tuple[tuple[Path, SavedController], ...] = ()
    experiments: tuple[Experiment, ...] = ()
    legged: Legged | None = None
    system: System | None = None

    @property
    def is_untrained(self) -> bool:
        """True if it is to be trained, and has no weights."""
        return bool(self.experiments) and not self.controllers

    @property
    def body(self) -> Body | Interface:
        """The body, or the interface of limbs elsewhere; of several systems that of the first."""
        systems = [self.system, *(saved.system for _, saved in self.controllers)]
        systems += [experiment.system for experiment in self.experiments]
        return next(system.body for system in systems if system is not None)

    def weighted(self) -> tuple[tuple[Path, SavedController], ...]:
        """The controllers with their weights.

        Raises:
            TegotaeError: if there are none, with what has some.
        """
        if self.controllers:
            return self.controllers
        for experiment in self.experiments[:1]:
            name = experiment.name
            files = is_reference(self.name) or is_walker_file(self.name)
            trained = self.name if files else name
            ready = f"{zoo.PREFIX}{name}"
            remedy = f"take {ready}, or train it" if ready in zoo.zoo_names() else "first"
            raise TegotaeError(
                f"{name} has weights to train and no file was given; "
                f"{remedy}: tegotae train {trained} --out FOLDER"
            )
        raise TegotaeError(
            f"{self.name} is a System, which has no weights; make a SavedController or a Legged "
            "of it, which has"
        )

    def controller(self) -> SavedController:
        """The one controller.

        Raises:
            TegotaeError: if there is none, or there are several.
        """
        (path, saved), *further = self.weighted()
        if further and path.suffix == ".npz":
            raise TegotaeError(
                f"{self.name} is a study of {1 + len(further)} controllers, and one is asked for; "
                "name a file of one"
            )
        if further:
            raise TegotaeError(
                f"{self.name} holds {1 + len(further)} controllers; name one of them, such as "
                f"{path}"
            )
        return saved

    def experiment(self) -> Experiment:
        """The one experiment.

        Raises:
            TegotaeError: if it says nothing of what is to be trained, or of several.
        """
        if len(self.experiments) == 1:
            return self.experiments[0]
        if self.experiments:
            raise TegotaeError(f"{self.name} holds {len(self.experiments)} experiments; name one")
        if self.legged is not None:
            reason = "which has nothing to learn"
            hint = f"; name a design upon it, such as AR@{self.name}"
        else:
            reason, hint = "which does not say what is to be trained", ""
        kind = "legged system" if self.legged else "System" if self.system else "controller"
        raise TegotaeError(
            f"{self.name} is no experiment: it is a {kind}, {reason}{hint or _SUCH_AS}"
        )

    def legs(self) -> Legged:
        """The one legged system with its weights, timed so that it settles whatever its release.

        Raises:
            TegotaeError: if it has one leg, no weights, or several.
        """
        if self.legged is not None:
            return self.legged
        require_legs(self.body)
        saved = self.controller()
        return settling(saved.system, saved.weights, saved.name or Path(self.name).stem)


_SUCH_AS = "; name a model such as ART, or an Experiment, FILE.py:OBJECT"


def resolve(name: str | Path | Named, *, budget: int | None = None) -> Resolved:
    """Resolve a name.

    Args:
        name: see this module; or an object such as it can mean.
        budget: largest number of trained parameters, of a model or a design; the paper's by
            default.

    Raises:
        TegotaeError: for a name that means nothing, with the nearest ones; a file that is damaged
            or not ours; a folder without controllers; or a budget for what has a controller of
            its own.

    Example:
        >>> resolve("ART").experiment().name, resolve("quadruped-c").legs().names
        ('ART-rF-tphif-w8', ('LF', 'RF', 'LH', 'RH'))
        >>> resolve("paper").controller().omega
        5.0
    """
    if not isinstance(name, (str, Path)):
        return _of_object(getattr(name, "name", None) or "mine", name)
    name = str(name)
    if (on_robot := law_on_robot(name)) is not None:
        return _of_robot(name, *on_robot)
    law = short_law(name)
    if law is not None or is_design(name) or _is_model(name):
        experiment = recipe(name).experiment(budget=BUDGET if budget is None else budget)
        return Resolved(name=name, controllers=_beside(name), experiments=(experiment,))
    if budget is not None:
        raise TegotaeError(
            f"--budget sizes the networks of the paper's models; {name} has a controller of its own"
        )
    if is_zoo_name(name):
        return _of_zoo(name)
    if is_front_name(name):
        return _of_object(name, front_walker(name))
    if name in SYSTEMS or is_walker_file(name):
        return _of_object(name, legged_by_name(name))
    path = Path(name)
    if is_vanilla(name) and not path.exists():
        return _of_object(name, vanilla(name))
    if is_reference(name):
        return _of_object(name, load_object(name, _KINDS, "system"))
    require_short(path)
    if path.is_dir():
        return _of_folder(name, path)
    if path.exists() or path.suffix or os.sep in name:
        return _of_file(name, path)
    names = [*_architectures(), *all_models(), *LAWS, *SYSTEMS, *PRESETS]
    raise unknown("model or system", name, names)


Recipe = Model | ShortLaw | Design
"""Controller to be trained: `controller()` makes it, and `experiment()` its training."""


def recipe(name: str) -> Recipe:
    """Return the recipe of a controller to be trained.

    Args:
        name: a model of the paper, an architecture, a short law, or a design for legs.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> recipe("V-reflex-w8").controller().n_weights, recipe("AR@quadruped-c").name
        (1, 'AR-rF@quadruped-c')
    """
    return short_law(name) or (design(name) if is_design(name) else find(name))


def legged_system(name: str) -> Legged:
    """The legged system of a name, with weights: one by name, a user's own, or a controller file.

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
    """A vanilla controller on its preset's hopper, released as it is there.

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
    source = preset(preset_name)
    oscillator = oscillator_called(of_oscillator or PHASE)
    system = System(
        controller=source.controller(actuation or source.actuation, oscillator),
        body=source.hopper,
        omega=source.omega_rad_per_s,
        release=Release(height_m=source.height_m),
    )
    # A trained oscillator's weights are zero where it is the one that it starts from.
    return SavedController(system, np.array([source.sigma, *[0.0] * oscillator.n_weights]), name)


def oscillator_called(name: str) -> Oscillator:
    """The oscillator of a name, or a user's own, `FILE.py:OBJECT`."""
    if is_reference(name):
        return load_object(name, Oscillator, "oscillator")
    return oscillator_named(name)


def controller_files(folder: Path) -> list[Path]:
    """The controller files in a folder and its subfolders; other documents are passed over, and
    what was set aside for a new beginning.

    Raises:
        TegotaeError: if a file may be a controller's and cannot be read: empty, cut short, without
            permission.
    """
    return [file for file in _json_files(folder) if _is_controller(file)]


Named = SavedController | Experiment | System | Legged | Sequence[Experiment]
"""Objects that a name in a user's own file can refer to."""
_KINDS = (SavedController, Experiment, System, Legged, list, tuple)


def _of_object(name: str, value: object) -> Resolved:
    if isinstance(value, Legged):
        saved = SavedController(value.system, np.array(value.weights), name)
        return Resolved(name=name, controllers=((Path(name), saved),), legged=value)
    if isinstance(value, SavedController):
        value = dataclasses.replace(value, name=value.name or name.rpartition(":")[2])
        return _with_weights(name, ((Path(name), value),))
    if isinstance(value, Experiment):
        return Resolved(name=name, experiments=(value,))
    if isinstance(value, System):
        return Resolved(name=name, system=value)
    experiments: list[Experiment] = []
    for item in cast(Iterable[object], value):
        if not isinstance(item, Experiment):
            raise TegotaeError(f"{name} holds a {type(item).__name__}, which is no experiment")
        experiments.append(item)
    return Resolved(name=name, experiments=tuple(experiments))


def _of_robot(name: str, law: str, robot: str) -> Resolved:
    """A controller from elsewhere on a robot; its file is read by a room above this one."""
    saved = dataclasses.replace(resolve(law), name=name).controller()
    transfer = importlib.import_module("tegotae.training.environments.transfer")
    return _of_object(name, transfer.on_robot(saved, robot))


def _of_zoo(name: str) -> Resolved:
    controllers = [
        (Path(place), controller_file.restored(document, place))
        for place, document in zoo.documents(name)
    ]
    return _with_weights(name, tuple(controllers))


def _of_folder(name: str, folder: Path) -> Resolved:
    if is_study(folder):
        return _with_weights(name, controllers_of_study(folder))
    files = controller_files(folder)
    if files:
        return _with_weights(name, tuple((file, controller_file.load(file)) for file in files))
    if is_vanilla(name):
        return _of_object(name, vanilla(name))
    raise TegotaeError(f"{folder} holds no controller files")


def _of_file(name: str, path: Path) -> Resolved:
    try:
        experiments = _experiments_in(path)
    except DamagedDocumentError as error:
        ours = controller_file.begins_as_ours(path)
        complaint = "is damaged" if ours else f"{controller_file.NOT_OURS}, nor of experiments"
        raise TegotaeError(f"{path} {complaint}: {error}") from None
    if experiments is not None:
        return Resolved(name=name, experiments=experiments)
    return _with_weights(name, ((path, controller_file.load(path)),))


def _with_weights(name: str, controllers: tuple[tuple[Path, SavedController], ...]) -> Resolved:
    """Controllers, and what they were trained in where they are one training's."""
    trained = [saved.experiment for _, saved in controllers if saved.experiment is not None]
    uniform = len(trained) == len(controllers) and all(
        training == trained[0] for training in trained
    )
    return Resolved(
        name=name, controllers=controllers, experiments=tuple(trained[:1]) if uniform else ()
    )


def _beside(name: str) -> tuple[tuple[Path, SavedController], ...]:
    """The controllers in a folder that is called as a model or a design."""
    folder = Path(name)
    if not folder.is_dir():
        return ()
    return tuple((file, controller_file.load(file)) for file in controller_files(folder))


def _experiments_in(path: Path) -> tuple[Experiment, ...] | None:
    """The experiments of a document, a list of them, or a study; None if it is none of these."""
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


def _is_model(name: str) -> bool:
    plain = name.partition("+")[0]
    is_listed = plain in all_models() or plain in _architectures()
    return is_listed or at_another_omega(plain) is not None


def _architectures() -> list[str]:
    return list(dict.fromkeys(model.architecture for model in all_models().values()))


def _json_files(folder: Path) -> list[Path]:
    """All files in a folder and its subfolders that are named as JSON; none of what was set aside
    for a new beginning."""

    def refuse(error: OSError) -> None:
        raise TegotaeError(f"cannot read {error.filename}: {error.strerror}") from None

    return sorted(
        Path(place, name)
        for place, _, names in os.walk(folder, onerror=refuse)
        if not any(map(is_earlier, Path(place).relative_to(folder).parts))
        for name in names
        if name.endswith(".json")
    )


def _is_controller(path: Path) -> bool:
    """Return whether a JSON file is a controller's and no other document.

    Raises:
        TegotaeError: if that cannot be decided.
    """
    try:
        return controller_file.is_controller(documents.read(path))
    except FileNotFoundError as error:  # a link to nowhere
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except DamagedDocumentError as error:
        complaint = f"damaged: {error}" if path.stat().st_size else "empty"
        raise TegotaeError(f"{path} is {complaint}; remove it from the folder") from None
