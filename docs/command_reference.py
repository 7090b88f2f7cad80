"""The command-line reference, from the parser that the commands have."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator, Mapping

from apps.playground.__main__ import PLAYGROUND
from research.benchmarks.__main__ import BENCH
from research.reproduction.__main__ import PROG, REPRODUCTION
from tegotae.api.parameters import description_of
from tegotae.cli.commands import COMMANDS
from tegotae.cli.functions import options_by_subject
from tegotae.cli.program import Command, CommandGroup
from tegotae.cli.records import fields_of
from tegotae.cli.words import flag_of


def command_reference() -> str:
    """All commands with their arguments and options, as Markdown."""
    programs = {f"tegotae {name}": command for name, command in COMMANDS.items()}
    programs[PROG] = REPRODUCTION
    programs["python -m apps.playground"] = PLAYGROUND
    programs["python -m research.benchmarks"] = BENCH
    return "\n".join(part for name, entry in programs.items() for part in _command(name, entry))


def _command(name: str, command: Command | CommandGroup, level: int = 2) -> Iterator[str]:
    yield f"{'#' * level} `{name}`\n"
    if isinstance(command, CommandGroup):
        yield f"{_text(command.summary)}\n"
        for sub, its in command.commands.items():
            yield from _command(f"{name} {sub}", its, level + 1)
        return
    own = command.load()
    yield f"{_text(description_of(own))}\n"
    if inspect.isfunction(own):
        for subject, known in options_by_subject(command).items():
            rows = {flag_of(option): option.description for option in known.values()}
            yield from _table(subject, rows)
    else:
        flags = {flag_of(x): _with_default(x.description, x.value) for x in fields_of(own)}
        yield from _table("option", flags)
    yield "```console\n" + "\n".join(command.examples) + "\n```\n"


def _with_default(text: str, value: object) -> str:
    unsaid = value is dataclasses.MISSING or value in (None, False, ())
    return text if unsaid else f"{text} (default: {value})"


def _table(heading: str, rows: Mapping[str, str]) -> Iterator[str]:
    if rows:
        yield f"| {heading} | meaning |\n|---|---|"
        yield "\n".join(f"| `{name}` | {_text(about)} |" for name, about in rows.items()) + "\n"


def _text(text: str) -> str:
    """A help text in one line of a Markdown table."""
    plain = " ".join(text.split())
    code = re.split(r"(`[^`]*`)", plain.replace("|", "\\|"))
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<$])", r"\\\1", part) for part in code
    )
