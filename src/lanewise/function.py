"""A function of one lane, such as a controller's tick, as native code that needs no JAX to run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import jax
import msgspec

from lanewise.emit import Emitter
from lanewise.machine import (
    Code,
    Fields,
    NativeStep,
    StepLayout,
    Store,
    Target,
    memory_type,
    object_file,
    sealed,
    target_of,
)
from lanewise.native_reader import NativeReader, given_arrays
from lanewise.nodes import Node, Tree, scalars
from lanewise.writer import FunctionWriter, module_text


@dataclass(frozen=True)
class FunctionKernel:
    """A compiled function: how its memory is laid out, and its code.

    The code is one function in C's way of calling, `void step(void *state, const void *inputs, void
    *outputs)`, of which each pointer is to memory that the layout describes.
    """

    layout: StepLayout
    text: str = field(repr=False)
    """The code in LLVM's language."""
    target: str = "scalar"
    """The processor of this machine that it is for, with or without vectors."""

    def step(self, store: Store | None = None) -> NativeStep:
        """Return the function as a callable of this process, its code taken from a store."""
        code = Code.compiled(self.text, target_of(self.target), store=store)
        return NativeStep(code, self.layout)

    def to_bytes(self, target: str | Target = "portable") -> bytes:
        """Return layout and code for a processor, with a checksum, as bytes that `load_step`
        reads without JAX.
        """
        code = object_file(self.text, target_of(target))
        return sealed(msgspec.msgpack.encode((self.layout, code)))


def compile_function(
    function: Callable[[Tree, Tree], tuple[Tree, Tree]],
    state: Tree,
    inputs: Tree,
    *,
    dtype: str = "float32",
    lanes: int = 0,
) -> FunctionKernel:
    """Compile a function of one lane, or of several side by side, to native code.

    Args:
        function: of (state, inputs): the new state, of the same structure, and outputs; all are
            pytrees of arrays. What it closes over, such as weights, becomes part of the code.
        state: a state, as arrays or `jax.ShapeDtypeStruct`.
        inputs: inputs likewise.
        dtype: "float32" or "float64": whether the function is traced with double precision.
        lanes: how many lanes are stepped at once: arrays [..., 1] of one lane then stand for
            [..., lanes] in memory, numbers for what all share, and the last vector is filled up.
            The function must be elementwise over lanes, its arrays of four bytes an entry. 0 takes
            arrays as they are.

    Raises:
        CannotLower: for an operation that has no native code, by its name and place.

    Example:
        >>> import numpy as np
        >>> def mean(state, inputs):
        ...     new = {"mean": 0.5 * (state["mean"] + inputs["x"])}
        ...     return new, {"doubled": 2.0 * new["mean"]}
        >>> zero = np.float32(0.0)
        >>> step = compile_function(mean, {"mean": zero}, {"x": zero}).step()
        >>> step.inputs["x"][...] = 3.0
        >>> step()
        >>> float(step.outputs["doubled"])
        3.0
    """
    with jax.enable_x64(dtype == "float64"):
        trace, (result, outputs) = jax.make_jaxpr(function, return_shape=True)(state, inputs)
        layout = _fields(state), _fields(inputs), _fields(outputs)
        assert _fields(result) == layout[0], "the new state differs from the old in its shape"
        arrays = [*given_arrays("state", state), *given_arrays("inputs", inputs)]
        results = scalars(NativeReader().read(trace, arrays))
    if not lanes:
        return FunctionKernel(layout, _text(results, layout))
    width = target_of("host").lanes_of_vector(dtype)
    filled_up = -(-lanes // width) * width
    state, inputs, outputs = (_with_lanes(fields, filled_up) for fields in layout)
    layout = state, inputs, outputs
    return FunctionKernel(layout, _text(results, layout, width, filled_up), "host")


def _with_lanes(fields: Fields, lanes: int) -> Fields:
    return tuple(
        (name, dtype, (*shape[:-1], lanes) if shape else ()) for name, dtype, shape in fields
    )


def _fields(tree: Tree) -> Fields:
    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return tuple(
        (jax.tree_util.keystr(path, simple=True, separator="."), str(x.dtype), x.shape)
        for path, x in leaves
    )


def _text(results: Sequence[Node], layout: StepLayout, width: int = 1, lanes: int = 0) -> str:
    """Return the text of a module that loads, computes, and then stores its results, vector by
    vector.
    """
    declared: set[str] = set()
    w = FunctionWriter(width, declared, alignment=4 if lanes else 64)
    names = ("state", "inputs", "outputs")
    places = {
        name: _places(fields, lanes, f"%{name}") for name, fields in zip(names, layout, strict=True)
    }

    def leaf(node: Node) -> tuple[str, int, bool] | None:
        if node.operation != "given" or node.detail[0] not in places:
            return None
        name, number = node.detail
        return places[name][number]

    if lanes:
        w.go("lanes")
        w.begin("lanes")
        w.also("%lane = phi i64 [ 0, %entry ], [ %next, %stepped ]")
        w.also("%bytes = mul i64 %lane, 4")
        for name in names:
            w.also(f"%{name}.here = getelementptr i8, ptr %{name}, i64 %bytes")
    emitted = Emitter(w, 1, results, leaf)
    values = [emitted.values(node)[0] for node in results]
    ends = [place for name in ("state", "outputs") for place in places[name]]
    for (base, offset, _), node, value in zip(ends, results, values, strict=True):
        w.store(base, offset, node.kind, value)
    wide = ""
    if lanes:
        w.go("stepped")
        w.begin("stepped")
        w.also(f"%next = add i64 %lane, {width}")
        w.also(f"%more = icmp slt i64 %next, {lanes}")
        w.go_if("%more", "lanes", "end")
        w.begin("end")
        bits = target_of("host").vector_bits
        wide = f'"prefer-vector-width"="{bits}" "min-legal-vector-width"="{bits}" '
    text = w.function("@step(ptr %state, ptr %inputs, ptr %outputs)")
    return module_text([text], declared, wide)


def _places(fields: Fields, lanes: int, base: str) -> list[tuple[str, int, bool]]:
    """Return the byte offset of each number; of lanes each row, at the lanes of the loop.

    A number that is not of a lane is the same for all.
    """
    kind = memory_type(fields)
    places: list[tuple[str, int, bool]] = []
    for name, _, shape in fields:
        begin, step = kind.fields[name][1], kind[name].base.itemsize * (lanes or 1)  # type: ignore[index]
        rows = bool(lanes and shape)
        row_base = f"{base}.here" if rows else base
        numbers = range(math.prod(shape[:-1] if rows else shape))
        places += [(row_base, begin + step * n, bool(lanes) and not rows) for n in numbers]
    return places
