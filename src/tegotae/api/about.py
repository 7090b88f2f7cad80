"""About the program: what is installed and what the machine offers, and how to cite."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, metadata, version

import pandas as pd

from tegotae import __version__
from tegotae._support.errors import how_to_install
from tegotae.api.parameters import check_types
from tegotae.api.results import Table

_CORE = ("jax", "jaxlib", "numpy", "scipy", "matplotlib")
"""Required packages whose versions decide about results."""
_FOR_DEVELOPERS = ("all", "dev", "docs", "test")
"""Extras that no command needs."""
_COMPILERS = ("cc", "gcc", "clang")


@check_types
def doctor() -> Table:
    """Print versions, extras, cores, engine and compiler for a bug report."""
    import jax

    from tegotae._support.engines import available_cores, selected, why_not_native

    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    versions = {
        "versions": {
            "tegotae": __version__,
            "python": platform.python_version(),
            **{name: installed(name) or "missing" for name in _CORE},
        },
        "extras": dict(_extras()),
        "machine": {
            "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
            "cores": available_cores(),
            "compiler": "none" if compiler is None else _first_line(compiler, "--version"),
            "ffmpeg": shutil.which("ffmpeg") or "none",
        },
        "engine": {
            "engine": selected(),
            "native code": why_not_native() or "can be had",
            "XLA's devices": ", ".join(map(str, jax.local_devices())),
        },
        "settings": {
            name: value
            for name, value in sorted(os.environ.items())
            if name.startswith(("TEGOTAE_", "JAX_", "OMP_"))
        }
        | {"executable": sys.executable},
    }
    rows = [(subject, name, x) for subject, facts in versions.items() for name, x in facts.items()]
    table = pd.DataFrame(rows, columns=["subject", "name", "value"])
    return Table(rows=table, views=[table.set_index(["subject", "name"])], data=versions)


def installed(package: str) -> str | None:
    """Return the version of an installed package; None if it is not installed.

    Example:
        >>> installed("no-such-package") is None
        True
    """
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def extras() -> Mapping[str, tuple[str, ...]]:
    """Return the packages of each extra that a command may need, from the metadata."""
    packages: dict[str, tuple[str, ...]] = {}
    for line in metadata("tegotae").get_all("Requires-Dist") or ():
        extra = re.search(r"extra == ['\"]([\w-]+)['\"]", line)
        name = re.match(r"[\w.-]+(?:\[([\w-]+)\])?", line)  # gymnasium[mujoco] brings mujoco
        if extra and name and extra[1] not in _FOR_DEVELOPERS:
            packages[extra[1]] = (*packages.get(extra[1], ()), name[1] or name[0])
    return packages


def _extras() -> Iterator[tuple[str, str]]:
    for extra, packages in extras().items():
        versions = {package: installed(package) for package in packages}
        if missing := [package for package in packages if versions[package] is None]:
            yield extra, f"not installed: {', '.join(missing)}; {how_to_install(extra)}"
        else:
            yield extra, ", ".join(f"{package} {x}" for package, x in versions.items())


def _first_line(*command: str) -> str:
    try:
        process = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{command[0]} does not run: {error}"
    return (process.stdout.splitlines() or [f"{command[0]} prints no version"])[0]


@dataclass(frozen=True)
class Reference:
    """A work to cite."""

    key: str
    """Key of the BibTeX entry."""
    kind: str
    """Kind of the BibTeX entry, such as inproceedings."""
    authors: tuple[str, ...]
    """Authors, with initials and family name, or a group."""
    title: str
    venue: str = ""
    year: str = ""
    version: str = ""

    def text(self) -> str:
        """Return the reference as one sentence of a bibliography."""
        *coauthors, last = self.authors
        authors = f"{', '.join(coauthors)} and {last}" if coauthors else last
        version = f"version {self.version}" if self.version else ""
        where = [self.venue or "Software", version, self.year]
        return f"{authors}: {self.title}. {', '.join(filter(None, where))}."

    def bibtex(self) -> str:
        """Return the reference as a BibTeX entry."""
        group = len(self.authors) == 1
        authors = " and ".join(self.authors)
        fields = {
            "author": f"{{{authors}}}" if group else authors,
            "title": f"{{{self.title}}}",
            "booktitle": self.venue,
            "version": self.version,
            "year": self.year,
        }
        lines = [f"  {name} = {{{value}}}," for name, value in fields.items() if value]
        return "\n".join([f"@{self.kind}{{{self.key},", *lines, "}"])


PAPER = Reference(
    key="herneth2023learnable",
    kind="inproceedings",
    authors=("C. Herneth", "M. Hayashibe", "D. Owaki"),
    title="Learnable Tegotae-based Feedback in CPGs with Sparse Observation Produces Efficient and "
    "Adaptive Locomotion",
    venue="IEEE International Conference on Robotics and Automation (ICRA)",
    year="2023",
)
"""The paper. Its DOI and page numbers are left out: no source at hand confirms them."""
SOFTWARE = Reference(
    key="tegotae",
    kind="software",
    authors=("The tegotae developers",),
    title="tegotae: learned Tegotae feedback in central pattern generators",
    version=__version__,
    year="2026",
)
"""This package."""


@check_types
def cite(*, bibtex: bool = False) -> Table:
    """Print how to cite this software and the paper that it implements, with BibTeX entries.

    Args:
        bibtex: print the BibTeX entries alone.
    """
    references = (SOFTWARE, PAPER)
    lines = ["Please cite the software and the paper:", *(x.text() for x in references)]
    entries = [x.bibtex() for x in references]
    return Table(
        title="\n\n".join(entries if bibtex else [*lines, *entries]),
        rows=[asdict(x) for x in references],
        data={x.key: x for x in references},
    )
