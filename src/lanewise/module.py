"""A program of lanes as a module of LLVM: once a run, once an episode, and the loop of ticks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lanewise.emit import Emitter
from lanewise.machine import Target
from lanewise.nodes import DTYPES, LANE, UNIFORM, Node
from lanewise.placement import Stages
from lanewise.writer import FunctionWriter, module_text

Address = tuple[str, int, bool]
_ALIGNMENT = 64
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
        """Offsets of the rows in bytes per lane: wide ones first, so that all are aligned."""
        sizes = [dtype.itemsize for dtype in self.dtypes]
        return _wide_first(sizes, sizes)

    @cached_property
    def size(self) -> int:
        """Size of all rows of a lane [bytes], a multiple of that of the widest row."""
        sizes = [dtype.itemsize for dtype in self.dtypes]
        widest = max(sizes, default=1)
        return -(-sum(sizes) // widest) * widest

    def memory(self, lanes: int) -> np.ndarray:
        """Return memory for all rows of so many lanes."""
        return aligned(self.size * lanes)

    def view(self, memory: np.ndarray, first: int, last: int, lanes: int) -> np.ndarray:
        """Return consecutive rows of one type: [rows, lanes]."""
        if first == last:
            return np.empty((0, lanes))
        shape = last - first, lanes
        return np.ndarray(shape, self.dtypes[first], memory.data, self.offsets[first] * lanes)


@dataclass(frozen=True)
class RecordedArrays:
    """Arrays of so many scalars of one kind, recorded frame by frame; true and false as int32.

    Each is whole in memory, [frames, scalars, lanes]: a summary takes it as it is.

    Args:
        kinds: of each array.
        scalars: how many a lane has of each in a frame.
    """

    kinds: tuple[str, ...]
    scalars: tuple[int, ...]

    @cached_property
    def dtypes(self) -> tuple[np.dtype, ...]:
        """The type of each array in memory."""
        return Rows(self.kinds).dtypes

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Size of each array per lane and frame [bytes]."""
        pairs = zip(self.dtypes, self.scalars, strict=True)
        return tuple(dtype.itemsize * scalars for dtype, scalars in pairs)

    @cached_property
    def offsets(self) -> tuple[int, ...]:
        """Offsets of the arrays in bytes per lane and frame: wide ones first, so that all are
        aligned."""
        return _wide_first(self.sizes, [dtype.itemsize for dtype in self.dtypes])

    @property
    def size(self) -> int:
        """Size of all arrays per lane and frame [bytes]."""
        return sum(self.sizes)

    def memory(self, frames: int, lanes: int) -> np.ndarray:
        """Return memory for all arrays."""
        return aligned(self.size * frames * lanes)

    def views(self, memory: np.ndarray, frames: int, lanes: int) -> list[np.ndarray]:
        """Return the arrays, [frames, scalars, lanes]."""
        return [
            np.ndarray((frames, scalars, lanes), dtype, memory.data, offset * frames * lanes)
            for scalars, dtype, offset in zip(self.scalars, self.dtypes, self.offsets, strict=True)
        ]


def _wide_first(sizes: Sequence[int], widths: Sequence[int]) -> tuple[int, ...]:
    """Return the offsets of items of these sizes, ordered by the widths of their numbers."""
    offsets, end = [0] * len(sizes), 0
    for i in sorted(range(len(sizes)), key=lambda i: -widths[i]):
        offsets[i], end = end, end + sizes[i]
    return tuple(offsets)


def aligned(size: int) -> np.ndarray:
    """Return so many bytes of memory, aligned for vectors."""
    memory = np.empty(size + _ALIGNMENT, np.uint8)
    offset = -memory.ctypes.data % _ALIGNMENT
    return memory[offset : offset + size]


@dataclass(frozen=True)
class EpisodeModule:
    """The code of a program of lanes.

    Its functions, of which pointers are to memory that begins at multiples of 64 bytes:

    - `uniform(shared, uniform)`: what all lanes share, eight bytes a number;
    - `start(lanes, uniform, invariant, state)`: a block's release;
    - `episode(lanes, uniform, invariant, state, out, frames, ticks, row, column)`: its frames,
      written at a column of rows of so many lanes.

    Args:
        stages: the program.
        lanes: kinds of what is given lane by lane.
        recorded: the arrays that its channels make, in their order.
        target: the processor.
        dtype: the type of its numbers.
        vectors: vectors of a block.
    """

    stages: Stages
    lanes: tuple[str, ...]
    recorded: RecordedArrays
    target: Target
    dtype: str
    vectors: int

    @property
    def width(self) -> int:
        """Lanes of a vector."""
        return self.target.lanes_of_vector(self.dtype)

    @property
    def block(self) -> int:
        """Lanes of a block."""
        return self.width * self.vectors

    @cached_property
    def lane_rows(self) -> Rows:
        """Rows of the inputs."""
        return Rows(self.lanes)

    @cached_property
    def state_rows(self) -> Rows:
        """Rows of the state."""
        return Rows(tuple(self.stages.start[slot].kind for slot in self.stages.slots))

    @cached_property
    def invariant_rows(self) -> Rows:
        """Rows of values that a block computes once."""
        return Rows(tuple(node.kind for node in self.stages.invariant))

    def text(self) -> str:
        """Return the module in LLVM's language."""
        declared: set[str] = set()
        functions = (
            self._start(FunctionWriter(self.width, declared)),
            self._episode(FunctionWriter(self.width, declared)),
            self._uniform(FunctionWriter(1, declared)),
        )
        bits = self.target.vector_bits
        wide = f'"prefer-vector-width"="{bits}" "min-legal-vector-width"="{bits}" ' if bits else ""
        return module_text(functions, declared, wide)

    @cached_property
    def _shared(self) -> dict[Node, int]:
        return {node: 8 * i for i, node in enumerate(self.stages.uniform)}

    @property
    def uniform_bytes(self) -> int:
        """Memory for values that all lanes share."""
        return 8 * len(self.stages.uniform)

    @cached_property
    def _invariant_offsets(self) -> dict[Node, int]:
        offsets = self.invariant_rows.offsets
        return {n: self.block * offsets[i] for i, n in enumerate(self.stages.invariant)}

    def _uniform(self, w: FunctionWriter) -> str:
        def leaf(node: Node) -> Address | None:
            is_input = node.operation == "given" and node.detail[0] == "shared"
            return ("%shared", 8 * node.detail[1], False) if is_input else None

        emitted = Emitter(w, 1, self.stages.uniform, leaf)
        for node, offset in self._shared.items():
            w.store("%uniform", offset, node.kind, *emitted.values(node))
        return w.function("@uniform(ptr %shared, ptr %uniform)")

    def _input_address(self, node: Node) -> Address:
        return "%lanes", self.block * self.lane_rows.offsets[node.detail[1]], False

    def _start(self, w: FunctionWriter) -> str:
        stages = self.stages

        def leaf(node: Node) -> Address | None:
            if node.stage == UNIFORM:
                return "%uniform", self._shared[node], True
            return self._input_address(node) if node.operation == "given" else None

        released = [stages.start[slot] for slot in stages.slots]
        emitted = Emitter(w, self.vectors, (*stages.invariant, *released), leaf)
        for node, offset in self._invariant_offsets.items():
            w.store("%invariant", offset, node.kind, *emitted.values(node))
        self._store_state(w, released, emitted)
        return w.function("@start(ptr %lanes, ptr %uniform, ptr %invariant, ptr %state)")

    def _episode(self, w: FunctionWriter) -> str:
        stages = self.stages
        w.go("frame")
        w.begin("frame")
        w.also("%f = phi i64 [ 0, %entry ], [ %next.f, %recorded ]")
        w.also("%first64 = mul i64 %f, %ticks")
        w.also("%first = trunc i64 %first64 to i32")
        w.also("%count = trunc i64 %ticks to i32")
        w.also("%end = add i32 %first, %count")
        w.go("tick")
        w.begin("tick")
        w.also("%index = phi i32 [ %first, %frame ], [ %next.index, %ticked ]")
        next_state = [stages.tick[slot] for slot in stages.slots]
        self._store_state(w, next_state, Emitter(w, self.vectors, next_state, self._leaf("%index")))
        w.go("ticked")
        w.begin("ticked")
        w.also("%next.index = add i32 %index, 1")
        w.also("%more = icmp slt i32 %next.index, %end")
        w.go_if("%more", "tick", "record")
        w.begin("record")
        w.also("%last = sub i32 %end, 1")
        again = [stages.frame[slot] for slot in stages.slots]
        emitted = Emitter(w, self.vectors, (*stages.channels, *again), self._leaf("%last"))
        self._record(w, emitted)
        self._store_state(w, again, emitted)
        w.go("recorded")
        w.begin("recorded")
        w.also("%next.f = add i64 %f, 1")
        w.also("%on = icmp slt i64 %next.f, %frames")
        w.go_if("%on", "frame", "stop")
        w.begin("stop")
        return w.function(
            "@episode(ptr %lanes, ptr %uniform, ptr %invariant, ptr %state, ptr %out, "
            "i64 %frames, i64 %ticks, i64 %row, i64 %column)"
        )

    def _leaf(self, index: str) -> Callable[[Node], Address | str | None]:
        """Return a lookup of values that were computed before the loop of ticks."""
        offsets = self.state_rows.offsets
        place = {slot: self.block * offsets[i] for i, slot in enumerate(self.stages.slots)}

        def leaf(node: Node) -> Address | str | None:
            if node.stage == UNIFORM:
                return "%uniform", self._shared[node], True
            if node.stage == LANE and node.operation == "given":
                return self._input_address(node)
            if node.stage == LANE:
                return "%invariant", self._invariant_offsets[node], False
            if node.operation != "given":
                return None
            name, number = node.detail
            return index if name == "index" else ("%state", place[number], False)

        return leaf

    def _record(self, w: FunctionWriter, emitted: Emitter) -> None:
        arrays, nodes = self.recorded, iter(self.stages.channels)
        for scalars, dtype, offset, size in zip(
            arrays.scalars, arrays.dtypes, arrays.offsets, arrays.sizes, strict=True
        ):
            begin = w.do(f"mul i64 %frames, {offset}")
            frame = w.do(f"add i64 {begin}, {w.do(f'mul i64 %f, {size}')}")
            column = w.do(f"mul i64 %column, {dtype.itemsize}")
            for number in range(scalars):
                byte = w.do(f"add i64 {frame}, {number * dtype.itemsize}")
                place = w.do(f"add i64 {w.do(f'mul i64 {byte}, %row')}, {column}")
                base = w.do(f"getelementptr i8, ptr %out, i64 {place}")
                node = next(nodes)
                w.store(base, 0, node.kind, *emitted.values(node))

    def _store_state(self, w: FunctionWriter, nodes: Sequence[Node], emitted: Emitter) -> None:
        """Store the state, once all of it is known."""
        values = [emitted.values(node) for node in nodes]
        for i, (node, registers) in enumerate(zip(nodes, values, strict=True)):
            slot = self.stages.slots[i]
            if node.operation == "given" and node.detail == ("state", slot):
                continue  # it stays as it is
            w.store("%state", self.block * self.state_rows.offsets[i], node.kind, *registers)
