"""A compiled step that is called from Python, one lane at a time; needs no JAX."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

from tegotae.lowering.layout import MemoryLayout
from tegotae.lowering.llvm.compile import Compiled, Loaded
from tegotae.lowering.llvm.seal import unsealed


def load_step(
    code: bytes, state: MemoryLayout, inputs: MemoryLayout, outputs: MemoryLayout
) -> NativeStep:
    """A step from the object file that `FunctionKernel.object_file` gave, and its layouts.

    Raises:
        TegotaeError: for code that was truncated or altered, or goes with other layouts; and for
            that of another kind of processor.
    """
    return NativeStep(Loaded(unsealed(code, state, inputs, outputs)), state, inputs, outputs)


class NativeStep:
    """A function of state and inputs, with memory of its own.

    Entries of `state`, `inputs` and `outputs` are arrays in that memory: write the inputs, call the
    step, read the outputs. A call makes no object and takes about a microsecond.

    Args:
        code: what was compiled, or loaded.
        state: what a step hands to the next.
        inputs: what it takes.
        outputs: what it gives.
    """

    def __init__(
        self,
        code: Compiled | Loaded,
        state: MemoryLayout,
        inputs: MemoryLayout,
        outputs: MemoryLayout,
    ) -> None:
        self._code = code
        self._memory = tuple(each.memory() for each in (state, inputs, outputs))
        self.state, self.inputs, self.outputs = (
            layout.views(memory)
            for layout, memory in zip((state, inputs, outputs), self._memory, strict=True)
        )
        kind = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)
        self._function: Callable[..., None] = kind(code.address("step"))
        self._pointers = tuple(ctypes.c_void_p(memory.ctypes.data) for memory in self._memory)

    def __call__(self) -> None:
        """Go one step on."""
        self._function(*self._pointers)

    def kept(self) -> tuple[bytes, ...]:
        """All memory as it is."""
        return tuple(memory.tobytes() for memory in self._memory)

    def restore(self, kept: tuple[bytes, ...]) -> None:
        """Put all memory where it was kept."""
        for memory, content in zip(self._memory, kept, strict=True):
            memory[:] = np.frombuffer(content, np.uint8)

    def reset(self, **state: np.ndarray) -> None:
        """Put the state, of which each entry is named, where it is to begin."""
        for name, value in state.items():
            self.state[name][...] = value
