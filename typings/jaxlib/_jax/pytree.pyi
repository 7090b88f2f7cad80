"""The structure of a pytree, without its leaves."""

from typing import Any

class PyTreeDef:
    num_leaves: int
    def unflatten(self, leaves: Any, /) -> Any: ...

def __getattr__(name: str) -> Any: ...
