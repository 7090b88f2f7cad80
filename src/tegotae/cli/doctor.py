"""`tegotae doctor`: what is installed and what the machine offers, for a bug report."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, metadata, version

from tegotae import __version__
from tegotae._support.errors import how_to_install

_CORE = ("jax", "jaxlib", "numpy", "scipy", "matplotlib")
"""Required packages whose versions decide about results."""
_FOR_DEVELOPERS = ("all", "dev", "docs", "test")
"""Extras that no command needs."""
_COMPILERS = ("cc", "gcc", "clang")
_PROGRAMS = ("ffmpeg",)


@dataclass(frozen=True)
class Doctor:
    """Print versions, extras, cores, engine and compiler for a bug report."""

    json: bool = False
    """Print one JSON object."""

    def run(self) -> None:
        """Look, and print."""
        found = diagnosis()
        if self.json:
            print(json.dumps(found, indent=1))
            return
        for title, values in found.items():
            print(title)
            for name, value in values.items():
                print(f"  {name:<14} {value}")


def diagnosis() -> dict[str, Mapping[str, str | int]]:
    """The installation and this machine, by subject."""
    return {
        "versions": {
            "tegotae": __version__,
            "python": platform.python_version(),
            **{name: installed(name) or "missing" for name in _CORE},
        },
        "extras": dict(_extras()),
        "machine": _machine(),
        "engine": _engine(),
        "settings": _settings(),
    }


def installed(package: str) -> str | None:
    """The version of an installed package; None if it is not installed.

    Example:
        >>> installed("no-such-package") is None
        True
    """
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def extras() -> Mapping[str, tuple[str, ...]]:
    """The packages of each extra that a command may need, from the metadata of tegotae."""
    found: dict[str, list[str]] = {}
    for line in metadata("tegotae").get_all("Requires-Dist") or ():
        extra = re.search(r"extra == ['\"]([\w-]+)['\"]", line)
        name = re.match(r"[\w.-]+(\[[\w-]+\])?", line)
        if extra is None or name is None or extra[1] in _FOR_DEVELOPERS:
            continue
        package = name[0].removesuffix("[mujoco]")
        found.setdefault(extra[1], []).append("mujoco" if package != name[0] else package)
    return {extra: tuple(packages) for extra, packages in found.items()}


def _extras() -> Iterator[tuple[str, str]]:
    for extra, packages in extras().items():
        versions = {package: installed(package) for package in packages}
        missing = [package for package, found in versions.items() if found is None]
        if missing:
            yield extra, f"not installed: {', '.join(missing)}; {how_to_install(extra)}"
        else:
            yield extra, ", ".join(f"{package} {found}" for package, found in versions.items())


def _machine() -> dict[str, str | int]:
    from tegotae._support.engines import available_cores

    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    return {
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "cores": available_cores(),
        "compiler": "none" if compiler is None else _first_line(compiler, "--version"),
        **{name: shutil.which(name) or "none" for name in _PROGRAMS},
    }


def _first_line(*command: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{command[0]} does not run: {error}"
    return (done.stdout.splitlines() or [f"{command[0]} prints no version"])[0]


def _engine() -> dict[str, str | int]:
    import jax

    from tegotae._support.engines import selected, why_not_native

    return {
        "engine": selected(),
        "native code": why_not_native() or "can be had",
        "XLA's devices": ", ".join(str(each) for each in jax.local_devices()),
    }


def _settings() -> dict[str, str]:
    """The variables of the environment that change what tegotae does."""
    own = {
        name: value
        for name, value in sorted(os.environ.items())
        if name.startswith(("TEGOTAE_", "JAX_", "OMP_"))
    }
    return own | {"executable": sys.executable}
