"""Nodes as instructions: branches that are taken if any lane takes them, loops while any lane goes.

Every fused multiply-add is formed here, from the graph alone, and nothing is left to the compiler:
so results are the same bits for any width of vectors, any number of them, any processor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from lanewise.nodes import FLOATS, Fork, Loop, Node, reachable
from lanewise.operations import OPERATIONS
from lanewise.placement import Region, Regions
from lanewise.writer import FunctionWriter

_SMALLEST_SIDE = 8
"""Operations from which the side of a branch is worth a jump."""

_SLOW = frozenset(("branch", "loop", "div", "sqrt"))
"""Operations that make a side worth a jump alone."""

Leaf = Callable[[Node], tuple[str, int, bool] | str | None]
"""Location of a node: base, offset in bytes of the first vector, and whether one number serves all
lanes; or the register of a number; None if it is to be computed."""


class Emitter:
    """Writer of the text of nodes.

    Args:
        writer: where to.
        vectors: vectors of a block.
        results: the nodes.
        leaf: what is in memory already.
    """

    def __init__(
        self, writer: FunctionWriter, vectors: int, results: Iterable[Node], leaf: Leaf
    ) -> None:
        self._writer, self._vectors, self._leaf = writer, vectors, leaf
        self._regions = Regions(
            results, lambda node: node.operation == "literal" or leaf(node) is not None
        )
        self._values: list[dict[Node, list[str]]] = [{}]
        self._fused = self._products_within_sums()
        self._emit(self._regions.top)

    def values(self, node: Node) -> list[str]:
        """Return a node's registers, one per vector."""
        for scope in reversed(self._values):
            if node in scope:
                return scope[node]
        w = self._writer
        if node.operation == "literal":
            return [w.number(node.detail, node.kind)] * self._vectors
        where = self._leaf(node)
        assert where is not None, f"{node.operation} is not computed yet"
        if isinstance(where, str):
            copies = [w.spread(where, node.kind)] * self._vectors
        else:
            base, offset, spread = where
            if spread:
                copies = [w.load(base, offset, node.kind, spread=True)] * self._vectors
            else:
                size = w.bytes_of(node.kind)
                copies = [w.load(base, offset + u * size, node.kind) for u in range(self._vectors)]
        self._values[-1][node] = copies
        return copies

    def _products_within_sums(self) -> dict[Node, int]:
        """Return, for sums that absorb a product, the index of that input."""
        uses, region = self._regions.uses, self._regions.region
        fused: dict[Node, int] = {}
        for node in region:
            if node.operation not in ("add", "sub") or node.kind not in FLOATS:
                continue
            a, b = node.inputs
            products = [i for i, x in enumerate((a, b)) if x.operation == "mul" and x in region]
            if a is b or not products:
                continue
            fused[node] = min(products, key=lambda i: (uses[node.inputs[i]], i))
        for node, position in fused.items():
            uses[node.inputs[position]] -= 1
        return fused

    def _emit(self, region: Region) -> None:
        for node in self._regions.nodes.get(region, ()):
            self._compute(node)

    def _compute(self, node: Node) -> None:
        scope = self._values[-1]
        if node.operation == "mul" and not self._regions.uses[node]:
            return  # all that use it take it with them
        if node.operation == "branch":
            self._branch(node)
        elif node.operation == "loop":
            self._loop(node)
        elif node.operation in ("given", "part") or node in scope:
            return
        elif node.operation == "row":
            scope[node] = self._row(node)
        elif node in self._fused:
            scope[node] = self._fused_sum(node)
        else:
            emission = OPERATIONS[node.operation].llvm
            assert emission is not None, node.operation
            operands = [self.values(operand) for operand in node.inputs]
            scope[node] = [
                emission(self._writer, node, *registers)
                for registers in zip(*operands, strict=True)
            ]

    def _fused_sum(self, node: Node) -> list[str]:
        """Return a b + c, or the sum with either sign, rounded once."""
        w, position = self._writer, self._fused[node]
        product, addend = node.inputs[position], node.inputs[1 - position]
        kind = w.type(node.kind)
        registers = []
        for a, b, c in zip(
            *(self.values(operand) for operand in (*product.inputs, addend)), strict=True
        ):
            if node.operation == "sub" and position == 1:
                a = w.do(f"fneg {kind} {a}")
            if node.operation == "sub" and position == 0:
                c = w.do(f"fneg {kind} {c}")
            registers.append(w.call("fma", (node.kind,), a, b, c))
        return registers

    def _branch(self, node: Node) -> None:
        fork: Fork = node.detail
        regions, w = self._regions, self._writer
        parts = {part: i for i in regions.parts[node] if (part := regions.part_of(node, i))}
        masks = self.values(node.inputs[0])
        no_side, yes_side = regions.sides[node]
        if self._is_small(no_side):
            self._emit(no_side)
            no = {part: self.values(fork.no[i]) for part, i in parts.items()}
        else:
            flipped = [w.do(f"xor {w.type('bool')} {m}, {w.number(True, 'bool')}") for m in masks]
            no = self._if_any(flipped, no_side, {p: fork.no[i] for p, i in parts.items()}, None)
        if self._is_small(yes_side):
            self._emit(yes_side)
            self._values[-1].update(
                (part, self._selected(masks, part, self.values(fork.yes[i]), no[part]))
                for part, i in parts.items()
            )
        else:
            yes = {part: fork.yes[i] for part, i in parts.items()}
            self._values[-1].update(self._if_any(masks, yes_side, yes, no))

    def _selected(
        self, masks: Sequence[str], part: Node, yes: Sequence[str], no: Sequence[str]
    ) -> list[str]:
        w = self._writer
        return [w.select(m, part.kind, y, n) for m, y, n in zip(masks, yes, no, strict=True)]

    def _is_small(self, side: Region) -> bool:
        nodes = self._regions.nodes.get(side, ())
        slow = any(node.operation in _SLOW for node in nodes)
        return len(nodes) < _SMALLEST_SIDE and not slow

    def _if_any(
        self,
        masks: list[str],
        side: Region,
        results: dict[Node, Node],
        otherwise: dict[Node, list[str]] | None,
    ) -> dict[Node, list[str]]:
        """Return the results of one branch, for the lanes that take it; it is computed if any
        lane does.
        """
        w = self._writer
        inside, rejoin = w.label("taken"), w.label("joined")
        w.go_if(w.any(masks), inside, rejoin, rarely=otherwise is not None)
        origin = w.block
        w.begin(inside)
        self._values.append({})
        self._emit(side)
        merged = {}
        for part, node in results.items():
            merged[part] = self.values(node)
            if otherwise is not None:
                merged[part] = self._selected(masks, part, merged[part], otherwise[part])
        self._values.pop()
        end = w.block
        w.go(rejoin)
        w.begin(rejoin)
        joined = {}
        for part, values in merged.items():
            none = [w.number(0, part.kind)] * self._vectors
            alternatives = none if otherwise is None else otherwise[part]
            joined[part] = [
                w.either(part.kind, (value, end), (alternative, origin))
                for value, alternative in zip(values, alternatives, strict=True)
            ]
        return joined

    def _loop(self, node: Node) -> None:
        """Write a loop that runs while any lane continues; values of finished lanes do not
        change.
        """
        loop: Loop = node.detail
        w, regions = self._writer, self._regions
        slots = regions.parts[node]
        carried = [loop.carried[slot] for slot in slots]
        begins = [self.values(node.inputs[slot]) for slot in slots]
        going = self._goes_on(node, carried, begins)
        inside, latch, ended = w.label("round"), w.label("latch"), w.label("ended")
        origin = w.block
        w.go_if(w.any(going), inside, ended, rarely=True)
        w.begin(inside)
        phis = [
            [
                w.either(entry.kind, (value, origin), (f"%{latch}.{slot}.{u}", latch))
                for u, value in enumerate(values)
            ]
            for entry, slot, values in zip(carried, slots, begins, strict=True)
        ]
        goes = [
            w.either("bool", (mask, origin), (f"%{latch}.goes.{u}", latch))
            for u, mask in enumerate(going)
        ]
        self._values.append(dict(zip(carried, phis, strict=True)))
        self._emit(regions.rounds[node])
        moved = [
            [
                w.select(*entry, name=f"%{latch}.{slot}.{u}")
                for u, entry in enumerate(
                    zip(goes, [carry.kind] * len(goes), self.values(new), old, strict=True)
                )
            ]
            for carry, slot, new, old in zip(
                carried, slots, [loop.onwards[slot] for slot in slots], phis, strict=True
            )
        ]
        self._values.pop()
        for u, mask in enumerate(self._goes_on(node, carried, moved)):
            w.do(f"or {w.type('bool')} {mask}, {mask}", name=f"%{latch}.goes.{u}")
        w.go(latch)
        w.begin(latch)
        w.go_if(w.any([f"%{latch}.goes.{u}" for u in range(len(goes))]), inside, ended)
        w.begin(ended)
        for slot, first, last in zip(slots, begins, moved, strict=True):
            part = regions.part_of(node, slot)
            if part is not None:
                self._values[-1][part] = [
                    w.either(part.kind, (b, origin), (m, latch))
                    for b, m in zip(first, last, strict=True)
                ]

    def _row(self, node: Node) -> list[str]:
        """Emit the load of an entry of an equidistant row by its index, which all lanes share."""
        w, (number, first, second, *_) = self._writer, node.inputs
        place, beyond = self._leaf(first), self._leaf(second)
        assert isinstance(place, tuple)
        assert isinstance(beyond, tuple)
        index = self.values(number)[0]
        if w.lanes > 1:
            index = w.do(f"extractelement {w.type('int32_t')} {index}, i64 0")
        distance = w.do(f"mul i64 {w.do(f'sext i32 {index} to i64')}, {beyond[1] - place[1]}")
        base, size = (
            w.do(f"getelementptr i8, ptr {place[0]}, i64 {distance}"),
            w.bytes_of(node.kind),
        )
        return [w.load(base, place[1] + u * size, node.kind) for u in range(self._vectors)]

    def _goes_on(self, node: Node, carried: list[Node], values: list[list[str]]) -> list[str]:
        """Return the condition of a loop, computed from the values that it carries."""
        condition = node.detail.goes_on
        self._values.append(dict(zip(carried, values, strict=True)))
        needed = set(reachable((condition,)))
        for computed in self._regions.nodes.get(self._regions.rounds[node], ()):
            if computed in needed:
                self._compute(computed)
        masks = self.values(condition)
        self._values.pop()
        return masks
