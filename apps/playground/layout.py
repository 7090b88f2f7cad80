"""Layout of a lane's numbers: one block of four-byte words, named."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class LayoutEntry:
    """Some words of a lane.

    Args:
        name: what they are, such as "body.mass_kg" or "channel.height_m".
        words: how many: one a limb, or a weight.
        kind: their type in a trace: "float32", "bool", which is kept as 0 or 1, or "int32".
    """

    name: str
    words: int
    kind: str = "float32"

    @property
    def member(self) -> str:
        """Name as a member of a struct of C."""
        return self.name.replace(".", "_")


@dataclass(frozen=True)
class Layout:
    """The block of a lane, entry after entry.

    Example:
        >>> layout = Layout((LayoutEntry("omega", 2), LayoutEntry("body.mass_kg", 1)))
        >>> layout.offsets(), layout.words
        ({'omega': 0, 'body.mass_kg': 2}, 3)
    """

    entries: tuple[LayoutEntry, ...]

    @property
    def words(self) -> int:
        """Number of words of a lane."""
        return sum(entry.words for entry in self.entries)

    def offsets(self) -> dict[str, int]:
        """Return the offset of each entry, in words."""
        offsets, position = {}, 0
        for entry in self.entries:
            offsets[entry.name] = position
            position += entry.words
        return offsets

    def document(self) -> dict[str, list[int]]:
        """Return the offset and the number of words of each entry, by name, for a page."""
        offsets = self.offsets()
        return {entry.name: [offsets[entry.name], entry.words] for entry in self.entries}

    def struct(self) -> str:
        """Return the block as a struct of C."""
        kinds = {"int32": "int32_t"}
        fields = "".join(
            f"    {kinds.get(entry.kind, 'float')} {entry.member}[{entry.words}];\n"
            for entry in self.entries
        )
        return f"typedef struct {{\n{fields}}} lane_block;\n"


def word_expressions(entry: LayoutEntry) -> list[str]:
    """Return the C expression of each word of an entry; a bool is true unless zero."""
    words = [f"l->{entry.member}[{i}]" for i in range(entry.words)]
    return [f"({word} != 0.0f)" for word in words] if entry.kind == "bool" else words


def merge_layouts(groups: Iterable[Iterable[LayoutEntry]]) -> Layout:
    """Merge layouts into one of all entries, group after group."""
    return Layout(tuple(entry for group in groups for entry in group))
