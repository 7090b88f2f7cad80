"""Conditions as they are written on a command line."""

from __future__ import annotations

from collections.abc import Iterable

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import number
from tegotae.simulation.world import Condition, OneOf, Uniform

_TIMES = ("from_s", "until_s")
_HOW = (
    "write NAME=LOW:HIGH, NAME=VALUE/VALUE or, limb by limb, NAME=1,1/0,1, and @FROM:UNTIL behind "
    "it if it holds for a time only"
)


def conditions_named(texts: Iterable[str]) -> tuple[Condition, ...]:
    """The conditions of `--vary`.

    Raises:
        TegotaeError: for a text that is none.

    Example:
        >>> conditions_named(["mass_kg=0.08:0.12"])
        (Uniform(name='mass_kg', from_s=0.0, until_s=None, low=0.08, high=0.12),)
        >>> conditions_named(["push_x_n=-5/5@8:8.2"])
        (OneOf(name='push_x_n', from_s=8.0, until_s=8.2, values=(-5.0, 5.0)),)
    """
    return tuple(map(_condition, texts))


def _condition(text: str) -> Condition:
    name, _, rest = text.partition("=")
    values, at, times = rest.partition("@")
    try:
        numbers = [number(each) for each in times.split(":")] if at else []
        if len(numbers) > len(_TIMES):
            raise ValueError
        window: dict[str, float] = dict(zip(_TIMES, numbers, strict=False))
        return _drawn(name, values, window)
    except ValueError as error:
        if isinstance(error, TegotaeError):
            raise
        raise TegotaeError(f"--vary {text} is no condition; {_HOW}") from None


def _drawn(name: str, values: str, window: dict[str, float]) -> Condition:
    if ":" in values:
        low, high = map(number, values.split(":"))
        return Uniform(name, low=low, high=high, **window)
    rows = [tuple(map(number, each.split(","))) for each in values.split("/")]
    if all(len(row) == 1 for row in rows):
        return OneOf(name, values=tuple(number for (number,) in rows), **window)
    return OneOf(name, values=tuple(rows), **window)
