"""Tegotae: learned feedback in central pattern generators, a thousand rollouts at a time.

Importing it changes nothing of the program that does, and loads nothing: every name is fetched when
it is first used.
"""

from __future__ import annotations

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOME_OF = {
    name: home
    for home, names in re.findall(r"^from (\S+) import (\([^)]*\)|.*)$", _STUB, re.MULTILINE)
    for name in re.findall(r"(\w+) as ", names)
}
"""By public name the module or the package that has it, as the stub says."""

_METHODS = ("simulate", "evaluate", "compare", "explain", "robustness")
"""Commands of the shell that are methods of loaded controllers."""

__all__ = sorted(_HOME_OF)  # pyright: ignore[reportUnsupportedDunderAll] - it reads the stub


def __getattr__(name: str) -> Any:
    """Return a public name, a module or the version at its first use (PEP 562)."""
    if name in _HOME_OF:
        home = import_module(_HOME_OF[name])
        value = getattr(home, name, None) or import_module(f"{home.__name__}.{name}")
    elif name == "__version__":
        value = _version()
    elif not name.startswith("_") and find_spec(f"{__name__}.{name}") is not None:
        return import_module(f"{__name__}.{name}")
    else:
        hint = f"; tegotae.load(NAME).{name} is a method" if name in _METHODS else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{hint}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", *(name for name in globals() if name[:2] == "__")})


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(__name__)
    except PackageNotFoundError:  # a source tree that is not installed
        return "0+unknown"
