"""Trained controllers by name: no training before the first picture.

`python -m research.reproduction zoo` writes their files.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np

from tegotae._support.documents import DamagedDocumentError, JsonObject, fitted, parse_json
from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.files import read_arrays
from tegotae.systems.recipe import recipe

FORMAT = "tegotae zoo"
VERSION = 1
SUFFIX = ".npz"
"""Suffix of an archive's file."""
MOST_BYTES = 2**28
"""Size limit of an unpacked archive [bytes]; that of the paper's study has some 2 MB."""

SELECTION = "selection"
"""The metric by which a study chose among its runs, on releases that serve nothing else."""
_OF_RUNS = ("seed", "fitness", "generations", "ended")
_INDEX = ("documents", *_OF_RUNS, "metrics")
"""The arrays of a file beside its weights."""


class ZooHeader(msgspec.Struct):
    """Header of an archive."""

    format: str
    version: int
    study: str
    software: dict[str, str]
    models: dict[str, Annotated[int, msgspec.Meta(ge=1)]]
    metrics: list[str]


def open_zoo(path: Path) -> Zoo:
    """Open the file of trained controllers at a place, which is read once.

    Raises:
        TegotaeError: if there is none, or it is damaged, of a later version, or not ours.
    """
    try:
        state = path.stat()
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    return _opened(path, state.st_mtime_ns, state.st_size)


class Zoo:
    """A file of trained controllers, whose weights are read on demand.

    Args:
        path: the file.

    Raises:
        TegotaeError: if it cannot be read, is damaged, of a later version, or not ours.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        header = self._header(str(self._read("header")["header"]))
        self.study = header.study
        """The study's name."""
        self.software = header.software
        """Versions of the programs that made it, and the engine."""
        self.models = header.models
        """How many runs each model has, by its name."""
        self.metrics = tuple(header.metrics)
        """The names of the metrics of the evaluation."""
        self._index = self._read(*_INDEX)
        ends = np.cumsum([0, *header.models.values()]).tolist()
        self._rows = {m: slice(*e) for m, e in zip(header.models, pairwise(ends), strict=True)}

    def runs(self, model: str) -> dict[str, np.ndarray]:
        """Return the numbers of a model's runs: `seed`, `fitness`, `generations`, `ended` and the
        metrics of the evaluation, [runs] each."""
        rows = self._rows[model]
        metrics = dict(zip(self.metrics, self._index["metrics"][rows].T, strict=True))
        return {name: self._index[name][rows] for name in _OF_RUNS} | metrics

    def best(self, model: str) -> int:
        """Return the run that the study's selection prefers; without one (`SELECTION`), that with
        the best training fitness. The first of equals.
        """
        runs = self.runs(model)
        merit = runs.get(SELECTION, runs["fitness"])
        if np.isnan(merit).all():
            merit = runs["fitness"]
        return int(np.argmax(np.where(np.isnan(merit), -np.inf, merit)))

    def document(self, model: str, run: int) -> JsonObject:
        """Return a run's controller file as JSON values.

        Its `training` says of the run: study, run, seed, best_fitness, generations, ended, and the
        evaluation's metrics, null where undefined.

        Raises:
            TegotaeError: if the file is damaged.
        """
        document = self.common(model)
        training = document["training"]
        assert isinstance(training, dict)  # `common`
        weights = self.weights(model)[run].tolist()
        numbers = {name: values[run].item() for name, values in self.runs(model).items()}
        of_run = {
            "study": self.study,
            "run": run,
            "seed": numbers["seed"],
            "best_fitness": numbers["fitness"],
            "generations": numbers["generations"],
            "ended": numbers["ended"],
            "evaluation": {
                name: None if np.isnan(numbers[name]) else numbers[name] for name in self.metrics
            },
        }
        return {**document, "weights": weights, "training": {**training, **of_run}}

    def common(self, model: str) -> JsonObject:
        """Return the common part of the controller files of a model's runs.

        Raises:
            TegotaeError: if the file is damaged.
        """
        try:
            text = bytes(self._index["documents"][list(self.models).index(model)])
            document = fitted(parse_json(text), JsonObject)
            return {**document, "training": fitted(document.get("training"), JsonObject)}
        except DamagedDocumentError as error:
            raise self._damaged(str(error)) from None

    def weights(self, model: str) -> np.ndarray:
        """Return the weights of a model's runs, [runs, n_weights].

        Raises:
            TegotaeError: if the file is damaged.
        """
        name = f"weights/{model}"
        return self._read(name)[name]

    def _header(self, text: str) -> ZooHeader:
        try:
            document = fitted(parse_json(text), JsonObject)
            if document.get("format") != FORMAT:
                raise TegotaeError(f"{self.path} {NOT_OURS}")
            if document.get("version") != VERSION:
                raise TegotaeError(
                    f"{self.path} is of version {document.get('version')!r}; this program reads "
                    f"version {VERSION}"
                )
            return fitted(document, ZooHeader)
        except DamagedDocumentError as error:
            raise self._damaged(str(error)) from None

    def _read(self, *names: str) -> dict[str, np.ndarray]:
        try:
            return read_arrays(self.path, MOST_BYTES, names)
        except OSError as error:
            raise TegotaeError(f"cannot read {self.path}: {error.strerror}") from None
        except ValueError as error:
            raise self._damaged((str(error).splitlines() or [""])[0]) from None

    def _damaged(self, reason: str) -> TegotaeError:
        return TegotaeError(f"{self.path} is damaged, or {NOT_OURS}: {reason}")


NOT_OURS = "no file of python -m research.reproduction zoo"


@lru_cache(maxsize=8)
def _opened(path: Path, _mtime_ns: int, _size: int) -> Zoo:
    return Zoo(path)


PREFIX = "zoo:"
"""Prefix of the zoo's names."""
ALL = "all"
"""Word in place of a run's number for every run of the model."""
DEFAULT = "paper"
"""The study that is looked into first."""
FOLDER = Path(__file__).parent / "data"
"""The files that come with the package, one a study."""
CORE = "core"
"""The file of some models of the paper's study. An installed package has it in place of the studies
`DEFAULT` and "calibrated", which are in the sources."""
ELSEWHERE = (
    "; an installed package has some: all are in paper.npz and calibrated.npz of its sources, "
    "src/tegotae/systems/zoo/data, of which zoo:FILE:NAME names one"
)


@dataclass(frozen=True)
class ZooName:
    """A name of the zoo in its parts.

    Args:
        study: a study's name or a file's path; empty for the first study that has the model.
        model: the recipe's name.
        run: a run's number, `ALL`, or empty for the best one.
    """

    study: str
    model: str
    run: str

    @classmethod
    def parse(cls, name: str) -> ZooName:
        """Parse a name into its parts, with or without `zoo:` before it.

        Example:
            >>> ZooName.parse("zoo:ART-rF-tphif-w8/3")
            ZooName(study='', model='ART-rF-tphif-w8', run='3')
            >>> ZooName.parse("zoo:results/mine.npz:ART").study
            'results/mine.npz'
        """
        study, _, controller = name.removeprefix(PREFIX).rpartition(":")
        model, _, run = controller.partition("/")
        return cls(study, model, run)

    def __str__(self) -> str:
        study = f"{self.study}:" if self.study else ""
        run = f"/{self.run}" if self.run else ""
        return f"{PREFIX}{study}{self.model}{run}"


def is_zoo_name(name: str) -> bool:
    """Return whether a name has the form of a trained controller of the zoo.

    Example:
        >>> is_zoo_name("zoo:ART"), is_zoo_name("ART")
        (True, False)
    """
    return name.startswith(PREFIX)


def stem(name: str) -> str:
    """Return a name of the zoo, or a file, as text for legends and names of other files.

    Example:
        >>> stem("zoo:ART-rF-tphif-w8/3"), stem("runs/art/ART-seed0.json")
        ('ART-rF-tphif-w8-3', 'ART-seed0')
        >>> stem("zoo:calibrated:ART-rF-tphif-w8")
        'calibrated-ART-rF-tphif-w8'
    """
    if not is_zoo_name(name):
        return Path(name).stem
    parts = ZooName.parse(name)
    study = "" if parts.study.endswith(SUFFIX) else parts.study
    return "-".join(filter(None, (study, parts.model, parts.run)))


def studies() -> tuple[Zoo, ...]:
    """Return the studies that come with the package, in the order in which a model is searched."""
    files = {file.stem: file for file in sorted(FOLDER.glob(f"*{SUFFIX}"))}
    core, paper = files.pop(CORE, None), files.pop(DEFAULT, None)
    return tuple(map(open_zoo, [*filter(None, [paper or core]), *files.values()]))


def unknown_trained(kind: str, name: str, names: Iterable[str]) -> TegotaeError:
    """Return the error for a name that no study has, with the places that have more names.

    Args:
        kind: what is named, such as "model of the zoo".
        name: what was asked for.
        names: the names that there are.
    """
    is_whole = (FOLDER / f"{DEFAULT}{SUFFIX}").exists()
    return TegotaeError(f"{unknown(kind, name, names)}{'' if is_whole else ELSEWHERE}")


def study_of(name: str) -> Zoo:
    """Return the study of this name, or in this file.

    Raises:
        TegotaeError: if there is none, or its file is damaged.
    """
    if name.endswith(SUFFIX):
        return open_zoo(Path(name))
    archives = {zoo.study: zoo for zoo in studies()}
    if name not in archives:
        raise unknown_trained("study of the zoo", name, archives)
    return archives[name]


def zoo_names() -> tuple[str, ...]:
    """Return a name for every model in the package's studies, which means its best run."""
    listed: dict[str, None] = {}
    for zoo in studies():
        for model in zoo.models:
            short = str(ZooName("", model, ""))
            listed[short if short not in listed else str(ZooName(zoo.study, model, ""))] = None
    return tuple(listed)


def documents(name: str) -> tuple[tuple[str, JsonObject], ...]:
    """Return the documents of the controllers of a name in the form of controller files, each with
    its unique name.

    Raises:
        TegotaeError: for a study, a model or a run that is not there, with the nearest names; or a
            file that is damaged.
    """
    parts = ZooName.parse(name)
    zoo, model = _place(parts)
    count = zoo.models[model]
    if parts.run == ALL:
        runs = range(count)
    elif not parts.run:
        runs = (zoo.best(model),)
    elif parts.run.isdecimal() and int(parts.run[:9]) < count:
        runs = (int(parts.run),)
    else:
        raise TegotaeError(
            f"{name} is not there: {model} has the runs 0 to {count - 1}; {ALL} names them all"
        )
    return tuple(
        (str(ZooName(parts.study, model, str(run))), zoo.document(model, run)) for run in runs
    )


def _place(parts: ZooName) -> tuple[Zoo, str]:
    """Return the study, and the model's name there."""
    archives = (study_of(parts.study),) if parts.study else studies()
    model = _plainest(parts.model)
    for zoo in archives:
        for candidate in (parts.model, model):
            if candidate in zoo.models:
                return zoo, candidate
    models = [candidate for zoo in archives for candidate in zoo.models]
    architectures = {
        candidate.partition("-")[0]: None for candidate in models if "@" not in candidate
    }
    suffix = f" of {parts.study}" if parts.study else ""
    raise unknown_trained(f"trained controller{suffix}", parts.model, [*architectures, *models])


def _plainest(name: str) -> str:
    """Return the full name of a model from a possible short one."""
    try:
        return recipe(name).name
    except TegotaeError:
        return name
