"""The one exception that this package raises for input it cannot use."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable


class TegotaeError(ValueError):
    """Input that cannot be used: what is wrong, which value, what would be right, in one line."""


def require_finite(
    name: str, value: float, *, above: float | None = None, least: float | None = None
) -> None:
    """Raise `TegotaeError` unless `value` is a finite number, `> above` and `>= least`."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} is {value!r}; it must be a number") from None
    if not math.isfinite(number):
        raise TegotaeError(f"{name} is {number}; it must be finite")
    if above is not None and not number > above:
        raise TegotaeError(f"{name} is {number:g}; it must be greater than {above:g}")
    if least is not None and not number >= least:
        raise TegotaeError(f"{name} is {number:g}; it must be at least {least:g}")


def require_count(name: str, value: int, *, least: int = 1) -> None:
    """Raise `TegotaeError` unless `value` is a whole number of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise TegotaeError(f"{name} is {value!r}; it must be a whole number of at least {least}")


def unknown(kind: str, name: str, known: Iterable[str]) -> TegotaeError:
    """The error for a name that is not known, with the nearest names that are."""
    known = list(known)
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.3)
    listed = f"{'some that are' if len(known) > 12 else 'known'}: {', '.join(known[:12])}"
    hint = f"did you mean {', '.join(close)}?" if close else listed
    return TegotaeError(f"no {kind} is called {name!r}; {hint}")
