"""A traced function as a graph of scalars: every array taken apart into its entries."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from tegotae.lowering.functions import function
from tegotae.lowering.nodes import (
    DTYPES,
    KINDS,
    CannotLower,
    Detail,
    Fork,
    Loop,
    Node,
    Parameters,
    Traced,
    array_of,
    constant,
    given,
    is_of_jax,
    literal,
    place_of,
    scalars,
)
from tegotae.lowering.operations import CALLS, OPERATIONS
from tegotae.lowering.rewriting import MOVES, folded, moved_by_number

_LONGEST_SCAN = 256
"""Rounds of a loop of known length that are written out one after the other."""


class Reader:
    """Reads traces; what it meets again is the same node.

    A trace is a jaxpr: a list of operations on arrays of known shape. Each array becomes a NumPy
    array of nodes, so that what only moves entries about (reshape, stack, slice) is done at once,
    and what computes becomes one node an entry. Calls are read as if they stood there; elementary
    functions become the package's own (`functions`); a `cond` stays a branch, a `while` a loop.
    """

    def __init__(self) -> None:
        self._nodes: dict[tuple[object, ...], Node] = {}

    def read(self, trace: Traced, inputs: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The results of a closed jaxpr for these arrays of nodes.

        Raises:
            CannotLower: for an operation that cannot be read, by its name and place.
        """
        constants = [self._constant(value, None) for value in trace.consts]
        return self._run(trace.jaxpr, constants, inputs, None)

    # What other targets do in ways of their own.

    def _origin(self, equation: Traced, outer: Traced) -> Traced:
        """What knows where an operation comes from."""
        return outer or equation

    def _refused(self, operation: str, origin: Traced, why: str = "") -> Exception:
        return CannotLower(operation, place_of(origin), why)

    def _constant(self, value: ArrayLike, origin: Traced) -> np.ndarray:
        try:
            return constant(value)
        except CannotLower as error:
            raise self._refused(error.operation, origin) from None

    def _kind(self, aval: Traced, name: str, origin: Traced) -> str:
        kind = KINDS.get(str(aval.dtype))
        if kind is None:
            raise self._refused(name, origin, f"of {aval.dtype}")
        return kind

    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        """The node of an operation, or what it comes to."""
        return self._shared(folded(Node(operation, kind, inputs, detail)))

    def _term(self, operation: str, kind: str, inputs: tuple[Node, ...], origin: Traced) -> Node:
        """A node of a product of matrices."""
        return self._node(operation, kind, inputs, None, origin)

    def _scalar(
        self,
        name: str,
        kind: str,
        arguments: Sequence[np.ndarray],
        equation: Traced,
        origin: Traced,
    ) -> np.ndarray:
        """An operation between entries."""
        operation = OPERATIONS.get(name)
        whole = function(equation)
        if whole is not None:
            scalar_axes = [array.reshape(-1) for array in _alike(arguments)]

            def entry(*nodes: Node) -> Node:
                inner = [array_of([node], ()) for node in nodes]
                constants = [constant(value) for value in whole.consts]
                return self._run(whole.jaxpr, constants, inner, origin)[0].item()

            entries = [entry(*nodes) for nodes in zip(*scalar_axes, strict=True)]
            return array_of(entries, _alike(arguments)[0].shape)
        if operation is None or operation.llvm is None:
            raise self._refused(name, origin)
        detail = operation.detail(equation.params)
        return elementwise(
            lambda *inputs: self._node(name, kind, inputs, detail, origin), arguments
        )

    def _call(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        jaxpr, constants, about = called(parameters)
        known = [self._constant(value, origin) for value in constants]
        return self._run(jaxpr, known, arguments, origin if is_of_jax(about) else None)

    def _branches(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        """Of two branches the one that is taken; of more, of ever later ones."""
        which, *given_to = arguments
        branches = [
            self._run(each.jaxpr, [self._constant(x, origin) for x in each.consts], given_to, None)
            for each in parameters["branches"]
        ]
        taken = branches[0]
        for number, branch in enumerate(branches[1:], 1):
            condition = self._reaches(which.item(), number, origin)
            no, yes = scalars(taken), scalars(branch)
            taken = _in_shapes(self._decided(condition, no, yes), [each.shape for each in branch])
        return taken

    def _reaches(self, which: Node, number: int, origin: Traced) -> Node:
        """Whether the branch of a number, or a later one, is taken."""
        if which.kind == "bool":
            return which
        if which.operation == "convert_element_type" and which.inputs[0].kind == "bool":
            return which.inputs[0]
        least = literal(np.asarray(number, DTYPES[which.kind])[()], which.kind)
        return self._node("ge", "bool", (which, self._shared(least)), None, origin)

    def _decided(self, condition: Node, no: list[Node], yes: list[Node]) -> list[Node]:
        if condition.operation == "literal":
            return yes if condition.detail else no
        differ = [i for i, (a, b) in enumerate(zip(no, yes, strict=True)) if a is not b]
        branch = Fork(tuple(no[i] for i in differ), tuple(yes[i] for i in differ))
        node = Node("branch", "", (condition, *branch.no, *branch.yes), branch)
        results = list(no)
        for part, i in enumerate(differ):
            results[i] = Node("part", no[i].kind, (node,), part)
        return results

    def _loop(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        n_test, n_step = parameters["cond_nconsts"], parameters["body_nconsts"]
        begins = arguments[n_test + n_step :]
        carried = [
            array_of([given(("carried",), node.kind) for node in array.reshape(-1)], array.shape)
            for array in begins
        ]

        def run(jaxpr: Traced, fixed: list[np.ndarray]) -> list[Node]:
            constants = [self._constant(value, origin) for value in jaxpr.consts]
            return scalars(self._run(jaxpr.jaxpr, constants, [*fixed, *carried], None))

        goes_on = run(parameters["cond_jaxpr"], arguments[:n_test])[0]
        onwards = run(parameters["body_jaxpr"], arguments[n_test : n_test + n_step])
        loop = Loop(tuple(scalars(carried)), goes_on, tuple(onwards))
        outside = _read_from_outside(loop)
        node = Node("loop", "", (*scalars(begins), *outside), loop)
        results = [Node("part", each.kind, (node,), i) for i, each in enumerate(loop.carried)]
        return _in_shapes(results, [array.shape for array in carried])

    # What all of them share.

    def _shared(self, node: Node) -> Node:
        """The node that is the same as this one, of those met so far."""
        if node.operation == "literal":
            key: tuple[object, ...] = (
                node.kind,
                np.asarray(node.detail, DTYPES[node.kind]).tobytes(),
            )
        elif node.operation in ("given", "part", "branch", "loop"):
            return node
        else:
            inputs = [each.number for each in node.inputs]
            if node.operation in _COMMUTE:
                inputs.sort()
            key = (node.operation, node.kind, node.detail, *inputs)
        return self._nodes.setdefault(key, node)

    def _run(
        self,
        jaxpr: Traced,
        constants: Sequence[np.ndarray],
        inputs: Sequence[np.ndarray],
        outer: Traced,
    ) -> list[np.ndarray]:
        known: dict[Traced, np.ndarray] = dict(zip(jaxpr.constvars, constants, strict=True))
        known.update(zip(jaxpr.invars, inputs, strict=True))

        def value(atom: Traced) -> np.ndarray:
            if hasattr(atom, "val"):  # a number that stands in the program
                return self._constant(np.asarray(atom.val, atom.aval.dtype), outer)
            return known[atom]

        for equation in jaxpr.eqns:
            arguments = [value(atom) for atom in equation.invars]
            origin = self._origin(equation, outer)
            results = self._apply(equation, arguments, origin)
            known.update(zip(equation.outvars, results, strict=True))
        return [value(atom) for atom in jaxpr.outvars]

    def _apply(
        self, equation: Traced, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        name: str = equation.primitive.name
        name, parameters = _ALIASES.get(name, name), equation.params
        if name in CALLS:
            return self._call(parameters, arguments, origin)
        if name == "cond":
            return self._branches(parameters, arguments, origin)
        if name == "while":
            return self._loop(parameters, arguments, origin)
        if name == "scan" and parameters["length"] <= _LONGEST_SCAN:
            return self._rounds(parameters, arguments, origin)
        if name in MOVES:
            try:
                return MOVES[name](arguments, parameters)
            except CannotLower as error:
                raise self._refused(name, origin, error.why) from None
        if name in _SUMS:
            return [self._reduced(_SUMS[name], arguments[0], parameters["axes"], origin)]
        if name in _RUNNING:
            return [self._running(_RUNNING[name], arguments[0], parameters, origin)]
        kind = self._kind(equation.outvars[0].aval, name, origin)
        if name == "dot_general":
            return [self._product(arguments, parameters, kind, origin)]
        if name in _BY_NUMBER:
            try:
                return moved_by_number(equation, arguments)
            except CannotLower as error:
                raise self._refused(name, origin, error.why) from None
        return [self._scalar(name, kind, arguments, equation, origin)]

    def _rounds(
        self, parameters: Parameters, arguments: list[np.ndarray], origin: Traced
    ) -> list[np.ndarray]:
        """A loop of known length, written out."""
        trace, n_fixed, n_carry = (parameters[k] for k in ("jaxpr", "num_consts", "num_carry"))
        fixed, carry = arguments[:n_fixed], arguments[n_fixed : n_fixed + n_carry]
        rows = arguments[n_fixed + n_carry :]
        constants = [self._constant(value, origin) for value in trace.consts]
        numbers = range(parameters["length"])
        found: dict[int, list[np.ndarray]] = {}
        for i in reversed(numbers) if parameters["reverse"] else numbers:
            results = self._run(
                trace.jaxpr,
                constants,
                [*fixed, *carry, *(np.asarray(each[i], object) for each in rows)],
                None,
            )
            carry, found[i] = results[:n_carry], results[n_carry:]
        columns = zip(*(found[i] for i in numbers), strict=True)
        return [*carry, *(np.stack(column) for column in columns)]

    def _reduced(
        self, operation: str, array: np.ndarray, axes: Sequence[int], origin: Traced
    ) -> np.ndarray:
        axes = tuple(axes)
        moved = np.moveaxis(array, axes, tuple(range(len(axes))))
        rows = _rows(moved.reshape(-1, *moved.shape[len(axes) :]))
        return functools.reduce(functools.partial(self._between, operation, origin), rows)

    def _running(
        self, operation: str, array: np.ndarray, parameters: Parameters, origin: Traced
    ) -> np.ndarray:
        axis, backwards = parameters["axis"], parameters["reverse"]
        rows = _rows(np.moveaxis(array, axis, 0))
        rows = rows[::-1] if backwards else rows
        both = functools.partial(self._between, operation, origin)
        found = list(itertools.accumulate(rows, both))
        return np.moveaxis(np.stack(found[::-1] if backwards else found), 0, axis)

    def _between(self, operation: str, origin: Traced, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        def node(*inputs: Node) -> Node:
            return self._node(operation, inputs[0].kind, inputs, None, origin)

        return elementwise(node, [a, b])

    def _product(
        self, arrays: Sequence[np.ndarray], parameters: Parameters, kind: str, origin: Traced
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
                self._term("mul", kind, (rows[n, i], columns[n, j]), origin) for n in range(inner)
            ]
            entries.append(
                functools.reduce(lambda a, b: self._term("add", kind, (a, b), origin), terms)
            )
        return array_of(entries, free)


def called(parameters: Parameters) -> tuple[Traced, Sequence[ArrayLike], str]:
    """Of an operation that calls a trace: that trace, its constants, and where it is from."""
    inner = parameters.get("jaxpr", parameters.get("call_jaxpr"))
    jaxpr, constants = getattr(inner, "jaxpr", inner), getattr(inner, "consts", ())
    about = getattr(jaxpr, "debug_info", None)
    return jaxpr, constants, getattr(about, "func_src_info", None) or ""


def _rows(array: np.ndarray) -> list[np.ndarray]:
    return [np.asarray(row, object) for row in array]


def _alike(arrays: Sequence[np.ndarray]) -> Sequence[np.ndarray]:
    """The arrays in one shape."""
    if all(array.shape == arrays[0].shape for array in arrays):
        return arrays
    return np.broadcast_arrays(*arrays)


def elementwise(node: Callable[..., Node], arrays: Sequence[np.ndarray]) -> np.ndarray:
    same = _alike(arrays)
    entries = [node(*nodes) for nodes in zip(*(a.reshape(-1) for a in same), strict=True)]
    return array_of(entries, same[0].shape)


def _in_shapes(nodes: list[Node], shapes: Sequence[tuple[int, ...]]) -> list[np.ndarray]:
    sizes = [int(np.prod(shape, dtype=int)) for shape in shapes]
    ends = np.cumsum(sizes)
    return [
        array_of(nodes[end - size : end], shape)
        for end, size, shape in zip(ends, sizes, shapes, strict=True)
    ]


def _read_from_outside(loop: Loop) -> tuple[Node, ...]:
    """What a round of a loop reads that does not change from round to round."""
    changes: dict[Node, bool] = dict.fromkeys(loop.carried, True)
    order = reachable((loop.goes_on, *loop.onwards))
    for node in order:
        changes.setdefault(node, any(changes[each] for each in node.inputs))
    read = {each: None for node in order if changes[node] for each in node.inputs}
    read.update(dict.fromkeys((loop.goes_on, *loop.onwards)))
    return tuple(each for each in read if not changes[each] and each.operation != "literal")


def reachable(nodes: Sequence[Node]) -> list[Node]:
    """All that the nodes are made of, in an order in which it can be computed."""
    found: set[Node] = set()
    left = list(nodes)
    while left:
        node = left.pop()
        if node not in found:
            found.add(node)
            left += node.inputs
    return sorted(found, key=lambda node: node.number)


_ALIASES = {"add_any": "add"}
"""Operations that are others under a name of their own: of derivatives, the sum."""
_COMMUTE = frozenset(("add", "mul", "and", "or", "xor", "eq", "ne"))
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
_BY_NUMBER = frozenset(("gather", "scatter", "dynamic_update_slice", "pad"))
"""Operations that put entries where numbers say."""
