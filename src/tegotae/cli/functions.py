"""Commands that are functions of the package: names first, then options of the named subject."""

from __future__ import annotations

import contextlib
import inspect
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

from tegotae._support.errors import MissingExtraError, TegotaeError
from tegotae.api.controllers import NAMES, kinds as kinds_of_controllers, load_all
from tegotae.api.parameters import (
    Option,
    Values,
    description_of,
    options_of,
    own_values_of,
    texts_of,
)
from tegotae.cli.kept_texts import HELP
from tegotae.cli.output import OutputOptions, output_options, result_of
from tegotae.cli.program import Command
from tegotae.cli.words import flag_of, help_text, known_options, split, values_of

_BODY = Option(
    "body",
    str,
    None,
    "Another body, FILE.toml of `tegotae identify`, FILE.py:OBJECT or MODULE:OBJECT.",
)
"""Option of every command about controllers."""


@dataclass(frozen=True)
class FunctionCall:
    """A function call from the command line; names are not looked up yet."""

    command: Command
    """Command of the function, or of a method of `LoadedController`."""
    prog: str
    """Words of the command."""
    names: tuple[str, ...] = ()
    """Names of the subjects."""
    options: Sequence[tuple[str, list[str]]] = ()
    """Options, each with the words after it."""

    @classmethod
    def from_words(cls, command: Command, words: Sequence[str], prog: str) -> FunctionCall | str:
        """Parse the call from the words of a command line; return its help if they want it.

        Raises:
            TegotaeError: for words without a name, where one is needed.
        """
        names, options = split(words)
        further = [option for option in options if option[0] not in HELP]
        call = cls(command, prog, names, further)
        if len(further) < len(options):
            return call.help()
        if not names and call.names_needed:
            raise TegotaeError(f"names come first: {prog} NAME [OPTIONS]")
        return call

    @cached_property
    def function(self) -> Callable[..., Any]:
        """Function or method of the command."""
        return self.command.load()

    @cached_property
    def subjects(self) -> list[inspect.Parameter]:
        """Positional parameters."""
        parameters = inspect.signature(self.function).parameters.values()
        return [x for x in parameters if x.kind is not inspect.Parameter.KEYWORD_ONLY]

    @property
    def is_method(self) -> bool:
        """True for a method of a controller."""
        return bool(self.subjects) and self.subjects[0].name == "self"

    @property
    def is_about_controllers(self) -> bool:
        """True if the names are those of controllers."""
        return self.is_method or "controller" in inspect.signature(self.function).parameters

    @property
    def names_needed(self) -> bool:
        """True if the function needs a name that it has no default for."""
        needed = [
            x for x in self.subjects if x.default is x.empty and x.kind is not x.VAR_POSITIONAL
        ]
        return bool(needed) and not self.command.names

    def help(self) -> str:
        """Return the help: of the named subject, or of the command."""
        shared, text, footer = self._shared(), description_of(self.function), []
        depends = self.is_about_controllers or own_values_of(self.function)
        if self.is_about_controllers and not self.names:
            footer.append(NAMES)
        elif self.subjects and not self.names:
            subject = self.subjects[0].name
            footer.append(f"NAME: {texts_of(self.function)[subject]}")
        if self.names or not depends or (self.options and not self.names_needed):
            bound = self._bound()
            options = bound.options | {n: x for n, x in shared.items() if n not in bound.options}
            text = description_of(bound.function)
        else:
            options = shared | self._common()
            footer.append(f"{self.prog} NAME --help lists its options.")
        groups: dict[str, list[Option]] = {}
        for option in options.values():
            groups.setdefault(option.heading or "Options", []).append(option)
        names = self.names or (("NAME",) if self.subjects else ())
        usage = " ".join([self.prog, *names, "[OPTIONS]"])
        text = "\n\n".join(filter(None, [text, " ".join(footer)]))
        return help_text(usage, text, groups, self._examples(options.values()))

    def _examples(self, options: Iterable[Option]) -> list[str]:
        """Return the command's examples, with the given names, as far as it has these options."""
        if not self.names:
            return [*self.command.examples]
        flags, lines = {*map(flag_of, options)}, dict[str, None]()
        for example in self.command.examples:
            _, calls = split(shlex.split(example.removeprefix(self.prog)))
            if all(flag in flags for flag, _ in calls):
                words = [x for flag, values in calls for x in (flag, *values)]
                lines[" ".join([self.prog, *map(shlex.quote, (*self.names, *words))])] = None
        return [*lines]

    def run(self) -> None:
        """Call the function, and show its result."""
        call, output = self.parsed()
        output.check(result_of(self.function))
        output.show(call())

    def parsed(self) -> tuple[Callable[[], Any], OutputOptions]:
        """Return the function with its arguments, and the output.

        Raises:
            TegotaeError: for a name or an option that there is not.
        """
        bound, shared = self._bound(), self._shared()
        options = {**shared, **bound.options}
        paths = values_of(self.options, options.values(), bound.name or self.prog)
        if self.is_about_controllers:
            paths.pop("body", None)  # with which the controllers are loaded
        output = OutputOptions(**{name: paths.pop(name) for name in shared if name in paths})
        subject = self.names[0] if self.names else bound.name
        output = output.with_default_file(self.command, subject)
        values = _nested(paths)
        if "out" in bound.options:  # the function works in the folder that is written
            values.setdefault("out", output.out or bound.options["out"].value)
            output = replace(output, out=values["out"])
        return partial(bound.function, *bound.subjects, **values), output

    def _shared(self) -> dict[str, Option]:
        """Return the options of every subject: those that load it, and the output."""
        loading = {"body": _BODY} if self.is_about_controllers else {}
        return {**loading, **output_options(self.command)}

    def _common(self) -> dict[str, Option]:
        """Return the options of every kind of subject, and those that decide which others it
        has.
        """
        own_values = own_values_of(self.function)
        deciding = inspect.signature(own_values).parameters if own_values else ()
        loading = {
            name: option
            for name, option in options_of(self.function, {}).items()
            if option.path.partition(".")[0] in deciding
        }
        kinds = [*options_by_subject(self.command).values()]
        first, *further = kinds[1:] or kinds
        common = {name: x for name, x in first.items() if all(y.get(name) == x for y in further)}
        return loading | {name: x for name, x in common.items() if not x.heading}

    def _bound(self) -> _Bound:
        """Return the function of the named subject, with its defaults.

        Raises:
            TegotaeError: for a name that means nothing here, or too many.
        """
        function, names = self.function, self.names or self.command.names
        if names and not self.subjects:
            raise TegotaeError(f"unexpected argument {names[0]!r}; {self.prog} takes no name")
        if not self.is_method:
            self._require_one(names)
        overrides = _nested(
            known_options(self.options, options_of(function, {}).values(), self.prog)
        )
        subjects: tuple[Any, ...] = tuple(names) or tuple(
            x.default for x in self.subjects if x.default not in (x.empty, None)
        )
        if "policy" in overrides and not names:
            subjects = ()
        defaults: Values = {"": str(self.names[0]) if self.names else ""}
        if subjects and self.is_about_controllers:
            body = known_options(self.options, [_BODY], self.prog).get("body")
            subjects = tuple(load_all(*subjects, body=body))
            self._require_one([x.name for x in subjects])
            defaults = {"": subjects[0].name, **subjects[0].defaults()}
        if self.is_method:
            return _Bound(getattr(subjects[0], function.__name__), subjects[1:], defaults)
        if (own_values := own_values_of(function)) is not None:
            defaults = {**defaults, **own_values(*subjects[:1], **overrides)}
        return _Bound(function, subjects, defaults)

    def _require_one(self, names: Sequence[str]) -> None:
        """Raise `TegotaeError` for more names than the function takes."""
        is_several = any(x.kind is x.VAR_POSITIONAL for x in self.subjects)
        if len(names) > 1 and not is_several:
            command, listed = self.prog.partition(" ")[2], ", ".join(names)
            raise TegotaeError(f"{command} takes one name; {listed} are {len(names)}")


@dataclass(frozen=True)
class _Bound:
    """A function, and the subjects that it is called with."""

    function: Callable[..., Any]
    subjects: tuple[Any, ...]
    """Positional arguments."""
    defaults: Values
    """Values of the first subject by parameter, and its name under ""."""

    @property
    def name(self) -> str:
        """Name of the first subject."""
        return self.defaults[""]

    @property
    def options(self) -> dict[str, Option]:
        """Options by name."""
        return options_of(self.function, self.defaults)


def _nested(paths: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by parameter; a nested one has its changes by field, and its name if there
    is one.
    """
    values = {path: value for path, value in paths.items() if "." not in path}
    changes: dict[str, dict[str, Any]] = {}
    for path, value in paths.items():
        name, dot, field = path.partition(".")
        if dot:
            named = {"name": values[name]} if name in values else {}
            changes.setdefault(name, named)[field] = value
    return values | changes


def options_by_subject(command: Command) -> dict[str, dict[str, Option]]:
    """Return the options by name: of every subject, and of each kind of subjects.

    Args:
        command: command of a function, or of a method of `LoadedController`.
    """
    call = FunctionCall(command, "tegotae")
    kinds: dict[str, dict[str, Option]] = {"option": call._shared()}
    if call.is_method:
        for heading, (kind, name) in kinds_of_controllers().items():
            defaults = load_all(name)[0].defaults() if name else {}
            kinds[heading] = options_of(getattr(kind, call.function.__name__), defaults)
        return kinds
    for heading, words in command.subjects.items():
        with contextlib.suppress(MissingExtraError):
            needed = words if heading or call.names_needed else ""
            options = FunctionCall(command, "tegotae", *split(shlex.split(needed)))._bound().options
            kinds[heading or "option"] = {**kinds.get(heading or "option", {}), **options}
    return kinds
