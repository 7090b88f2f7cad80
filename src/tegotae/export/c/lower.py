"""C statements of a graph of scalars, and the structs that they use."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from tegotae._support.documents import Json
from tegotae._support.errors import TegotaeError
from tegotae.export.c.names import HELPERS, Call, LoopProcedure, Procedure, c_name
from tegotae.lowering.graph import reachable
from tegotae.lowering.nodes import Node
from tegotae.lowering.operations import (
    ATOM,
    OPERATIONS,
    PRODUCT,
    UNARY,
    WHOLE,
    Operation,
)
from tegotae.parts._shapes import Number
from tegotae.parts.weight_names import WeightName, nested

WIDTH = 96
_LONGEST = 220
"""Letters of an expression beyond which its parts get names."""


@dataclass
class Library:
    """What the functions written so far call: helpers and procedures, in an order that C takes."""

    helpers: set[str] = field(default_factory=set)
    procedures: list[str] = field(default_factory=list)
    """Their C, as it was written."""
    names: dict[int, str] = field(default_factory=dict)
    """What each procedure is called in C, by its identity."""
    taken: set[str] = field(default_factory=lambda: set(HELPERS))

    def helper_texts(self) -> list[str]:
        """The C of the helpers that are needed."""
        return [text for name, text in HELPERS.items() if name in self.helpers]

    def name_of(self, procedure: Procedure) -> str:
        """The name of a procedure in C, which is written on its first call."""
        if id(procedure) not in self.names and isinstance(procedure, LoopProcedure):
            name = self.names[id(procedure)] = c_name(procedure.name, self.taken)
            self.procedures.append(_loop(self, procedure, name))
        if id(procedure) not in self.names:
            body = Statements(self, procedure.parameters)
            results = body.all(procedure.results)
            name = c_name(procedure.name, self.taken)
            self.names[id(procedure)] = name
            parameters = ", ".join(
                f"{node.kind} {text}"
                for node, text in zip(procedure.inputs, procedure.parameters, strict=True)
            )
            kinds = [node.kind for node in procedure.results]
            self.procedures.append(
                function(name, parameters, body.lines, results, kinds, comment=procedure.about)
            )
        return self.names[id(procedure)]


ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


def members(count: int) -> tuple[str, ...]:
    """What the results of a procedure are called."""
    return ORDINALS[:count] if count <= len(ORDINALS) else tuple(f"r{i}" for i in range(count))


def function(
    name: str,
    parameters: str,
    lines: Sequence[str],
    results: Sequence[str],
    kinds: Sequence[str],
    names: Sequence[str] | None = None,
    comment: str = "",
) -> str:
    """A static function in C; one with several results returns a struct of them."""
    text = comment_of(comment)
    indented = [wrapped(line) for line in lines]
    if len(results) == 1 and names is None:
        head, back = kinds[0], wrapped(f"return {results[0]};")
    else:
        names = members(len(results)) if names is None else names
        fields = "".join(f"    {k} {n};\n" for k, n in zip(kinds, names, strict=True))
        text = f"typedef struct {{\n{fields}}} {name}_result;\n\n" + text
        head = f"{name}_result"
        indented.append(f"    {head} result;")
        indented += [wrapped(f"result.{n} = {r};") for n, r in zip(names, results, strict=True)]
        back = "    return result;"
    body = "\n".join([*indented, back])
    return f"{text}static {head} {name}({parameters or 'void'})\n{{\n{body}\n}}\n"


def _loop(library: Library, loop: LoopProcedure, name: str) -> str:
    """A loop as a function: it changes its own copies of what is carried, and returns them."""
    carried = loop.inputs[len(loop.inputs) - loop.carried :]
    names = [str(node.detail) for node in carried]
    test = Statements(library, (*loop.parameters, *(f"next_{each}" for each in names)))
    goes_on = test.all([loop.goes_on])[0] if loop.goes_on else "false"
    step = Statements(library, test.taken)
    onwards = step.all(loop.onwards)
    lines = [*test.lines, f"if (!({goes_on})) {{", "    break;", "}", *step.lines]
    lines += [
        f"const {n.kind} next_{n.detail} = {x};" for n, x in zip(carried, onwards, strict=True)
    ]
    lines += [f"{each} = next_{each};" for each in names]
    around = ["for (;;) {", *(f"    {line}" for line in lines), "}"]
    parameters = ", ".join(f"{node.kind} {node.detail}" for node in loop.inputs)
    kinds = [node.kind for node in carried]
    return function(name, parameters, around, names, kinds, comment=loop.about)


def comment_of(text: str) -> str:
    """A comment in C, wrapped."""
    if not text:
        return ""
    lines = textwrap.wrap(text, WIDTH - 6)
    return "/* " + "\n   ".join(lines) + " */\n"


def wrapped(line: str, indent: str = "    ") -> str:
    """A statement on as many lines as it needs."""
    return "\n".join(
        textwrap.wrap(
            line,
            WIDTH,
            initial_indent=indent,
            subsequent_indent=indent + "    ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    )


class Statements:
    """Writes the statements that compute some nodes.

    A value used once stands where it is used; one used more often, or too long to read, gets a
    name: that which the Python source gives it.
    """

    def __init__(self, library: Library, taken: Iterable[str] = ()) -> None:
        self._library = library
        self.taken = set(taken) | library.taken
        """Names that are given away already."""
        self._texts: dict[Node, tuple[str, int]] = {}
        self._uses: dict[Node, int] = {}
        self._calls: dict[Call, str] = {}
        self.lines: list[str] = []
        self.given: set[str] = set()
        """All that the statements read of what is given."""

    def all(self, nodes: Sequence[Node]) -> list[str]:
        """Texts of the nodes, with the statements that they need in `lines`."""
        order = reachable(nodes)
        calls: set[Call] = set()
        for node in order:
            if node.operation == "result":  # of which a call may have several
                if node.detail[0] in calls:
                    continue
                calls.add(node.detail[0])
            for each in node.inputs:
                self._uses[each] = self._uses.get(each, 0) + 1
        for node in nodes:
            self._uses[node] = self._uses.get(node, 0) + 1
        for node in order:
            self._texts[node] = self._settled(node)
        return [self._texts[node][0] for node in nodes]

    def _settled(self, node: Node) -> tuple[str, int]:
        text, binds = self._expression(node)
        leaf = node.operation in ("literal", "given", "result")
        if leaf or (self._uses[node] == 1 and len(text) <= _LONGEST):
            return text, binds
        name = c_name(node.place.names[0] if node.place else "value", self.taken)
        self.lines.append(f"const {node.kind} {name} = {text};")
        return name, ATOM

    def _expression(self, node: Node) -> tuple[str, int]:
        if node.operation == "literal":
            return number(node.detail, node.kind)
        if node.operation == "given":
            self.given.add(node.detail)
            return node.detail, ATOM
        if node.operation == "result":
            return self._result(node), ATOM
        if node.operation == "convert_element_type":
            return self._converted(node)
        if node.operation == "integer_pow":
            return self._power(node)
        operation = _operation(node)
        for helper in (operation.needs or "").split():
            self._library.helpers.add(helper)
        operands = [self._inside(each, operation.inside[i]) for i, each in enumerate(node.inputs)]
        text = cast(str, operation.text)  # `CReader` refuses operations without one
        if text.count("{0}") > 1 and self._texts[node.inputs[0]][1] != ATOM:
            operands[0] = self._named(node.inputs[0])
        return text.format(*operands), operation.binds

    def _inside(self, node: Node, least: int) -> str:
        text, binds = self._texts[node]
        return f"({text})" if binds < least else text

    def _named(self, node: Node) -> str:
        """A name for a value, even if it is used only once."""
        text, _ = self._texts[node]
        name = c_name(node.place.names[0] if node.place else "value", self.taken)
        self.lines.append(f"const {node.kind} {name} = {text};")
        self._texts[node] = name, ATOM
        return name

    def _result(self, node: Node) -> str:
        call, index = node.detail
        procedure = call.procedure
        if call not in self._calls:
            name = self._library.name_of(procedure)
            self.taken.add(name)
            inputs = ", ".join(self._texts[each][0] for each in call.inputs)
            wanted = call.place.names if call.place else (procedure.name,)
            single = len(procedure.results) == 1
            label = wanted[0] if single else "_".join(wanted)
            variable = c_name(label, self.taken)
            kind = procedure.results[0].kind if single else f"{name}_result"
            self.lines.append(f"const {kind} {variable} = {name}({inputs});")
            self._calls[call] = variable
        variable = self._calls[call]
        count = len(procedure.results)
        return variable if count == 1 else f"{variable}.{members(count)[index]}"

    def _converted(self, node: Node) -> tuple[str, int]:
        (of,) = node.inputs
        if of.kind == node.kind:
            return self._texts[of]
        if node.kind == "bool":
            return f"{self._inside(of, PRODUCT)} != {number(0, of.kind)[0]}", OPERATIONS["ne"].binds
        if of.kind == "bool":
            yes, no = number(1, node.kind)[0], number(0, node.kind)[0]
            return f"{self._inside(of, OPERATIONS['lt'].binds)} ? {yes} : {no}", 1
        if node.kind == "int32_t":
            self._library.helpers.add("as_int32")
            return f"as_int32({self._texts[of][0]})", ATOM
        return f"(float){self._inside(of, ATOM)}", UNARY

    def _power(self, node: Node) -> tuple[str, int]:
        (of,), power = node.inputs, node.detail
        if power == 0:
            return "1.0f", ATOM
        text, binds = self._texts[of]
        base = text if binds == ATOM else self._named(of)
        product = " * ".join([base] * abs(power))
        return (product, PRODUCT) if power > 0 else (f"1.0f / ({product})", PRODUCT)


def _operation(node: Node) -> Operation:
    of = node.inputs[-1].kind
    if of == "int32_t":
        operation = WHOLE.get(node.operation)
        if operation is None:
            raise TegotaeError(
                f"the controller uses {node.operation!r} on whole numbers, which cannot be exported"
            )
        return operation
    return OPERATIONS[node.operation]


def number(value: Number, kind: str) -> tuple[str, int]:
    """A constant in C, and how tightly it binds.

    Example:
        >>> number(0.1, "float"), number(-2, "int32_t"), number(True, "bool")
        (('0.1f', 9), ('-2', 8), ('true', 9))
    """
    if kind == "bool":
        return ("true" if value else "false"), ATOM
    if kind == "int32_t":
        whole = int(value)
        if whole == -(2**31):
            return "INT32_MIN", ATOM
        return str(whole), ATOM if whole >= 0 else UNARY
    single = np.float32(value)
    if np.isnan(single):
        return "NAN", ATOM
    if np.isinf(single):
        return ("INFINITY", ATOM) if single > 0 else ("-INFINITY", UNARY)
    text = str(single)
    if "e" not in text and "." not in text:
        text += ".0"
    return f"{text}f", ATOM if single >= 0 and not text.startswith("-") else UNARY


def struct(name: str, paths: Sequence[WeightName]) -> str:
    """The type of a part's weights."""
    tree = nested(paths, [0.0] * len(paths))
    return f"typedef struct {{\n{_members(tree, '    ')}}} {name};\n"


def _members(tree: Mapping[str, Json], indent: str) -> str:
    return "".join(_member(name, entry, indent) for name, entry in tree.items())


def _member(name: str, entry: Json, indent: str) -> str:
    if isinstance(entry, dict):
        return f"{indent}struct {{\n{_members(entry, indent + '    ')}{indent}}} {name};\n"
    if isinstance(entry, list):
        whole = _member(name, entry[0], indent)
        return f"{whole[: whole.rindex(';')]}[{len(entry)}];\n"
    return f"{indent}float {name};\n"


def initialiser(paths: Sequence[WeightName], values: Sequence[Json], indent: str = "    ") -> str:
    """The values of a struct, each under its name."""
    return _values(nested(paths, values), indent)


def _values(tree: Json, indent: str) -> str:
    if not isinstance(tree, (dict, list)):
        return number(cast(float, tree), "float")[0]
    inner = indent + "    "
    if isinstance(tree, dict):
        entries = [f".{name} = {_values(entry, inner)}" for name, entry in tree.items()]
    else:
        entries = [_values(entry, inner) for entry in tree]
    line = ", ".join(entries)
    if "\n" not in line and "{" not in line:
        short = f"{{{line}}}"
        return short if len(short) + len(indent) < 90 else _long(line, indent)
    return "{\n" + "".join(f"{inner}{entry},\n" for entry in entries) + f"{indent}}}"


def _long(line: str, indent: str) -> str:
    whole = wrapped(line.replace(" = ", "~=~"), indent + "    ").replace("~=~", " = ")
    return f"{{\n{whole}\n{indent}}}"
