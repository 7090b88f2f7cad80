"""Text of a function in LLVM: instructions with their registers, in blocks."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from lanewise.nodes import FLOATS, Detail

TYPES = {
    "float": "float",
    "double": "double",
    "int32_t": "i32",
    "uint32_t": "i32",
    "int64_t": "i64",
    "uint64_t": "i64",
    "bool": "i1",
}
"""Types in LLVM by those in C."""
_STORED = {**TYPES, "bool": "i32"}
"""Types in memory."""
_BYTES = {"float": 4, "double": 8, "i32": 4, "i64": 8}
_LIKELY = "!0"
_SHORT = {"float": "f32", "double": "f64"}


@dataclass
class FunctionWriter:
    """Writer of a function.

    Args:
        lanes: numbers in a vector; 1 for plain scalars.
        declared: declarations of the intrinsics that are called, shared by functions of a module.
    """

    lanes: int
    declared: set[str]
    alignment: int = 64
    """Bytes that memory of vectors begins at a multiple of."""
    lines: list[str] = field(default_factory=list)
    block: str = "entry"
    """The block that is being written."""
    _registers: int = 0
    _labels: int = 0

    def type(self, kind: str) -> str:
        """Return the vector type of a value, one entry per lane."""
        return self._wide(TYPES[kind])

    def _wide(self, scalar: str) -> str:
        return scalar if self.lanes == 1 else f"<{self.lanes} x {scalar}>"

    def do(self, instruction: str, name: str = "") -> str:
        """Write an instruction; the register of its value, of this name or of a new one."""
        self._registers += 1
        register = name or f"%v{self._registers}"
        self.lines.append(f"  {register} = {instruction}")
        return register

    def also(self, instruction: str) -> None:
        """Write an instruction without a value."""
        self.lines.append(f"  {instruction}")

    def label(self, name: str) -> str:
        """Return a name for a block that is written later."""
        self._labels += 1
        return f"{name}{self._labels}"

    def begin(self, label: str) -> None:
        """Begin a block."""
        self.lines.append(f"{label}:")
        self.block = label

    def number(self, value: Detail, kind: str) -> str:
        """Return a constant, the same in all lanes."""
        if kind in FLOATS:
            exact = float(np.float32(value) if kind == "float" else np.float64(value))
            if exact != exact:
                exact = float("nan")
            text = f"0x{struct.unpack('<Q', struct.pack('<d', exact))[0]:016X}"
        elif kind == "bool":
            text = "true" if value else "false"
        else:
            text = str(int(value))
        return text if self.lanes == 1 else f"splat ({TYPES[kind]} {text})"

    def call(self, intrinsic: str, kinds: tuple[str, ...], *operands: str) -> str:
        """Call an intrinsic, named with the types that it is overloaded with."""
        wide = "" if self.lanes == 1 else f"v{self.lanes}"
        names = [wide + _SHORT.get(TYPES[kind], TYPES[kind]) for kind in kinds]
        name = f"@llvm.{'.'.join((intrinsic, *names))}"
        result, operand = self.type(kinds[0]), self.type(kinds[-1])
        self.declared.add(f"declare {result} {name}({', '.join([operand] * len(operands))})")
        arguments = ", ".join(f"{operand} {x}" for x in operands)
        return self.do(f"call {result} {name}({arguments})")

    def select(self, mask: str, kind: str, yes: str, no: str, name: str = "") -> str:
        """Select one of two values, lane by lane."""
        type_name = self.type(kind)
        return self.do(
            f"select {self.type('bool')} {mask}, {type_name} {yes}, {type_name} {no}", name
        )

    def any(self, masks: list[str]) -> str:
        """Emit the test whether a mask holds for any lane of any vector."""
        together, kind = masks[0], self.type("bool")
        for mask in masks[1:]:
            together = self.do(f"or {kind} {together}, {mask}")
        if self.lanes == 1:
            return together
        bits = self.do(f"bitcast {kind} {together} to i{self.lanes}")
        return self.do(f"icmp ne i{self.lanes} {bits}, 0")

    def go(self, label: str) -> None:
        """Continue at a block."""
        self.also(f"br label %{label}")

    def go_if(self, condition: str, yes: str, no: str, *, rarely: bool = False) -> None:
        """Continue at one of two blocks."""
        weights = f", !prof {_LIKELY}" if rarely else ""
        self.also(f"br i1 {condition}, label %{yes}, label %{no}{weights}")

    def either(self, kind: str, *cases: tuple[str, str]) -> str:
        """Return the value of the block that ran before, from pairs of value and block."""
        pairs = ", ".join(f"[ {value}, %{block} ]" for value, block in cases)
        return self.do(f"phi {self.type(kind)} {pairs}")

    def bytes_of(self, kind: str) -> int:
        """Return the size of a vector in memory [bytes]."""
        return self.lanes * _BYTES[_STORED[kind]]

    def _memory(self, base: str, offset: int, kind: str, lanes: int) -> str:
        """Return an address and its alignment."""
        address = self.do(f"getelementptr i8, ptr {base}, i64 {offset}") if offset else base
        return f"ptr {address}, align {min(lanes * _BYTES[_STORED[kind]], self.alignment)}"

    def load(self, base: str, offset: int, kind: str, *, spread: bool = False) -> str:
        """Load a value from memory, or with `spread` one number into all lanes."""
        stored = _STORED[kind]
        wide = self._wide(stored)
        if spread:
            place = self._memory(base, offset, kind, 1)
            value = self._spread(self.do(f"load {stored}, {place}"), stored)
        else:
            value = self.do(f"load {wide}, {self._memory(base, offset, kind, self.lanes)}")
        return self.do(f"icmp ne {wide} {value}, zeroinitializer") if kind == "bool" else value

    def store(self, base: str, offset: int, kind: str, *values: str) -> None:
        """Store vectors one after the other; booleans become whole numbers."""
        wide = self._wide(_STORED[kind])
        for number, value in enumerate(values):
            if kind == "bool":
                value = self.do(f"zext {self.type(kind)} {value} to {wide}")
            place = offset + number * self.bytes_of(kind)
            self.also(f"store {wide} {value}, {self._memory(base, place, kind, self.lanes)}")

    def spread(self, scalar: str, kind: str) -> str:
        """Spread a number of a register over all lanes."""
        return self._spread(scalar, TYPES[kind])

    def _spread(self, scalar: str, type_name: str) -> str:
        if self.lanes == 1:
            return scalar
        wide = self._wide(type_name)
        first = self.do(f"insertelement {wide} poison, {type_name} {scalar}, i64 0")
        zeros = f"<{self.lanes} x i32> zeroinitializer"
        return self.do(f"shufflevector {wide} {first}, {wide} poison, {zeros}")

    def function(self, head: str) -> str:
        """Return the text of the function with its head."""
        return "\n".join((f"define void {head} #0 {{", "entry:", *self.lines, "  ret void", "}"))


def module_text(functions: Iterable[str], declared: Iterable[str], attributes: str = "") -> str:
    """Return a module of functions, with declarations of what they call and attributes of all of
    them.
    """
    return "\n".join(
        (
            *functions,
            *sorted(declared),
            f"attributes #0 = {{ {attributes}nounwind }}",
            f'{_LIKELY} = !{{!"branch_weights", i32 1, i32 50}}',
            "",
        )
    )
