"""How options are made of the fields of a command."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import tyro

from tegotae.cli.commands import Command, CommandGroup, in_name_only
from tegotae.cli.help import ABOUT

_CONFIG = (
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
    tyro.conf.PositionalMetavarFromFieldName,
)


def parse(words: Sequence[str], commands: Mapping[str, Command | CommandGroup], prog: str) -> Any:
    """The command that words make, with its options; of all commands this one alone is imported.

    Args:
        words: the command's name and its options.
        commands: those to choose from.
        prog: the words before.

    Raises:
        SystemExit: of status 2 for words that do not make a command; of 0 after `--help`.
    """
    known: dict[str, Callable[..., object]] = {
        each: in_name_only(entry) for each, entry in commands.items()
    }
    if words and isinstance(chosen := commands.get(words[0]), Command):
        known[words[0]] = chosen.load()
    return tyro.extras.subcommand_cli_from_dict(
        known, prog=prog, description=ABOUT, args=list(words), config=_CONFIG
    )


def parser(command: type) -> Any:
    """The parser of a command's options, in the form of argparse."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return tyro.extras.get_parser(command, config=_CONFIG)
