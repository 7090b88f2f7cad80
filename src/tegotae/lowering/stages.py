"""When each node of a program of lanes is computed: once a run, once an episode, every tick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from tegotae.lowering.graph import reachable
from tegotae.lowering.nodes import Node

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
