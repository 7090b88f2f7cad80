"""Processors that code is made for; results do not depend on which."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from tegotae._support.errors import unknown

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
