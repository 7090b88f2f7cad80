"""Names, types and shapes of what a compiled function takes and gives; needs no JAX."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from tegotae.lowering.buffers import Rows
from tegotae.lowering.nodes import KINDS

_Written = Iterable[tuple[str, str, Iterable[int]]]
"""A layout as JSON values: of each array its name, type and shape."""


@dataclass(frozen=True)
class Entry:
    """An array of a layout.

    Args:
        name: its path, such as "oscillator.phase".
        dtype: its type in a trace.
        shape: its shape.
    """

    name: str
    dtype: str
    shape: tuple[int, ...]


@dataclass(frozen=True)
class MemoryLayout:
    """Arrays in memory, one after the other, true and false as int32.

    Example:
        >>> layout = MemoryLayout((Entry("x", "float32", (2,)), Entry("on", "bool", ())))
        >>> memory = layout.memory()
        >>> {name: array.shape for name, array in layout.views(memory).items()}
        {'x': (2,), 'on': ()}
        >>> MemoryLayout.of_document(layout.document()) == layout
        True
    """

    entries: tuple[Entry, ...]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of all scalars, in their order."""
        return tuple(KINDS[e.dtype] for e in self.entries for _ in range(math.prod(e.shape)))

    def memory(self) -> np.ndarray:
        """Memory for it, all zero."""
        memory = Rows(self.kinds).memory(1)
        memory[:] = 0
        return memory

    def views(self, memory: np.ndarray) -> dict[str, np.ndarray]:
        """The arrays in memory, by name: written to and read from in place."""
        offsets, found, first = Rows(self.kinds).offsets, {}, 0
        for entry in self.entries:
            dtype = "int32" if entry.dtype == "bool" else entry.dtype
            found[entry.name] = np.ndarray(entry.shape, dtype, memory.data, offsets[first])
            first += math.prod(entry.shape)
        return found

    def document(self) -> list[list[str | list[int]]]:
        """Plain JSON values that say the same."""
        return [[e.name, e.dtype, list(e.shape)] for e in self.entries]

    @classmethod
    def of_document(cls, document: _Written) -> MemoryLayout:
        """The layout of such values."""
        return cls(tuple(Entry(name, dtype, tuple(shape)) for name, dtype, shape in document))
