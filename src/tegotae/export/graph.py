"""A traced function as a graph of scalars: every array taken apart into its entries."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from tegotae.errors import TegotaeError
from tegotae.export.names import Place, c_name, docstring, is_of_jax, place_of
from tegotae.export.primitives import CALLS, SCALAR

_KINDS = {"float32": "float", "int32": "int32_t", "bool": "bool"}
_SMALLEST_PROCEDURE = 4
"""Operations from which a function of the package is worth one in C."""
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


class Reader:
    """Reads traces; procedures that it meets again are the same ones.

    A trace is a jaxpr: a list of operations on arrays of known shape. Each array becomes a NumPy
    array of nodes, so that what only moves entries about (reshape, stack, slice) is done at once,
    and what computes becomes one node an entry.
    """

    def __init__(self) -> None:
        self._procedures: dict[str, Procedure] = {}

    def read(self, trace: Any, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The results of a closed jaxpr for these arrays of nodes.

        Raises:
            TegotaeError: for an operation that has no C, by its name.
        """
        constants = [_constant(value) for value in trace.consts]
        return self._run(trace.jaxpr, constants, inputs, None)

    def _run(
        self, jaxpr: Any, constants: Sequence[np.ndarray], inputs: Any, outer: Place | None
    ) -> list[np.ndarray]:
        known: dict[Any, np.ndarray] = dict(zip(jaxpr.constvars, constants, strict=True))
        known.update(zip(jaxpr.invars, inputs, strict=True))

        def value(atom: Any) -> np.ndarray:
            if hasattr(atom, "val"):  # a number that stands in the program
                return _constant(np.asarray(atom.val, atom.aval.dtype))
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
        if name in _MOVES:
            return _MOVES[name](arguments, parameters)
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
        known = [_constant(value) for value in constants]
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
            _array([node], out.aval.shape) for node, out in zip(results, jaxpr.outvars, strict=True)
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
            arrays = [_array([n], v.aval.shape) for n, v in zip(inputs, jaxpr.invars, strict=True)]
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
    if dtype not in _KINDS:
        raise TegotaeError(
            f"the controller uses {name!r} in {dtype}, which cannot be exported; C gets "
            f"{', '.join(_KINDS)}"
        )
    return _KINDS[dtype]


def _where(place: Place | None) -> str:
    return "" if place is None else f" ({place.file.name}, line {place.line})"


def _array(nodes: Sequence[Node], shape: tuple[int, ...]) -> np.ndarray:
    array = np.empty(len(nodes), object)
    array[:] = nodes
    return array.reshape(shape)


def _constant(value: Any) -> np.ndarray:
    numbers = np.asarray(value)
    kind = _KINDS.get(str(numbers.dtype))
    if kind is None:
        raise TegotaeError(
            f"the controller holds numbers of {numbers.dtype}, which cannot be exported"
        )
    return _array([literal(each, kind) for each in numbers.reshape(-1)], numbers.shape)


def _elementwise(node: Callable[..., Node], arrays: Sequence[np.ndarray]) -> np.ndarray:
    same = np.broadcast_arrays(*arrays)
    return _array(
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
    dtype = {kind: name for name, kind in _KINDS.items()}[node.kind]
    with np.errstate(all="ignore"):
        value = fold(*(each.detail for each in node.inputs))
    return literal(np.asarray(value).astype(dtype)[()], node.kind)


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
    return _array(entries, free)


def _known(array: np.ndarray) -> int:
    node = array.item()
    if node.operation != "literal":
        raise TegotaeError(
            "the controller picks an entry by a number that it computes, which is "
            "not exported; pick it by jnp.where"
        )
    return int(node.detail)


def _in_dimensions(arrays: Any, parameters: Any) -> list[np.ndarray]:
    array, shape = arrays[0], parameters["shape"]
    whole = [1] * len(shape)
    for axis, at in enumerate(parameters["broadcast_dimensions"]):
        whole[at] = array.shape[axis]
    return [np.broadcast_to(array.reshape(whole), shape)]


def _slice(arrays: Any, parameters: Any) -> list[np.ndarray]:
    strides = parameters["strides"] or (1,) * arrays[0].ndim
    bounds = zip(parameters["start_indices"], parameters["limit_indices"], strides, strict=True)
    return [arrays[0][tuple(slice(*each) for each in bounds)]]


def _dynamic_slice(arrays: Any, parameters: Any) -> list[np.ndarray]:
    array, *starts = arrays
    sizes = parameters["slice_sizes"]
    firsts = [
        min(max(_known(at), 0), length - size)
        for at, length, size in zip(starts, array.shape, sizes, strict=True)
    ]
    return [array[tuple(slice(at, at + n) for at, n in zip(firsts, sizes, strict=True))]]


def _split(arrays: Any, parameters: Any) -> list[np.ndarray]:
    ends = np.cumsum(parameters["sizes"])[:-1]
    return list(np.split(arrays[0], ends, axis=parameters["axis"]))


def _iota(arrays: Any, parameters: Any) -> list[np.ndarray]:
    shape, at = parameters["shape"], parameters["dimension"]
    numbers = np.arange(shape[at]).reshape([-1 if i == at else 1 for i in range(len(shape))])
    dtype = jax.dtypes.canonicalize_dtype(parameters["dtype"])
    return [_constant(np.broadcast_to(numbers, shape).astype(dtype))]


_MOVES: dict[str, Callable[[Any, Any], list[np.ndarray]]] = {
    "broadcast_in_dim": _in_dimensions,
    "reshape": lambda a, p: [a[0].reshape(p["new_sizes"])],
    "squeeze": lambda a, p: [np.squeeze(a[0], tuple(p["dimensions"]))],
    "expand_dims": lambda a, p: [np.expand_dims(a[0], tuple(p["dimensions"]))],
    "transpose": lambda a, p: [np.transpose(a[0], p["permutation"])],
    "rev": lambda a, p: [np.flip(a[0], tuple(p["dimensions"]))],
    "concatenate": lambda a, p: [np.concatenate(a, axis=p["dimension"])],
    "stack": lambda a, p: [np.stack(a, axis=p["axis"])],
    "unstack": lambda a, p: list(np.moveaxis(a[0], p["axis"], 0)),
    "slice": _slice,
    "dynamic_slice": _dynamic_slice,
    "split": _split,
    "iota": _iota,
    "copy": lambda a, p: [a[0]],
    "copy_p": lambda a, p: [a[0]],
    "stop_gradient": lambda a, p: [a[0]],
}
"""Operations that only put entries elsewhere."""
_SUMS = {
    "reduce_sum": "add",
    "reduce_prod": "mul",
    "reduce_max": "max",
    "reduce_min": "min",
    "reduce_and": "and",
    "reduce_or": "or",
}
"""Operations over an axis, by the one between two entries."""
