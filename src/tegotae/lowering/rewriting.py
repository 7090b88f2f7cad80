"""What needs no arithmetic: entries that are only moved, and operations whose value is known."""

from __future__ import annotations

import itertools
from collections.abc import Callable

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

_Arrays = list[np.ndarray]


def _known(array: np.ndarray) -> int:
    node = array.item()
    if node.operation != "literal":
        why = "it picks an entry by a number that is computed; pick it by jnp.where"
        raise CannotLower("dynamic_slice", why=why)
    return int(node.detail)


def _in_dimensions(arrays: _Arrays, parameters: Parameters) -> _Arrays:
    array, shape = arrays[0], parameters["shape"]
    whole = [1] * len(shape)
    for axis, dimension in enumerate(parameters["broadcast_dimensions"]):
        whole[dimension] = array.shape[axis]
    return [np.broadcast_to(array.reshape(whole), shape)]


def _slice(arrays: _Arrays, parameters: Parameters) -> _Arrays:
    strides = parameters["strides"] or (1,) * arrays[0].ndim
    bounds = zip(parameters["start_indices"], parameters["limit_indices"], strides, strict=True)
    return [arrays[0][tuple(itertools.starmap(slice, bounds))]]


def _dynamic_slice(arrays: _Arrays, parameters: Parameters) -> _Arrays:
    array, *starts = arrays
    sizes = parameters["slice_sizes"]
    firsts = [
        min(max(_known(start), 0), length - size)
        for start, length, size in zip(starts, array.shape, sizes, strict=True)
    ]
    return [array[tuple(slice(i, i + n) for i, n in zip(firsts, sizes, strict=True))]]


def _split(arrays: _Arrays, parameters: Parameters) -> _Arrays:
    ends = np.cumsum(parameters["sizes"])[:-1]
    return list(np.split(arrays[0], ends, axis=parameters["axis"]))


def _iota(arrays: _Arrays, parameters: Parameters) -> _Arrays:
    shape, axis = parameters["shape"], parameters["dimension"]
    numbers = np.arange(shape[axis]).reshape([-1 if i == axis else 1 for i in range(len(shape))])
    dtype = jax.dtypes.canonicalize_dtype(parameters["dtype"])
    return [constant(np.broadcast_to(numbers, shape).astype(dtype))]


_MOVES: dict[str, Callable[[_Arrays, Parameters], _Arrays]] = {
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
    **dict.fromkeys(("copy", "copy_p", "stop_gradient"), lambda a, p: [a[0]]),
}
"""By their names in a trace: from arrays and parameters to arrays."""
_PLACED = {"gather": (0,), "scatter": (0, 2), "dynamic_update_slice": (0, 1), "pad": (0, 1)}
"""Moves to or from places that other operands say, by which of the operands hold entries."""
MOVES = frozenset((*_MOVES, *_PLACED))
"""Operations that only move entries, by their names in a trace."""


def moved(equation: Traced, arguments: _Arrays) -> _Arrays:
    """What an operation of `MOVES` gives.

    Raises:
        CannotLower: for places that are computed.
    """
    name = equation.primitive.name
    if name in _MOVES:
        return _MOVES[name](arguments, equation.params)
    entries, numbered = [], []  # the operation itself moves the entries' numbers
    for position, array in enumerate(arguments):
        if position in _PLACED[name]:
            numbered.append(np.arange(array.size, dtype=np.int32).reshape(array.shape))
            numbered[-1] += len(entries)
            entries += list(array.reshape(-1))
        else:
            values = [_known(np.asarray(entry, object)) for entry in array.reshape(-1)]
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


def exact(node: Node) -> Node | None:
    """What an operation comes to for all numbers, to the bit, if that is simpler."""
    kind = node.kind
    match node.operation, node.inputs:
        case "select_n", (_, first, *others) if all(x is first for x in others):
            return first
        case "mul", (a, b) if _is(a, 1) or _is(b, 1):
            return b if _is(a, 1) else a
        case "div", (a, b) if _is_power_of_two(b):
            inverse = _literal(1.0 / b.detail, kind)
            return folded(Node("mul", kind, (a, inverse), None, node.origin))
        case "convert_element_type", (a,) if a.kind == kind:
            return a
        case "neg" | "not", (a,) if a.operation == node.operation:
            return a.inputs[0]
        case ("and" | "or") as operation, (a, b) if kind == "bool":
            for one, other in ((a, b), (b, a)):
                if one.operation == "literal":
                    return other if bool(one.detail) == (operation == "and") else one
        case "add", (a, b) if kind not in FLOATS and (_is(a, 0) or _is(b, 0)):
            return b if _is(a, 0) else a
    return None


def of_finite(node: Node) -> Node | None:
    """What an operation with nothing comes to, where no sign of zero matters."""
    match node.operation, node.inputs:
        case "sub", (a, b) if a is b:
            return _literal(0, node.kind)
        case "mul", (a, b) if _is(a, 0) or _is(b, 0):
            return _literal(0, node.kind)
        case "add", (a, b) if _is(a, 0) or _is(b, 0):
            return b if _is(a, 0) else a
    return None


def folded(node: Node, simpler: Callable[[Node], Node | None] = exact) -> Node:
    """The node, or what it comes to: its value where all that it is made of is known, less work.

    Args:
        node: an operation.
        simpler: which numbers matter, `exact` or `of_finite`.
    """
    match node.operation, node.inputs:
        case "max" | "min", (a, b) if a is b:
            return a
        case "select_n", (which, no, yes) if which.operation == "literal":
            return yes if which.detail else no
    plain = simpler(node)
    if plain is not None:
        return plain
    fold = OPERATIONS[node.operation].fold
    if fold is None or any(x.operation != "literal" for x in node.inputs):
        return node
    with np.errstate(all="ignore"):
        return _literal(fold(*(x.detail for x in node.inputs)), node.kind)


def _is(node: Node, value: float) -> bool:
    return node.operation == "literal" and node.detail == value


def _is_power_of_two(node: Node) -> bool:
    """Whether it is one whose inverse is exact, too."""
    if node.operation != "literal" or node.kind not in FLOATS:
        return False
    size = abs(float(node.detail))
    return 1e-30 < size < 1e30 and np.frexp(size)[0] == 0.5


def _literal(value: ArrayLike, kind: str) -> Node:
    return literal(np.asarray(value).astype(DTYPES[kind])[()], kind)
