"""The commands of `tegotae`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tegotae.cli.program import Command, CommandGroup

_PURPOSES: Mapping[str, Mapping[str, Any]] = tomllib.loads(
    Path(__file__).with_name("commands.toml").read_text(encoding="utf-8")
)
"""By purpose and name the function of each command, and what a user can type after the name."""
_FUNCTIONS = {name: entry for commands in _PURPOSES.values() for name, entry in commands.items()}

_GROUPS: Mapping[str, str] = {
    "wiring": "Put controllers on a leg of your own: a MuJoCo model, or any environment.",
    "figure": "Draw a figure that explains a controller, and write its numbers.",
    "gait": "Study the gaits of a body with several legs.",
    "export": "Export a controller to a robot.",
    "benchmark": "Score controllers of any kind on the same bodies.",
}
"""What the commands of two words are for, by the first."""


def _command(name: str, function: str, examples: Sequence[str]) -> Command:
    """The command of a function or a method."""
    inside = "." not in function.partition(":")[0]
    place = f"tegotae.api.{function}" if inside else function
    return Command(place, *(f"tegotae {name} {words}".rstrip() for words in examples))


def _commands() -> dict[str, Command | CommandGroup]:
    loaded = {name: _command(name, **entry) for name, entry in _FUNCTIONS.items()}
    commands: dict[str, Command | CommandGroup] = {}
    for name in loaded:
        first, _, grouped = name.partition(" ")
        if grouped:
            subcommands = {
                n.partition(" ")[2]: loaded[n] for n in loaded if n.startswith(f"{first} ")
            }
            commands[first] = CommandGroup(_GROUPS[first], subcommands)
        else:
            commands[name] = loaded[name]
    return commands


COMMANDS: Mapping[str, Command | CommandGroup] = _commands()
SECTIONS: Mapping[str, tuple[str, ...]] = {
    purpose: tuple(dict.fromkeys(name.partition(" ")[0] for name in commands))
    for purpose, commands in _PURPOSES.items()
}
"""The commands by what one wants to do, for the list of them."""

TEGOTAE = CommandGroup(
    "Train, simulate and compare learned Tegotae feedback in central pattern generators.",
    COMMANDS,
    SECTIONS,
)
"""The program."""
