"""Graphs made smaller: constants folded, and moves of values without arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax
import numpy as np
from numpy.typing import ArrayLike

from tegotae.lowering.nodes import (
    DTYPES,
    FLOATS,
    CannotLower,
    Node,
    Parameters,
    Traced,
    array_of,
    constant,
    literal,
)
from tegotae.lowering.operations import OPERATIONS

COMPUTED = "it picks an entry by a number that is computed; pick it by jnp.where"
"""Why an entry cannot be moved."""


def _known(array: np.ndarray) -> int:
    node = array.item()
    if node.operation != "literal":
        raise CannotLower("dynamic_slice", why=COMPUTED)
    return int(node.detail)


def _in_dimensions(arrays: Sequence[np.ndarray], parameters: Parameters) -> list[np.ndarray]:
    array, shape = arrays[0], parameters["shape"]
    whole = [1] * len(shape)
    for axis, at in enumerate(parameters["broadcast_dimensions"]):
        whole[at] = array.shape[axis]
    return [np.broadcast_to(array.reshape(whole), shape)]


def _slice(arrays: Sequence[np.ndarray], parameters: Parameters) -> list[np.ndarray]:
    strides = parameters["strides"] or (1,) * arrays[0].ndim
    bounds = zip(parameters["start_indices"], parameters["limit_indices"], strides, strict=True)
    return [arrays[0][tuple(slice(*each) for each in bounds)]]


def _dynamic_slice(arrays: Sequence[np.ndarray], parameters: Parameters) -> list[np.ndarray]:
    array, *starts = arrays
    sizes = parameters["slice_sizes"]
    firsts = [
        min(max(_known(at), 0), length - size)
        for at, length, size in zip(starts, array.shape, sizes, strict=True)
    ]
    return [array[tuple(slice(at, at + n) for at, n in zip(firsts, sizes, strict=True))]]


def _split(arrays: Sequence[np.ndarray], parameters: Parameters) -> list[np.ndarray]:
    ends = np.cumsum(parameters["sizes"])[:-1]
    return list(np.split(arrays[0], ends, axis=parameters["axis"]))


def _iota(arrays: Sequence[np.ndarray], parameters: Parameters) -> list[np.ndarray]:
    shape, at = parameters["shape"], parameters["dimension"]
    numbers = np.arange(shape[at]).reshape([-1 if i == at else 1 for i in range(len(shape))])
    dtype = jax.dtypes.canonicalize_dtype(parameters["dtype"])
    return [constant(np.broadcast_to(numbers, shape).astype(dtype))]


MOVES: dict[str, Callable[[Sequence[np.ndarray], Parameters], list[np.ndarray]]] = {
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
"""By their names in a trace: from arrays and parameters to arrays."""


def moved_by_number(equation: Traced, arguments: list[np.ndarray]) -> list[np.ndarray]:
    """An operation such as `gather`, for places that are known: done once, with entries' numbers.

    Raises:
        CannotLower: for places that are computed.
    """
    name, entries, numbered = equation.primitive.name, [], []
    for position, array in enumerate(arguments):
        if position in _ENTRIES[name]:
            numbered.append(np.arange(array.size, dtype=np.int32).reshape(array.shape))
            numbered[-1] += len(entries)
            entries += list(array.reshape(-1))
        else:
            values = [_known(np.asarray(each, object)) for each in array.reshape(-1)]
            dtype = equation.invars[position].aval.dtype
            numbered.append(np.asarray(values, dtype).reshape(array.shape))
    parameters = dict(equation.params)
    if "fill_value" in parameters:
        parameters["fill_value"] = len(entries)
    places = np.asarray(equation.primitive.bind(*numbered, **parameters))
    dtype = equation.outvars[0].aval.dtype
    filling = np.nan if np.issubdtype(dtype, np.floating) else 0
    entries.append(constant(np.asarray(filling, dtype)).item())
    return [array_of([entries[place] for place in places.reshape(-1)], places.shape)]


_ENTRIES = {"gather": (0,), "scatter": (0, 2), "dynamic_update_slice": (0, 1), "pad": (0, 1)}
"""Which operands hold entries; the others say where these go."""


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
