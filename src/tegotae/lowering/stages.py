"""The stages of an episode as graphs of scalars, read for one lane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tegotae.lowering.graph import Reader, reachable
from tegotae.lowering.nodes import DTYPES, FLOATS, Detail, Node, Traced, literal

UNIFORM, LANE, TICK = range(3)
"""The same for all lanes; of a lane, and the same all the time; of every tick."""
_BEGINS = {"shared": UNIFORM, "lanes": LANE, "state": TICK, "index": TICK}


def begins(node: Node) -> int:
    """The stage of what is given, or of a constant."""
    return UNIFORM if node.operation == "literal" else _BEGINS.get(node.detail[0], TICK)


@dataclass(frozen=True)
class Roots:
    """What a program of lanes computes, as nodes of what is given.

    Given are `("shared", n)`, `("lanes", n)`, `("state", n)` and `("index", 0)`.
    """

    start: tuple[Node, ...]
    """The state at release."""
    tick: tuple[Node, ...]
    """The state a tick later."""
    frame: tuple[Node, ...]
    """The state that the next frame begins with."""
    channels: tuple[Node, ...]
    """What a frame records."""


@dataclass(frozen=True)
class Stages:
    """The stage of each node of a program, and what one stage leaves to the next."""

    roots: Roots
    level: dict[Node, int] = field(repr=False)
    slots: tuple[int, ...]
    """The entries of the state that anything depends on."""
    uniform: tuple[Node, ...]
    """What is computed once a run and read later."""
    invariant: tuple[Node, ...]
    """What is computed once an episode and read every tick or frame."""

    @classmethod
    def of(cls, roots: Roots) -> Stages:
        """The stages of a program."""
        whole = (*roots.start, *roots.tick, *roots.frame, *roots.channels)
        order = _with_rounds(reachable(whole))
        level: dict[Node, int] = {}
        for node in order:
            inputs = node.inputs
            level[node] = max(level[each] for each in inputs) if inputs else begins(node)
        slots = _needed(roots)
        ticked = [roots.tick[i] for i in slots] + [roots.frame[i] for i in slots]
        later = [*ticked, *roots.channels]
        invariant = _read(later, level, LANE)
        released = [roots.start[i] for i in slots]
        uniform = _read([*later, *invariant, *released], level, UNIFORM)
        return cls(roots, level, slots, tuple(uniform), tuple(invariant))


def _with_rounds(order: Sequence[Node]) -> list[Node]:
    """The nodes with those inside of loops, each after what it depends on."""
    found = dict.fromkeys(order)
    left = [node for node in order if node.operation == "loop"]
    while left:
        loop = left.pop().detail
        inside = [node for node in reachable((loop.goes_on, *loop.onwards)) if node not in found]
        found.update(dict.fromkeys(inside))
        left += [node for node in inside if node.operation == "loop"]
    return sorted(found, key=lambda node: node.number)


def _needed(roots: Roots) -> tuple[int, ...]:
    """The entries of the state that what is recorded depends on, sooner or later."""
    needed: set[int] = set()
    left = list(roots.channels)
    while left:
        read = {
            node.detail[1]
            for node in _with_rounds(reachable(left))
            if node.operation == "given" and node.detail[0] == "state"
        }
        new = read - needed
        needed |= new
        left = [n for i in new for n in (roots.tick[i], roots.frame[i])]
    return tuple(sorted(needed))


def _read(results: Sequence[Node], level: dict[Node, int], stage: int) -> list[Node]:
    """The nodes of a stage that later stages read."""
    found: dict[Node, None] = {}
    seen: set[Node] = set()
    left = list(results)
    while left:
        node = left.pop()
        if node in seen:
            continue
        seen.add(node)
        if level[node] <= stage:
            if level[node] == stage and node.operation != "literal":
                found[node] = None
            continue
        left += node.inputs
        if node.operation == "loop":
            left += (node.detail.goes_on, *node.detail.onwards)
    return sorted(found, key=lambda node: node.number)


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
