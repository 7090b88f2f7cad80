"""A function of one lane, such as a controller's tick, as native code that needs no JAX to run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import jax
import msgspec

from tegotae.lowering.emit import Emitter
from tegotae.lowering.machine import (
    Code,
    Fields,
    NativeStep,
    StepLayout,
    Target,
    memory_type,
    object_file,
    sealed,
    target_of,
)
from tegotae.lowering.native_reader import NativeReader, given_arrays
from tegotae.lowering.nodes import Node, Tree, scalars
from tegotae.lowering.writer import FunctionWriter, module_text


@dataclass(frozen=True)
class FunctionKernel:
    """A compiled function: how its memory is laid out, and its code.

    The code is one function in C's way of calling, `void step(void *state, const void *inputs, void
    *outputs)`, of which each pointer is to memory that the layout describes.
    """

    layout: StepLayout
    text: str = field(repr=False)
    """The code in LLVM's language."""

    def step(self) -> NativeStep:
        """The function, ready to be called in this process."""
        return NativeStep(Code.compiled(self.text, target_of("scalar")), self.layout)

    def to_bytes(self, target: str | Target = "portable") -> bytes:
        """Layout and code for a processor, with a checksum: what `load_step` takes, without JAX."""
        code = object_file(self.text, target_of(target))
        return sealed(msgspec.msgpack.encode((self.layout, code)))


def compile_function(
    function: Callable[[Tree, Tree], tuple[Tree, Tree]],
    state: Tree,
    inputs: Tree,
    *,
    dtype: str = "float32",
) -> FunctionKernel:
    """A function of one lane as native code.

    Args:
        function: of (state, inputs): the new state, of the same structure, and outputs; all are
            pytrees of arrays. What it closes over, such as weights, becomes part of the code.
        state: a state, as arrays or `jax.ShapeDtypeStruct`.
        inputs: inputs likewise.
        dtype: "float32" or "float64": whether the function is traced with double precision.

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
        trace, (after, outputs) = jax.make_jaxpr(function, return_shape=True)(state, inputs)
        layout = _fields(state), _fields(inputs), _fields(outputs)
        assert _fields(after) == layout[0], "the new state differs from the old in its shape"
        arrays = [*given_arrays("state", state), *given_arrays("inputs", inputs)]
        results = scalars(NativeReader().read(trace, arrays))
    return FunctionKernel(layout, _text(results, layout))


def _fields(tree: Tree) -> Fields:
    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return tuple(
        (jax.tree_util.keystr(path, simple=True, separator="."), str(x.dtype), x.shape)
        for path, x in leaves
    )


def _text(results: Sequence[Node], layout: StepLayout) -> str:
    """The module: loads, computes, and stores once all is known."""
    declared: set[str] = set()
    w = FunctionWriter(1, declared)
    names = ("state", "inputs", "outputs")
    offsets = {name: _offsets(fields) for name, fields in zip(names, layout, strict=True)}

    def leaf(node: Node) -> tuple[str, int, bool] | None:
        if node.operation != "given" or node.detail[0] not in offsets:
            return None
        name, number = node.detail
        return f"%{name}", offsets[name][number], False

    emitted = Emitter(w, 1, results, leaf)
    values = [emitted.values(node)[0] for node in results]
    places = [(f"%{name}", x) for name in ("state", "outputs") for x in offsets[name]]
    for (base, offset), node, value in zip(places, results, values, strict=True):
        w.store(base, offset, node.kind, value)
    return module_text([w.function("@step(ptr %state, ptr %inputs, ptr %outputs)")], declared)


def _offsets(fields: Fields) -> list[int]:
    """Where each number of the arrays begins, in bytes."""
    kind = memory_type(fields)
    begins = [(kind[name].base.itemsize, kind.fields[name][1]) for name in kind.names or ()]  # type: ignore[index]
    sizes = [math.prod(shape) for _, _, shape in fields]
    return [
        begin + number * step
        for (step, begin), size in zip(begins, sizes, strict=True)
        for number in range(size)
    ]
