"""A function of one lane, such as a controller's tick, as native code that needs no JAX to run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import jax
import numpy as np

from tegotae.lowering.graph import Reader
from tegotae.lowering.layout import Entry, MemoryLayout, Rows
from tegotae.lowering.llvm.compile import (
    Compiled,
    NativeStep,
    Target,
    object_file,
    sealed,
    target_of,
)
from tegotae.lowering.llvm.emit import Emitter
from tegotae.lowering.llvm.writer import FunctionWriter
from tegotae.lowering.nodes import KINDS, Node, Tree, array_of, given, scalars


@dataclass(frozen=True)
class FunctionKernel:
    """A compiled function: how its memory is laid out, and its code.

    The code is one function in C's way of calling, `void step(void *state, const void *inputs, void
    *outputs)`, of which each pointer is to memory that a layout describes.
    """

    state: MemoryLayout
    """What a step hands to the next; every entry is named by its path in the pytree."""
    inputs: MemoryLayout
    """What it takes."""
    outputs: MemoryLayout
    """What it gives."""
    text: str = field(repr=False)
    """The code in LLVM's language."""

    def step(self) -> NativeStep:
        """The function, ready to be called in this process."""
        return NativeStep(
            Compiled(self.text, target_of("scalar")), self.state, self.inputs, self.outputs
        )

    def object_file(self, target: str | Target = "portable") -> bytes:
        """The code for a processor, with a checksum: what `load_step` takes, without JAX."""
        code = object_file(self.text, target_of(target))
        return sealed(code, self.state, self.inputs, self.outputs)


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
        layouts = [_layout(tree) for tree in (*shapes, outputs)]
        assert _layout(after) == layouts[0], "the new state differs from the old one in its shape"
        arrays = [
            array
            for name, layout in zip(("state", "inputs"), layouts, strict=False)
            for array in _given(name, layout)
        ]
        results = scalars(Reader().read(trace, arrays))
    of_state, of_inputs, of_outputs = layouts
    return FunctionKernel(of_state, of_inputs, of_outputs, _text(results, layouts))


def _layout(tree: Tree) -> MemoryLayout:
    leaves, _ = jax.tree_util.tree_flatten_with_path(tree)
    return MemoryLayout(
        tuple(
            Entry(jax.tree_util.keystr(path, simple=True, separator="."), str(x.dtype), x.shape)
            for path, x in leaves
        )
    )


def _given(name: str, layout: MemoryLayout) -> list[np.ndarray]:
    """Nodes of a layout, array by array, numbered one after the other."""
    found, first = [], 0
    for entry in layout.entries:
        size = len(MemoryLayout((entry,)).kinds)
        kind = KINDS[entry.dtype]
        nodes = [given((name, first + i), kind) for i in range(size)]
        found.append(array_of(nodes, entry.shape))
        first += size
    return found


def _text(results: Sequence[Node], layouts: Sequence[MemoryLayout]) -> str:
    """The module: loads, computes, and stores once all is known."""
    declared: set[str] = set()
    w = FunctionWriter(1, declared)
    offsets = {
        name: Rows(layout.kinds).offsets
        for name, layout in zip(("state", "inputs", "outputs"), layouts, strict=True)
    }

    def leaf(node: Node) -> tuple[str, int, bool] | None:
        if node.operation != "given" or node.detail[0] not in offsets:
            return None
        name, number = node.detail
        return f"%{name}", offsets[name][number], False

    found = Emitter(w, 1, results, leaf)
    values = [found.values(node)[0] for node in results]
    n_state = len(layouts[0].kinds)
    places = [("%state", at) for at in offsets["state"]]
    places += [("%outputs", at) for at in offsets["outputs"]]
    assert len(places) == len(results) >= n_state
    for (base, offset), node, value in zip(places, results, values, strict=True):
        w.store(base, offset, node.kind, value)
    function = w.function("@step(ptr %state, ptr %inputs, ptr %outputs)")
    return "\n".join(
        (
            function,
            *sorted(declared),
            "attributes #0 = { nounwind }",
            '!0 = !{!"branch_weights", i32 1, i32 50}',
            "",
        )
    )
