"""Names of trained controllers: `zoo:[STUDY:]MODEL[/RUN]`.

- `zoo:ART-rF-tphif-w8` is the run with the best training fitness;
- `zoo:ART-rF-tphif-w8/3` is run 3, counted from 0 as seeds are;
- `zoo:ART-rF-tphif-w8/all` stands for all runs;
- `zoo:ART` is its plainest member, as everywhere.

STUDY is the name of a study that comes with the package, or the path of a file that
`python -m reproduction zoo` wrote. Without it the first study that has the model is meant, `paper`
before the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae.systems.models import find
from tegotae.systems.zoo.file import SUFFIX, Zoo, open_zoo

PREFIX = "zoo:"
"""How every name of the zoo begins."""
ALL = "all"
"""In place of a run's number: every run of the model."""
DEFAULT = "paper"
"""The study that is looked into first."""
FOLDER = Path(__file__).parent / "data"
"""The files that come with the package, one a study."""


@dataclass(frozen=True)
class ZooName:
    """A name of the zoo in its parts.

    Args:
        study: a study's name or a file's path; empty for the first study that has the model.
        model: the model's name, or a design's.
        run: a run's number, `ALL`, or empty for the best one.
    """

    study: str
    model: str
    run: str

    @classmethod
    def of(cls, name: str) -> ZooName:
        """The parts of a name, with or without `zoo:` before it.

        Example:
            >>> ZooName.of("zoo:ART-rF-tphif-w8/3")
            ZooName(study='', model='ART-rF-tphif-w8', run='3')
            >>> ZooName.of("zoo:results/mine.npz:ART").study
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
    """Whether a name is meant as that of a trained controller of the zoo.

    Example:
        >>> is_zoo_name("zoo:ART"), is_zoo_name("ART")
        (True, False)
    """
    return name.startswith(PREFIX)


def stem(name: str) -> str:
    """What a name of the zoo, or a file, is called in legends and in the names of other files.

    Example:
        >>> stem("zoo:ART-rF-tphif-w8/3"), stem("runs/art/ART-seed0.json")
        ('ART-rF-tphif-w8-3', 'ART-seed0')
        >>> stem("zoo:calibrated:ART-rF-tphif-w8")
        'calibrated-ART-rF-tphif-w8'
    """
    if not is_zoo_name(name):
        return Path(name).stem
    parts = ZooName.of(name)
    study = "" if parts.study.endswith(SUFFIX) else parts.study
    return "-".join(filter(None, (study, parts.model, parts.run)))


def studies() -> tuple[Zoo, ...]:
    """The studies that come with the package, in the order in which a model is looked for."""
    files = sorted(FOLDER.glob(f"*{SUFFIX}"), key=lambda file: (file.stem != DEFAULT, file.stem))
    return tuple(map(open_zoo, files))


def study_of(name: str) -> Zoo:
    """The study of this name, or in this file.

    Raises:
        TegotaeError: if there is none, or its file is damaged.
    """
    if name.endswith(SUFFIX):
        return open_zoo(Path(name))
    known = {zoo.study: zoo for zoo in studies()}
    if name not in known:
        raise unknown("study of the zoo", name, known)
    return known[name]


def names() -> tuple[str, ...]:
    """A name for every model in the package's studies; that of its best run."""
    found: dict[str, None] = {}
    for zoo in studies():
        for model in zoo.models:
            short = str(ZooName("", model, ""))
            found[short if short not in found else str(ZooName(zoo.study, model, ""))] = None
    return tuple(found)


def documents(name: str) -> tuple[tuple[str, JsonObject], ...]:
    """The documents of the controllers of a name, as controller files hold them, each with the
    name that stands for it alone.

    Raises:
        TegotaeError: for a study, a model or a run that is not there, with the nearest names; or a
            file that is damaged.
    """
    parts = ZooName.of(name)
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
    """The study, and the model's name there."""
    there = (study_of(parts.study),) if parts.study else studies()
    model = _plainest(parts.model)
    for zoo in there:
        for each in (parts.model, model):
            if each in zoo.models:
                return zoo, each
    models = [each for zoo in there for each in zoo.models]
    architectures = {each.partition("-")[0]: None for each in models if "@" not in each}
    of = f" of {parts.study}" if parts.study else ""
    raise unknown(f"trained controller{of}", parts.model, [*architectures, *models])


def _plainest(name: str) -> str:
    """The full name of what may be a model's short one."""
    try:
        return find(name).name
    except TegotaeError:
        return name
