"""What a trace is taken apart into: scalars, and branches and loops of them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tegotae.lowering.errors import CannotLower
from tegotae.lowering.jaxprs import Detail

if TYPE_CHECKING:
    from tegotae.lowering.places import Place

KINDS = {
    "float32": "float",
    "float64": "double",
    "int32": "int32_t",
    "int64": "int64_t",
    "uint32": "uint32_t",
    "uint64": "uint64_t",
    "bool": "bool",
}
"""Types in C by those of a trace."""
DTYPES = {kind: dtype for dtype, kind in KINDS.items()}
"""Types of a trace by those in C."""
FLOATS = ("float", "double")
_number = itertools.count()


@dataclass(eq=False)
class Node:
    """A scalar: a constant, something given, or what an operation makes of other scalars."""

    operation: str
    """A name of `OPERATIONS`; or literal, given, result; branch or loop, of which parts are."""
    kind: str
    """Its type in C."""
    inputs: tuple[Node, ...] = ()
    detail: Detail = None
    """The value of a literal, the name of what is given, which result of which call."""
    place: Place | None = None
    """Where in the program it was computed."""
    number: int = field(default_factory=lambda: next(_number))
    """Later ones depend on earlier ones alone."""


@dataclass(eq=False)
class Fork:
    """What a node `branch` decides between: the results of either side.

    The node's inputs are the condition, then `no`, then `yes`.
    """

    no: tuple[Node, ...]
    yes: tuple[Node, ...]


@dataclass(eq=False)
class Loop:
    """What a node `loop` repeats while a condition holds.

    The node's inputs are the values that `carried` begins with, then all from outside that a round
    reads.
    """

    carried: tuple[Node, ...]
    """What changes from round to round, as nodes that are given."""
    goes_on: Node
    """The condition, of what is carried."""
    onwards: tuple[Node, ...]
    """What is carried to the next round."""


def given(name: Detail, kind: str = "float") -> Node:
    """A scalar that comes from outside; of C, the text that it has there."""
    return Node("given", kind, detail=name)


def literal(value: Detail, kind: str) -> Node:
    """A constant."""
    return Node("literal", kind, detail=value)


def array_of(nodes: Sequence[Node], shape: tuple[int, ...]) -> np.ndarray:
    """The nodes as an array."""
    array = np.empty(len(nodes), object)
    array[:] = nodes
    return array.reshape(shape)


def constant(value: ArrayLike) -> np.ndarray:
    """An array of known numbers as literals.

    Raises:
        CannotLower: for numbers of a type that no scalar has.
    """
    numbers = np.asarray(value)
    kind = KINDS.get(str(numbers.dtype))
    if kind is None:
        raise CannotLower(f"numbers of {numbers.dtype}")
    return array_of([literal(each, kind) for each in numbers.reshape(-1)], numbers.shape)


def scalars(arrays: Sequence[np.ndarray]) -> list[Node]:
    """All entries of the arrays."""
    return [node for array in arrays for node in array.reshape(-1)]
