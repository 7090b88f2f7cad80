"""Errors that a user can act on, packages that an extra brings, and what borders check."""

from __future__ import annotations

import difflib
import importlib
import math
import operator
import reprlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType
from typing import TypeVar

T = TypeVar("T")

_LONGEST = 600
"""Longest message [characters]."""


class TegotaeError(ValueError):
    """Input that cannot be used: what is wrong, which value, what would be right, in one line.

    Of a message that quotes a very long value the middle is left out.
    """

    __module__ = "tegotae"  # where users find it

    def __init__(self, message: str) -> None:
        super().__init__(shortened(message))


def shortened(text: str) -> str:
    """Return a text without its middle if it is longer than a message may be.

    Example:
        >>> len(shortened("a" * 5000))
        600
    """
    half = (_LONGEST - 3) // 2
    return text if len(text) <= _LONGEST else f"{text[: half + 1]}...{text[-half:]}"


def require_finite(
    name: str,
    value: float,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> None:
    """Raise `TegotaeError` unless `value` is a finite number, `> above`, `>= least`, `<= most`."""
    try:
        number = float(value)
    except OverflowError:  # of a whole number beyond all floats
        raise TegotaeError(f"{name} is {_short(int(value))}, which is too large") from None
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} is {reprlib.repr(value)}; it must be a number") from None
    if not math.isfinite(number):
        raise TegotaeError(f"{name} is {number}; it must be finite")
    if above is not None and not number > above:
        raise TegotaeError(f"{name} is {number:g}; it must be greater than {above:g}")
    if least is not None and not number >= least:
        raise TegotaeError(f"{name} is {number:g}; it must be at least {least:g}")
    if most is not None and not number <= most:
        raise TegotaeError(f"{name} is {number:g}; it must be at most {most:g}")


def require_kind(name: str, value: object, kind: type, right: str) -> None:
    """Raise `TegotaeError` unless `value` is a `kind`, which is called `right`: "a Coupling"."""
    if not isinstance(value, kind):
        raise TegotaeError(f"{name} is {value!r}; it must be {right}")


def require_count(name: str, value: int, *, least: int = 1, most: int | None = None) -> None:
    """Raise `TegotaeError` unless `value` is a whole number from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise TegotaeError(f"{name} is {value!r}; it must be a whole number of at least {least}")
    if most is not None and value > most:
        raise TegotaeError(f"{name} is {_short(value)}; it must be at most {most}")


def whole_numbers(name: str, values: Iterable[int]) -> tuple[int, ...]:
    """Return the values as a tuple, which unlike a list can be hashed.

    Raises:
        TegotaeError: unless they are whole numbers.

    Example:
        >>> whole_numbers("wiring", [1, 0])
        (1, 0)
    """
    try:
        numbers = tuple(operator.index(value) for value in values)
    except TypeError:
        raise TegotaeError(
            f"{name} is {reprlib.repr(values)}; it must be whole numbers, such as (0, 1)"
        ) from None
    return numbers


def _short(value: int) -> str:
    """Return a whole number of any length as text; Python refuses to write one of thousands of
    digits.
    """
    return str(value) if value.bit_length() < 100 else f"about 2^{value.bit_length()}"


def is_of(value: object, kind: type) -> bool:
    """Return whether a value is an instance of a class: for user input, which annotations do not
    check.

    Example:
        >>> is_of(True, int), is_of("one", int)
        (True, False)
    """
    return isinstance(value, kind)


def formatted(error: BaseException) -> str:
    """Return another library's error in short: its kind and its first line.

    Example:
        >>> formatted(ValueError("no leg")), formatted(SystemExit(0))
        ('ValueError: no leg', 'SystemExit: it ends the program')
    """
    ends = isinstance(error, SystemExit)
    first = "it ends the program" if ends else (str(error).splitlines() or [""])[0]
    return f"{type(error).__name__}: {first}"


@contextmanager
def other_code(outcome: str) -> Iterator[None]:
    """Convert any exception of foreign code into a `TegotaeError`: the outcome, and then the
    reason.

    Args:
        outcome: what has come of it, such as "robot.py:body cannot be made".

    Example:
        >>> with other_code("mine.py:leg cannot be made"):
        ...     1 / 0
        Traceback (most recent call last):
        tegotae.TegotaeError: mine.py:leg cannot be made: ZeroDivisionError: division by zero
    """
    try:
        yield
    except TegotaeError as error:
        raise TegotaeError(f"{outcome}: {error}") from None
    except (Exception, SystemExit) as error:
        raise TegotaeError(f"{outcome}: {formatted(error)}") from None


def unknown(kind: str, name: str, names: Iterable[str]) -> TegotaeError:
    """Return the error for an unknown name, with the nearest known names.

    A name that differs from a known one in capitals alone is the nearest. The hyphens that an
    option begins with do not count.

    Example:
        >>> print(unknown("model", "art", ["AR", "ART", "V"]))
        no model is called 'art'; did you mean ART, AR?
    """
    names = list(dict.fromkeys(names))
    by_letters: dict[str, list[str]] = {}
    for candidate in names:
        by_letters.setdefault(candidate.lower().lstrip("-"), []).append(candidate)
    letters = name.lower().lstrip("-")[:100]
    near = difflib.get_close_matches(letters, by_letters, n=3, cutoff=0.3)
    # Of two that differ in capitals alone, the one written more like it comes first.
    matches = (difflib.get_close_matches(name[:100], by_letters[x], n=3, cutoff=0.0) for x in near)
    close = [candidate for group in matches for candidate in group][:3]
    listed = f"{'some that are' if len(names) > 12 else 'known'}: {', '.join(names[:12])}"
    hint = f"did you mean {', '.join(close)}?" if close else listed if names else "there is none"
    return TegotaeError(f"no {kind} is called {reprlib.repr(name)}; {hint}")


def require_known(kind: str, name: object, names: Collection[object]) -> None:
    """Raise `TegotaeError` unless a name is among the known ones, with the nearest of them.

    Args:
        kind: what is named, such as "leg of this body".
        name: the name.
        names: the known ones.
    """
    if name not in names:
        raise unknown(kind, str(name), map(str, names))


def lookup(kind: str, name: str, table: Mapping[str, T]) -> T:
    """Return the entry of a table by its name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> lookup("leg", "left", {"left": 0, "right": 1})
        0
    """
    require_known(kind, name, table)
    return table[name]


_CPU_TORCH = "pip install torch --index-url https://download.pytorch.org/whl/cpu"
"""Torch for the CPU; on Linux, what the extra sb3 installs by itself has CUDA, too."""


class MissingExtraError(TegotaeError, ImportError):
    """An optional package is not installed: says which extra of tegotae installs it."""


def require(module: str, extra: str) -> ModuleType:
    """Import and return an optional module.

    Raises:
        MissingExtraError: if it, or a package that it needs, is not installed.

    Example:
        >>> try:
        ...     require("no_such_module", "gym")
        ... except MissingExtraError as error:
        ...     print(error)
        no_such_module is not installed; pip install 'tegotae[gym]', or in a clone \
pip install '.[gym]'
    """
    require_all({module: extra})
    return importlib.import_module(module)


def require_all(extras: Mapping[str, str]) -> None:
    """Import optional modules, given with their extras.

    Raises:
        MissingExtraError: one for all that are not installed.

    Example:
        >>> require_all({"json": "gym", "no_module": "gym", "nor_this": "mujoco"})
        Traceback (most recent call last):
        tegotae._support.errors.MissingExtraError: no_module, nor_this are not \
installed; pip install 'tegotae[gym,mujoco]', or in a clone pip install '.[gym,mujoco]'
    """
    missing: dict[str, str] = {}
    for module, extra in extras.items():
        try:
            importlib.import_module(module)
        except ModuleNotFoundError as error:
            missing[str(error.name)] = extra
    if missing:
        are = "is" if len(missing) == 1 else "are"
        command = how_to_install(*dict.fromkeys(missing.values()))
        raise MissingExtraError(f"{', '.join(missing)} {are} not installed; {command}")


def how_to_install(*extras: str) -> str:
    """Return the commands that install extras for an installed package, and for a clone.

    Example:
        >>> how_to_install("gym", "mujoco")
        "pip install 'tegotae[gym,mujoco]', or in a clone pip install '.[gym,mujoco]'"
    """
    names = ",".join(extras)
    command = f"pip install 'tegotae[{names}]', or in a clone pip install '.[{names}]'"
    if "sb3" in extras:
        return f"{_CPU_TORCH} (by default torch is several GB, for GPUs), then {command}"
    return command
