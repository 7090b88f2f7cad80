"""Placement of each node: once a run, an episode or a tick; always, on one side of a branch, in a
loop."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from lanewise.nodes import LANE, UNIFORM, Fork, Loop, Node, reachable


@dataclass(frozen=True)
class Stages:
    """Nodes of a program of lanes by stage, and the values that one stage leaves to the next.

    Args:
        start: the state at release.
        tick: the state a tick later.
        frame: the state that the next frame begins with.
        channels: what a frame records.

    All are nodes of what is given: `("shared", n)`, `("lanes", n)`, `("state", n)` and
    `("index", 0)`.
    """

    start: Sequence[Node]
    tick: Sequence[Node]
    frame: Sequence[Node]
    channels: Sequence[Node]

    @cached_property
    def slots(self) -> tuple[int, ...]:
        """The entries of the state on which recorded values depend, directly or indirectly."""
        needed: set[int] = set()
        pending = list(self.channels)
        while pending:
            read = {
                node.detail[1]
                for node in reachable(pending)
                if node.operation == "given" and node.detail[0] == "state"
            }
            new = read - needed
            needed |= new
            pending = [node for i in new for node in (self.tick[i], self.frame[i])]
        return tuple(sorted(needed))

    @cached_property
    def invariant(self) -> tuple[Node, ...]:
        """Nodes computed once an episode and read every tick or frame; inputs excluded."""
        return tuple(node for node in _read(self._later, LANE) if node.operation != "given")

    @cached_property
    def uniform(self) -> tuple[Node, ...]:
        """Nodes computed once a run and read later."""
        released = [self.start[i] for i in self.slots]
        return _read([*self._later, *self.invariant, *released], UNIFORM)

    @property
    def _later(self) -> list[Node]:
        carried = [nodes[i] for nodes in (self.tick, self.frame) for i in self.slots]
        return [*carried, *self.channels]


def _read(results: Sequence[Node], stage: int) -> tuple[Node, ...]:
    """Return the nodes of a stage that later stages read."""
    read: set[Node] = set()
    met: set[Node] = set()
    pending = list(results)
    while pending:
        node = pending.pop()
        if node in met:
            continue
        met.add(node)
        if node.stage > stage:
            pending += node.inputs
        elif node.stage == stage and node.operation != "literal":
            read.add(node)
    return tuple(sorted(read, key=lambda node: node.number))


@dataclass(eq=False)
class Region:
    """A stretch of a function: the whole function, a side of a branch, or the rounds of a loop."""

    outer: Region | None = None
    loop: Node | None = None
    """The loop whose rounds it is."""
    depth: int = 0

    def within(self, loop: Node | None = None) -> Region:
        """Return whether a region is inside this one."""
        return Region(self, loop, self.depth + 1)


class Regions:
    """The nodes that some results need, each in the innermost region that all its uses are in.

    So what a branch shares with the world around is computed before it, and what a loop repeats in
    vain before the loop; what only one side of a branch needs is left out where no lane takes it.

    Args:
        results: what is asked for.
        is_leaf: whether a node comes from memory or is a constant, so that nothing of it is
            computed here.
    """

    def __init__(self, results: Iterable[Node], is_leaf: Callable[[Node], bool]) -> None:
        self.results = tuple(results)
        self._is_leaf = is_leaf
        self.parts: dict[Node, list[int]] = {}
        """Which results of a branch or loop are used."""
        self._parts: dict[tuple[Node, int], Node] = {}
        self._carriers: dict[Node, tuple[Node, int]] = {}
        live = sorted(self._live(), key=lambda node: node.number)
        self.top = Region()
        self.sides: dict[Node, tuple[Region, Region]] = {}
        """Of a branch the regions of no and yes."""
        self.rounds: dict[Node, Region] = {}
        """Of a loop the region of its rounds."""
        self.uses: dict[Node, int] = {}
        """How often a node is used."""
        self.region = self._placed(live)
        self.nodes: dict[Region, list[Node]] = {}
        """The nodes of each region, in the order of the trace: a node reads none after it."""
        for node in live:
            self.nodes.setdefault(self.region[node], []).append(node)

    def part_of(self, node: Node, index: int) -> Node | None:
        """Return the node of a branch's or loop's result, or None if nothing uses it."""
        return self._parts.get((node, index))

    def _live(self) -> set[Node]:
        live: set[Node] = set()
        pending = list(self.results)

        def carry(loop: Node, slot: int) -> None:
            slots = self.parts[loop]
            if slot not in slots:
                slots.append(slot)
                pending.extend((loop.inputs[slot], loop.detail.onwards[slot]))

        while pending:
            node = pending.pop()
            if node in self._carriers:
                carry(*self._carriers[node])
                live.add(node)
                continue
            if node in live or self._is_leaf(node):
                continue
            live.add(node)
            if node.operation == "loop":
                self.parts.setdefault(node, [])
                loop: Loop = node.detail
                self._carriers.update((x, (node, i)) for i, x in enumerate(loop.carried))
                pending.append(loop.goes_on)
            elif node.operation == "branch":
                self.parts.setdefault(node, [])
                pending.append(node.inputs[0])
            elif node.operation == "part":
                (operand,) = node.inputs
                self._parts[operand, node.detail] = node
                if operand not in live:
                    pending += [node, operand]
                    live.discard(node)
                elif operand.operation == "loop":
                    carry(operand, node.detail)
                elif node.detail not in self.parts[operand]:
                    self.parts[operand].append(node.detail)
                    pending += [operand.detail.no[node.detail], operand.detail.yes[node.detail]]
            else:
                pending += node.inputs
        for slots in self.parts.values():
            slots.sort()
        return live

    def _placed(self, live: list[Node]) -> dict[Node, Region]:
        region: dict[Node, Region] = {}
        alive = set(live)

        def use(node: Node, where: Region) -> None:
            if node not in alive:
                return
            self.uses[node] = self.uses.get(node, 0) + 1
            where = self._out_of_loops(node, where)
            region[node] = _common(region.get(node, where), where)

        for node in self.results:
            use(node, self.top)
        for node in reversed(live):
            home = region[node]
            if node.operation == "branch":
                branch: Fork = node.detail
                no, yes = self.sides[node] = home.within(), home.within()
                use(node.inputs[0], home)
                for part in self.parts[node]:
                    use(branch.no[part], no)
                    use(branch.yes[part], yes)
            elif node.operation == "loop":
                loop: Loop = node.detail
                rounds = self.rounds[node] = home.within(node)
                use(loop.goes_on, rounds)
                for part in self.parts[node]:
                    region.setdefault(loop.carried[part], rounds)
                    use(node.inputs[part], home)
                    use(loop.onwards[part], rounds)
            elif node not in self._carriers:
                for x in node.inputs:
                    use(x, home)
        return region

    def _out_of_loops(self, node: Node, where: Region) -> Region:
        """Return the region outside of all loops that leave a node unchanged."""
        outside = where
        for region in _outwards(where):
            if region.loop is not None and node not in region.loop.detail.changing:
                assert region.outer is not None
                outside = region.outer
        return outside


def _outwards(region: Region | None) -> Iterator[Region]:
    while region is not None:
        yield region
        region = region.outer


def _common(a: Region, b: Region) -> Region:
    """Return the innermost region that contains both."""
    while a is not b:
        if a.depth < b.depth:
            a, b = b, a
        assert a.outer is not None
        a = a.outer
    return a
