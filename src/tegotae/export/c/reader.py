"""Reads traces for C: calls of the package's functions stay calls, for people to read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.export.c.names import Call, LoopProcedure, Procedure, c_name, docstring
from tegotae.lowering.graph import Reader, called, elementwise
from tegotae.lowering.nodes import (
    Detail,
    Node,
    Parameters,
    Place,
    Traced,
    array_of,
    constant,
    given,
    is_of_jax,
    literal,
    place_of,
    scalars,
)
from tegotae.lowering.operations import OPERATIONS
from tegotae.lowering.rewriting import folded

KINDS = {"float32": "float", "int32": "int32_t", "bool": "bool"}
"""Types in C by those of a trace, of those that C gets."""
_SMALLEST_PROCEDURE = 4
"""Operations from which a function of the package is worth one in C."""


class CReader(Reader):
    """Reads traces; procedures that it meets again are the same ones.

    Args:
        loops: whether there may be loops of unknown length, which a robot's tick must not have.
    """

    def __init__(self, loops: bool = False) -> None:
        super().__init__()
        self._loops = loops
        self._procedures: dict[str, Procedure] = {}

    def _origin(self, equation: Traced, outer: Place | None) -> Place | None:
        return outer or place_of(equation)

    def _refused(self, operation: str, origin: Place | None, why: str = "") -> Exception:
        where = "" if origin is None else f" ({origin.file.name}, line {origin.line})"
        return TegotaeError(
            f"the controller uses {operation!r}{where}, which cannot be exported; "
            f"{why or 'write it with elementary functions and jnp.where'}"
        )

    def _constant(self, value: ArrayLike, origin: Place | None) -> np.ndarray:
        dtype = str(np.asarray(value).dtype)
        if dtype not in KINDS:
            raise TegotaeError(f"the controller holds numbers of {dtype}, which cannot be exported")
        return constant(value)

    def _kind(self, aval: Traced, name: str, origin: Place | None) -> str:
        dtype = str(aval.dtype)
        if dtype not in KINDS:
            raise TegotaeError(
                f"the controller uses {name!r} in {dtype}, which cannot be exported; C gets "
                f"{', '.join(KINDS)}"
            )
        return KINDS[dtype]

    def _node(
        self,
        operation: str,
        kind: str,
        inputs: tuple[Node, ...],
        detail: Detail,
        origin: Place | None,
    ) -> Node:
        return folded(Node(operation, kind, inputs, detail, origin), finite=True)

    def _term(
        self, operation: str, kind: str, inputs: tuple[Node, ...], origin: Place | None
    ) -> Node:
        return Node(operation, kind, inputs, None, origin)

    def _scalar(
        self,
        name: str,
        kind: str,
        arguments: Sequence[np.ndarray],
        equation: Traced,
        origin: Place | None,
    ) -> np.ndarray:
        operation = OPERATIONS.get(name)
        if operation is None or operation.text is None:
            raise self._refused(name, origin)
        detail = operation.detail(equation.params)
        return elementwise(
            lambda *inputs: self._node(name, kind, inputs, detail, origin), arguments
        )

    def _call(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Place | None
    ) -> list[np.ndarray]:
        jaxpr, constants, source = called(parameters)
        known = [self._constant(value, origin) for value in constants]
        own = not is_of_jax(source)
        alone = all(array.size == 1 for array in arguments)
        alone &= all(int(np.prod(out.aval.shape)) == 1 for out in jaxpr.outvars)
        if not (own and alone and len(jaxpr.eqns) >= _SMALLEST_PROCEDURE and "name" in parameters):
            return self._run(jaxpr, known, arguments, None if own else origin)
        procedure = self._procedure(parameters["name"], jaxpr, known)
        call = Call(procedure, tuple(array.item() for array in arguments), origin)
        results = [
            Node("result", result.kind, call.inputs, (call, index), origin)
            for index, result in enumerate(procedure.results)
        ]
        return [
            array_of([node], out.aval.shape)
            for node, out in zip(results, jaxpr.outvars, strict=True)
        ]

    def _branches(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Place | None
    ) -> list[np.ndarray]:
        """All branches, and of their results those of the one that is taken."""
        which, *given_to = arguments
        taken, *others = (
            self._run(each.jaxpr, [self._constant(x, origin) for x in each.consts], given_to, None)
            for each in parameters["branches"]
        )
        for number, branch in enumerate(others, 1):
            least = array_of([literal(np.int32(number), "int32_t")], ())
            here = which
            if which.item().kind != "bool":
                here = elementwise(lambda *inputs: _chosen("ge", *inputs), [which, least])
            taken = [
                elementwise(lambda *inputs: _chosen("select_n", *inputs), [here, old, new])
                for old, new in zip(taken, branch, strict=True)
            ]
        return taken

    def _loop(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Place | None
    ) -> list[np.ndarray]:
        """A procedure of scalars that goes round while its condition holds."""
        if not self._loops:
            raise self._refused("while", origin)
        n_test, n_step = parameters["cond_nconsts"], parameters["body_nconsts"]
        taken: set[str] = set()
        inside = []
        for array in arguments:
            kind = array.reshape(-1)[0].kind
            names = [c_name("x", taken) for _ in range(array.size)]
            inside.append(array_of([given(name, kind) for name in names], array.shape))
        carry = inside[n_test + n_step :]

        def run(jaxpr: Traced, fixed: list[np.ndarray]) -> list[Node]:
            constants = [self._constant(value, origin) for value in jaxpr.consts]
            return scalars(self._run(jaxpr.jaxpr, constants, [*fixed, *carry], None))

        goes_on = run(parameters["cond_jaxpr"], inside[:n_test])[0]
        onwards = run(parameters["body_jaxpr"], inside[n_test : n_test + n_step])
        inputs = scalars(inside)
        loop = LoopProcedure(
            "going_on",
            tuple(str(node.detail) for node in inputs),
            tuple(inputs),
            tuple(scalars(carry)),
            "Goes round while something is left to do.",
            len(onwards),
            goes_on,
            tuple(onwards),
        )
        call = Call(loop, tuple(scalars(arguments)), origin)
        results = [
            Node("result", node.kind, call.inputs, (call, index), origin)
            for index, node in enumerate(loop.results)
        ]
        ends = np.cumsum([array.size for array in carry])
        return [
            array_of(results[end - array.size : end], array.shape)
            for end, array in zip(ends, carry, strict=True)
        ]

    def _procedure(self, name: str, jaxpr: Traced, constants: Sequence[np.ndarray]) -> Procedure:
        text = f"{name}{jaxpr}"
        if text not in self._procedures:
            about = getattr(jaxpr, "debug_info", None)
            names = getattr(about, "arg_names", None) or ()
            if len(names) != len(jaxpr.invars):
                names = [f"x{i}" for i in range(len(jaxpr.invars))]
            taken: set[str] = set()
            names = [c_name(each, taken) for each in names]
            kinds = [self._kind(each.aval, name, None) for each in jaxpr.invars]
            inputs = [given(n, kind) for n, kind in zip(names, kinds, strict=True)]
            arrays = [
                array_of([n], v.aval.shape) for n, v in zip(inputs, jaxpr.invars, strict=True)
            ]
            results = [array.item() for array in self._run(jaxpr, constants, arrays, None)]
            self._procedures[text] = Procedure(
                name,
                tuple(names),
                tuple(inputs),
                tuple(results),
                docstring(getattr(about, "func_src_info", None) or ""),
            )
        return self._procedures[text]


def _chosen(operation: str, *inputs: Node) -> Node:
    """An operation between what branches of a trace gave."""
    kind = "bool" if operation == "ge" else inputs[-1].kind
    return folded(Node(operation, kind, inputs), finite=True)
