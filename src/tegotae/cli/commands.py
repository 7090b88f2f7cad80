"""The commands of `tegotae`, as `commands.toml` lists them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tegotae.cli.program import Command, CommandGroup

_TABLES: Mapping[str, Mapping[str, Any]] = tomllib.loads(
    Path(__file__).with_name("commands.toml").read_text(encoding="utf-8")
)
"""Tables of commands and groups, by purpose and name."""


def _command(
    name: str, table: Mapping[str, Any], subjects: Mapping[str, str]
) -> Command | CommandGroup:
    """Return the command or the group of a table.

    Args:
        name: words after `tegotae`.
        table: its entries in the file.
        subjects: words for each kind of subject, if the table has none.
    """
    subjects = table.get("subjects", subjects)
    if "function" in table:
        function = table["function"]
        is_outside = "." in function.partition(":")[0]
        return Command(
            function if is_outside else f"tegotae.api.{function}",
            *(f"tegotae {name} {words}".rstrip() for words in table["examples"]),
            subjects=subjects or {"": table["examples"][0]},
            **{key: table[key] for key in ("names", "out", "pictures") if key in table},
        )
    tables = {x: table[x] for x in table if x not in ("summary", "subjects")}
    commands = {x: _command(f"{name} {x}", tables[x], subjects) for x in tables}
    return CommandGroup(table["summary"], commands)


COMMANDS: Mapping[str, Command | CommandGroup] = {
    name: _command(name, table, {}) for tables in _TABLES.values() for name, table in tables.items()
}
"""The commands by name."""
SECTIONS: Mapping[str, tuple[str, ...]] = {title: tuple(_TABLES[title]) for title in _TABLES}
"""Names of the commands by purpose, for the list of them."""
TEGOTAE = CommandGroup(
    "Train, simulate and compare learned Tegotae feedback in central pattern generators.",
    COMMANDS,
    SECTIONS,
)
"""The program."""
