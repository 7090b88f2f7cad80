"""Where values lie in the buffers that compiled code is called with."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tegotae.lowering.nodes import DTYPES, KINDS

ALIGNMENT = 64
"""Bytes that memory begins at a multiple of: a vector of AVX-512."""


@dataclass(frozen=True)
class Rows:
    """Scalars of these kinds, each a row of as many lanes as one likes; true and false as int32."""

    kinds: tuple[str, ...]

    @cached_property
    def dtypes(self) -> tuple[np.dtype, ...]:
        """The type of each row in memory."""
        return tuple(np.dtype("int32" if k == "bool" else DTYPES[k]) for k in self.kinds)

    @cached_property
    def offsets(self) -> tuple[int, ...]:
        """Where each row begins, in bytes a lane: wide ones first, so that all are aligned."""
        sizes = [dtype.itemsize for dtype in self.dtypes]
        ends = {size: sum(x for x in sizes if x > size) for size in sizes}
        offsets = []
        for size in sizes:
            offsets.append(ends[size])
            ends[size] += size
        return tuple(offsets)

    @cached_property
    def size(self) -> int:
        """Bytes a lane of all rows, a multiple of the widest one's."""
        sizes = [dtype.itemsize for dtype in self.dtypes]
        widest = max(sizes, default=1)
        return -(-sum(sizes) // widest) * widest

    def memory(self, lanes: int, times: int = 1) -> np.ndarray:
        """Bytes for all rows of so many lanes, so many times."""
        return aligned(self.size * lanes * times)

    def view(
        self, memory: np.ndarray, first: int, last: int, lanes: int, times: int = 1
    ) -> np.ndarray:
        """Rows that follow each other, of one type: [times, rows, lanes]."""
        if first == last:
            return np.empty((times, 0, lanes))
        dtype = self.dtypes[first]
        row = dtype.itemsize * lanes
        return np.ndarray(
            (times, last - first, lanes),
            dtype,
            memory.data,
            self.offsets[first] * lanes,
            (self.size * lanes, row, dtype.itemsize),
        )


def aligned(size: int) -> np.ndarray:
    """So many bytes of memory, which begin where a vector may."""
    memory = np.empty(size + ALIGNMENT, np.uint8)
    offset = -memory.ctypes.data % ALIGNMENT
    return memory[offset : offset + size]


class Entry(NamedTuple):
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
    """

    entries: tuple[Entry, ...]

    @property
    def rows(self) -> Rows:
        """All scalars, in their order."""
        return Rows(tuple(KINDS[e.dtype] for e in self.entries for _ in range(math.prod(e.shape))))

    def memory(self) -> np.ndarray:
        """Memory for it, all zero."""
        memory = self.rows.memory(1)
        memory[:] = 0
        return memory

    def views(self, memory: np.ndarray) -> dict[str, np.ndarray]:
        """The arrays in memory, by name: written to and read from in place."""
        offsets, views, first = self.rows.offsets, {}, 0
        for entry in self.entries:
            dtype = "int32" if entry.dtype == "bool" else entry.dtype
            views[entry.name] = np.ndarray(entry.shape, dtype, memory.data, offsets[first])
            first += math.prod(entry.shape)
        return views


@dataclass(frozen=True)
class StepLayout:
    """Memory of a function of state and inputs."""

    state: MemoryLayout
    """What a step hands to the next; every entry is named by its path in the pytree."""
    inputs: MemoryLayout
    """What it takes."""
    outputs: MemoryLayout
    """What it gives."""

    def __iter__(self) -> Iterator[MemoryLayout]:
        return iter((self.state, self.inputs, self.outputs))
