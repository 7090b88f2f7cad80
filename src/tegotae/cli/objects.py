"""A user's own objects on the command line: module:object."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

from tegotae.errors import TegotaeError


def load_object(name: str) -> Any:
    """The object of a module, given as module:object. Importing it runs the module's code.

    The module may lie in the current folder.

    Raises:
        TegotaeError: if there is no such module or object, or the module cannot be imported.

    Example:
        >>> load_object("math:tau").hex()
        '0x1.921fb54442d18p+2'
    """
    module_name, _, attribute = name.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), attribute)):
        raise TegotaeError(
            f"{name!r} names no object; write module:object, such as my_metrics:peak_force for "
            "peak_force of my_metrics.py"
        )
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        module = importlib.import_module(module_name)
    except TegotaeError:
        raise
    except Exception as error:  # the user's code, which may raise anything
        lines = str(error).strip().splitlines() or [""]
        raise TegotaeError(
            f"cannot import {module_name}: {type(error).__name__}: {lines[0]}"
        ) from error
    try:
        return getattr(module, attribute)
    except AttributeError:
        raise TegotaeError(f"{module_name} has no {attribute}") from None
