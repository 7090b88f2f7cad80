"""The code of a user's part as one hash: of its file, and of the modules beside it.

Comments, docstrings and layout are no part of it.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import inspect
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from typing import cast

_OWN = __name__.partition(".")[0]


def code_of(kind: type | Callable[..., object]) -> str | None:
    """Return the SHA-256 of a class's or function's code, or None for this package's and unknown
    code.

    A class of no file, such as a notebook's, is its own methods alone.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> code_of(Hopper) is None
        True
    """
    if kind.__module__.partition(".")[0] == _OWN:
        return None
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    if file is not None and Path(file).is_file():
        return code_of_file(Path(file), kind.__module__)
    texts = list(_methods(kind))
    return hashlib.sha256("\n".join(texts).encode()).hexdigest() if texts else None


def code_of_file(file: Path, module: str = "") -> str:
    """Return the SHA-256 of a Python file and of the modules beside it that it imports,
    recursively.

    Beside it is what lies in its folder, or in its package and the folder around that. Of another
    kind of file it is that of its bytes.

    Args:
        file: where it is.
        module: its name, which says in which packages it is, if these have no `__init__.py`.

    Raises:
        OSError: if it cannot be read.
    """
    file = file.resolve()
    if file.suffix != ".py":
        return hashlib.sha256(file.read_bytes()).hexdigest()
    root = file.parents[module.count(".") + (file.stem == "__init__") if "." in module else 0]
    while (root / "__init__.py").is_file():
        root = root.parent
    texts: dict[Path, bytes] = {}
    waiting = [file]
    while waiting:
        path = waiting.pop()
        if path in texts:
            continue
        texts[path] = path.read_bytes()
        with contextlib.suppress(SyntaxError, ValueError):  # of an extension module, such as .so
            tree = ast.parse(texts[path])
            texts[path] = _canonical(tree).encode(errors="backslashreplace")
            waiting += _beside(tree, path, root)
    digest = hashlib.sha256()
    for path, text in sorted(texts.items()):
        digest.update(f"{path.relative_to(root).as_posix()} {len(text)}\n".encode())
        digest.update(text)
    return digest.hexdigest()


def _canonical(tree: ast.Module) -> str:
    """Return the code as text, level by level: as `ast.dump`, but the same in all versions of
    Python.
    """
    lines: list[str] = []
    waiting: deque[object] = deque([tree])
    while waiting:
        node = waiting.popleft()
        if isinstance(node, list):
            nodes = cast(list[object], node)
            lines.append(str(len(nodes)))
            waiting.extend(nodes)
        elif isinstance(node, ast.AST):
            fields = _fields(node)
            lines.append(" ".join((type(node).__name__, *fields)))
            waiting.extend(fields.values())
        else:
            lines.append(repr(node))
    return "\n".join(lines)


def _fields(node: ast.AST) -> dict[str, object]:
    fields = dict(ast.iter_fields(node))
    if isinstance(node, _WITH_DOCSTRING) and ast.get_docstring(node, clean=False) is not None:
        fields["body"] = node.body[1:]
    return {
        name: value
        for name, value in fields.items()
        if value not in (None, []) and name not in ("kind", "type_comment")
    }


_WITH_DOCSTRING = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
_INSTALLED = ("site-packages", "dist-packages")
"""Folders whose entries are independent packages."""


def _beside(tree: ast.Module, path: Path, root: Path) -> Iterator[Path]:
    """Yield the files of the modules that code imports from under a root."""
    package = path.relative_to(root).parent.parts
    for name in _imported(tree, package):
        top = name.partition(".")[0]
        ours = top in sys.stdlib_module_names or top == _OWN
        if not ours and (root.name not in _INSTALLED or package[:1] == (top,)):
            yield from _files(name, root)


def _imported(tree: ast.Module, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the names of all possible modules in the import statements of a module in a package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            base = (*above, *filter(None, [node.module]))
            yield from (".".join((*base, alias.name)) for alias in node.names)


def _files(name: str, root: Path) -> Iterator[Path]:
    """Yield the files that run when a module, or a name of one, is imported from under a root."""
    places: Sequence[str] | None = [str(root)]
    steps = name.split(".")
    for i in range(len(steps)):
        spec = None if places is None else PathFinder.find_spec(".".join(steps[: i + 1]), places)
        if spec is None:
            return
        if spec.origin is not None:  # a folder alone is a package, too
            yield Path(spec.origin)
        places = spec.submodule_search_locations


def _methods(kind: type | Callable[..., object]) -> Iterator[str]:
    """Yield the text of a class's own methods, where it is known."""
    for _, value in sorted(vars(kind).items()):
        functions = (getattr(value, name, None) for name in ("fget", "func", "__func__"))
        function = next(filter(None, functions), value)
        with contextlib.suppress(OSError, TypeError):
            if inspect.isfunction(function):
                yield inspect.getsource(function)
