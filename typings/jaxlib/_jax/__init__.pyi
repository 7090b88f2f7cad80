"""What JAX's annotations name of its compiled module, which has no types of its own.

Without it `device: Device` makes the types of `jnp.zeros_like` and all its kin partially unknown.
"""

from typing import Any

class Device:
    """A processor that JAX computes on."""

    platform: str
    device_kind: str
    id: int
    process_index: int

def __getattr__(name: str) -> Any: ...
