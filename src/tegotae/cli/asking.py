"""Questions on the command line: names first, then the options of what is named."""

from __future__ import annotations

import dataclasses
import inspect
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, NoReturn

import tyro

from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder
from tegotae.cli.console import print_rows, print_text
from tegotae.cli.parsing import parse
from tegotae.questions import verbs
from tegotae.questions.answer import AnswerBase, RecordedRun, check_output
from tegotae.questions.generalising import GeneralisationOptions
from tegotae.questions.measuring import RecordingOptions
from tegotae.questions.options import OptionValue, options_of, without_unit
from tegotae.questions.task import tasks_of

SUBJECTS = """\
A name is a controller file, a folder of them, a trained controller such as zoo:ART, a vanilla one
such as V-sector-w4, paper-reflex or pyTegotaeCPG+hopf, a legged system such as quadruped-c, or
FILE.py:OBJECT. What it names has options of its own: tegotae {verb} NAME --help lists them."""


_UNSET = tyro.conf.arg(help_behavior_hint="")


@dataclass(frozen=True, kw_only=True)
class AnswerOutput:
    """How the answer is shown, and which files are written."""

    json: bool = False
    """Print one JSON object."""
    csv: Annotated[Path | None, _UNSET] = None
    """Write the numbers (.csv, .parquet) or all of the answer (.json)."""
    plot: Annotated[Path | None, _UNSET] = None
    """Write a figure (.png, .pdf, .svg); if there are several, the others go beside it."""

    def check(self) -> None:
        """Raise `TegotaeError` before long work for what cannot be written."""
        from tegotae.figures.style import figure_file

        check_output(self.csv, ".csv", ".parquet", ".json")
        if self.plot is not None:
            figure_file(self.plot)

    def show(self, answer: AnswerBase) -> None:
        """Print the answer, and then write what was asked for: a picture may fail."""
        if self.json:
            print(json.dumps(answer.document(), allow_nan=False), flush=True)
        else:
            self._print(answer)
        written = self.write(answer)
        if written and not self.json:
            print("wrote " + ", ".join(map(str, written)))

    def write(self, answer: AnswerBase) -> list[Path]:
        """Write the files that were asked for."""
        written = [] if self.csv is None else [answer.write(self.csv)]
        if self.plot is not None:
            answer.plot(self.plot)
            written.append(self.plot)
        return written

    def _print(self, answer: AnswerBase) -> None:
        if answer.title:
            print(answer.title)
        for table in answer.texts():
            keys, cells = table.index.nlevels, table.reset_index()
            print_rows(map(str, cells.columns), cells.to_numpy(str), key=keys, turned=True)
        for note in answer.notes:
            print_text(note)
        sys.stdout.flush()


@dataclass(frozen=True, kw_only=True)
class FolderOutput(AnswerOutput):
    """The same with a folder for all of it."""

    out: Annotated[Path | None, _UNSET] = None
    """Folder for all figures, the numbers and the document."""

    def check(self) -> None:
        super().check()
        if self.out is not None:
            check_folder(self.out)

    def write(self, answer: AnswerBase) -> list[Path]:
        written = super().write(answer)
        return written if self.out is None else [*written, *answer.save(self.out)]


@dataclass(frozen=True, kw_only=True)
class RunOutput(FolderOutput):
    """The same of a recorded run."""

    animate: Annotated[Path | None, _UNSET] = None
    """Write an animation (.gif, or .mp4, which needs ffmpeg)."""

    def check(self) -> None:
        super().check()
        if self.animate is not None:
            from tegotae.figures.animation import animation_file

            animation_file(self.animate)

    def write(self, answer: AnswerBase) -> list[Path]:
        written = super().write(answer)
        if self.animate is not None and isinstance(answer, RecordedRun):
            written.append(answer.animate(self.animate))
        return written


@dataclass(frozen=True)
class Question:
    """A question about what is named, with the options of that."""

    ask: ClassVar[Callable[..., AnswerBase]]
    output_kind: ClassVar[type[AnswerOutput]] = FolderOutput
    default: ClassVar[tuple[str, ...]] = ()
    """Subjects where none is named."""
    needs_name: ClassVar[bool] = True

    names: tuple[str, ...]
    """The subjects."""
    words: tuple[str, ...]
    """The options."""
    prog: str
    """The words before."""

    @classmethod
    def asked(cls, words: Sequence[str], prog: str) -> Question:
        """The question that words ask; what they name is not looked for yet.

        Raises:
            TegotaeError: for words without a name.
            SystemExit: of status 0 after `--help`.
        """
        first = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
        question = cls(tuple(words[:first]) or cls.default, tuple(words[first:]), prog)
        if {"-h", "--help"} & {*question.words}:
            question.help(named=first > 0)
        if cls.needs_name and not question.names:
            raise TegotaeError(f"names come first: {prog} NAME [OPTIONS]")
        return question

    def run(self) -> None:
        """Ask, and show the answer."""
        subjects, given, output = self.parsed()
        output.check()
        output.show(type(self).ask(*subjects, **given))

    def parsed(self) -> tuple[Sequence[Any], dict[str, Any], AnswerOutput]:
        """What is named, the options that are given, and the output.

        Raises:
            TegotaeError: for a name or an option that there is not.
        """
        words, subjects, own = self.subjects(list(self.words))
        known = options_of(own)
        words = [_plain(word, known) for word in words]
        about = "\n\n".join(inspect.getdoc(kind) or "" for kind in (type(self), type(own)))
        kind = _class_of(type(own).__name__, known, self.output_kind)
        parsed = parse(kind, words, " ".join([self.prog, *self.names]), about)
        said = {word[2:].partition("=")[0].replace("-", "_") for word in words if word[:2] == "--"}
        given = {name: _value(parsed, known[name], name) for name in known if name in said}
        fields = dataclasses.fields(self.output_kind)
        output = self.output_kind(**{field.name: getattr(parsed, field.name) for field in fields})
        return subjects, given, output

    def help(self, *, named: bool) -> NoReturn:
        """Print the help, of what is named if there is anything."""
        self.parsed()
        raise AssertionError("a help text ends the command")

    def subjects(self, words: list[str]) -> tuple[list[str], Sequence[Any], Any]:
        """The options without those that decide what the subjects are; the subjects; their options,
        with their own values."""
        raise NotImplementedError

    @classmethod
    def options_by_subject(cls) -> dict[str, dict[str, OptionValue]]:
        """The options of each kind of subject, for a reference of them all."""
        raise NotImplementedError


class TaskQuestion(Question):
    """A question about controllers, whose options are theirs."""

    options_as: ClassVar[str] = "evaluate"

    def subjects(self, words: list[str]) -> tuple[list[str], Sequence[Any], Any]:
        words, body = _taken("--body", words)
        tasks = tasks_of(*self.names, body=body)
        return words, tasks, tasks[0].options(self.options_as)

    def help(self, *, named: bool) -> NoReturn:
        if not named:  # nothing is simulated
            about = SUBJECTS.format(verb=type(self).__name__.lower())
            text = f"{inspect.getdoc(type(self))}\n\n{about}"
            parse(self.output_kind, ["--help"], f"{self.prog} NAME", text)
        super().help(named=named)

    @classmethod
    def options_by_subject(cls) -> dict[str, dict[str, OptionValue]]:
        from tegotae.questions.environment import EnvironmentEvaluation, EnvironmentSimulation

        hopper, legs = (task.options(cls.options_as) for task in tasks_of("paper", "quadruped-c"))
        there = EnvironmentEvaluation(omega=())
        return {
            "One leg, such as paper": options_of(hopper),
            "Several legs, such as quadruped-c": options_of(legs),
            "Trained in another simulator": options_of(
                EnvironmentSimulation(duration_s=24.0) if cls.options_as == "simulate" else there
            ),
        }


class Simulate(TaskQuestion):
    """Simulate a controller: one run, closely."""

    ask = staticmethod(verbs.simulate)
    options_as = "simulate"
    default = ("paper",)
    output_kind = RunOutput


class Evaluate(TaskQuestion):
    """Evaluate controllers: means over the runs of a training with their 95 % intervals."""

    ask = staticmethod(verbs.evaluate)


class Compare(TaskQuestion):
    """Compare controllers: how good each is, and how it differs from the first."""

    ask = staticmethod(verbs.compare)


class Measure(Question):
    """Measure a recorded gait of a robot or simulator: every metric, or why it is undefined."""

    ask = staticmethod(verbs.measure)

    def subjects(self, words: list[str]) -> tuple[list[str], Sequence[Any], Any]:
        return words, self.names, RecordingOptions()

    @classmethod
    def options_by_subject(cls) -> dict[str, dict[str, OptionValue]]:
        return {"option": options_of(RecordingOptions())}


class Generalise(Question):
    """Test trained controllers in conditions outside of their training; run it again on the same
    folder to continue. The controllers stay unchanged."""

    ask = staticmethod(verbs.generalise)
    output_kind = AnswerOutput
    needs_name = False

    def subjects(self, words: list[str]) -> tuple[list[str], Sequence[Any], Any]:
        return words, self.names, GeneralisationOptions()

    @classmethod
    def options_by_subject(cls) -> dict[str, dict[str, OptionValue]]:
        return {"option": options_of(GeneralisationOptions())}


def _taken(option: str, words: list[str]) -> tuple[list[str], str | None]:
    """The words without an option, and its value."""
    for i, word in enumerate(words):
        if word == option and i + 1 < len(words):
            return [*words[:i], *words[i + 2 :]], words[i + 1]
        if word.startswith(f"{option}="):
            return [*words[:i], *words[i + 1 :]], word.partition("=")[2]
    return words, None


def _plain(word: str, known: dict[str, OptionValue]) -> str:
    """An option without the unit of its name."""
    name, equals, value = word.partition("=")
    plain = without_unit(name.removeprefix("--").replace("-", "_"))
    return f"--{plain.replace('_', '-')}{equals}{value}" if plain in known else word


def _class_of(name: str, known: dict[str, OptionValue], output: type[AnswerOutput]) -> type:
    """A class with these options, those of a part within a class of their own."""
    own: list[Any] = []
    parts: dict[str, list[Any]] = {}
    for key, option in known.items():
        hint = {"help_behavior_hint": ""} if option.value in (None, (), False) else {}
        kind = option.kind | None if option.value is None else option.kind
        annotated = Annotated[kind, tyro.conf.arg(help=option.about, **hint)]
        into = parts.setdefault(option.heading, []) if option.heading else own
        into.append((key, annotated, field(default=option.value)))
    for heading, fields in parts.items():
        part = dataclasses.make_dataclass(heading, fields, kw_only=True)
        own.append((heading, part, field(default_factory=part)))
    return dataclasses.make_dataclass(name, own, bases=(output,), frozen=True, kw_only=True)


def _value(parsed: Any, option: OptionValue, name: str) -> Any:
    return getattr(getattr(parsed, option.heading) if option.heading else parsed, name)
