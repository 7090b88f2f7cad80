"""C statements of a graph of scalars, and the functions and structs that they use."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

from lanewise.nodes import Node, place_of, reachable
from lanewise.operations import ATOM, OPERATIONS, PRODUCT, UNARY, WHOLE, Operation
from tegotae._support.documents import Json
from tegotae._support.errors import TegotaeError
from tegotae.parts.weight_names import WeightName, nested
from tegotae_robots.c.reader import Call, Procedure
from tegotae_robots.c.text import c_name, c_number, comment_of, floating, template_text, wrapped

_LONGEST = 220
"""Letters of an expression beyond which its parts get names."""


@functools.cache
def helpers() -> dict[str, str]:
    """Return the functions that generated code may call, by their names."""
    texts = template_text("helpers.c").split("\n\n")
    matches = ((re.search(r"^static \w+ (\w+)\(", text, re.MULTILINE), text) for text in texts)
    return {match[1]: f"{text.rstrip()}\n" for match, text in matches if match}


@dataclass
class Library:
    """Functions that the code so far calls: helpers and procedures, in an order that C takes."""

    helpers: set[str] = field(default_factory=set)
    procedures: list[str] = field(default_factory=list)
    """Their C, as it was written."""
    names: dict[int, str] = field(default_factory=dict)
    """Name of each procedure in C, by its identity."""
    taken: set[str] = field(default_factory=lambda: set(helpers()))

    def texts(self) -> list[str]:
        """Return the C of helpers and procedures that are needed."""
        needed = [text for name, text in helpers().items() if name in self.helpers]
        return [*needed, *self.procedures]

    def name_of(self, procedure: Procedure) -> str:
        """Return the name of a procedure in C; the first call writes the procedure."""
        if id(procedure) not in self.names:
            name, lines, results = self._body(procedure)
            parameters = ", ".join(f"{node.kind} {node.detail}" for node in procedure.inputs)
            kinds = [node.kind for node in procedure.results]
            text = c_function(name, parameters, lines, results, kinds, comment=procedure.summary)
            self.names[id(procedure)] = name
            self.procedures.append(text)
        return self.names[id(procedure)]

    def _body(self, procedure: Procedure) -> tuple[str, list[str], list[str]]:
        """Return a procedure's name, its statements, and the texts of its results."""
        body = Statements(self, procedure.parameters)
        results = body.all(procedure.results)
        return c_name(procedure.name, self.taken), body.lines, results


_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


def members(count: int) -> tuple[str, ...]:
    """Return names for the results of a procedure."""
    return _ORDINALS[:count] if count <= len(_ORDINALS) else tuple(f"r{i}" for i in range(count))


def c_function(
    name: str,
    parameters: str,
    lines: Sequence[str],
    results: Sequence[str],
    kinds: Sequence[str],
    names: Sequence[str] | None = None,
    comment: str = "",
    struct: str = "",
) -> str:
    """Return a static function in C.

    Args:
        name: its name.
        parameters: as they stand in C.
        lines: its statements.
        results: expressions; of several it returns a struct.
        kinds: their types.
        names: what they are called in the struct.
        comment: on what it does.
        struct: the type of the struct, if it is known already.
    """
    text = comment_of(comment)
    indented = [wrapped(line) for line in lines]
    if len(results) == 1 and names is None:
        head, back = kinds[0], wrapped(f"return {results[0]};")
    else:
        names = members(len(results)) if names is None else names
        head, back = struct or f"{name}_result", "    return result;"
        if not struct:
            fields = "".join(f"    {k} {n};\n" for k, n in zip(kinds, names, strict=True))
            text = f"typedef struct {{\n{fields}}} {head};\n\n{text}"
        indented.append(f"    {head} result;")
        indented += [wrapped(f"result.{n} = {r};") for n, r in zip(names, results, strict=True)]
    body = "\n".join([*indented, back])
    return f"{text}static {head} {name}({parameters or 'void'})\n{{\n{body}\n}}\n"


class Statements:
    """Writer of the statements that compute some nodes.

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
        """Return the texts of the nodes, and add the statements that they need to `lines`."""
        order = reachable(nodes)
        calls: set[Call] = set()
        for node in order:
            if node.operation == "result":  # of which a call may have several
                if node.detail[0] in calls:
                    continue
                calls.add(node.detail[0])
            for x in node.inputs:
                self._uses[x] = self._uses.get(x, 0) + 1
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
        return self._named(node, text), ATOM

    def _named(self, node: Node, text: str) -> str:
        """Return a new name for a value, with the statement that gives it."""
        name = c_name(_source_name(node), self.taken)
        self.lines.append(f"const {node.kind} {name} = {text};")
        return name

    def _expression(self, node: Node) -> tuple[str, int]:
        if node.operation == "literal":
            return c_number(node.detail, node.kind)
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
        operands = [self._inside(x, operation.inside[i]) for i, x in enumerate(node.inputs)]
        text = cast(str, operation.text)  # `CReader` refuses operations without one
        if text.count("{0}") > 1 and self._texts[node.inputs[0]][1] != ATOM:
            operands[0] = self._variable(node.inputs[0])
        return text.format(*operands), operation.binds

    def _inside(self, node: Node, binding: int) -> str:
        text, binds = self._texts[node]
        return f"({text})" if binds < binding else text

    def _variable(self, node: Node) -> str:
        """Return a name for a value, even if it is used only once."""
        name = self._named(node, self._texts[node][0])
        self._texts[node] = name, ATOM
        return name

    def _result(self, node: Node) -> str:
        call, index = node.detail
        procedure = call.procedure
        if call not in self._calls:
            name = self._library.name_of(procedure)
            self.taken.add(name)
            inputs = ", ".join(self._texts[x][0] for x in call.inputs)
            labels = call.names
            single = len(procedure.results) == 1
            label = labels[0] if single else "_".join(labels)
            variable = c_name(label, self.taken)
            kind = procedure.results[0].kind if single else f"{name}_result"
            self.lines.append(f"const {kind} {variable} = {name}({inputs});")
            self._calls[call] = variable
        variable = self._calls[call]
        count = len(procedure.results)
        return variable if count == 1 else f"{variable}.{members(count)[index]}"

    def _converted(self, node: Node) -> tuple[str, int]:
        (operand,) = node.inputs
        if operand.kind == node.kind:
            return self._texts[operand]
        if node.kind == "bool":
            return (
                f"{self._inside(operand, PRODUCT)} != {c_number(0, operand.kind)[0]}",
                OPERATIONS["ne"].binds,
            )
        if operand.kind == "bool":
            yes, no = c_number(1, node.kind)[0], c_number(0, node.kind)[0]
            return f"{self._inside(operand, OPERATIONS['lt'].binds)} ? {yes} : {no}", 1
        if node.kind == "int32_t":
            self._library.helpers.add("as_int32")
            return f"as_int32({self._texts[operand][0]})", ATOM
        return f"(float){self._inside(operand, ATOM)}", UNARY

    def _power(self, node: Node) -> tuple[str, int]:
        (operand,), power = node.inputs, node.detail
        if power == 0:
            return "1.0f", ATOM
        text, binds = self._texts[operand]
        base = text if binds == ATOM else self._variable(operand)
        product = " * ".join([base] * abs(power))
        return (product, PRODUCT) if power > 0 else (f"1.0f / ({product})", PRODUCT)


def _source_name(node: Node) -> str:
    """Return the name of a value in the Python source."""
    place = place_of(node.origin)
    return place.names[0] if place else "value"


def _operation(node: Node) -> Operation:
    kind = node.inputs[-1].kind
    if kind == "int32_t":
        operation = WHOLE.get(node.operation)
        if operation is None:
            raise TegotaeError(
                f"the controller uses {node.operation!r} on whole numbers, which cannot be exported"
            )
        return operation
    return OPERATIONS[node.operation]


def struct(name: str, paths: Sequence[WeightName]) -> str:
    """Return the type of a part's weights."""
    tree = nested(paths, [0.0] * len(paths))
    return f"typedef struct {{\n{_members(tree, '    ')}}} {name};\n"


def _members(tree: Mapping[str, Json], indent: str) -> str:
    return "".join(_member(name, entry, indent) for name, entry in tree.items())


def _member(name: str, entry: Json, indent: str) -> str:
    if isinstance(entry, dict):
        return f"{indent}struct {{\n{_members(entry, indent + '    ')}{indent}}} {name};\n"
    if isinstance(entry, list):
        declaration = _member(name, entry[0], indent)
        return f"{declaration[: declaration.rindex(';')]}[{len(entry)}];\n"
    return f"{indent}float {name};\n"


def initialiser(paths: Sequence[WeightName], values: Sequence[Json], indent: str = "    ") -> str:
    """Return the values of a struct, each under its name."""
    return _values(nested(paths, values), indent)


def _values(tree: Json, indent: str) -> str:
    if not isinstance(tree, (dict, list)):
        return floating(cast(float, tree))
    deeper = indent + "    "
    if isinstance(tree, dict):
        entries = [f".{name} = {_values(entry, deeper)}" for name, entry in tree.items()]
    else:
        entries = [_values(entry, deeper) for entry in tree]
    line = ", ".join(entries)
    if "\n" not in line and "{" not in line:
        short = f"{{{line}}}"
        return short if len(short) + len(indent) < 90 else _long(line, indent)
    return "{\n" + "".join(f"{deeper}{entry},\n" for entry in entries) + f"{indent}}}"


def _long(line: str, indent: str) -> str:
    lines = wrapped(line.replace(" = ", "~=~"), indent + "    ").replace("~=~", " = ")
    return f"{{\n{lines}\n{indent}}}"
