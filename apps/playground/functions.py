"""The program of a lane as functions of scalars, traced."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import numpy as np

from apps.playground.layout import LayoutEntry, word_expressions
from apps.playground.loops import LoopReader
from apps.playground.program import Program
from lanewise.nodes import Node, input_node, keeping_calls
from tegotae.parts._shapes import ArrayTree

ASKED = ("phase", "spring", "velocity")
"""Inputs of a point of the actuation surface."""
_KINDS = {"float32": "float", "int32": "int32_t", "bool": "bool"}


class EngineFunction(NamedTuple):
    """A traced function: its name, its inputs beside the lane, and its outputs in the lane."""

    name: str
    description: str
    writes: tuple[tuple[LayoutEntry, tuple[Node, ...]], ...] = ()
    takes: tuple[str, ...] = ()
    returns: Node | None = None


def functions(program: Program) -> tuple[EngineFunction, ...]:
    """Return the functions of a program, traced in float32.

    Raises:
        TegotaeError: for an operation that has no C, by its name.
    """
    trace = _Trace({e.name: _nodes(e, program.shape_of(e)) for e in program.inputs})
    state = program.state
    lane = _arrays(state, program.shapes[0])
    ticks = np.array(input_node("l->ticks[0]", "int32_t"), object)
    events = [entry for entry in state if entry.name.startswith("state.events.")]
    no_event = [_no_number(entry) for entry in events]
    point = [np.array([input_node(name)], object) for name in ASKED]
    released = trace(program.released)
    ticked = trace(program.ticked, ticks, lane)
    recorded = trace(program.recorded, ticks, lane)
    force = trace(program.answer, *point)[0].item()
    return (
        EngineFunction("released", "The lane at its release.", _paired(state, released)),
        EngineFunction("quiet", "A frame begins: no event yet.", _paired(events, no_event)),
        EngineFunction("ticked", "One control tick.", _paired(state, ticked)),
        EngineFunction("recorded", "What is recorded of it.", _paired(program.channels, recorded)),
        EngineFunction("answer", "The force [N] of the first leg at this point.", (), ASKED, force),
    )


class _Trace:
    """Tracer of functions of a page's input and more."""

    def __init__(self, inputs: dict[str, np.ndarray]) -> None:
        self._reader, self._inputs = LoopReader(), inputs

    def __call__(self, function: Callable[..., ArrayTree], *states: ArrayTree) -> list[np.ndarray]:
        """Return the results' scalars, leaf by leaf."""
        arguments = (self._inputs, *states)
        leaves, structure = jax.tree.flatten(arguments, is_leaf=lambda x: isinstance(x, np.ndarray))
        shapes = [jax.ShapeDtypeStruct(leaf.shape, _dtype(leaf)) for leaf in leaves]

        def flat(*arrays: jax.Array) -> ArrayTree:
            return function(*jax.tree.unflatten(structure, arrays))

        with jax.enable_x64(False), keeping_calls():
            return self._reader.read(jax.make_jaxpr(flat)(*shapes), leaves)


def _paired(
    entries: Sequence[LayoutEntry], nodes: Sequence[np.ndarray]
) -> tuple[tuple[LayoutEntry, tuple[Node, ...]], ...]:
    return tuple((e, tuple(n.reshape(-1))) for e, n in zip(entries, nodes, strict=True))


def _dtype(array: np.ndarray) -> str:
    kind = array.reshape(-1)[0].kind
    return next(dtype for dtype, name in _KINDS.items() if name == kind)


def _nodes(entry: LayoutEntry, shape: tuple[int, ...]) -> np.ndarray:
    array = np.empty(entry.words, object)
    array[:] = [input_node(text, _KINDS[entry.kind]) for text in word_expressions(entry)]
    return array.reshape(shape)


def _arrays(entries: Sequence[LayoutEntry], shapes: ArrayTree) -> ArrayTree:
    leaves, structure = jax.tree.flatten(shapes)
    arrays = [_nodes(e, leaf.shape) for e, leaf in zip(entries, leaves, strict=True)]
    return jax.tree.unflatten(structure, arrays)


def _no_number(entry: LayoutEntry) -> np.ndarray:
    """Return the value of an absent event."""
    array = np.empty(entry.words, object)
    array[:] = [Node("literal", "float", detail=np.float32("nan")) for _ in range(entry.words)]
    return array
