"""The public names: those that the pages of the API name."""

import importlib
import inspect
import re
from collections.abc import Iterator
from typing import Any

from places import ROOT

PAGES = sorted((ROOT / "docs" / "api").glob("*.md"))
_DIRECTIVE = re.compile(r"^\.\. (\w+):: (\S+)\n((?:   :.*\n)*)", re.MULTILINE)


def public() -> Iterator[tuple[str, Any]]:
    """Every name that the pages document, with what it is; modules, too."""
    for page in PAGES:
        for directive, name, options in _DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            if directive == "automodule":
                yield from _of_module(name, options)
            else:
                home, _, attribute = name.rpartition(".")
                yield name, getattr(importlib.import_module(home), attribute)


def _of_module(name: str, options: str) -> Iterator[tuple[str, Any]]:
    module = importlib.import_module(name)
    yield name, module
    inputs = re.search(r":members:(.*)", options)
    if inputs is None:
        return
    members = [entry.strip() for entry in inputs[1].split(",") if entry.strip()]
    if not members:
        members = list(getattr(module, "__all__", None) or _own(module))
    for member in members:
        yield f"{name}.{member}", getattr(module, member)


def _own(module: Any) -> Iterator[str]:
    for name, value in vars(module).items():
        is_code = inspect.isclass(value) or inspect.isfunction(value)
        if is_code and value.__module__ == module.__name__ and not name.startswith("_"):
            yield name
