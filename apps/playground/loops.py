"""Loops of unknown length in C: a body has them, a robot's tick must not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanewise.graph import Arrays, in_shapes
from lanewise.nodes import Node, Parameters, Traced, input_node, scalars
from tegotae_robots.c.reader import Call, CReader, Procedure
from tegotae_robots.c.statements import Library, Statements
from tegotae_robots.c.text import c_name


@dataclass(eq=False)
class LoopProcedure(Procedure):
    """A procedure with a loop: while a condition holds, it computes new values for some
    parameters.
    """

    goes_on: Node | None = None
    """The condition."""
    onwards: tuple[Node, ...] = ()
    """The new values of the last parameters, which are its results."""


class LoopReader(CReader):
    """Reader that turns a loop into a procedure of scalars, repeated while its condition holds."""

    def _loop(self, parameters: Parameters, arguments: Arrays, origin: Traced) -> list[np.ndarray]:
        n_test, n_step = parameters["cond_nconsts"], parameters["body_nconsts"]
        taken: set[str] = set()
        inputs = [input_node(c_name("x", taken), node.kind) for node in scalars(arguments)]
        inside = in_shapes(inputs, [array.shape for array in arguments])
        carry = inside[n_test + n_step :]

        def run(trace: Traced, fixed: Arrays) -> list[Node]:
            return scalars(self._run_closed(trace, [*fixed, *carry], origin))

        goes_on = run(parameters["cond_jaxpr"], inside[:n_test])[0]
        onwards = run(parameters["body_jaxpr"], inside[n_test : n_test + n_step])
        loop = LoopProcedure(
            "going_on",
            tuple(inputs),
            tuple(scalars(carry)),
            "Goes round while something is left to do.",
            goes_on,
            tuple(onwards),
        )
        call = Call(loop, tuple(scalars(arguments)), origin)
        return in_shapes(call.results(), [array.shape for array in carry])


class LoopLibrary(Library):
    """Writer of a loop that changes its own copies of the carried values, and returns them."""

    def _body(self, procedure: Procedure) -> tuple[str, list[str], list[str]]:
        if not isinstance(procedure, LoopProcedure):
            return super()._body(procedure)
        assert procedure.goes_on is not None
        carried = procedure.results
        names = [str(node.detail) for node in carried]
        name = c_name(procedure.name, self.taken)
        test = Statements(self, (*procedure.parameters, *(f"next_{name}" for name in names)))
        (goes_on,) = test.all([procedure.goes_on])
        step = Statements(self, test.taken)
        onwards = step.all(procedure.onwards)
        lines = [*test.lines, f"if (!({goes_on})) {{", "    break;", "}", *step.lines]
        lines += [
            f"const {n.kind} next_{n.detail} = {x};" for n, x in zip(carried, onwards, strict=True)
        ]
        lines += [f"{name} = next_{name};" for name in names]
        return name, ["for (;;) {", *(f"    {line}" for line in lines), "}"], names
