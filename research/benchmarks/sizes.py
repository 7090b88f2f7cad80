"""The disk that tegotae, its dependencies and its extras take, from what is installed here.

    python -m research.benchmarks.sizes

A dependency is counted with what nothing else needs, an extra with what it needs beyond a plain
installation.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
LEAST = ("docstring-parser", "jax", "msgspec", "numpy", "pandas", "rich", "scipy")
"""Dependencies with which controllers are simulated and exported, on XLA and without figures."""
NOT_FOR_USERS = ("all", "dev", "docs", "test")


def closure(requirements: Iterable[str]) -> set[str]:
    """Return the names of the installed distributions that requirements need, directly or
    indirectly.
    """
    names: set[str] = set()
    visited: set[tuple[str, str]] = set()
    waiting = [Requirement(text) for text in requirements]
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        try:
            needs = [Requirement(text) for text in distribution(name).requires or []]
        except PackageNotFoundError:
            continue
        names.add(name)
        for extra in {"", *requirement.extras} - {
            option for text, option in visited if text == name
        }:
            visited.add((name, extra))
            waiting += [
                need
                for need in needs
                if need.marker is None or need.marker.evaluate({"extra": extra})
            ]
    return names


def megabytes(names: Iterable[str]) -> float:
    """Return the size of the files of distributions [MB]."""
    files = {Path(str(f.locate())) for name in names for f in distribution(name).files or []}
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6


def main() -> None:
    """Print a line for the plain installation, for the least one, for each dependency and for each
    extra.
    """
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    plain = closure(project["dependencies"])
    sizes = sorted(((megabytes([name]), name) for name in plain), reverse=True)
    largest = ", ".join(f"{name} {size:.0f}" for size, name in sizes[:8])
    print(f"{'(none)':18}{megabytes(plain):6.0f} MB  {largest}")
    print(f"{'(least)':18}{megabytes(closure(LEAST)):6.0f} MB  {', '.join(LEAST)}")
    for dependency in project["dependencies"]:
        reduced = [entry for entry in project["dependencies"] if entry != dependency]
        exclusive = sorted(plain - closure(reduced))
        name = Requirement(dependency).name
        print(f"{name:18}{megabytes(exclusive):6.0f} MB  {', '.join(exclusive) or 'shared'}")
    for extra, requirements in project["optional-dependencies"].items():
        if extra not in NOT_FOR_USERS:
            further = sorted(closure(requirements) - plain)
            print(f"{extra:18}{megabytes(further):6.0f} MB  {', '.join(further)}")


if __name__ == "__main__":
    main()
