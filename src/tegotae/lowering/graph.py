"""A traced function as a graph of scalars: every array taken apart into its entries."""

from __future__ import annotations

import functools
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from tegotae.lowering.nodes import (
    DTYPES,
    KINDS,
    CannotLower,
    Detail,
    Node,
    Parameters,
    Traced,
    array_of,
    constant,
    literal,
    place_of,
)
from tegotae.lowering.rewriting import MOVES, moved

_LONGEST_SCAN = 256
"""Rounds of a loop of known length that are written out one after the other."""
Arrays = Sequence[np.ndarray]
"""Arrays of nodes."""


class Reader(ABC):
    """Reads traces.

    A trace is a jaxpr: a list of operations on arrays of known shape. Each array becomes a NumPy
    array of nodes, so that what only moves entries about (reshape, stack, slice) is done at once,
    and what computes becomes one node an entry. How functions, calls, branches and loops are read
    is a matter of the code that is written of the graph.
    """

    target: ClassVar[str] = "native code"
    """The code, for errors."""
    advice: ClassVar[str] = ""
    """What else to write in place of an operation that it lacks."""
    kinds: ClassVar[Mapping[str, str]] = KINDS
    """Its types, by those of a trace."""

    def read(self, trace: Traced, inputs: Arrays) -> list[np.ndarray]:
        """The results of a closed jaxpr for these arrays of nodes.

        Raises:
            CannotLower: for an operation that cannot be read, by its name and place.
        """
        return self._run_closed(trace, inputs, None)

    @abstractmethod
    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        """The node of an operation, or what it comes to."""

    @abstractmethod
    def _between_entries(
        self, name: str, kind: str, arguments: Arrays, equation: Traced, origin: Traced
    ) -> np.ndarray:
        """An operation between entries."""

    @abstractmethod
    def _call(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        """A call of a trace within."""

    @abstractmethod
    def _fork(
        self, condition: np.ndarray, no: Arrays, yes: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """The results of one of two branches."""

    @abstractmethod
    def _loop(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        """A loop of unknown length."""

    def _refused(self, operation: str, origin: Traced, why: str = "") -> CannotLower:
        return CannotLower(operation, place_of(origin), why or self.advice, self.target)

    def _constant(self, value: ArrayLike, origin: Traced) -> np.ndarray:
        try:
            return constant(value, self.kinds)
        except CannotLower as error:
            raise self._refused(error.operation, origin) from None

    def _kind(self, aval: Traced, name: str, origin: Traced) -> str:
        kind = self.kinds.get(str(aval.dtype))
        if kind is None:
            raise self._refused(name, origin, f"it is of {aval.dtype}")
        return kind

    def _run_closed(self, trace: Traced, inputs: Arrays, origin: Traced) -> list[np.ndarray]:
        constants = [self._constant(value, origin) for value in trace.consts]
        return self._run(trace.jaxpr, constants, inputs, None)

    def _run(
        self, jaxpr: Traced, constants: Arrays, inputs: Arrays, outer: Traced
    ) -> list[np.ndarray]:
        known: dict[Traced, np.ndarray] = dict(zip(jaxpr.constvars, constants, strict=True))
        known.update(zip(jaxpr.invars, inputs, strict=True))

        def value(atom: Traced) -> np.ndarray:
            if hasattr(atom, "val"):  # a number that stands in the program
                return self._constant(np.asarray(atom.val, atom.aval.dtype), outer)
            return known[atom]

        for equation in jaxpr.eqns:
            arguments = [value(atom) for atom in equation.invars]
            results = self._apply(equation, arguments, outer or equation)
            known.update(zip(equation.outvars, results, strict=True))
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
        if name == "scan" and parameters["length"] <= _LONGEST_SCAN:
            return self._rounds(parameters, arguments, origin)
        if name in MOVES:
            try:
                return moved(equation, arguments)
            except CannotLower as error:
                raise self._refused(name, origin, error.why) from None
        if name in _SUMS:
            return [self._reduced(_SUMS[name], arguments[0], parameters["axes"], origin)]
        if name in _RUNNING:
            return [self._running(_RUNNING[name], arguments[0], parameters, origin)]
        kind = self._kind(equation.outvars[0].aval, name, origin)
        if name == "dot_general":
            return [self._product(arguments, parameters, kind, origin)]
        return [self._between_entries(name, kind, arguments, equation, origin)]

    def _branches(
        self, parameters: Parameters, arguments: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Of two branches the one that is taken; of more, of ever later ones."""
        which, *inputs = arguments
        branches = [self._run_closed(x, inputs, origin) for x in parameters["branches"]]
        taken = branches[0]
        for number, branch in enumerate(branches[1:], 1):
            taken = self._fork(self._reaches(which, number, origin), taken, branch, origin)
        return taken

    def _reaches(self, which: np.ndarray, number: int, origin: Traced) -> np.ndarray:
        """Whether the branch of a number, or a later one, is taken."""
        node = which.item()
        if node.kind == "bool":
            return which
        least = array_of([self._number(number, node.kind)], ())
        return self._entrywise("ge", "bool", [which, least], None)

    def _number(self, value: float, kind: str) -> Node:
        """A constant that the reader itself needs."""
        return literal(np.asarray(value, DTYPES[kind])[()], kind)

    def _rounds(
        self, parameters: Parameters, arguments: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """A loop of known length, written out."""
        n_fixed, n_carry = parameters["num_consts"], parameters["num_carry"]
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

    def _reduced(
        self, operation: str, array: np.ndarray, axes: Sequence[int], origin: Traced
    ) -> np.ndarray:
        ahead = np.moveaxis(array, tuple(axes), tuple(range(len(axes))))
        rows = _rows(ahead.reshape(-1, *ahead.shape[len(axes) :]))
        return functools.reduce(self._pairwise(operation, origin), rows)

    def _running(
        self, operation: str, array: np.ndarray, parameters: Parameters, origin: Traced
    ) -> np.ndarray:
        axis, step = parameters["axis"], -1 if parameters["reverse"] else 1
        rows = _rows(np.moveaxis(array, axis, 0))[::step]
        sums = list(itertools.accumulate(rows, self._pairwise(operation, origin)))
        return np.moveaxis(np.stack(sums[::step]), 0, axis)

    def _pairwise(
        self, operation: str, origin: Traced
    ) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
        def both(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            return self._entrywise(operation, "", [a, b], origin)

        return both

    def _product(
        self, arrays: Arrays, parameters: Parameters, kind: str, origin: Traced
    ) -> np.ndarray:
        ((left_sums, right_sums), (left_batch, right_batch)) = parameters["dimension_numbers"]
        if left_batch or right_batch:
            raise self._refused("dot_general", origin, "of batches of matrices")
        left = np.moveaxis(arrays[0], left_sums, range(len(left_sums)))
        right = np.moveaxis(arrays[1], right_sums, range(len(right_sums)))
        inner = int(np.prod(left.shape[: len(left_sums)]))
        free = (*left.shape[len(left_sums) :], *right.shape[len(right_sums) :])
        rows, columns = left.reshape(inner, -1), right.reshape(inner, -1)
        entries = []
        for i, j in itertools.product(range(rows.shape[1]), range(columns.shape[1])):
            terms = [
                self._node("mul", kind, (rows[n, i], columns[n, j]), None, origin)
                for n in range(inner)
            ]
            entries.append(
                functools.reduce(lambda a, b: self._node("add", kind, (a, b), None, origin), terms)
            )
        return array_of(entries, free)

    def _entrywise(
        self, operation: str, kind: str, arrays: Arrays, origin: Traced, detail: Detail = None
    ) -> np.ndarray:
        """An operation between the entries of arrays; its kind is that of the last unless given."""

        def node(*inputs: Node) -> Node:
            return self._node(operation, kind or inputs[-1].kind, inputs, detail, origin)

        return elementwise(node, arrays)


def elementwise(node: Callable[..., Node], arrays: Arrays) -> np.ndarray:
    """What a function of nodes gives for entry after entry of arrays."""
    alike = arrays
    if any(array.shape != arrays[0].shape for array in arrays):
        alike = np.broadcast_arrays(*arrays)
    entries = [node(*nodes) for nodes in zip(*(a.reshape(-1) for a in alike), strict=True)]
    return array_of(entries, alike[0].shape)


def called(parameters: Parameters) -> tuple[Traced, Sequence[ArrayLike], str]:
    """Of an operation that calls a trace: that trace, its constants, and where it is from."""
    inner = parameters.get("jaxpr", parameters.get("call_jaxpr"))
    jaxpr, constants = getattr(inner, "jaxpr", inner), getattr(inner, "consts", ())
    about = getattr(jaxpr, "debug_info", None)
    return jaxpr, constants, getattr(about, "func_src_info", None) or ""


def in_shapes(nodes: Sequence[Node], shapes: Sequence[tuple[int, ...]]) -> list[np.ndarray]:
    """Nodes, one after the other, in arrays of these shapes."""
    sizes = [math.prod(shape) for shape in shapes]
    ends = itertools.accumulate(sizes)
    return [
        array_of(nodes[end - size : end], shape)
        for end, size, shape in zip(ends, sizes, shapes, strict=True)
    ]


def _rows(array: np.ndarray) -> list[np.ndarray]:
    return [np.asarray(row, object) for row in array]


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
