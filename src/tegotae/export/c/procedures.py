"""Functions within exported C: procedures of scalars, loops, and calls of them."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.lowering.nodes import Node, Place


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
class LoopProcedure(Procedure):
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
