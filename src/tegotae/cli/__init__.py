"""The `tegotae` command: its words, and its end."""

from __future__ import annotations

import gc
import inspect
import os
import sys
from collections.abc import Sequence
from typing import Any

from tegotae._start import QUIET, end_on_ctrl_c, open_streams, ready
from tegotae._support.compiled import keep_xla_programs
from tegotae._support.errors import TegotaeError, unknown
from tegotae.cli.commands import TEGOTAE
from tegotae.cli.console import DEBUG, exit_status, leave, make_safe, warn_in_one_line
from tegotae.cli.kept_texts import HELP, is_help, kept
from tegotae.cli.program import Command, CommandGroup, overview

_LONGEST_WORD = 1000


def main(
    arguments: Sequence[str] | None = None,
    program: Command | CommandGroup = TEGOTAE,
    prog: str = "tegotae",
) -> int:
    """Run a command of a program; return the exit status (`exit_status`).

    Args:
        arguments: words after the program's name; by default those of the shell.
        program: the commands to choose from, or the only one.
        prog: the words that start the program.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    for switch, variable in (("--debug", DEBUG), ("--quiet", QUIET)):
        if switch in words:
            os.environ[variable] = "1"  # which worker processes inherit
            words = [word for word in words if word != switch]
    return exit_status(lambda: _run(words, program, prog))


def _run(words: list[str], program: Command | CommandGroup, prog: str) -> None:
    if words == ["--version"]:
        from tegotae import __version__

        print(f"tegotae {__version__}")
        return
    words, places = split_parts(words)
    if places:
        _check_environment()
        from tegotae.systems.registry import imported

        for place in places:
            imported(place)
    if program is TEGOTAE and not places and is_help(words):  # whose files `kept` knows
        command: Any = kept(words, lambda: parsed(words, program, prog))
    else:
        command = parsed(words, program, prog)
    if isinstance(command, str):
        print(command)
        return
    _check_environment()
    ready()
    if not gc.isenabled():
        gc.freeze()
        gc.enable()
    try:
        command.run()
    except SystemExit:  # no command of ours ends so: a part does, perhaps in a worker
        raise TegotaeError(
            "code of a part ended the command (SystemExit); a part returns, or raises an error"
        ) from None


def parsed(
    words: Sequence[str], entry: Command | CommandGroup = TEGOTAE, prog: str = "tegotae"
) -> Any:
    """Return the command that words make, with its options, or its help; it alone is imported.

    Args:
        words: such as `["figure", "surface", "--out", "surface.png"]`.
        entry: the commands to choose from, or the only one.
        prog: the words before.

    Raises:
        TegotaeError: for words that do not make a command; with the nearest one.

    Example:
        >>> parsed(["completion", "zsh"]).shell
        'zsh'
    """
    if max(map(len, words), default=0) > _LONGEST_WORD:
        raise TegotaeError(
            f"an argument has {max(map(len, words))} characters; it must have at most "
            f"{_LONGEST_WORD}"
        )
    if isinstance(entry, CommandGroup):
        if len(words) == 1 and words[0] in HELP:
            return overview(entry, prog)
        if words and (command_entry := entry.commands.get(words[0])):
            return parsed(words[1:], command_entry, f"{prog} {words[0]}")
        if words and words[0] and not words[0].startswith("-"):
            raise unknown(f"command of {prog}", words[0], entry.commands)
        problem = f"{prog} has no option {words[0]!r}" if words else "no command is given"
        listed = ", ".join(entry.commands)
        raise TegotaeError(f"{problem}; {prog} takes one of {listed}, or --help")
    command = entry.load()
    if inspect.isfunction(command):
        from tegotae.cli.functions import FunctionCall

        return FunctionCall.from_words(entry, words, prog)
    from tegotae.cli.records import parse

    return parse(command, words, prog, entry.examples)


def _check_environment() -> None:
    from tegotae._support.engines import check_environment

    check_environment()


def split_parts(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the words without --parts, and the files and modules after it.

    Example:
        >>> split_parts(["--parts", "a.py", "b.py", "train", "--parts", "c", "ART"])
        (['train', 'ART'], ['a.py', 'b.py', 'c'])
    """
    words_without_parts, places = [], []
    queue = [part for word in words for part in _after_parts(word)]
    while queue:
        word = queue.pop(0)
        if word != "--parts":
            words_without_parts.append(word)
            continue
        if not queue or queue[0].startswith("-"):
            raise TegotaeError("--parts names no file; write --parts FILE.py, or a module")
        places.append(queue.pop(0))
        while queue and queue[0].endswith(".py"):
            places.append(queue.pop(0))
    return words_without_parts, places


def _after_parts(word: str) -> list[str]:
    """Return the word, or --parts=FILE.py as two words."""
    option, equals, value = word.partition("=")
    return [option, value] if option == "--parts" and equals else [word]


def entry(program: Command | CommandGroup = TEGOTAE, prog: str = "tegotae") -> None:
    """Run a program as a command of the shell."""
    gc.disable()  # what is loaded stays: nothing of it is garbage
    open_streams()
    end_on_ctrl_c()
    keep_xla_programs()
    make_safe()
    warn_in_one_line()
    leave(main(program=program, prog=prog))
