"""What a trace is taken apart into: scalars, and procedures of them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.export.c.names import Place

KINDS = {"float32": "float", "int32": "int32_t", "bool": "bool"}
"""Types in C by those of a trace."""
_number = itertools.count()


@dataclass(eq=False)
class Node:
    """A scalar: a constant, something given, or what an operation makes of other scalars."""

    operation: str
    """A name of `SCALAR`; or literal, given, result."""
    kind: str
    """Its type in C."""
    inputs: tuple[Node, ...] = ()
    detail: Any = None
    """The value of a literal, the C text of what is given, which result of which call."""
    place: Place | None = None
    """Where in the program it was computed."""
    number: int = field(default_factory=lambda: next(_number))
    """Later ones depend on earlier ones alone."""


@dataclass(eq=False)
class Procedure:
    """A function that the traced one calls by name: scalars in, scalars out."""

    name: str
    parameters: tuple[str, ...]
    inputs: tuple[Node, ...]
    results: tuple[Node, ...]
    about: str = ""
    """What its docstring says it does."""


@dataclass(eq=False)
class Loop(Procedure):
    """A procedure that goes round: while a condition holds, new values for some parameters."""

    carried: int = 0
    """How many of its parameters, the last ones, get new values; its results are their last."""
    goes_on: Node | None = None
    """The condition."""
    onwards: tuple[Node, ...] = ()
    """The new values."""


@dataclass(eq=False)
class Call:
    """One call of a procedure."""

    procedure: Procedure
    inputs: tuple[Node, ...]
    place: Place | None


def given(text: str, kind: str = "float") -> Node:
    """A scalar that C calls so."""
    return Node("given", kind, detail=text)


def literal(value: Any, kind: str) -> Node:
    """A constant."""
    return Node("literal", kind, detail=value)


def array_of(nodes: Sequence[Node], shape: tuple[int, ...]) -> np.ndarray:
    """The nodes as an array."""
    array = np.empty(len(nodes), object)
    array[:] = nodes
    return array.reshape(shape)


def constant(value: Any) -> np.ndarray:
    """An array of known numbers as literals.

    Raises:
        TegotaeError: for numbers of a type that C does not get.
    """
    numbers = np.asarray(value)
    kind = KINDS.get(str(numbers.dtype))
    if kind is None:
        raise TegotaeError(
            f"the controller holds numbers of {numbers.dtype}, which cannot be exported"
        )
    return array_of([literal(each, kind) for each in numbers.reshape(-1)], numbers.shape)
