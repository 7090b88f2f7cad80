"""Writing an export: what cannot be exported is refused before the first file is written."""

from __future__ import annotations

from pathlib import Path

from tegotae._support.files import output_folder, write_atomically
from tegotae.export.c.check_program import check_program
from tegotae.export.c.golden import golden
from tegotae.export.c.header import header
from tegotae.export.c.manifest import manifest
from tegotae.export.c.plan import Export
from tegotae.export.c.readme import cmake, readme
from tegotae.export.c.source import source


def texts(export: Export) -> dict[str, str]:
    """All files of an export by name.

    Raises:
        TegotaeError: for a controller with an operation that has no C, by its name.
    """
    prefix = export.prefix
    written = {f"{prefix}.c": source(export), f"{prefix}.h": header(export)}
    vectors = golden(export)
    return {
        **written,
        f"test_{prefix}.c": check_program(export, vectors),
        f"{prefix}.json": manifest(export, vectors),
        "golden.csv": vectors.csv(),
        "CMakeLists.txt": cmake(export),
        "README.md": readme(export),
    }


def write(export: Export, folder: Path) -> list[Path]:
    """Write an export; the paths of its files.

    Args:
        export: what.
        folder: where; made if it is missing.

    Raises:
        TegotaeError: for what cannot be exported, or a folder that cannot be written to.
    """
    source(export)  # refuses what has no C, and is quick
    output_folder(folder)
    made = texts(export)
    for name, text in made.items():
        write_atomically(folder / name, text)
    return [folder / name for name in made]
