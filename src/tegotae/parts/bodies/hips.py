"""Where the hips of a frame are: checked numbers around its middle."""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

from tegotae._support.errors import TegotaeError, require_finite


def hips_at(name: str, value: object, wanted: str) -> tuple[float, ...]:
    """The places as a tuple: of a list, say.

    Args:
        name: what they are called.
        value: what was given.
        wanted: what would be right, such as "two to four places, such as (-0.5, 0.5)".

    Raises:
        TegotaeError: unless they are finite numbers.

    Example:
        >>> hips_at("hips_m", [-1, 1], "two places")
        (-1, 1)
    """
    if not isinstance(value, Iterable) or isinstance(value, str):
        raise TegotaeError(f"{name} is {value!r}; name {wanted}")
    found = tuple(cast(Iterable[float], value))
    for hip in found:
        require_finite("a hip", hip)
    return found


def require_level(name: str, hips: tuple[float, ...], body: str) -> None:
    """Raise `TegotaeError` unless the hips' mean is zero, so that the body rests level.

    Example:
        >>> require_level("hips_m", (-0.5, 0.7), "bar")
        Traceback (most recent call last):
        ...
        tegotae.TegotaeError: hips_m is (-0.5, 0.7), whose mean is 0.1; it must be 0, for \
the bar to rest level
    """
    if abs(sum(hips)) > 1e-6 * max(map(abs, hips)):
        raise TegotaeError(
            f"{name} is {hips}, whose mean is {sum(hips) / len(hips):g}; it must be 0, for the "
            f"{body} to rest level"
        )
