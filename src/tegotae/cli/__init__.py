"""Train, simulate and compare learned Tegotae feedback in central pattern generators."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from tegotae._start import end_on_ctrl_c, open_streams, ready
from tegotae._support.errors import TegotaeError
from tegotae.cli.commands import COMMANDS, MOVED, Command, CommandGroup, in_name_only
from tegotae.cli.console import make_safe
from tegotae.cli.status import DEBUG, exit_status, leave, warn_in_one_line

_SWITCHES = (
    "With --parts FILE.py, or --parts MODULE, any command knows the parts that you wrote there, "
    "which files that name them need; several files may follow, or another --parts. "
    "--version says which version this is. With --debug, or "
    "TEGOTAE_DEBUG=1, an error shows where it arose."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; the exit status is 0, or another one (`exit_status`).

    Raises:
        SystemExit: of status 2 for arguments that do not make a command; of 0 after `--help`.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "--debug" in words:
        os.environ[DEBUG] = "1"  # which worker processes inherit
    words = [word for word in words if word != "--debug"]
    return exit_status(lambda: _run(words))


def _run(words: list[str]) -> None:
    if words == ["--version"]:
        from tegotae import __version__

        print(f"tegotae {__version__}")
        return
    words, places = split_parts(words)
    if places:
        _start_engine()
        from tegotae.systems.user_objects import imported

        for place in places:
            imported(place)
    command = parsed(words)
    _start_engine()
    ready()
    try:
        command.run()
    except SystemExit:  # no command of ours ends so: a part does, perhaps in a worker
        raise TegotaeError(
            "code of a part ended the command (SystemExit); a part returns, or raises an error"
        ) from None


def parsed(
    words: Sequence[str],
    commands: Mapping[str, Command | CommandGroup] = COMMANDS,
    prog: str = "tegotae",
    description: str = f"{__doc__} {_SWITCHES}",
) -> Any:
    """The command that words make, with its options; of all commands this one alone is imported.

    Args:
        words: such as `["figure", "surface", "--out", "surface.png"]`.
        commands: those to choose from.
        prog: the words before.
        description: what the help says above the list of commands.

    Raises:
        SystemExit: of status 2 for words that do not make a command; of 0 after `--help`.

    Example:
        >>> parsed(["models", "ART", "--json"]).json
        True
    """
    name = words[0] if words else ""
    before = f"{prog} {name}".removeprefix("tegotae ")
    if before in MOVED:
        raise TegotaeError(f"tegotae {before} is tegotae {MOVED[before]} now")
    chosen = commands.get(name)
    if isinstance(chosen, CommandGroup):
        return parsed(words[1:], chosen.commands, f"{prog} {name}", chosen.summary)
    import tyro

    known: dict[str, Any] = {each: in_name_only(entry) for each, entry in commands.items()}
    if chosen is not None:
        known[name] = chosen.load()
    return tyro.extras.subcommand_cli_from_dict(
        known,
        prog=prog,
        description=description,
        args=list(words),
        config=(
            tyro.conf.FlagCreatePairsOff,
            tyro.conf.DisallowNone,
            tyro.conf.PositionalMetavarFromFieldName,
        ),
    )


def _start_engine() -> None:
    from tegotae._support.devices import check_environment, set_up

    set_up()
    check_environment()


def split_parts(words: list[str]) -> tuple[list[str], list[str]]:
    """The words without --parts, and what it names: a file or module, more files behind it.

    Example:
        >>> split_parts(["--parts", "a.py", "b.py", "study", "--parts", "c", "run"])
        (['study', 'run'], ['a.py', 'b.py', 'c'])
    """
    kept, places = [], []
    rest = [each for word in words for each in _after_parts(word)]
    while rest:
        word = rest.pop(0)
        if word != "--parts":
            kept.append(word)
            continue
        if not rest or rest[0].startswith("-"):
            raise TegotaeError("--parts names no file; write --parts FILE.py, or a module")
        places.append(rest.pop(0))
        while rest and rest[0].endswith(".py"):
            places.append(rest.pop(0))
    return kept, places


def _after_parts(word: str) -> list[str]:
    """The word; what stands for two, such as --parts=FILE.py, as two."""
    option, equals, value = word.partition("=")
    return [option, value] if option == "--parts" and equals else [word]


def entry() -> None:
    """The console script."""
    open_streams()
    end_on_ctrl_c()
    make_safe()
    warn_in_one_line()
    leave(main())
