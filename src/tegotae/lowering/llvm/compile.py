"""Machine code of this processor from LLVM's text, sealed for files, and called step by step."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError, unknown
from tegotae.lowering.layout import MemoryLayout

FLOAT_BITS = {"float32": 32, "float64": 64}
"""Bits of a number by its type."""


@dataclass(frozen=True)
class Target:
    """A processor: what it is called, and how wide its vectors are."""

    name: str
    triple: str
    """Architecture and system, as LLVM names them; empty for this machine's."""
    cpu: str
    features: str
    vector_bits: int
    """Bits of a vector; 0 where code is to be of scalars."""

    def lanes_of_vector(self, dtype: str) -> int:
        """Numbers of this type in a vector."""
        return max(1, self.vector_bits // FLOAT_BITS[dtype])


_TARGETS = {
    "avx2": Target("avx2", "", "haswell", "+avx2,+fma", 256),
    "avx512": Target("avx512", "", "skylake-avx512", "+avx2,+fma,+avx512f,+avx512vl", 512),
    "aarch64": Target("aarch64", "aarch64-unknown-linux-gnu", "generic", "+neon", 128),
}

_OWN = ("host", "scalar", "portable")


def target_of(target: str | Target) -> Target:
    """The target of a name: "host", "scalar", "portable", "avx2", "avx512" or "aarch64".

    "scalar" is this machine without vectors; "portable" any of the last ten years that is like it.

    Raises:
        TegotaeError: for another name.

    Example:
        >>> target_of("avx2").lanes_of_vector("float32")
        8
    """
    if isinstance(target, Target):
        return target
    if target in _OWN:
        return _host(target)
    if target not in _TARGETS:
        raise unknown("target", target, (*_OWN, *_TARGETS))
    return _TARGETS[target]


@functools.cache
def _host(name: str) -> Target:
    import llvmlite.binding as llvm

    if name == "portable":
        x86 = llvm.get_process_triple().startswith("x86_64")
        return Target(name, "", "haswell" if x86 else "generic", "+fma" if x86 else "", 0)
    features = llvm.get_host_cpu_features()
    bits = next(
        (bits for feature, bits in (("avx512f", 512), ("avx2", 256)) if features.get(feature)),
        128,
    )
    return Target(
        name, "", llvm.get_host_cpu_name(), features.flatten(), bits if name == "host" else 0
    )


_OPTIMISATION = 2


class Compiled:
    """A module in memory; its code lives as long as this object.

    Args:
        text: the module in LLVM's language.
        target: the processor.
        optimisation: how hard the compiler tries, from 0 to 3; results are the same.
    """

    def __init__(self, text: str, target: Target, optimisation: int = _OPTIMISATION) -> None:
        module, machine = _optimised(text, target, optimisation)
        self._engine = _llvm().create_mcjit_compiler(module, machine)
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Where a function begins."""
        return self._engine.get_function_address(name)


class Loaded:
    """An object file in memory; its code lives as long as this object.

    Args:
        code: what `object_file` gave, unaltered: the loader trusts it.

    Raises:
        TegotaeError: for code of another kind of processor.
    """

    def __init__(self, code: bytes) -> None:
        llvm = _llvm()
        machine = llvm.Target.from_default_triple().create_target_machine(reloc="pic")
        own = machine.emit_object(llvm.parse_assembly(""))
        if _format(code) != _format(own):
            raise TegotaeError(
                "the code is for another processor or system than "
                f"{llvm.get_process_triple()}; compile it for this one"
            )
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
        self._engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Where a function begins."""
        return self._engine.get_function_address(name)


def _format(code: bytes) -> bytes:
    """Of an object file what says its format and processor."""
    return code[:5] + code[18:20] if code[:4] == b"\x7fELF" else code[:8]


def object_file(text: str, target: Target, optimisation: int = _OPTIMISATION) -> bytes:
    """A module as an object file of the target."""
    module, machine = _optimised(text, target, optimisation)
    return machine.emit_object(module)


def _optimised(text: str, target: Target, optimisation: int) -> tuple[Any, Any]:
    llvm = _llvm()
    if target.triple:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    triple = target.triple or llvm.get_process_triple()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=target.cpu,
        features=target.features,
        opt=optimisation,
        reloc="pic",
        codemodel="small" if target.triple else "jitdefault",
    )
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = triple, str(machine.target_data)
    module.verify()
    if optimisation:
        options = llvm.create_pipeline_tuning_options(speed_level=optimisation)
        options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
        passes = llvm.create_pass_builder(machine, options)
        passes.getModulePassManager().run(module, passes)
    return module, machine


@functools.cache
def _llvm() -> Any:
    """llvmlite, ready for this machine."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


_BYTES = hashlib.sha256().digest_size


def sealed(code: bytes, *layouts: MemoryLayout) -> bytes:
    """Code and, after it, a checksum over it and the layouts of its memory.

    Args:
        code: an object file, which stays one.
        layouts: of the memory that it reads and writes, in its order.

    Example:
        >>> unsealed(sealed(b"code"))
        b'code'
    """
    return code + _checksum(code, layouts)


def unsealed(kept: bytes, *layouts: MemoryLayout) -> bytes:
    """The code that was sealed with these layouts.

    Args:
        kept: what `sealed` gave.
        layouts: the same as then.

    Raises:
        TegotaeError: where a byte differs, is missing or was added, or a layout differs.
    """
    code, checksum = kept[:-_BYTES], kept[-_BYTES:]
    if checksum != _checksum(code, layouts):
        raise TegotaeError(
            "the machine code is truncated or altered, or of another layout of its memory; "
            "compile it again"
        )
    return code


def _checksum(code: bytes, layouts: tuple[MemoryLayout, ...]) -> bytes:
    described = json.dumps([layout.document() for layout in layouts])
    return hashlib.sha256(described.encode() + code).digest()


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
