"""The command-line reference, from the parser that the commands have."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from tegotae.cli.commands import COMMANDS, Command, CommandGroup
from tegotae.cli.parsing import parser


def command_reference() -> str:
    """All commands with their arguments and options, as Markdown."""
    return "\n".join(part for name, command in COMMANDS.items() for part in _command(name, command))


def _command(name: str, command: Command | CommandGroup, level: int = 2) -> Iterator[str]:
    yield f"{'#' * level} `tegotae {name}`\n"
    if isinstance(command, CommandGroup):
        yield f"{_text(command.summary)}\n"
        for sub, its in command.commands.items():
            yield from _command(f"{name} {sub}", its, level + 1)
        return
    own = parser(command.load())
    yield f"{_text(own.description or '')}\n"
    # The class is the kind of an action, in tyro's own copy of argparse.
    rows = [_row(each) for each in own._actions if type(each).__name__ != "_HelpAction"]
    if rows:
        yield "| option | meaning |\n|---|---|"
        yield "\n".join(rows) + "\n"
    yield "```console\n" + "\n".join(command.examples) + "\n```\n"


def _row(action: Any) -> str:
    names = [option for option in action.option_strings if option.startswith("--")]
    value = action.metavar if isinstance(action.metavar, str) else ""
    # Of names that mean the same, the last is the one of today.
    shown = f"{names[-1]} {value}".strip() if names else value
    return f"| `{shown}` | {_text(action.help or '')} |"


def _text(text: str) -> str:
    """A help text in one line of a Markdown table."""
    for unsaid in ("(default: )", "(default: False)"):
        text = text.replace(unsaid, "")
    plain = " ".join(text.split())
    code = re.split(r"(`[^`]*`)", plain.replace("|", "\\|"))
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<$])", r"\\\1", part) for part in code
    )
