"""Machine code of this processor from LLVM's text, sealed for files, and called step by step."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import msgspec
import numpy as np

from lanewise.nodes import LanewiseError

VARIABLE = "LANEWISE_OPT"
"""The environment variable of how hard LLVM tries, from 0 to 3; results are the same bits."""
_USUAL = 1
_FLOAT_BITS = {"float32": 32, "float64": 64}


@dataclass(frozen=True)
class Target:
    """A processor: its name and the width of its vectors."""

    name: str
    triple: str
    """Architecture and system, as LLVM names them; empty for this machine's."""
    cpu: str
    features: str
    vector_bits: int
    """Bits of a vector; 0 where code is to be of scalars."""

    def lanes_of_vector(self, dtype: str) -> int:
        """Return the number of values of this type in a vector."""
        return max(1, self.vector_bits // _FLOAT_BITS[dtype])


_TARGETS = {
    "avx2": Target("avx2", "", "haswell", "+avx2,+fma", 256),
    "avx512": Target("avx512", "", "skylake-avx512", "+avx2,+fma,+avx512f,+avx512vl", 512),
    "aarch64": Target("aarch64", "aarch64-unknown-linux-gnu", "generic", "+neon", 128),
}

_OWN = ("host", "scalar", "portable")


def target_of(target: str | Target) -> Target:
    """Return the target of a name: "host", "scalar", "portable", "avx2", "avx512" or "aarch64".

    "scalar" is this machine without vectors; "portable" any of the last ten years that is like it.

    Raises:
        LanewiseError: for another name.

    Example:
        >>> target_of("avx2").lanes_of_vector("float32")
        8
    """
    if isinstance(target, Target):
        return target
    if target in _OWN:
        return _host(target)
    if target not in _TARGETS:
        names = ", ".join((*_OWN, *_TARGETS))
        raise LanewiseError(f"there is no target {target!r}; there are {names}")
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


def optimisation_level() -> int:
    """Return LLVM's optimisation level: `LANEWISE_OPT`, else 1. At 0 it compiles in a fifth of the
    time.

    Raises:
        LanewiseError: for another value than 0, 1, 2 or 3.
    """
    setting = os.environ.get(VARIABLE) or str(_USUAL)
    if setting not in ("0", "1", "2", "3"):
        raise LanewiseError(f"{VARIABLE} is {setting!r}; it must be 0, 1, 2 or 3")
    return int(setting)


class Store(Protocol):
    """Storage of machine code between processes."""

    def stored_code(self, key: str) -> bytes | None:
        """Return the code under a key, or None if there is none, or none that is complete."""
        ...

    def store_code(self, key: str, content: bytes) -> None:
        """Keep code under a key, if that is possible."""
        ...


class Code:
    """Machine code in memory; it lives as long as this object.

    Args:
        module: of LLVM.
        machine: of LLVM, the target.
        object_file: further code.
    """

    def __init__(self, module: Any, machine: Any, object_file: bytes | None = None) -> None:
        llvm = _llvm()
        self._engine = llvm.create_mcjit_compiler(module, machine)
        if object_file is not None:
            self._engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(object_file))
        self._engine.finalize_object()

    @classmethod
    def compiled(
        cls,
        text: str,
        target: Target,
        optimisation: int | None = None,
        store: Store | None = None,
    ) -> Code:
        """Compile a module in LLVM's language, or load its kept code.

        Args:
            text: the module.
            target: the processor.
            optimisation: how hard the compiler tries, from 0 to 3, else `optimisation_level()`;
                results are the same.
            store: where code is kept; nowhere if None.
        """
        if optimisation is None:
            optimisation = optimisation_level()
        parts = text, repr(target), f"{_llvm().llvm_version_info} {optimisation}"
        key = hashlib.sha256("\0".join(parts).encode()).hexdigest()
        code = store.stored_code(key) if store else None
        if code is None:
            code = object_file(text, target, optimisation)
            if store:
                store.store_code(key, code)
        return cls.loaded(code)

    @classmethod
    def loaded(cls, object_file: bytes) -> Code:
        """Load an object file as it is: the loader trusts it.

        Raises:
            LanewiseError: for code of another kind of processor.
        """
        llvm = _llvm()
        machine = llvm.Target.from_default_triple().create_target_machine(reloc="pic")
        empty = machine.emit_object(llvm.parse_assembly(""))
        if _format(object_file) != _format(empty):
            raise LanewiseError(
                "the code is for another processor or system than "
                f"{llvm.get_process_triple()}; compile it for this one"
            )
        return cls(llvm.parse_assembly(""), machine, object_file)

    def function(self, name: str, pointers: int, numbers: int = 0) -> Callable[..., None]:
        """Return a function that takes so many pointers, and whole numbers after them."""
        kinds = [ctypes.c_void_p] * pointers + [ctypes.c_int64] * numbers
        return ctypes.CFUNCTYPE(None, *kinds)(self._engine.get_function_address(name))


def _format(code: bytes) -> bytes:
    """Return the format and processor bytes of an object file."""
    return code[:5] + code[18:20] if code[:4] == b"\x7fELF" else code[:8]


def object_file(text: str, target: Target, optimisation: int = _USUAL) -> bytes:
    """Compile a module to an object file of the target."""
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
    """Return llvmlite, initialised for this machine."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


_CHECKSUM_BYTES = hashlib.sha256().digest_size


def sealed(content: bytes) -> bytes:
    """Return bytes behind their checksum.

    Example:
        >>> unsealed(sealed(b"code"))
        b'code'
    """
    return hashlib.sha256(content).digest() + content


def unsealed(data: bytes) -> bytes:
    """Return the sealed content.

    Raises:
        LanewiseError: where a byte differs, is missing or was added.
    """
    checksum, content = data[:_CHECKSUM_BYTES], data[_CHECKSUM_BYTES:]
    if hashlib.sha256(content).digest() != checksum:
        raise LanewiseError("the machine code is truncated or altered; compile it again")
    return content


Fields: TypeAlias = tuple[tuple[str, str, tuple[int, ...]], ...]
"""Arrays in memory, one after the other: name, type in a trace, shape; true and false as int32."""
StepLayout: TypeAlias = tuple[Fields, Fields, Fields]
"""Memory of state, inputs and outputs of a step."""


def memory_type(fields: Fields) -> np.dtype:
    """Return the type of memory with these arrays.

    Example:
        >>> memory = np.zeros((), memory_type((("x", "float32", (2,)), ("on", "bool", ()))))
        >>> memory["x"].shape, memory["on"].shape
        ((2,), ())
    """
    types = [(name, "int32" if dtype == "bool" else dtype, shape) for name, dtype, shape in fields]
    return np.dtype(types, align=True)


def load_step(content: bytes) -> NativeStep:
    """Load a step from the bytes that `FunctionKernel.to_bytes` returned.

    Raises:
        LanewiseError: for bytes that were truncated or altered, or code of another kind of
            processor.
    """
    layout, code = msgspec.msgpack.decode(unsealed(content), type=tuple[StepLayout, bytes])
    return NativeStep(Code.loaded(code), layout)


class NativeStep:
    """A function of state and inputs, with memory of its own.

    Write the arrays of `inputs`, call the step, read those of `outputs`. A call makes no object and
    takes about a microsecond.

    Args:
        code: what was compiled, or loaded.
        layout: of its memory.
    """

    def __init__(self, code: Code, layout: StepLayout) -> None:
        self._memory = tuple(np.zeros((), memory_type(fields)) for fields in layout)
        self.state, self.inputs, self.outputs = self._memory
        self._code = code
        self._function = code.function("step", 3)
        self._pointers = tuple(ctypes.c_void_p(memory.ctypes.data) for memory in self._memory)

    def __call__(self) -> None:
        """Advance one step."""
        self._function(*self._pointers)

    def buffers(self) -> tuple[np.ndarray, ...]:
        """Return all memory, unchanged."""
        return tuple(memory.copy() for memory in self._memory)

    def restore(self, snapshot: tuple[np.ndarray, ...]) -> None:
        """Put all memory where it was kept."""
        for memory, content in zip(self._memory, snapshot, strict=True):
            memory[...] = content

    def reset(self, **state: np.ndarray) -> None:
        """Put the state, of which each entry is named, where it is to begin."""
        for name, value in state.items():
            self.state[name][...] = value
