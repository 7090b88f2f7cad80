"""Reads programs of lanes, and spares divisions: a processor has one slow divider."""

from __future__ import annotations

import numpy as np

from tegotae.lowering.graph import Reader
from tegotae.lowering.jaxprs import Detail, Traced
from tegotae.lowering.nodes import DTYPES, FLOATS, Node, literal
from tegotae.lowering.stages import TICK, begins


class LaneReader(Reader):
    """Reads what is given lane by lane and tick by tick; divides where it must, and when."""

    def __init__(self) -> None:
        super().__init__()
        self._stage: dict[Node, int] = {}

    def _node(
        self, operation: str, kind: str, inputs: tuple[Node, ...], detail: Detail, origin: Traced
    ) -> Node:
        if operation == "div" and kind in FLOATS and inputs[1].operation != "literal":
            over, under = inputs
            if _is_guarded(under):
                return self._guarded(over, under, origin)
            if self._stage_of(under) < TICK <= self._stage_of(over):
                return self._by_what_stays(over, under, origin)
        return super()._node(operation, kind, inputs, detail, origin)

    def _stage_of(self, node: Node) -> int:
        """When a node is computed."""
        left = [node]
        while left:
            last = left[-1]
            unknown = [each for each in last.inputs if each not in self._stage]
            if last in self._stage or not unknown:
                left.pop()
                stages = [self._stage[each] for each in last.inputs]
                self._stage[last] = max(stages) if stages else begins(last)
            else:
                left += unknown
        return self._stage[node]

    def _guarded(self, over: Node, under: Node, origin: Traced) -> Node:
        """A ratio that only some lanes need: divided only where any does."""
        needed, one, real = under.inputs
        no = self._node("div", over.kind, (over, one), None, origin)
        yes = super()._node("div", over.kind, (over, real), None, origin)
        return self._decided(needed, [no], [yes])[0]

    def _by_what_stays(self, over: Node, under: Node, origin: Traced) -> Node:
        """A ratio by a number that stays: its inverse, and what the product leaves, once more.

        The result is that of the division, to the bit, unless what is left is lost below the
        smallest numbers (P. Markstein, Computation of elementary functions on the IBM RISC
        System/6000 processor, 1990).
        """
        kind = over.kind

        def node(operation: str, *inputs: Node, of: str = kind) -> Node:
            return self._node(operation, of, inputs, None, origin)

        one = self._shared(literal(np.ones((), DTYPES[kind])[()], kind))
        inverse = super()._node("div", kind, (one, under), None, origin)
        guess = node("mul", over, inverse)
        left = node("sub", over, node("mul", guess, under))
        better = node("add", guess, node("mul", left, inverse))
        zero = self._shared(literal(np.zeros((), DTYPES[kind])[()], kind))
        return node("select_n", node("differ", left, zero, of="bool"), guess, better)


def _is_guarded(under: Node) -> bool:
    """Whether a number is one wherever a condition does not hold."""
    return (
        under.operation == "select_n"
        and len(under.inputs) == 3
        and under.inputs[0].kind == "bool"
        and under.inputs[1].operation == "literal"
        and under.inputs[1].detail == 1.0
        and under.inputs[2].operation != "literal"
    )
