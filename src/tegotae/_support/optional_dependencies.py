"""Optional packages: what is missing, and which extra to install."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from types import ModuleType

from tegotae._support.errors import TegotaeError

CPU_TORCH = "pip install torch --index-url https://download.pytorch.org/whl/cpu"
"""Torch for the CPU; on Linux, what the extra sb3 installs by itself has CUDA, too."""


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
    require_all({module: extra})
    return importlib.import_module(module)


def require_all(extras: Mapping[str, str]) -> None:
    """Import optional modules, given with their extras.

    Raises:
        MissingExtraError: one for all that are not installed.

    Example:
        >>> require_all({"json": "gym", "no_module": "gym", "nor_this": "mujoco"})
        Traceback (most recent call last):
        tegotae._support.optional_dependencies.MissingExtraError: no_module, nor_this are not \
installed; pip install 'tegotae[gym,mujoco]', or in a clone pip install '.[gym,mujoco]'
    """
    missing: dict[str, str] = {}
    for module, extra in extras.items():
        try:
            importlib.import_module(module)
        except ModuleNotFoundError as error:
            missing[str(error.name)] = extra
    if missing:
        are = "is" if len(missing) == 1 else "are"
        how = how_to_install(*dict.fromkeys(missing.values()))
        raise MissingExtraError(f"{', '.join(missing)} {are} not installed; {how}")


def how_to_install(*extras: str) -> str:
    """How extras come to a package that was installed, and to a clone of its sources.

    Example:
        >>> how_to_install("gym", "mujoco")
        "pip install 'tegotae[gym,mujoco]', or in a clone pip install '.[gym,mujoco]'"
    """
    names = ",".join(extras)
    how = f"pip install 'tegotae[{names}]', or in a clone pip install '.[{names}]'"
    if "sb3" in extras:
        return f"{CPU_TORCH} (by default torch is several GB, for GPUs), then {how}"
    return how
