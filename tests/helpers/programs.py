"""The programs of this checkout: `tegotae`, and those beside the package."""

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from apps.playground.__main__ import PLAYGROUND
from research.benchmarks.__main__ import BENCH
from research.reproduction.__main__ import PROG, REPRODUCTION
from tegotae import cli
from tegotae.cli.commands import TEGOTAE
from tegotae.cli.program import Command, CommandGroup

PROGRAMS: Mapping[str, tuple[Command | CommandGroup, str]] = {
    "tegotae": (TEGOTAE, "tegotae"),
    "reproduction": (REPRODUCTION, PROG),
    "benchmarks": (BENCH, "python -m research.benchmarks"),
    "playground": (PLAYGROUND, "python -m apps.playground"),
}
"""Each with the words that start it."""


def main(words: Sequence[str]) -> int:
    """Run `tegotae`, or another program that the first word names: its exit status."""
    program, arguments = _split(words)
    return cli.main(arguments, *PROGRAMS[program])


def parsed(words: Sequence[str]) -> Any:
    """The command of `tegotae`, or of another program that the first word names."""
    program, arguments = _split(words)
    return cli.parsed(arguments, *PROGRAMS[program])


def _split(words: Sequence[str]) -> tuple[str, list[str]]:
    if words and words[0] in PROGRAMS:
        return words[0], list(words[1:])
    return "tegotae", list(words)


def words_of(line: str) -> list[str] | None:
    """The words of a line of the shell that starts a program, its name first; None of others."""
    words = shlex.split(line.partition(" > ")[0], comments=True)
    for name, (_, prog) in PROGRAMS.items():
        start = prog.split()
        if words[: len(start)] == start:
            return [name, *words[len(start) :]]
    return None
