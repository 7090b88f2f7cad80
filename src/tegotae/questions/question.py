"""A question: a function of what is named and of its options, for Python and the shell alike."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, TypeVar, get_args, get_type_hints

from tegotae._support.engines import check_jax
from tegotae._support.errors import TegotaeError
from tegotae.questions.answer import AnswerBase
from tegotae.questions.options import changed, options_of
from tegotae.questions.task import Subject, Task
from tegotae.questions.tasks import tasks_of

A = TypeVar("A", bound=AnswerBase)


@dataclass(frozen=True, kw_only=True)
class Tasks:
    """Controllers by name. The fields, which decide what is named, are options as well."""

    NAMED: ClassVar[str] = (
        "A name is a controller file, a folder of them, a trained controller such as zoo:ART, a "
        "vanilla one such as V-sector-w4, paper-reflex or pyTegotaeCPG+hopf, a legged system such "
        "as quadruped-c or FILE.toml, or FILE.py:OBJECT. What it names has options of its own."
    )
    """What a name is, for help."""

    KIND: ClassVar[type[Task]] = Task
    """What a name has to mean."""
    WHY: ClassVar[str] = ""
    """Why other controllers are none of these."""

    body: str | None = None
    """Another body, FILE.toml of `tegotae identify`, FILE.py:OBJECT or MODULE:OBJECT."""

    def named(self, *names: Subject | Task) -> Sequence[Any]:
        """What the names mean.

        Raises:
            TegotaeError: for a name that means nothing here.
        """
        tasks = tasks_of(*names, body=self.body)
        for task in tasks:
            if not isinstance(task, self.KIND):
                raise TegotaeError(f"{task.name} {task.what}, and {self.WHY}")
        return tasks


@dataclass(frozen=True, kw_only=True)
class Names:
    """Names as they are, such as of files."""

    NAMED: ClassVar[str] = ""

    def named(self, *names: Any) -> Sequence[Any]:
        """The names."""
        return names


@dataclass(frozen=True, kw_only=True)
class Recordings(Names):
    """Recordings, each in a file."""

    NAMED: ClassVar[str] = (
        "A name is a recording, FILE.csv, FILE.npz or FILE.parquet, and has options of its own."
    )

    def named(self, *names: Any) -> Sequence[Any]:
        """The names.

        Raises:
            TegotaeError: for what is no name of a file.
        """
        for name in names:
            if not isinstance(name, str | Path):
                raise TegotaeError(
                    f"a recording is called {reprlib.repr(name)}; it must be the name of a file, "
                    "such as 'log.csv'"
                )
        return names


@dataclass(frozen=True, kw_only=True)
class Nothing(Names):
    """Of a question about the program itself."""

    def named(self, *names: Any) -> Sequence[Any]:
        """No subjects.

        Raises:
            TegotaeError: for any name.
        """
        if names:
            raise TegotaeError(f"{names[0]!r} is one word too many; no name is asked for")
        return ()


@dataclass(frozen=True, kw_only=True)
class NoOptions:
    """It has no options of its own."""


@dataclass(eq=False)
class Question(Generic[A]):
    """A question; called with names and options, it gives the answer.

    Args:
        ask: a function of one subject and its options; or of all subjects and the options of each.
        subjects: how names become subjects.
        own: the options of a subject, with its own values; by default the class that `ask` says
            its second argument has, or of that the class method `options_of`, called with the
            subject.
        several: whether `ask` takes all subjects.
        nameless: whether it can be asked without any.
        usual: the names where none is given.
        kinds: of kinds of subjects an example, for a reference: a name, or a function that makes
            its options.
        written: what the shell writes unless it is told: nothing, a folder, or the file that the
            answer is (`AnswerBase.ENDING`).
    """

    ask: Callable[[Any, Any], A]
    subjects: type[Tasks | Names] = Tasks
    own: Callable[[Any], Any] | None = None
    several: bool = False
    nameless: bool = False
    usual: tuple[Any, ...] = ()
    kinds: Mapping[str, Any] = field(default_factory=dict)
    written: Literal["nothing", "folder", "file"] = "nothing"

    def __post_init__(self) -> None:
        self.__doc__, self.__name__ = self.ask.__doc__, self.ask.__name__
        self.__module__, self.__qualname__ = self.ask.__module__, self.ask.__qualname__

    def __call__(self, *names: Any, **given: Any) -> A:
        """The answer.

        Args:
            names: of the subjects, or objects.
            given: options by name, with or without their units.

        Raises:
            TegotaeError: for a name that means nothing, an option that a subject does not have, or
                a value that cannot be; before long work begins.
        """
        check_jax()
        chooser = self.subjects()
        known = {*options_of(chooser), *(f.name for f in fields(chooser))}
        choosing = {name: given.pop(name) for name in [*given] if name in known}
        subjects = changed(chooser, choosing, self.__name__).named(*(names or self.usual))
        return self.about(subjects, **given)

    def about(self, subjects: Sequence[Any], **given: Any) -> A:
        """The answer about subjects that are looked up already.

        Args:
            subjects: what names mean.
            given: as for a call, of the subjects' options.

        Raises:
            TegotaeError: for an option that a subject does not have, or a value that cannot be.
        """
        asked = [changed(self.options(x), given, called(x)) for x in subjects]
        if not subjects and self.nameless:
            asked = [changed(self.options(None), given, self.__name__)]
        if not asked:
            raise TegotaeError(f"{self.__name__} needs a name, at least one")
        if self.several:
            return self.ask(subjects, asked)
        if len(asked) != 1:
            named = ", ".join(map(called, subjects)) or "nothing"
            raise TegotaeError(f"{self.__name__} takes one name; {named} are {len(subjects)}")
        return self.ask(subjects[0] if subjects else None, asked[0])

    @property
    def answer(self) -> type[A]:
        """The class of the answer."""
        return get_type_hints(self.ask)["return"]

    @property
    def has_own(self) -> bool:
        """Whether options differ from subject to subject."""
        return self.own is not None or hasattr(self._kind, "options_of")

    @property
    def _kind(self) -> Any:
        kind = get_type_hints(self.ask)["options"]
        return get_args(kind)[0] if self.several else kind

    def options(self, subject: Any) -> Any:
        """The options of a subject, with its own values."""
        if self.own is not None:
            return self.own(subject)
        return self._kind.options_of(subject) if self.has_own else self._kind()

    def examples(self) -> dict[str, Any]:
        """The options of each kind of subject."""
        if not self.has_own:
            return {"option": self.options(None)}
        return {kind: self.example(kind) for kind in self.kinds}

    def example(self, kind: str) -> Any:
        """The options of a kind of subject."""
        one = self.kinds[kind]
        return self.options(self.subjects().named(one)[0]) if isinstance(one, str) else one()


def question(**settings: Any) -> Callable[[Callable[[Any, Any], A]], Question[A]]:
    """Make a question of a function.

    Args:
        settings: the fields of `Question`.
    """
    return lambda ask: Question(ask, **settings)


def called(subject: Any) -> str:
    """The name of a subject."""
    return str(getattr(subject, "name", subject))
