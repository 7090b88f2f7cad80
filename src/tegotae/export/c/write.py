"""Writing an export: what cannot be exported is refused before the first file is written."""

from __future__ import annotations

from pathlib import Path

from tegotae._support.files import output_file, output_folder, write_atomically
from tegotae.export.c.check_program import check_program
from tegotae.export.c.golden import golden
from tegotae.export.c.header import header
from tegotae.export.c.layouts import LAYOUTS, ExportLayout
from tegotae.export.c.manifest import manifest
from tegotae.export.c.plan import Export
from tegotae.export.c.readme import cmake, readme
from tegotae.export.c.source import source


def texts(export: Export, layout: ExportLayout = LAYOUTS["flat"]) -> dict[str, str]:
    """All files of an export by their paths in its folder.

    Raises:
        TegotaeError: for a controller with an operation that has no C, by its name.
    """
    prefix = export.prefix
    code = {f"{prefix}.c": source(export), f"{prefix}.h": header(export)}
    vectors = golden(export)
    made = {
        **code,
        f"test_{prefix}.c": check_program(export, vectors),
        f"{prefix}.json": "",  # lists all files, itself too
        "golden.csv": vectors.csv(),
        "README.md": readme(export, layout),
    }
    if not layout.library:
        made["CMakeLists.txt"] = cmake(export)
    placed = {layout.place(name): text for name, text in made.items()} | layout.own_files(export)
    own = layout.place(f"{prefix}.json")
    return {**placed, own: manifest(export, vectors, layout, list(placed))}


def write(export: Export, folder: Path, layout: ExportLayout = LAYOUTS["flat"]) -> list[Path]:
    """Write an export; the paths of its files.

    Args:
        export: what.
        folder: where; made if it is missing.
        layout: which folders of it the files lie in.

    Raises:
        TegotaeError: for what cannot be exported, or a folder that cannot be written to.
    """
    source(export)  # refuses what has no C, and is quick
    output_folder(folder)
    made = texts(export, layout)
    for name, text in made.items():
        write_atomically(output_file(folder / name), text)
    return [folder / name for name in made]
