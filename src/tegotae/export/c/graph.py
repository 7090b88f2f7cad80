"""A traced function as a graph of scalars: every array taken apart into its entries."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.export.c.moves import MOVES
from tegotae.export.c.names import (
    Place,
    c_name,
    docstring,
    is_of_jax,
    place_of,
)
from tegotae.export.c.nodes import (
    KINDS,
    Call,
    Loop,
    Node,
    Procedure,
    array_of,
    constant,
    given,
    literal,
)
from tegotae.export.c.primitives import CALLS, SCALAR

_SMALLEST_PROCEDURE = 4
"""Operations from which a function of the package is worth one in C."""


class Reader:
    """Reads traces; procedures that it meets again are the same ones.

    A trace is a jaxpr: a list of operations on arrays of known shape. Each array becomes a NumPy
    array of nodes, so that what only moves entries about (reshape, stack, slice) is done at once,
    and what computes becomes one node an entry.

    Args:
        loops: whether there may be loops of unknown length, which a robot's tick must not have.
    """

    def __init__(self, loops: bool = False) -> None:
        self._loops = loops
        self._procedures: dict[str, Procedure] = {}

    def read(self, trace: Any, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The results of a closed jaxpr for these arrays of nodes.

        Raises:
            TegotaeError: for an operation that has no C, by its name.
        """
        constants = [constant(value) for value in trace.consts]
        return self._run(trace.jaxpr, constants, inputs, None)

    def _run(
        self, jaxpr: Any, constants: Sequence[np.ndarray], inputs: Any, outer: Place | None
    ) -> list[np.ndarray]:
        known: dict[Any, np.ndarray] = dict(zip(jaxpr.constvars, constants, strict=True))
        known.update(zip(jaxpr.invars, inputs, strict=True))

        def value(atom: Any) -> np.ndarray:
            if hasattr(atom, "val"):  # a number that stands in the program
                return constant(np.asarray(atom.val, atom.aval.dtype))
            return known[atom]

        for equation in jaxpr.eqns:
            arguments = [value(atom) for atom in equation.invars]
            place = outer or place_of(equation)
            results = self._apply(equation, arguments, place)
            known.update(zip(equation.outvars, results, strict=True))
        return [value(atom) for atom in jaxpr.outvars]

    def _apply(
        self, equation: Any, arguments: list[np.ndarray], place: Place | None
    ) -> list[np.ndarray]:
        name, parameters = equation.primitive.name, equation.params
        if name in CALLS:
            return self._call(parameters, arguments, place)
        if name == "cond":
            return self._branches(parameters, arguments, place)
        if name == "while" and self._loops:
            return self._loop(parameters, arguments, place)
        if name in MOVES:
            return MOVES[name](arguments, parameters)
        if name in _SUMS:
            return [_reduced(_SUMS[name], arguments[0], parameters["axes"], place)]
        kind = _kind(equation.outvars[0].aval, name)
        if name == "dot_general":
            return [_product(arguments, parameters, kind, place)]
        operation = SCALAR.get(name)
        if operation is None:
            raise TegotaeError(
                f"the controller uses {name!r}{_where(place)}, which cannot be exported; write it "
                "with elementary functions and jnp.where"
            )
        detail = operation.detail(parameters)

        def node(*inputs: Node) -> Node:
            return _folded(Node(name, kind, inputs, detail, place))

        return [_elementwise(node, arguments)]

    def _call(
        self, parameters: Any, arguments: list[np.ndarray], place: Place | None
    ) -> list[np.ndarray]:
        inner = parameters.get("jaxpr", parameters.get("call_jaxpr"))
        jaxpr, constants = getattr(inner, "jaxpr", inner), getattr(inner, "consts", ())
        known = [constant(value) for value in constants]
        about = getattr(jaxpr, "debug_info", None)
        source = getattr(about, "func_src_info", None) or ""
        own = not is_of_jax(source)
        scalars = all(array.size == 1 for array in arguments)
        scalars &= all(int(np.prod(out.aval.shape)) == 1 for out in jaxpr.outvars)
        if not (
            own and scalars and len(jaxpr.eqns) >= _SMALLEST_PROCEDURE and "name" in parameters
        ):
            return self._run(jaxpr, known, arguments, None if own else place)
        procedure = self._procedure(parameters["name"], jaxpr, known, about)
        call = Call(procedure, tuple(array.item() for array in arguments), place)
        results = [
            Node("result", result.kind, call.inputs, (call, index), place)
            for index, result in enumerate(procedure.results)
        ]
        return [
            array_of([node], out.aval.shape)
            for node, out in zip(results, jaxpr.outvars, strict=True)
        ]

    def _branches(
        self, parameters: Any, arguments: list[np.ndarray], place: Place | None
    ) -> list[np.ndarray]:
        """All branches, and of their results those of the one that is taken."""
        which, *given_to = arguments
        kind = which.item().kind
        taken, *others = (
            self._run(each.jaxpr, [constant(x) for x in each.consts], given_to, None)
            for each in parameters["branches"]
        )
        for number, branch in enumerate(others, 1):
            least = array_of([literal(np.int32(number), "int32_t")], ())
            here = (
                which if kind == "bool" else _elementwise(_operator("ge", "bool"), [which, least])
            )
            taken = [
                _elementwise(_operator("select_n", new.reshape(-1)[0].kind), [here, old, new])
                for old, new in zip(taken, branch, strict=True)
            ]
        return taken

    def _loop(
        self, parameters: Any, arguments: list[np.ndarray], place: Place | None
    ) -> list[np.ndarray]:
        """A procedure of scalars that goes round while its condition holds."""
        n_test, n_step = parameters["cond_nconsts"], parameters["body_nconsts"]
        kinds = [each.item().kind for each in map(_first, arguments)]
        taken: set[str] = set()
        inside = []
        for array, kind in zip(arguments, kinds, strict=True):
            names = [c_name("x", taken) for _ in range(array.size)]
            inside.append(array_of([given(name, kind) for name in names], array.shape))
        carry = inside[n_test + n_step :]

        def run(jaxpr: Any, fixed: list[np.ndarray]) -> list[Node]:
            constants = [constant(value) for value in jaxpr.consts]
            return _scalars(self._run(jaxpr.jaxpr, constants, [*fixed, *carry], None))

        goes_on = run(parameters["cond_jaxpr"], inside[:n_test])[0]
        onwards = run(parameters["body_jaxpr"], inside[n_test : n_test + n_step])
        inputs = _scalars(inside)
        loop = Loop(
            "going_on",
            tuple(str(node.detail) for node in inputs),
            tuple(inputs),
            tuple(_scalars(carry)),
            "Goes round while something is left to do.",
            len(onwards),
            goes_on,
            tuple(onwards),
        )
        call = Call(loop, tuple(_scalars(arguments)), place)
        results = [
            Node("result", node.kind, call.inputs, (call, index), place)
            for index, node in enumerate(loop.results)
        ]
        ends = np.cumsum([array.size for array in carry])
        return [
            array_of(results[end - array.size : end], array.shape)
            for end, array in zip(ends, carry, strict=True)
        ]

    def _procedure(self, name: str, jaxpr: Any, constants: Any, about: Any) -> Procedure:
        text = f"{name}{jaxpr}"
        if text not in self._procedures:
            names = getattr(about, "arg_names", None) or ()
            if len(names) != len(jaxpr.invars):
                names = [f"x{i}" for i in range(len(jaxpr.invars))]
            taken: set[str] = set()
            names = [c_name(each, taken) for each in names]
            kinds = [_kind(each.aval, name) for each in jaxpr.invars]
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


def _kind(aval: Any, name: str) -> str:
    dtype = str(aval.dtype)
    if dtype not in KINDS:
        raise TegotaeError(
            f"the controller uses {name!r} in {dtype}, which cannot be exported; C gets "
            f"{', '.join(KINDS)}"
        )
    return KINDS[dtype]


def _where(place: Place | None) -> str:
    return "" if place is None else f" ({place.file.name}, line {place.line})"


def _elementwise(node: Callable[..., Node], arrays: Sequence[np.ndarray]) -> np.ndarray:
    same = np.broadcast_arrays(*arrays)
    return array_of(
        [node(*entries) for entries in zip(*(a.reshape(-1) for a in same), strict=True)],
        same[0].shape,
    )


def _folded(node: Node) -> Node:
    """The node, or what it comes to: its value where all that it is made of is known, less work.

    What is said of finite numbers here is not so of others, which never get that far (README.md).
    """
    operation, inputs = node.operation, node.inputs
    if operation in ("max", "min") and inputs[0] is inputs[1]:
        return inputs[0]
    if operation == "sub" and inputs[0] is inputs[1]:
        return literal(_zero(node.kind), node.kind)
    if operation == "mul" and any(_is(each, 0) for each in inputs):
        return literal(_zero(node.kind), node.kind)
    if operation == "add" and any(_is(each, 0) for each in inputs):
        return inputs[1] if _is(inputs[0], 0) else inputs[0]
    if operation == "select_n" and len(inputs) == 3 and inputs[0].operation == "literal":
        return inputs[2 if inputs[0].detail else 1]
    fold = SCALAR[node.operation].fold
    if fold is None or any(each.operation != "literal" for each in node.inputs):
        return node
    dtype = {kind: name for name, kind in KINDS.items()}[node.kind]
    with np.errstate(all="ignore"):
        value = fold(*(each.detail for each in node.inputs))
    return literal(np.asarray(value).astype(dtype)[()], node.kind)


def _operator(operation: str, kind: str) -> Callable[..., Node]:
    """An operation of its own: between what branches of a trace gave, say."""
    return lambda *inputs: _folded(Node(operation, kind, inputs))


def _first(array: np.ndarray) -> np.ndarray:
    return array.reshape(-1)[:1]


def _scalars(arrays: Sequence[np.ndarray]) -> list[Node]:
    return [node for array in arrays for node in array.reshape(-1)]


def _is(node: Node, value: float) -> bool:
    return node.operation == "literal" and node.detail == value


def _zero(kind: str) -> Any:
    return np.float32(0.0) if kind == "float" else np.int32(0)


def _reduced(operation: str, array: np.ndarray, axes: Any, place: Place | None) -> np.ndarray:
    axes = tuple(axes)
    moved = np.moveaxis(array, axes, tuple(range(len(axes))))
    rows = moved.reshape(-1, *moved.shape[len(axes) :])

    def both(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        def node(*inputs: Node) -> Node:
            return _folded(Node(operation, inputs[0].kind, inputs, None, place))

        return _elementwise(node, [a, b])

    return functools.reduce(both, rows)


def _product(arrays: Any, parameters: Any, kind: str, place: Place | None) -> np.ndarray:
    ((left_sums, right_sums), (left_batch, right_batch)) = parameters["dimension_numbers"]
    if left_batch or right_batch:
        raise TegotaeError("the controller multiplies batches of matrices, which is not exported")
    left = np.moveaxis(arrays[0], left_sums, range(len(left_sums)))
    right = np.moveaxis(arrays[1], right_sums, range(len(right_sums)))
    inner = int(np.prod(left.shape[: len(left_sums)]))
    free = (*left.shape[len(left_sums) :], *right.shape[len(right_sums) :])
    rows, columns = left.reshape(inner, -1), right.reshape(inner, -1)
    entries = []
    for i, j in itertools.product(range(rows.shape[1]), range(columns.shape[1])):
        terms = [Node("mul", kind, (rows[n, i], columns[n, j]), None, place) for n in range(inner)]
        entries.append(functools.reduce(lambda a, b: Node("add", kind, (a, b), None, place), terms))
    return array_of(entries, free)


_SUMS = {
    "reduce_sum": "add",
    "reduce_prod": "mul",
    "reduce_max": "max",
    "reduce_min": "min",
    "reduce_and": "and",
    "reduce_or": "or",
}
"""Operations over an axis, by the one between two entries."""
