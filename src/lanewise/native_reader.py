"""Traces as graphs for native code: equal operations once, functions made of basic operations."""

from __future__ import annotations

import itertools
import math

import jax
import numpy as np

from lanewise.functions import function
from lanewise.graph import Arrays, Reader, callee, elementwise, in_shapes, scan_sizes
from lanewise.nodes import (
    DTYPES,
    FLOATS,
    KINDS,
    TICK,
    Detail,
    Fork,
    Loop,
    Node,
    Parameters,
    Traced,
    Tree,
    array_of,
    input_node,
    is_of_jax,
    scalars,
)
from lanewise.operations import OPERATIONS, folded


class NativeReader(Reader):
    """Reader of traces in which equal operations become one node.

    Calls are read as if they stood there; elementary functions become the package's own
    (`functions`); a `cond` stays a branch, a `while` a loop. It divides where it must, and when.
    """

    def __init__(self) -> None:
        self._nodes: dict[tuple[object, ...], Node] = {}

    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        if operation == "div" and kind in FLOATS and inputs[1].operation != "literal":
            over, under = inputs
            if _is_guarded(under):
                return self._guarded(over, under, origin)
            if under.stage < TICK <= over.stage:
                return self._by_what_stays(over, under, origin)
        return self._shared(folded(Node(operation, kind, inputs, detail)))

    def _shared(self, node: Node) -> Node:
        """Return the equal node met before, or this one if it is the first."""
        if node.operation == "literal":
            key: tuple[object, ...] = (
                node.kind,
                np.asarray(node.detail, DTYPES[node.kind]).tobytes(),
            )
        elif node.operation in ("given", "part", "branch", "loop"):
            return node
        else:
            numbers = [x.number for x in node.inputs]
            if node.operation in _COMMUTE:
                numbers.sort()
            key = (node.operation, node.kind, node.detail, *numbers)
        return self._nodes.setdefault(key, node)

    def _number(self, value: float, kind: str) -> Node:
        return self._shared(super()._number(value, kind))

    def _guarded(self, over: Node, under: Node, origin: Traced) -> Node:
        """Divide only where any lane needs the ratio."""
        needed, unit, real = under.inputs
        no = self._node("div", over.kind, (over, unit), None, origin)
        yes = self._shared(folded(Node("div", over.kind, (over, real))))
        return self._decided(needed, [no], [yes])[0]

    def _by_what_stays(self, over: Node, under: Node, origin: Traced) -> Node:
        """Return a ratio by a constant number: the product with its inverse, corrected once by the
        remainder.

        The result is that of the division, to the bit, unless what is left is lost below the
        smallest numbers (P. Markstein, Computation of elementary functions on the IBM RISC
        System/6000 processor, 1990).
        """
        kind = over.kind

        def node(operation: str, *inputs: Node, kind_of_node: str = kind) -> Node:
            return self._node(operation, kind_of_node, inputs, None, origin)

        unit = self._number(1, kind)
        inverse = self._shared(folded(Node("div", kind, (unit, under))))
        guess = node("mul", over, inverse)
        residual = node("sub", over, node("mul", guess, under))
        better = node("add", guess, node("mul", residual, inverse))
        zero = self._number(0, kind)
        return node("select_n", node("differ", residual, zero, kind_of_node="bool"), guess, better)

    def _between_entries(
        self, name: str, kind: str, arguments: Arrays, equation: Traced, origin: Traced
    ) -> np.ndarray:
        result = function(equation)
        if result is None:
            operation = OPERATIONS.get(name)
            if operation is None or operation.llvm is None:
                raise self._refused(name, origin)
            return self._entrywise(name, kind, arguments, origin, operation.detail(equation.params))

        def entry(*nodes: Node) -> Node:
            inputs = [array_of([node], ()) for node in nodes]
            constants = [self._constant(value, origin) for value in result.consts]
            return self._run(result.jaxpr, constants, inputs, origin)[0].item()

        return elementwise(entry, arguments)

    def _call(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        jaxpr, constants, info = callee(parameters)
        constant_nodes = [self._constant(value, origin) for value in constants]
        return self._run(jaxpr, constant_nodes, arguments, origin if is_of_jax(info) else None)

    def _reaches(self, index: np.ndarray, number: int, origin: Traced) -> np.ndarray:
        node = index.item()
        if node.operation == "convert_element_type" and node.inputs[0].kind == "bool":
            return array_of(node.inputs, ())
        return super()._reaches(index, number, origin)

    def _fork(
        self, condition: np.ndarray, no: Arrays, yes: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        nodes = self._decided(condition.item(), scalars(no), scalars(yes))
        return in_shapes(nodes, [array.shape for array in yes])

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

    def _loop(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        n_test, n_step = parameters["cond_nconsts"], parameters["body_nconsts"]
        begins = arguments[n_test + n_step :]
        shapes = [array.shape for array in begins]
        carried = [input_node(("carried",), node.kind) for node in scalars(begins)]

        def run(trace: Traced, fixed: Arrays) -> list[Node]:
            inputs = [*fixed, *in_shapes(carried, shapes)]
            return scalars(self._run_closed(trace, inputs, origin))

        goes_on = run(parameters["cond_jaxpr"], arguments[:n_test])[0]
        onwards = run(parameters["body_jaxpr"], arguments[n_test : n_test + n_step])
        loop = Loop(tuple(carried), goes_on, tuple(onwards))
        node = Node("loop", "", (*scalars(begins), *loop.outside()), loop)
        results = [Node("part", x.kind, (node,), i) for i, x in enumerate(carried)]
        return in_shapes(results, shapes)

    def _rounds(
        self, parameters: Parameters, arguments: Arrays, origin: Traced
    ) -> list[np.ndarray]:
        """Return a loop over rows of inputs that carries floats alone; any other loop is
        written out.
        """
        n_fixed, n_carry = scan_sizes(parameters)
        fixed, begins = arguments[:n_fixed], arguments[n_fixed : n_fixed + n_carry]
        rows, results = arguments[n_fixed + n_carry :], parameters["jaxpr"].jaxpr.outvars
        columns = [array.reshape(len(array), -1) for array in rows]
        plain = len(results) == n_carry and not parameters["reverse"]
        plain = plain and all(node.kind in FLOATS for node in scalars(begins))
        if not (plain and columns and all(map(_is_given, columns))):
            return super()._rounds(parameters, arguments, origin)
        number = input_node(("carried",), "int32_t")
        shapes = [array.shape for array in begins]
        carried = [input_node(("carried",), node.kind) for node in scalars(begins)]
        read = [
            array_of([self._row(number, column) for column in array.T], row.shape[1:])
            for array, row in zip(columns, rows, strict=True)
        ]
        inputs = [*fixed, *in_shapes(carried, shapes), *read]
        onwards = scalars(self._run_closed(parameters["jaxpr"], inputs, origin))
        unit, length = (self._number(n, "int32_t") for n in (1, parameters["length"]))
        goes_on = self._node("lt", "bool", (number, length), None, origin)
        following = self._node("add", "int32_t", (number, unit), None, origin)
        loop = Loop((number, *carried), goes_on, (following, *onwards))
        first = (self._number(0, "int32_t"), *scalars(begins))
        node = Node("loop", "", (*first, *loop.outside()), loop)
        parts = [Node("part", x.kind, (node,), i) for i, x in enumerate(carried, 1)]
        return in_shapes(parts, shapes)

    def _row(self, number: Node, column: np.ndarray) -> Node:
        """Return the node of the row at an index, from consecutive inputs."""
        return self._shared(Node("row", column[0].kind, (number, *column)))


def _is_given(columns: np.ndarray) -> bool:
    """Return whether rows, at least two, are inputs of each lane at equal distances."""
    nodes = columns.reshape(-1)
    if len(columns) < 2 or any(
        node.operation != "given" or node.detail[0] != "lanes" for node in nodes
    ):
        return False
    steps = np.diff([[node.detail[1] for node in row] for row in columns], axis=0)
    return bool(np.all(steps == steps[0]) and len({node.kind for node in nodes}) == 1)


_COMMUTE = frozenset(("add", "mul", "and", "or", "xor", "eq", "ne"))


def _is_guarded(under: Node) -> bool:
    """Return whether a number is one wherever a condition does not hold."""
    match under.operation, under.inputs:
        case "select_n", (condition, no, yes):
            is_one = no.operation == "literal" and no.detail == 1.0
            return condition.kind == "bool" and is_one and yes.operation != "literal"
    return False


def given_arrays(name: str, tree: Tree, stage: int = TICK) -> list[np.ndarray]:
    """Return the nodes of an input by its name, leaf by leaf, numbered consecutively."""
    numbers = itertools.count()
    return [
        array_of(
            [
                input_node((name, next(numbers)), KINDS[str(leaf.dtype)], stage)
                for _ in range(math.prod(leaf.shape))
            ],
            leaf.shape,
        )
        for leaf in jax.tree.leaves(tree)
    ]
