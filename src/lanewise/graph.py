"""A traced function as a graph of scalars: every array taken apart into its entries."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lanewise.nodes import (
    DTYPES,
    KINDS,
    CannotLower,
    Detail,
    Node,
    Parameters,
    Traced,
    array_of,
    constant,
    dtype_name,
    literal,
    place_of,
)

_LONGEST_SCAN = 256
"""Rounds of a loop of known length that are written out one after the other."""
Arrays = Sequence[np.ndarray]
"""Arrays of nodes."""


class Reader(ABC):
    """Reader of traces.

    A trace is a jaxpr: a list of operations on arrays of known shape. Each array becomes a NumPy
    array of nodes, so that what only moves entries about (reshape, stack, slice) is done at once,
    and what computes becomes one node an entry. How functions, calls, branches and loops are read
    is a matter of the code that is written of the graph.
    """

    target: ClassVar[str] = "native code"
    """The code, for errors."""
    advice: ClassVar[str] = ""
    """Advice for an unsupported operation."""
    kinds: ClassVar[Mapping[str, str]] = KINDS
    """Its types, by those of a trace."""

    def read(self, trace: Traced, inputs: Arrays) -> list[np.ndarray]:
        """Return the results of a closed jaxpr for these arrays of nodes.

        Raises:
            CannotLower: for an operation that cannot be read, by its name and place.
        """
        return self._run_closed(trace, inputs, None)

    @abstractmethod
    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        """Return the node of an operation, folded where possible."""

    @abstractmethod
    def _between_entries(
        self, name: str, kind: str, arguments: Arrays, equation: Traced, origin: Traced
    ) -> np.ndarray:
        """Return the results of an operation between entries of arrays."""

    @abstractmethod
    def _call(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        """Return the results of a call of an inner trace."""

    @abstractmethod
    def _fork(
        self, condition: np.ndarray, no: Arrays, yes: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Return the results of one of two branches."""

    def _loop(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        """Return the results of a loop of unknown length."""
        raise self._refused("while", origin)

    def _refused(self, operation: str, origin: Traced, reason: str = "") -> CannotLower:
        return CannotLower(operation, place_of(origin), reason or self.advice, self.target)

    def _constant(self, value: ArrayLike, origin: Traced) -> np.ndarray:
        try:
            return constant(value, self.kinds)
        except CannotLower as error:
            raise self._refused(error.operation, origin) from None

    def _kind(self, aval: Traced, name: str, origin: Traced) -> str:
        kind = self.kinds.get(dtype_name(aval.dtype))
        if kind is None:
            raise self._refused(name, origin, f"it is of {aval.dtype}")
        return kind

    def _run_closed(self, trace: Traced, inputs: Arrays, origin: Traced) -> list[np.ndarray]:
        constants = [self._constant(value, origin) for value in trace.consts]
        return self._run(trace.jaxpr, constants, inputs, None)

    def _run(
        self, jaxpr: Traced, constants: Arrays, inputs: Arrays, caller: Traced
    ) -> list[np.ndarray]:
        values: dict[Traced, np.ndarray] = dict(zip(jaxpr.constvars, constants, strict=True))
        values.update(zip(jaxpr.invars, inputs, strict=True))

        def value(atom: Traced) -> np.ndarray:
            if hasattr(atom, "val"):  # a number that stands in the program
                return self._constant(np.asarray(atom.val, atom.aval.dtype), caller)
            return values[atom]

        for equation in jaxpr.eqns:
            arguments = [value(atom) for atom in equation.invars]
            results = self._apply(equation, arguments, caller or equation)
            values.update(zip(equation.outvars, results, strict=True))
        return [value(atom) for atom in jaxpr.outvars]

    def _apply(
        self, equation: Traced, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        name: str = equation.primitive.name
        name, parameters = _ALIASES.get(name, name), equation.params
        if name in _CALLS:
            return self._call(parameters, arguments, origin)
        if name == "cond":
            return self._branches(parameters, arguments, origin)
        if name == "while":
            return self._loop(parameters, arguments, origin)
        if name == "scan":
            return self._rounds(parameters, arguments, origin)
        if name in _MOVES:
            try:
                return _moved(equation, arguments)
            except CannotLower as error:
                raise self._refused(name, origin, error.why) from None
        if name in _SUMS:
            return [self._reduced(_SUMS[name], arguments[0], parameters["axes"], origin)]
        if name in _RUNNING:
            return [self._running(_RUNNING[name], arguments[0], parameters, origin)]
        kind = self._kind(equation.outvars[0].aval, name, origin)
        if name == "dot_general":
            return [self._product(arguments, parameters, origin)]
        return [self._between_entries(name, kind, arguments, equation, origin)]

    def _branches(
        self, parameters: Parameters, arguments: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Select the taken branch by a chain of forks."""
        index, *inputs = arguments
        branches = [self._run_closed(x, inputs, origin) for x in parameters["branches"]]
        taken = branches[0]
        for number, branch in enumerate(branches[1:], 1):
            taken = self._fork(self._reaches(index, number, origin), taken, branch, origin)
        return taken

    def _reaches(self, index: np.ndarray, number: int, origin: Traced) -> np.ndarray:
        """Return whether the branch of an index, or a later one, is taken."""
        node = index.item()
        if node.kind == "bool":
            return index
        bound = array_of([self._number(number, node.kind)], ())
        return self._entrywise("ge", "bool", [index, bound], None)

    def _number(self, value: float, kind: str) -> Node:
        """Return a constant that the reader itself needs."""
        return literal(np.asarray(value, DTYPES[kind])[()], kind)

    def _rounds(
        self, parameters: Parameters, arguments: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Return the results of a loop of known length, written out."""
        if parameters["length"] > _LONGEST_SCAN:
            raise self._refused("scan", origin, f"it has more than {_LONGEST_SCAN} rounds")
        n_fixed, n_carry = scan_sizes(parameters)
        fixed, carry = arguments[:n_fixed], arguments[n_fixed : n_fixed + n_carry]
        rows = arguments[n_fixed + n_carry :]
        numbers = range(parameters["length"])
        columns: dict[int, Arrays] = {}
        for i in reversed(numbers) if parameters["reverse"] else numbers:
            inputs = [*fixed, *carry, *(np.asarray(row[i], object) for row in rows)]
            results = self._run_closed(parameters["jaxpr"], inputs, origin)
            carry, columns[i] = results[:n_carry], results[n_carry:]
        stacked = zip(*(columns[i] for i in numbers), strict=True)
        return [*carry, *(np.stack(column) for column in stacked)]

    def _pairwise(self, operation: str, origin: Traced) -> np.ufunc:
        """Return a NumPy function that applies an operation to arrays of nodes, pair by pair."""

        def conjunction(a: Node, b: Node) -> Node:
            return self._node(operation, b.kind, (a, b), None, origin)

        return np.frompyfunc(conjunction, 2, 1)

    def _reduced(
        self, operation: str, array: np.ndarray, axes: Sequence[int], origin: Traced
    ) -> np.ndarray:
        ahead = np.moveaxis(array, tuple(axes), tuple(range(len(axes))))
        rows = ahead.reshape(-1, *ahead.shape[len(axes) :])
        return np.asarray(self._pairwise(operation, origin).reduce(rows), object)

    def _running(
        self, operation: str, array: np.ndarray, parameters: Parameters, origin: Traced
    ) -> np.ndarray:
        axis, step = parameters["axis"], -1 if parameters["reverse"] else 1
        rows = np.moveaxis(array, axis, 0)[::step]
        sums = self._pairwise(operation, origin).accumulate(rows, dtype=object)
        return np.moveaxis(sums[::step], 0, axis)

    def _product(self, arrays: Arrays, parameters: Parameters, origin: Traced) -> np.ndarray:
        ((left_sums, right_sums), (left_batch, right_batch)) = parameters["dimension_numbers"]
        if left_batch or right_batch:
            raise self._refused("dot_general", origin, "of batches of matrices")
        left_rows = np.moveaxis(arrays[0], left_sums, range(len(left_sums)))
        right = np.moveaxis(arrays[1], right_sums, range(len(right_sums)))
        terms = math.prod(left_rows.shape[: len(left_sums)])
        free = (*left_rows.shape[len(left_sums) :], *right.shape[len(right_sums) :])
        rows, columns = left_rows.reshape(terms, -1).T, right.reshape(terms, -1).T
        times, plus = (self._pairwise(name, origin) for name in ("mul", "add"))
        entries = [plus.reduce(times(row, column)) for row in rows for column in columns]
        return array_of(entries, free)

    def _entrywise(
        self, operation: str, kind: str, arrays: Arrays, origin: Traced, detail: Detail = None
    ) -> np.ndarray:
        """Apply an operation to the entries of arrays; its kind is that of the last unless
        given.
        """

        def node(*inputs: Node) -> Node:
            return self._node(operation, kind or inputs[-1].kind, inputs, detail, origin)

        return elementwise(node, arrays)


def scan_sizes(parameters: Parameters) -> tuple[int, int]:
    """Return the numbers of constant and of carried inputs of a `scan`; JAX 0.11 counts anew."""
    if "ft_in" in parameters:
        fixed, carry, _ = parameters["ft_in"].elts
        return len(fixed), len(carry)
    return parameters["num_consts"], parameters["num_carry"]


def elementwise(node: Callable[..., Node], arrays: Arrays) -> np.ndarray:
    """Apply a function of nodes to arrays entry by entry."""
    if all(array.ndim == 0 for array in arrays):  # as in most operations, and faster
        return array_of([node(*[array.item() for array in arrays])], ())
    return np.asarray(np.frompyfunc(node, len(arrays), 1)(*arrays), object)


def callee(parameters: Parameters) -> tuple[Traced, Sequence[ArrayLike], str]:
    """Return the trace that an operation calls, its constants, and its origin."""
    closed = parameters.get("jaxpr", parameters.get("call_jaxpr"))
    jaxpr, constants = getattr(closed, "jaxpr", closed), getattr(closed, "consts", ())
    info = getattr(jaxpr, "debug_info", None)
    return jaxpr, constants, getattr(info, "func_src_info", None) or ""


def in_shapes(nodes: Sequence[Node], shapes: Sequence[tuple[int, ...]]) -> list[np.ndarray]:
    """Return consecutive nodes as arrays of these shapes."""
    sizes = [math.prod(shape) for shape in shapes]
    ends = itertools.accumulate(sizes)
    return [
        array_of(nodes[end - size : end], shape)
        for end, size, shape in zip(ends, sizes, shapes, strict=True)
    ]


def _in_dimensions(array: np.ndarray, parameters: Parameters) -> np.ndarray:
    shape = parameters["shape"]
    shape_in = [1] * len(shape)
    for axis, dimension in enumerate(parameters["broadcast_dimensions"]):
        shape_in[dimension] = array.shape[axis]
    return np.broadcast_to(array.reshape(shape_in), shape)


def _slice(array: np.ndarray, parameters: Parameters) -> np.ndarray:
    strides = parameters["strides"] or (1,) * array.ndim
    bounds = zip(parameters["start_indices"], parameters["limit_indices"], strides, strict=True)
    return array[tuple(itertools.starmap(slice, bounds))]


_QUICK: dict[str, Callable[[Arrays, Parameters], np.ndarray]] = {
    "broadcast_in_dim": lambda a, p: _in_dimensions(a[0], p),
    "reshape": lambda a, p: a[0].reshape(p["new_sizes"]),
    "squeeze": lambda a, p: np.squeeze(a[0], tuple(p["dimensions"])),
    "transpose": lambda a, p: np.transpose(a[0], p["permutation"]),
    "concatenate": lambda a, p: np.concatenate(a, axis=p["dimension"]),
    "stack": lambda a, p: np.stack(a, axis=p["axis"]),
    "slice": lambda a, p: _slice(a[0], p),
}
"""NumPy functions of the most frequent operations, by their names in a trace."""
_PLACED = {
    **{"dynamic_slice": (0,), "gather": (0,)},
    **{"scatter": (0, 2), "dynamic_update_slice": (0, 1)},
}
"""Moves to or from places that other operands say, by which of the operands hold entries."""
_MOVES = frozenset(
    (*_QUICK, *_PLACED, "copy", "copy_p", "expand_dims", "iota", "pad", "rev", "split", "unstack")
)
"""Operations that only move entries."""


def _moved(equation: Traced, arguments: Arrays) -> list[np.ndarray]:
    """Return the result of an operation of `_MOVES`, which only moves numbers.

    Raises:
        CannotLower: for places that are computed.
    """
    name, primitive = equation.primitive.name, equation.primitive
    if name in _QUICK:
        return [_QUICK[name](arguments, equation.params)]
    if name == "iota":
        return [constant(np.asarray(primitive.bind(**equation.params)))]
    entries, numbered = [], []
    for position, array in enumerate(arguments):
        if position in _PLACED.get(name, (position,)):
            numbers = np.arange(array.size, dtype=np.int32) + np.int32(len(entries))
            entries += list(array.reshape(-1))
        else:
            dtype = equation.invars[position].aval.dtype
            numbers = np.asarray([_static_index(node, name) for node in array.reshape(-1)], dtype)
        numbered.append(numbers.reshape(array.shape))
    parameters = dict(equation.params)
    if "fill_value" in parameters:
        parameters["fill_value"] = len(entries)
    dtype = equation.outvars[0].aval.dtype
    filling = np.nan if np.issubdtype(dtype, np.floating) else 0
    nodes = array_of([*entries, constant(np.asarray(filling, dtype)).item()], (-1,))
    results = primitive.bind(*numbered, **parameters)
    return [nodes[np.asarray(x)] for x in (results if primitive.multiple_results else [results])]


def _static_index(node: Node, name: str) -> int:
    if node.operation != "literal":
        reason = "it picks an entry by a number that is computed; pick it by jnp.where"
        raise CannotLower(name, reason=reason)
    return int(node.detail)


_ALIASES = {"add_any": "add"}
"""Operations that are others under a name of their own: of derivatives, the sum."""
_CALLS = frozenset(
    ("jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "remote")
)
"""Operations that call a trace within."""
_SUMS = {
    "reduce_sum": "add",
    "reduce_prod": "mul",
    "reduce_max": "max",
    "reduce_min": "min",
    "reduce_and": "and",
    "reduce_or": "or",
    "reduce_xor": "xor",
}
"""Operations over an axis, by the one between two entries."""
_RUNNING = {"cumsum": "add", "cumprod": "mul", "cummax": "max", "cummin": "min"}
"""Operations along an axis, by the one between two entries."""
