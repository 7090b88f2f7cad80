"""Weights as structs of C: a type for each part, and its values under their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

from tegotae._support.documents import Json
from tegotae.export.c.lower import number, wrapped
from tegotae.parts.weight_names import WeightName, nested


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
