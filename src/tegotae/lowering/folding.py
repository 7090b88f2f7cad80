"""Less work for the same value: what is known beforehand, and what changes nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tegotae.lowering.nodes import DTYPES, FLOATS, Node, literal
from tegotae.lowering.operations import OPERATIONS


def folded(node: Node, *, finite: bool = False) -> Node:
    """The node, or what it comes to: its value where all that it is made of is known, less work.

    Args:
        node: an operation.
        finite: whether no infinite number, none that is no number, and no sign of zero matter.
    """
    operation, inputs = node.operation, node.inputs
    same = len(inputs) == 2 and inputs[0] is inputs[1]
    if operation in ("max", "min") and same:
        return inputs[0]
    if operation == "select_n" and len(inputs) == 3 and inputs[0].operation == "literal":
        return inputs[2 if inputs[0].detail else 1]
    plain = _finite(node, same) if finite else _exact(node)
    if plain is not None:
        return plain
    fold = OPERATIONS[operation].fold
    if fold is None or any(each.operation != "literal" for each in inputs):
        return node
    dtype = DTYPES[node.kind]
    with np.errstate(all="ignore"):
        value = fold(*(each.detail for each in inputs))
    return literal(np.asarray(value).astype(dtype)[()], node.kind)


def _finite(node: Node, same: bool) -> Node | None:
    """What holds of finite numbers alone."""
    operation, inputs = node.operation, node.inputs
    if operation == "sub" and same:
        return _zero(node.kind)
    if operation == "mul" and any(_is(each, 0) for each in inputs):
        return _zero(node.kind)
    if operation == "add" and any(_is(each, 0) for each in inputs):
        return inputs[1] if _is(inputs[0], 0) else inputs[0]
    return None


def _exact(node: Node) -> Node | None:
    """What holds of all numbers, to the bit."""
    operation, inputs = node.operation, node.inputs
    if operation == "mul":
        for one, other in (inputs, inputs[::-1]):
            if _is(one, 1):
                return other
    if operation == "div" and _is_power_of_two(inputs[1]):
        inverse = _literal(1.0 / inputs[1].detail, node.kind)
        return folded(Node("mul", node.kind, (inputs[0], inverse), None, node.place))
    if operation == "convert_element_type" and inputs[0].kind == node.kind:
        return inputs[0]
    if operation == "neg" and inputs[0].operation == "neg":
        return inputs[0].inputs[0]
    if operation == "not" and inputs[0].operation == "not":
        return inputs[0].inputs[0]
    if operation == "select_n" and all(each is inputs[1] for each in inputs[2:]):
        return inputs[1]
    if operation in ("and", "or") and node.kind == "bool":
        for one, other in (inputs, inputs[::-1]):
            if one.operation == "literal":
                return other if bool(one.detail) == (operation == "and") else one
    if operation == "add" and node.kind not in FLOATS:
        for one, other in (inputs, inputs[::-1]):
            if _is(one, 0):
                return other
    return None


def _is(node: Node, value: float) -> bool:
    return node.operation == "literal" and node.detail == value


def _is_power_of_two(node: Node) -> bool:
    """Whether it is one whose inverse is exact, too."""
    if node.operation != "literal" or node.kind not in FLOATS:
        return False
    size = abs(float(node.detail))
    return 1e-30 < size < 1e30 and np.frexp(size)[0] == 0.5


def _zero(kind: str) -> Node:
    return _literal(0, kind)


def _literal(value: ArrayLike, kind: str) -> Node:
    return literal(np.asarray(value, DTYPES[kind])[()], kind)
