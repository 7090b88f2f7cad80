"""What cannot become code, by its name and place."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tegotae._support.errors import TegotaeError

if TYPE_CHECKING:
    from tegotae.lowering.places import Place


class CannotLower(TegotaeError):  # noqa: N818 - it says what cannot be done
    """An operation that has no native code: which, and where it was written.

    Args:
        operation: its name in a trace, or other words that name it.
        place: the line of the program, if that is known.
        why: what about it, if not all of it.

    Example:
        >>> print(CannotLower("sort"))
        'sort' has no native code
    """

    def __init__(self, operation: str, place: Place | None = None, why: str = "") -> None:
        named = repr(operation) if operation.isidentifier() else operation
        where = "" if place is None else f" ({place.file.name}, line {place.line})"
        super().__init__(f"{named}{where} has no native code{why and ': '}{why}")
        self.operation, self.place, self.why = operation, place, why
