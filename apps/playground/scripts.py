"""JavaScript modules joined into one script: what they import comes first, once."""

from __future__ import annotations

import re
from importlib import resources
from posixpath import dirname, join, normpath

_IMPORT = re.compile(r'^import\s*\{[^}]*\}\s*from\s*"(\.[^"]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(async |function|class|const|let))", re.MULTILINE)


def read_source(name: str) -> str:
    """Read a file of the page's source."""
    return (resources.files("apps.playground") / "web" / name).read_text(encoding="utf-8")


def modules(entry: str) -> list[str]:
    """Return the module and all its imports, in an order in which they can run.

    Example:
        >>> modules("learn/fitness.js")
        ['measures.js', 'learn/spectrum.js', 'learn/fitness.js']
    """
    order: list[str] = []

    def visit(name: str) -> None:
        if name in order:
            return
        for imported in _IMPORT.findall(read_source(name)):
            visit(normpath(join(dirname(name), imported)))
        order.append(name)

    visit(entry)
    return order


def bundle_scripts(entry: str) -> str:
    """Bundle a module and all its imports as one script; their names are all distinct."""
    parts = []
    for name in modules(entry):
        text = _EXPORT.sub("", _IMPORT.sub("", read_source(name)))
        parts.append(f"// {name}\n{text}")
    return "\n".join(parts)
