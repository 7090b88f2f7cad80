"""Optional packages: what is missing, and which extra to install."""

from __future__ import annotations

import importlib
from types import ModuleType

from tegotae._support.errors import TegotaeError


class MissingExtraError(TegotaeError, ImportError):
    """An optional package is not installed: says which extra of tegotae installs it."""


def require(module: str, extra: str) -> ModuleType:
    """The optional module, imported.

    Raises:
        MissingExtraError: if it, or a package that it needs, is not installed.

    Example:
        >>> try:
        ...     require("no_such_module", "gym")
        ... except MissingExtraError as error:
        ...     print(error)
        no_such_module is not installed; pip install 'tegotae[gym]', or in a clone \
pip install '.[gym]'
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise MissingExtraError(f"{error.name} is not installed; {how_to_install(extra)}") from None


def how_to_install(extra: str) -> str:
    """How an extra comes to a package that was installed, and to a clone of its sources.

    Example:
        >>> how_to_install("sb3")
        "pip install 'tegotae[sb3]', or in a clone pip install '.[sb3]'"
    """
    return f"pip install 'tegotae[{extra}]', or in a clone pip install '.[{extra}]'"
