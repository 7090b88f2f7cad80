"""Names for what traces are made of, and for values that no annotation can narrow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

Traced: TypeAlias = Any
"""A jaxpr or a piece of one: JAX declares neither shapes nor types of what stands in it."""
Parameters: TypeAlias = Mapping[str, Any]
"""What an operation of a trace is given beside arrays: each has entries of its own."""
Tree: TypeAlias = Any
"""Any pytree of arrays, or of their shapes, such as a lane's state."""
Detail: TypeAlias = Any
"""What a node knows beside its inputs: a number, a name, or which branch or loop it is."""
