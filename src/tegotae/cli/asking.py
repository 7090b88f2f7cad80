"""Words of the command line to options, by tyro; of a question names first, then the options of
what is named."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import io
import json
import os
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, get_type_hints

import tyro

from tegotae._support.errors import TegotaeError
from tegotae.cli.console import print_rows, print_text
from tegotae.cli.program import WIDTH, examples_text
from tegotae.questions.answer import AnswerBase, RecordedRun, check_output
from tegotae.questions.options import (
    OptionValue,
    about as about_field,
    changed,
    options_of,
    without_unit,
)
from tegotae.questions.question import Question, called
from tegotae.systems.zoo import is_zoo_name, stem


@dataclass(frozen=True, kw_only=True)
class AnswerOutput:
    """How the answer is shown, and which files are written."""

    json: bool = False
    """Print one JSON object."""
    csv: Path | None = None
    """Write the numbers (.csv, .parquet) or all of the answer (.json)."""
    plot: Path | None = None
    """Write a figure (.png, .pdf, .svg); if there are several, the others go beside it."""
    out: Path | None = None
    """Folder for all figures, the numbers and the document."""
    format: Literal["png", "svg", "pdf"] = "png"
    """Format of the pictures in the folder."""
    animate: Path | None = None
    """Write an animation (.gif, or .mp4, which needs ffmpeg)."""

    def check(self, question: Question) -> None:
        """Raise `TegotaeError` before long work for what cannot be written."""
        check_output(self.csv, ".csv", ".parquet", ".json")
        pictured = question.answer.ENDING == ".png"
        for picture in filter(None, [self.plot, self.out if pictured else None]):
            from tegotae.figures.style import figure_file

            figure_file(picture)
        if self.out is not None:
            question.answer.check_file(self.out)
        if self.animate is not None:
            from tegotae.figures.animation import animation_file

            animation_file(self.animate)

    def usual(self, question: Question, name: str) -> AnswerOutput:
        """The same, with what a question writes if nothing else is asked for."""
        if self.json or self.csv or self.plot or self.out:
            return self
        if question.written == "nothing":
            return self
        kind = question.__name__.removeprefix("figure_").replace("_", "-")
        stem = "-".join(filter(None, [kind, file_stem(name)]))
        return dataclasses.replace(self, out=Path(stem + question.answer.ENDING))

    def show(self, answer: AnswerBase) -> None:
        """Print the answer, and then write what was asked for: a picture may fail."""
        if self.json:
            print(json.dumps(answer.document(), allow_nan=False), flush=True)
        else:
            _print(answer)
        written = [] if self.csv is None else [answer.write(self.csv)]
        if self.plot is not None:
            answer.plot(self.plot)
            written.append(self.plot)
        if self.out is not None:
            written += answer.save(self.out, self.format)
        if self.animate is not None and isinstance(answer, RecordedRun):
            answer.animate(self.animate)
            written.append(self.animate)
        if written and not self.json:
            print("wrote " + ", ".join(map(str, written)))


def _print(answer: AnswerBase) -> None:
    if answer.title:
        print(answer.title)
    for table in answer.texts():
        keys, cells = table.index.nlevels, table.reset_index()
        print_rows(map(str, cells.columns), cells.to_numpy(str), key=keys)
    for note in answer.notes:
        print_text(note)
    sys.stdout.flush()


@dataclass(frozen=True)
class Asked:
    """Words that ask a question: names first, then options; nothing is looked up yet."""

    question: Question
    names: tuple[str, ...]
    """The subjects."""
    words: tuple[str, ...]
    """The options."""
    prog: str
    """The words before."""
    examples: Sequence[str] = ()
    """What a user can type."""

    @classmethod
    def of(
        cls, question: Question, words: Sequence[str], prog: str, examples: Sequence[str]
    ) -> Asked:
        """The question that words ask.

        Raises:
            TegotaeError: for words without a name, where one is needed.
            SystemExit: of status 0 after `--help`.
        """
        first = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
        asked = cls(question, tuple(words[:first]), tuple(words[first:]), prog, examples)
        if {"-h", "--help"} & {*words}:
            asked.help()
        if not (asked.names or question.usual or question.nameless):
            raise TegotaeError(f"names come first: {prog} NAME [OPTIONS]")
        return asked

    def help(self) -> NoReturn:
        """Print the help: of what is named, or else of what may be."""
        question, about = self.question, about_of(self.question)
        if question.has_own and not self.names and {*self.words} <= {"-h", "--help"}:
            known = options_of(question.subjects()) | outputs_of(question) | shared_of(question)
            more = f"{question.subjects.NAMED} {self.prog} NAME --help lists them."
            text = f"{about}\n\n{more}"
            parse(_class_of(known), ["--help"], f"{self.prog} NAME", text, self.examples)
        self.parsed()
        raise AssertionError("a help text ends the command")

    def run(self) -> None:
        """Ask, and show the answer."""
        subjects, given, output = self.parsed()
        output.check(self.question)
        output.show(self.question.about(subjects, **given))

    def parsed(self) -> tuple[Sequence[Any], dict[str, Any], AnswerOutput]:
        """What is named, the options that are given, and the output.

        Raises:
            TegotaeError: for a name or an option that there is not.
        """
        question, words = self.question, list(self.words)
        choices, outputs = options_of(question.subjects()), outputs_of(question)
        chosen, words = parse_known(_class_of(choices), words, self.prog)
        chooser = changed(question.subjects(), _values(chosen, choices), self.prog)
        subjects = chooser.named(*(self.names or question.usual))
        own = question.options(subjects[0] if subjects else None)
        known = options_of(own)
        words = [_plain(word, known) for word in words]
        about = "\n\n".join(filter(None, [about_of(question), inspect.getdoc(type(own))]))
        prog = " ".join([self.prog, *self.names])
        parsed = parse(_class_of(outputs | known), words, prog, about, self.examples)
        said = {word[2:].partition("=")[0].replace("-", "_") for word in words if word[:2] == "--"}
        given = _values(parsed, {name: known[name] for name in known if name in said})
        shown = AnswerOutput(**_values(parsed, outputs))
        first = [*self.names, *map(called, subjects[:1])]
        output = shown.usual(question, first[0] if first else "")
        if "out" in known:  # it works in the folder that is written
            given["out"] = output.out
        return subjects, given, output


def options_by_subject(question: Question) -> dict[str, dict[str, OptionValue]]:
    """What may be given by name: of every subject, and of each kind of subjects."""
    shared = options_of(question.subjects()) | outputs_of(question)
    kinds = {kind: options_of(own) for kind, own in question.examples().items()}
    return {"option": shared | kinds.pop("option", {}), **kinds}


def shared_of(question: Question) -> dict[str, OptionValue]:
    """The options of the question itself that all kinds of names have alike."""
    whole = [x for x, one in question.kinds.items() if isinstance(one, str) or x == "option"]
    kinds = [options_of(question.example(kind)) for kind in whole]
    return {
        name: option
        for name, option in kinds[0].items()
        if not option.heading and all(kind.get(name) == option for kind in kinds)
    }


def about_of(question: Question) -> str:
    """The docstring of a question, as far as it is for all readers."""
    return (inspect.getdoc(question) or "").partition("\n\nExample:")[0]


def outputs_of(question: Question) -> dict[str, OptionValue]:
    """The options of `AnswerOutput` that the answer to a question has."""
    known, answer = options_of(AnswerOutput()), question.answer
    if answer.figures is AnswerBase.figures and answer is not AnswerBase:
        known = {name: known[name] for name in known if name not in ("plot", "format")}
    if not hasattr(answer, "animate"):
        known.pop("animate")
    if answer.ENDING:
        known.pop("format", None)
        what = "the picture (.png, .pdf, .svg); its numbers go beside it"
        what = what if answer.ENDING == ".png" else f"all of it ({answer.ENDING})"
        more = "By default it is called after the question and what is named, in this folder."
        known["out"] = dataclasses.replace(known["out"], about=f"File of {what}. {more}")
    return known


_LONGEST_STEM = 80
"""Letters of a name that are a part of a file's name, which has few."""


def file_stem(name: str) -> str:
    """What something is called, as a part of a file's name.

    Example:
        >>> file_stem("runs/art/ART-rF-w8-seed0.json"), file_stem("mine.py:hopper")
        ('ART-rF-w8-seed0', 'hopper')
        >>> file_stem("zoo:ART-rF-tphif-w8/3")
        'ART-rF-tphif-w8-3'
    """
    if is_zoo_name(name):
        name = stem(name)
    last = re.split(r"[/\\\\:]", name)[-1]
    plain = re.sub(r"\.(json|zip|onnx|py)$", "", last)
    return re.sub(r"[^\w.@+-]+", "-", plain)[:_LONGEST_STEM].strip("-.")


def _plain(word: str, known: dict[str, OptionValue]) -> str:
    """An option without the unit of its name."""
    if not word.startswith("--"):
        return word
    name, equals, value = word.partition("=")
    plain = without_unit(name.removeprefix("--").replace("-", "_"))
    return f"--{plain.replace('_', '-')}{equals}{value}" if plain in known else word


def _class_of(known: dict[str, OptionValue]) -> type:
    """A class with these options, those of a part within a class of their own."""
    own: list[Any] = []
    parts: dict[str, list[Any]] = {}
    for name, option in known.items():
        hint = {"help_behavior_hint": ""} if option.value in (None, (), False) else {}
        kind: Any = option.kind | None if option.value is None else option.kind
        settings = tyro.conf.arg(help=option.about, **hint)  # type: ignore[call-overload]
        into = parts.setdefault(option.heading, []) if option.heading else own
        into.append((name, Annotated[kind, settings], field(default=option.value)))
    for heading, fields in parts.items():
        part = dataclasses.make_dataclass(heading, fields, kw_only=True)
        own.append((heading, part, field(default_factory=part)))
    return dataclasses.make_dataclass("Options", own, kw_only=True)


def _values(parsed: Any, known: dict[str, OptionValue]) -> dict[str, Any]:
    """What was parsed, by name."""
    return {
        name: getattr(getattr(parsed, option.heading) if option.heading else parsed, name)
        for name, option in known.items()
    }


# Words to an object of options, by tyro; what it refuses, in one line.

_CONFIG = (
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
    tyro.conf.OmitArgPrefixes,
    tyro.conf.PositionalMetavarFromFieldName,
)


def parse(
    kind: type, words: Sequence[str], prog: str, about: str = "", examples: Sequence[str] = ()
) -> Any:
    """Words as an object of a class.

    Args:
        kind: a dataclass of options.
        words: the options.
        prog: the words before.
        about: what the help says before the options; the docstring of the class by default.
        examples: what it says after them.

    Raises:
        TegotaeError: for words that make none.
        SystemExit: of status 0 after `--help`.
    """
    text = about or inspect.getdoc(kind) or ""
    helps = bool({"-h", "--help"} & {*words})
    try:
        return _cli(kind, ["--help"] if helps else words, prog, helps=helps, description=text)
    except SystemExit:
        print(examples_text(examples))
        raise


def parse_known(kind: type, words: Sequence[str], prog: str) -> tuple[Any, list[str]]:
    """An object of a class of the words that it has a meaning for, and the other words.

    Args:
        kind: a dataclass of options.
        words: the options.
        prog: the words before.

    Raises:
        TegotaeError: for a value that cannot be.
    """
    if not dataclasses.fields(kind):  # type: ignore[arg-type]
        return kind(), [*words]
    helps = [word for word in words if word in ("-h", "--help")]
    words = [word for word in words if word not in helps]
    made, rest = _cli(kind, words, prog, return_unknown_args=True)
    return made, [*rest, *helps]


def _cli(kind: type, words: Sequence[str], prog: str, *, helps: bool = False, **more: Any) -> Any:
    """What tyro makes of words; its refusal is one line."""
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box), _width(helps):
            return tyro.cli(kind, prog=prog, args=list(words), config=_CONFIG, **more)
    except SystemExit:
        if helps:
            raise
        raise TegotaeError(f"{_said(box.getvalue(), prog)}; see {prog} --help") from None


def flags_of(kind: Any) -> Iterator[tuple[str, str, object]]:
    """The options of a class: their flags, or names in capitals; what they are; and defaults.

    Example:
        >>> from tegotae.cli.completion import Completion
        >>> [flag for flag, *_ in flags_of(Completion)]
        ['SHELL']
    """
    hints = get_type_hints(kind, include_extras=True)
    for own in dataclasses.fields(kind):
        hint = hints[own.name]
        if dataclasses.is_dataclass(hint):
            yield from flags_of(hint)
            continue
        positional = tyro.conf.Positional in getattr(hint, "__metadata__", ())
        flag = own.name.upper() if positional else f"--{own.name.replace('_', '-')}"
        yield flag, about_field(kind, own.name), own.default


@contextlib.contextmanager
def _width(helps: bool) -> Iterator[None]:
    """A terminal as wide as help is, or else so wide that no line of an error is broken."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(WIDTH if helps else 100_000)
    try:
        yield
    finally:
        del os.environ["COLUMNS"]
        if before is not None:
            os.environ["COLUMNS"] = before


def _said(box: str, prog: str) -> str:
    """What tyro says in a box of several paragraphs, in one line."""
    lines = re.sub(r"\x1b\[[\d;]*m", "", box).splitlines()[1:]
    lines = ["" if set(line) <= set("╰─╯│- ") else line[2:].rstrip("│ ") for line in lines]
    text = "\n".join(lines).partition("For full helptext")[0].strip("\n")
    named = re.findall(r"^ {4}(\S.*)", text, re.MULTILINE)
    first = " ".join(text.partition("\n\n")[0].split()).rstrip(".")
    if first.startswith("Missing from"):
        return f"{prog} needs {', '.join(named)}"
    if re.match(r"Unrecognized options: [^-]", first):
        return f"{first}; a name comes before the options, if the command takes one"
    if wrong := re.match(r"Error parsing (\S+): (.*)", first):
        given = " ".join(re.findall(r"'([^']*)'", wrong[2]))
        return f"{wrong[1]} is {given!r}; write {named[0]}"
    return f"{first}; perhaps you meant {', '.join(named)}" if named else first
