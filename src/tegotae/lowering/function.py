"""A function of one lane, such as a controller's tick, as native code that needs no JAX to run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import jax
import msgspec

from tegotae.lowering.emit import Emitter
from tegotae.lowering.graph import in_shapes
from tegotae.lowering.layout import Entry, MemoryLayout, StepLayout
from tegotae.lowering.machine import Code, NativeStep, Target, object_file, sealed, target_of
from tegotae.lowering.native_reader import NativeReader
from tegotae.lowering.nodes import Node, Tree, given, scalars
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

    def object_file(self, target: str | Target = "portable") -> bytes:
        """The code for a processor."""
        return object_file(self.text, target_of(target))

    def to_bytes(self, target: str | Target = "portable") -> bytes:
        """Layout and code for a processor, with a checksum: what `load_step` takes, without JAX."""
        return sealed(msgspec.msgpack.encode((self.layout, self.object_file(target))))


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
        shapes = [
            jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype), tree)
            for tree in (state, inputs)
        ]
        trace, (after, outputs) = jax.make_jaxpr(function, return_shape=True)(*shapes)
        layout = StepLayout(*map(_layout, (*shapes, outputs)))
        assert _layout(after) == layout.state, "the new state differs from the old in its shape"
        arrays = [
            array
            for name, part in (("state", layout.state), ("inputs", layout.inputs))
            for array in in_shapes(
                [given((name, i), kind) for i, kind in enumerate(part.rows.kinds)],
                [entry.shape for entry in part.entries],
            )
        ]
        results = scalars(NativeReader().read(trace, arrays))
    return FunctionKernel(layout, _text(results, layout))


def _layout(tree: Tree) -> MemoryLayout:
    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return MemoryLayout(
        tuple(
            Entry(jax.tree_util.keystr(path, simple=True, separator="."), str(x.dtype), x.shape)
            for path, x in leaves
        )
    )


def _text(results: Sequence[Node], layout: StepLayout) -> str:
    """The module: loads, computes, and stores once all is known."""
    declared: set[str] = set()
    w = FunctionWriter(1, declared)
    offsets = {name: part.rows.offsets for name, part in vars(layout).items()}

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
