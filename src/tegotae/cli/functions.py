"""Commands that are functions of the package: names first, then options of the named subject."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NoReturn

from tegotae._support.errors import MissingExtraError, TegotaeError
from tegotae.api.controllers import NAMES, kinds as kinds_of_controllers, load_all
from tegotae.api.parameters import (
    InShell,
    Option,
    Values,
    about,
    facts_of,
    options_of,
)
from tegotae.cli.output import OutputOptions, output_options, result_of
from tegotae.cli.words import help_text, known_options, split, values_of

_BODY = Option(
    "body",
    str,
    None,
    "Another body, FILE.toml of `tegotae identify`, FILE.py:OBJECT or MODULE:OBJECT.",
)
"""Option of every command about controllers."""


@dataclass(frozen=True)
class FunctionCall:
    """Words that call a function; no name is looked up yet."""

    function: Callable[..., Any]
    """Function, or method of `LoadedController`."""
    names: tuple[str, ...]
    """Names of the subjects."""
    options: list[tuple[str, list[str]]]
    """Options, each with the words after it."""
    prog: str
    """Words of the command."""
    examples: Sequence[str] = ()
    """Lines that a user can type."""

    @classmethod
    def from_words(
        cls, function: Callable[..., Any], words: Sequence[str], prog: str, examples: Sequence[str]
    ) -> FunctionCall:
        """Return the call that words make.

        Raises:
            TegotaeError: for words without a name, where one is needed.
            SystemExit: of status 0 after `--help`.
        """
        names, options = split(words)
        helps = [option for option in options if option[0] not in ("-h", "--help")]
        call = cls(function, names, helps, prog, examples)
        if len(helps) < len(options):
            call.help()
        if not names and call.names_needed:
            raise TegotaeError(f"names come first: {prog} NAME [OPTIONS]")
        return call

    @property
    def facts(self) -> InShell:
        """Facts about the function that its signature does not say."""
        return facts_of(self.function)

    @property
    def is_method(self) -> bool:
        """True for a method of a controller."""
        return next(iter(inspect.signature(self.function).parameters), "") == "self"

    @property
    def is_about_controllers(self) -> bool:
        """True if the names are those of controllers."""
        return self.is_method or "controller" in inspect.signature(self.function).parameters

    @property
    def subjects(self) -> list[inspect.Parameter]:
        """Positional parameters."""
        parameters = inspect.signature(self.function).parameters.values()
        return [x for x in parameters if x.kind is not inspect.Parameter.KEYWORD_ONLY]

    @property
    def names_needed(self) -> bool:
        """True if the function needs a name that it has no default for."""
        if self.is_method:
            return not self.facts.default_names
        return any(x.default is x.empty and x.kind is not x.VAR_POSITIONAL for x in self.subjects)

    @property
    def _is_several(self) -> bool:
        return any(x.kind is x.VAR_POSITIONAL for x in self.subjects)

    def help(self) -> NoReturn:
        """Print the help: of the named subject, or of the command."""
        shared, text, footer = self._shared(), about(self.function), ""
        if self.names or self.options or not (self.is_about_controllers or self.facts.defaults):
            bound = self._bound()
            shared = {**bound.options, **shared, **_only(bound.options, "out")}
            text = about(bound.function)
        else:
            shared |= _only(options_of(self.function, self.facts.values), *self.facts.loads)
            kinds = [*options_by_subject(self.function).values()]
            kinds = kinds[1:] or kinds
            first = kinds[0]
            common = [x for x in first if all(kind.get(x) == first[x] for kind in kinds)]
            shared |= {x: first[x] for x in common if not first[x].heading}
            footer = f"\n\n{self.facts.names or NAMES} {self.prog} NAME --help lists its options."
        groups: dict[str, list[Option]] = {}
        for option in shared.values():
            groups.setdefault(option.heading or "Options", []).append(option)
        names = self.names or (("NAME",) if self.subjects else ())
        usage = " ".join([self.prog, *names, "[OPTIONS]"])
        print(help_text(usage, text + footer, groups, self.examples))
        raise SystemExit(0)

    def run(self) -> None:
        """FunctionCall the function, and show its result."""
        call, output = self.parsed()
        output.check(result_of(self.function), self.facts)
        output.show(call())

    def parsed(self) -> tuple[Callable[[], Any], OutputOptions]:
        """Return the function with its arguments, and the output.

        Raises:
            TegotaeError: for a name or an option that there is not.
        """
        bound, shared = self._bound(), self._shared()
        options = {**shared, **bound.options}
        paths = values_of(self.options, options.values(), bound.name or self.prog)
        paths.pop("body", None) if self.is_about_controllers else None
        output_values = {name: paths.pop(name) for name in shared if name in paths}
        output = OutputOptions(**{name: x for name, x in output_values.items() if name != "body"})
        command = self.prog.partition(" ")[2]
        subject = self.names[0] if self.names else bound.name
        output = output.with_default_file(result_of(self.function), self.facts, command, subject)
        values = _nested(paths)
        if "out" in bound.options:  # the function works in the folder that is written
            folder = output.out or bound.options["out"].value
            output = replace(output, out=values.get("out", folder))
            values["out"] = output.out
        return partial(bound.function, *bound.subjects, **values), output

    def _shared(self) -> dict[str, Option]:
        """Options of every subject: how it is loaded, and the output."""
        loading = {"body": _BODY} if self.is_about_controllers else {}
        return {**loading, **output_options(self.function, self.facts)}

    def _bound(self) -> _Bound:
        """The function of the named subject, with its own values.

        Raises:
            TegotaeError: for a name that means nothing here, or too many.
        """
        function, facts, names = self.function, self.facts, self.names or self.facts.default_names
        if not self.is_method:
            self._require_one(names)
        if names and not self.subjects:
            raise TegotaeError(f"unexpected argument {names[0]!r}; {self.prog} takes no name")
        if self.is_method:
            body = known_options(self.options, [_BODY], self.prog).get("body")
            first, *further = load_all(*names, body=body)
            function = getattr(first, function.__name__)
            self._require_one([x.name for x in (first, *further)])
            return _Bound(function, tuple(further), first.defaults(), first.name)
        plain = options_of(function, facts.values).values()
        overrides = _nested(known_options(self.options, plain, self.prog))
        subjects: tuple[Any, ...] = tuple(names) or tuple(
            x.default for x in self.subjects if x.default not in (x.empty, None)
        )
        if "policy" in overrides and not names:
            subjects = ()
        if self.is_about_controllers:
            body = known_options(self.options, [_BODY], self.prog).get("body")
            subjects = tuple(load_all(*subjects, body=body)) if subjects else ()
            self._require_one([x.name for x in subjects])
            name = subjects[0].name if subjects else ""
            defaults = subjects[0].defaults() if subjects else {}
        else:
            name, defaults = str(subjects[0]) if subjects else "", {}
        if facts.defaults is not None:
            defaults = {**defaults, **facts.defaults(*subjects[:1], **overrides)}
        defaults = {**facts.values, **defaults}
        return _Bound(function, subjects, defaults, defaults.get("", name))

    def _require_one(self, names: Sequence[str]) -> None:
        """Raise `TegotaeError` for more names than the function takes."""
        if len(names) > 1 and not self._is_several:
            command = self.prog.partition(" ")[2]
            raise TegotaeError(f"{command} takes one name; {', '.join(names)} are {len(names)}")


@dataclass(frozen=True)
class _Bound:
    """A function, and the subjects that it is called with."""

    function: Callable[..., Any]
    subjects: tuple[Any, ...]
    """Positional arguments."""
    defaults: Values
    """Own values of the first subject."""
    name: str
    """Name of the first subject."""

    @property
    def options(self) -> dict[str, Option]:
        """Options by name."""
        return options_of(self.function, self.defaults)


def _nested(paths: Mapping[str, Any]) -> dict[str, Any]:
    """Values by parameter: of a nested one its changes by field, and its name if it is given."""
    values: dict[str, Any] = {}
    for path, value in paths.items():
        name, dot, field = path.partition(".")
        if dot:
            changes = values.setdefault(name, {})
            if not isinstance(changes, dict):
                values[name] = changes = {"name": changes}
            changes[field] = value
        elif name in values:
            values[name]["name"] = value
        else:
            values[name] = value
    return values


def _only(options: Mapping[str, Option], *names: str) -> dict[str, Option]:
    return {name: options[name] for name in names if name in options}


def options_by_subject(function: Callable[..., Any]) -> dict[str, dict[str, Option]]:
    """Return the options by name: of every subject, and of each kind of subjects.

    Args:
        function: a function, or a method of `LoadedController`.
    """
    call = FunctionCall(function, (), [], "tegotae")
    kinds: dict[str, dict[str, Option]] = {}
    if call.is_method:
        for heading, (kind, name) in kinds_of_controllers().items():
            defaults = load_all(name)[0].defaults() if name else {}
            kinds[heading] = options_of(getattr(kind, function.__name__), defaults)
        return {"option": call._shared(), **kinds}
    for heading, words in call.facts.examples.items() or {"option": ""}.items():
        names, options = split(words.split())
        with contextlib.suppress(MissingExtraError):
            kinds[heading] = FunctionCall(function, names, options, "tegotae")._bound().options
    if "" in kinds:
        return {"option": call._shared() | kinds.pop("")}
    return {"option": call._shared() | kinds.pop("option", {}), **kinds}
