"""Modules as machine code, by llvmlite: in this process, or as an object file for another."""

from __future__ import annotations

import functools
from typing import Any

from tegotae._support.errors import TegotaeError
from tegotae.lowering.llvm.target import Target

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
