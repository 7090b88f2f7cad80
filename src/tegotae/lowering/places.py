"""Where in a program an operation of a trace was written."""

from __future__ import annotations

import ast
import functools
from dataclasses import dataclass
from pathlib import Path

import jax

from tegotae.lowering import tracing
from tegotae.lowering.jaxprs import Traced


@dataclass(frozen=True)
class Place:
    """Where in a program something is computed."""

    file: Path
    line: int
    function: str

    @property
    def names(self) -> tuple[str, ...]:
        """What the line's assignment calls its value or its values; else the function's name."""
        name = self.function.split(".")[-1].strip("_")
        return _assigned(self.file).get(self.line) or (name if name.isidentifier() else "value",)


def is_of_jax(path: str) -> bool:
    """Whether a path, or what begins with one, is that of a file of JAX itself."""
    return _JAX in path


_JAX = str(Path(jax.__file__).parent)


def place_of(equation: Traced) -> Place | None:
    """The line of the program that made an operation of a trace, if that is known."""
    try:
        frames = equation.source_info.traceback.frames
    except AttributeError:
        return None
    for frame in frames:
        path = frame.file_name
        if path != tracing.__file__ and not is_of_jax(path) and not path.startswith("<"):
            return Place(Path(path), frame.line_num, frame.function_name)
    return None


@functools.cache
def _assigned(file: Path) -> dict[int, tuple[str, ...]]:
    """The names that each line of a file assigns to."""
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return {}
    found: dict[int, tuple[str, ...]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
        elif isinstance(node, ast.AugAssign | ast.AnnAssign):
            target = node.target
        else:
            continue
        each = target.elts if isinstance(target, ast.Tuple) else [target]
        names = tuple(name.id for name in each if isinstance(name, ast.Name))
        if len(names) == len(each):
            for line in range(node.lineno, (node.end_lineno or node.lineno) + 1):
                found[line] = names
    return found
