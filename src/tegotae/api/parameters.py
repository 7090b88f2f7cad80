"""Options: the parameters of a function, and the fields of the dataclasses among them.

Options that several functions share are keys of a `TypedDict`, each annotated with its meaning,
and with its default where that is not None.
"""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, wraps
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import docstring_parser

from tegotae._support.engines import check_jax
from tegotae._support.errors import unknown
from tegotae._support.kinds import fits, require_kind_of
from tegotae.parts.fields import replace

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])

_PLAIN = (bool, int, float, str, Path)
HIDDEN = ...
"""Own value of a parameter that does not apply to a subject."""
Values = Mapping[str, Any]
"""Own values of a subject by parameter."""


POSITIONAL = "positional"
"""Mark of a field that is given before the options, `Annotated[Path, POSITIONAL]`."""
SEVERAL = "several"
"""Mark of a field whose option may be given several times, each time with one word or more."""


@dataclass(frozen=True)
class Option:
    """A value that words can give."""

    path: str
    """Parameter, or the way to a field, such as body.mass_kg."""
    kind: Any
    """Type."""
    value: Any
    """Default: the subject's own value."""
    description: str = ""
    """Meaning."""
    heading: str = ""
    """Class of the field; empty for a parameter."""
    mark: str = ""
    """`POSITIONAL`, `SEVERAL`, or empty."""

    @property
    def name(self) -> str:
        """Name in the shell, with underscores."""
        return self.path.rpartition(".")[2]


_OWN_VALUES: dict[Any, Callable[..., Values]] = {}


def with_own_values(own_values: Callable[..., Values]) -> Callable[[F], F]:
    """Return a decorator that checks options (`check_types`) and remembers the subjects' values.

    Args:
        own_values: function of the name, and of the options that decide about further ones, that
            returns the values of the subject.
    """

    def remembering(function: F) -> F:
        function = check_types(function)
        _OWN_VALUES[function] = own_values
        return function

    return remembering


def own_values_of(function: Callable[..., Any]) -> Callable[..., Values] | None:
    """Return the function of `with_own_values`, if there is one."""
    return _OWN_VALUES.get(function)


def check_types(function: F) -> F:
    """Return a function that refuses unknown options, and options of another type.

    Shared options, `**options: Unpack[...]`, stand in its signature and its docstring as those of
    its own, and are passed on with their defaults.

    Args:
        function: a function or a method with typed keyword parameters.

    Raises:
        TypeError: at a call, for an unknown option, with the nearest ones.
        TegotaeError: at a call, for an option of another type.
    """
    hints: dict[str, Any] = {}
    signature, shared = inspect.signature(function), shared_options(function)
    if shared:
        parameters = [x for x in signature.parameters.values() if x.kind is not x.VAR_KEYWORD]
        parameters += [option.parameter for option in shared.values()]
        signature = signature.replace(parameters=parameters)
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    keywords = [x.name for x in signature.parameters.values() if x.kind in kinds]

    @wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        if options and not hints:
            hints.update(hints_of(function))
        for name in options.keys() - signature.parameters.keys():
            raise TypeError(str(unknown(f"option of {function.__name__}", name, keywords)))
        for name in options.keys() & hints.keys():
            if getattr(options[name], "ndim", None) == 0:  # a number of NumPy or JAX
                options[name] = options[name].item()
            require_kind_of(name, hints[name], options[name])
        defaults = {name: x.parameter.default for name, x in shared.items()}
        return function(*args, **defaults | options)

    if shared:
        call.__signature__ = signature  # type: ignore[attr-defined]
        call.__doc__ = _with_arguments(function.__doc__, shared)
    return cast(F, call)


@dataclass(frozen=True)
class SharedOption:
    """An option that several functions have."""

    parameter: inspect.Parameter
    """Its place in a signature."""
    kind: Any
    """Type."""
    description: str
    """Meaning."""


def shared_options(function: Callable[..., Any]) -> dict[str, SharedOption]:
    """Return the options that a function takes as `**options: Unpack[...]` of a `TypedDict`.

    Args:
        function: a function or a method.
    """
    text = function.__annotations__.get("options", "")
    if not text.startswith("Unpack["):
        return {}
    (group,) = get_args(eval(text, function.__globals__))  # type: ignore[attr-defined]
    return _keys(group)


@cache
def _keys(group: type) -> dict[str, SharedOption]:
    options: dict[str, SharedOption] = {}
    for name, hint in get_type_hints(group, include_extras=True).items():
        kind, description, *default = get_args(hint)
        # The type as it is written, such as Changes, reads better than the type in full.
        expression: Any = ast.parse(group.__annotations__[name].__forward_arg__, mode="eval")
        parameter = inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=default[0] if default else None,
            annotation=ast.unparse(expression.body.slice.elts[0]),
        )
        options[name] = SharedOption(parameter, kind, description)
    return options


def _with_arguments(docstring: str | None, shared: Mapping[str, SharedOption]) -> str:
    """Return a docstring with further entries at the end of its list of arguments."""
    entries = [
        textwrap.fill(
            f"{name}: {x.description}.", 96, initial_indent="    ", subsequent_indent=" " * 8
        )
        for name, x in shared.items()
    ]
    blocks = inspect.cleandoc(docstring or "").split("\n\n")
    sections = [x.partition(":\n")[0] for x in blocks]
    if "Args" in sections:
        blocks[sections.index("Args")] += "\n" + "\n".join(entries)
    else:
        place = sections.index("Raises") if "Raises" in sections else len(blocks)
        blocks.insert(place, "\n".join(["Args:", *entries]))
    return "\n\n".join(blocks)


def options_of(function: Callable[..., Any], defaults: Values) -> dict[str, Option]:
    """Return the options of a function by name; of two of one name that of the outer value.

    Args:
        function: a function or a method with typed keyword parameters.
        defaults: the subject's own values by parameter; `HIDDEN` for one that does not apply.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> def fall(*, height_m: float = 1.0, body: Hopper | None = None) -> None: ...
        >>> [option.path for option in options_of(fall, {"body": Hopper()}).values()][:2]
        ['height_m', 'body.mass_kg']
    """
    hints, texts = hints_of(function), texts_of(function)
    candidates: list[Option] = []
    for name, parameter in inspect.signature(function).parameters.items():
        default = defaults.get(name)
        if parameter.kind is not inspect.Parameter.KEYWORD_ONLY or default is HIDDEN:
            continue
        own_wins = parameter.default is None or dataclasses.is_dataclass(default)
        value = default if own_wins else parameter.default
        if dataclasses.is_dataclass(value):
            candidates += leaves(value, f"{name}.")
            value = None if parameter.default is None else parameter.default
        if (kind := kind_of(hints[name], value)) is not None:
            candidates.append(Option(name, kind, value, texts.get(name, "")))
    return _by_name(candidates)


def _by_name(options: Iterable[Option]) -> dict[str, Option]:
    """Return options by name; of two of one name that of the outer value."""
    by_name: dict[str, Option] = {}
    for option in sorted(options, key=lambda option: option.path.count(".")):
        by_name.setdefault(option.name, option)
    return by_name


def hints_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the annotations, None for a class that only type checkers import.

    Args:
        function: a function or a method.
    """
    hints: dict[str, Any] = {}
    function = inspect.unwrap(getattr(function, "__func__", function))
    for name, text in inspect.get_annotations(function).items():
        hints[name] = None
        with contextlib.suppress(NameError):
            hint = eval(text, function.__globals__) if isinstance(text, str) else text  # type: ignore[attr-defined]
            hints[name] = hint
    return hints | {name: option.kind for name, option in shared_options(function).items()}


def leaves(value: Any, prefix: str = "") -> Iterator[Option]:
    """Yield the fields of a dataclass that words can set, and those of nested dataclasses.

    Args:
        value: the dataclass.
        prefix: the path to it.
    """
    hints = get_type_hints(type(value))
    for field in dataclasses.fields(value):
        value_of_field, path = getattr(value, field.name), f"{prefix}{field.name}"
        if dataclasses.is_dataclass(value_of_field):
            yield from leaves(value_of_field, f"{path}.")
        elif field.init and (kind := kind_of(hints[field.name], value_of_field)) is not None:
            heading = type(value).__name__.removesuffix("Options")
            yield Option(path, kind, value_of_field, field_text(type(value), field.name), heading)


def kind_of(hint: Any, value: Any) -> Any:
    """Return the type that words make, None for a value that they cannot.

    Args:
        hint: the annotation.
        value: the default.

    Example:
        >>> kind_of(float | None, None), kind_of(Sequence[str], ())
        (<class 'float'>, tuple[str, ...])
    """
    choices = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    choices = [x for x in choices if x is not NoneType]
    if isinstance(value, tuple) and value:
        fixed = [x for x in choices if get_origin(x) is tuple and Ellipsis not in get_args(x)]
        (first, *further) = {type(entry) for entry in value}
        homogeneous = tuple[first, ...] if not further and first in _PLAIN else None
        return _made_of_words(fixed[0]) if fixed else homogeneous
    if value is not None and not isinstance(value, tuple):
        literal = [x for x in choices if get_origin(x) is Literal]
        plain = [x for x in choices if _is_plain(x) and isinstance(value, x)]
        if literal or plain:
            return (literal or plain)[0]
    return next((kind for x in choices if (kind := _made_of_words(x)) is not None), None)


def _is_plain(hint: Any) -> bool:
    return isinstance(hint, type) and hint in _PLAIN


def _made_of_words(hint: Any) -> Any:
    if _is_plain(hint) or get_origin(hint) is Literal:
        return hint
    entries = [x for x in get_args(hint) if x is not Ellipsis]
    if get_origin(hint) not in (tuple, list, Sequence):
        return None
    if not entries or not all(map(_is_plain, entries)):
        return None
    several = Ellipsis in get_args(hint) or get_origin(hint) is not tuple
    return tuple[entries[0], ...] if several else hint


def filled(options: Mapping[str, Any], defaults: Values) -> SimpleNamespace:
    """Return options with the subject's own values in place of None.

    Args:
        options: parameters by name, those that are shared in `options`; `self` and private ones
            are left out. Changes of a nested dataclass, a mapping by field, are made to the
            subject's own.
        defaults: own values.

    Raises:
        TegotaeError: for a change of a field that there is not.
    """
    check_jax()
    options, values = {**options, **options.get("options", {})}, dict[str, Any]()
    for name, value in options.items():
        if name in ("self", "options") or name.startswith("_"):
            continue
        default = defaults.get(name)
        if default is HIDDEN and not (value is None or value is False or value == ()):
            fitting = [x for x in options if defaults.get(x) is not HIDDEN]
            raise unknown(f"option of {defaults.get('', 'this')}", name, fitting)
        if value is None and default is not HIDDEN:
            value = default
        elif isinstance(value, Mapping) and dataclasses.is_dataclass(default):
            value = with_options(default, value)
        values[name] = tuple(value) if isinstance(value, list) else value
    return SimpleNamespace(**values)


def with_options(value: T, changes: Mapping[str, Any]) -> T:
    """Return a dataclass with other fields, which may be those of dataclasses in it.

    Args:
        value: the dataclass.
        changes: values by field, or by path; of two of one name the outer one.

    Raises:
        TegotaeError: for an unknown field, or a value that the dataclass refuses.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> with_options(Hopper(), {"mass_kg": 0.2}).mass_kg
        0.2
    """
    options = _by_name(leaves(value))
    kinds = {option.path: option.kind for option in options.values()}
    paths = {name: option.path for name, option in options.items()} | {x: x for x in kinds}
    paths |= {field.name: field.name for field in dataclasses.fields(cast(Any, value))}
    changes = {name: x for name, x in changes.items() if name != "name"}  # of the whole
    for name, replacement in changes.items():
        if name not in paths:
            raise unknown(f"field of a {type(value).__name__}", name, options)
        if paths[name] in kinds:
            kind = kinds[paths[name]]
            if get_origin(kind) is tuple and fits(float, replacement):
                continue  # one number for all entries
            require_kind_of(name, kind | None, replacement)
    return replace(value, {paths[name]: x for name, x in changes.items()})


def changes(options: Any, reference: Any) -> dict[str, Any]:
    """Return the fields in which a dataclass differs from another.

    Args:
        options: the dataclass.
        reference: another one of the same class.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> changes(Hopper(mass_kg=0.2), Hopper())
        {'mass_kg': 0.2}
    """
    values = ((f.name, getattr(options, f.name)) for f in dataclasses.fields(options) if f.init)
    return {name: value for name, value in values if value != getattr(reference, name)}


@cache
def field_text(owner: type, name: str) -> str:
    """Return the meaning of a field: the text below it, or in the list of arguments.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> field_text(Hopper, "mass_kg")
        'Mass of the body per leg, m [kg].'
    """
    for kind in owner.__mro__:
        if name in vars(kind).get("__annotations__", {}):
            parameters = docstring_parser.parse_from_object(kind).params
            text = next((x.description for x in parameters if x.arg_name == name), "")
            return _sentence(text)
    return ""


def description_of(function: Callable[..., Any]) -> str:
    """Return the docstring of a function before its arguments and examples."""
    parsed = docstring_parser.parse(inspect.getdoc(function) or "")
    return "\n\n".join(filter(None, [parsed.short_description, parsed.long_description]))


def texts_of(function: Callable[..., Any]) -> dict[str, str]:
    """Return the descriptions of the parameters of a function by name."""
    parameters = docstring_parser.parse(inspect.getdoc(function) or "").params
    return {x.arg_name: _sentence(x.description) for x in parameters}


def _sentence(text: str | None) -> str:
    text = " ".join((text or "").split())
    return text[:1].upper() + text[1:]
