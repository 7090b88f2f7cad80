"""Reads traces for C: calls of the package's functions stay calls, for people to read."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from lanewise.graph import Arrays, Reader, callee, in_shapes
from lanewise.nodes import (
    Detail,
    Node,
    Parameters,
    Traced,
    input_node,
    is_of_jax,
    place_of,
    scalars,
)
from lanewise.operations import OPERATIONS, folded, of_finite
from tegotae_robots.c.text import c_name, commented

_SMALLEST_PROCEDURE = 4
"""Operations from which a function of the package is worth one in C."""


@dataclass(eq=False)
class Procedure:
    """A function that the traced one calls by name: scalars in, scalars out."""

    name: str
    inputs: tuple[Node, ...]
    """Given by the names of its parameters."""
    results: tuple[Node, ...]
    summary: str = ""
    """First line of its docstring."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names."""
        return tuple(str(node.detail) for node in self.inputs)


@dataclass(eq=False)
class Call:
    """One call of a procedure."""

    procedure: Procedure
    inputs: tuple[Node, ...]
    origin: Traced

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its results in the program."""
        place = place_of(self.origin)
        return place.names if place else (self.procedure.name,)

    def results(self) -> list[Node]:
        """Return the nodes of its results."""
        return [
            Node("result", result.kind, self.inputs, (self, index), self.origin)
            for index, result in enumerate(self.procedure.results)
        ]


class CReader(Reader):
    """Reader of traces in which equal procedures are one.

    It refuses loops of unknown length, which a robot's tick must not have.
    """

    target = "C"
    advice = "write it with elementary functions and jnp.where"
    kinds: ClassVar[Mapping[str, str]] = {"float32": "float", "int32": "int32_t", "bool": "bool"}

    def __init__(self) -> None:
        self._procedures: dict[str, Procedure] = {}

    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        return folded(Node(operation, kind, inputs, detail, origin), of_finite)

    def _between_entries(
        self, name: str, kind: str, arguments: Arrays, equation: Traced, origin: Traced
    ) -> np.ndarray:
        operation = OPERATIONS.get(name)
        if operation is None or operation.text is None:
            raise self._refused(name, origin)
        return self._entrywise(name, kind, arguments, origin, operation.detail(equation.params))

    def _call(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        jaxpr, constants, source = callee(parameters)
        values = [self._constant(value, origin) for value in constants]
        of_author = not is_of_jax(source)
        alone = all(array.size == 1 for array in arguments)
        alone &= all(int(np.prod(out.aval.shape)) == 1 for out in jaxpr.outvars)
        if not (
            of_author and alone and len(jaxpr.eqns) >= _SMALLEST_PROCEDURE and "name" in parameters
        ):
            return self._run(jaxpr, values, arguments, None if of_author else origin)
        procedure = self._procedure(parameters["name"], jaxpr, values)
        call = Call(procedure, tuple(scalars(arguments)), origin)
        return in_shapes(call.results(), [out.aval.shape for out in jaxpr.outvars])

    def _fork(
        self, condition: np.ndarray, no: Arrays, yes: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Return the results of the chosen branch; both are computed."""
        return [
            self._entrywise("select_n", "", [condition, *cases], None)
            for cases in zip(no, yes, strict=True)
        ]

    def _procedure(self, name: str, jaxpr: Traced, constants: Sequence[np.ndarray]) -> Procedure:
        text = f"{name}{jaxpr}"
        if text not in self._procedures:
            debug_info = getattr(jaxpr, "debug_info", None)
            names = getattr(debug_info, "arg_names", None) or ()
            if len(names) != len(jaxpr.invars):
                names = [f"x{i}" for i in range(len(jaxpr.invars))]
            taken: set[str] = set()
            inputs = [
                input_node(c_name(x, taken), self._kind(atom.aval, name, None))
                for x, atom in zip(names, jaxpr.invars, strict=True)
            ]
            arrays = in_shapes(inputs, [atom.aval.shape for atom in jaxpr.invars])
            results = scalars(self._run(jaxpr, constants, arrays, None))
            source = getattr(debug_info, "func_src_info", None) or ""
            self._procedures[text] = Procedure(
                name, tuple(inputs), tuple(results), _docstring(source)
            )
        return self._procedures[text]


def _docstring(source: str) -> str:
    """Return the first line of a function's docstring, from the place that a trace names: NAME at
    FILE:LINE.
    """
    name, _, place = source.partition(" at ")
    file = Path(place.rpartition(":")[0])
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return ""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return commented(ast.get_docstring(node) or "")
    return ""
