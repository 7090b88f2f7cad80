"""`tegotae completion`: commands, options and trained controllers for the TAB key of a shell."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Annotated, Literal

from tegotae.api.parameters import POSITIONAL
from tegotae.cli.commands import COMMANDS
from tegotae.cli.functions import options_by_subject
from tegotae.cli.kept_texts import kept
from tegotae.cli.program import SWITCHES, Command, CommandGroup
from tegotae.cli.records import fields_of
from tegotae.cli.words import flag_of
from tegotae.systems.zoo import PREFIX, zoo_names

_ZSH = """\
# Completion of tegotae. In zsh: source this file, such as in ~/.zshrc.
autoload -U +X bashcompinit && bashcompinit
"""


@dataclass(frozen=True)
class Completion:
    """Print a script that completes commands, options and trained controllers with the TAB key."""

    shell: Annotated[Literal["bash", "zsh"], POSITIONAL]
    """Shell of the script."""

    def run(self) -> None:
        """Print the script."""
        print((_ZSH if self.shell == "zsh" else "") + kept(["completion"], script), end="")


def script() -> str:
    """Return the script for bash."""
    candidates = dict(completions(COMMANDS))
    candidates[""] += tuple(switch.split()[0] for switch in SWITCHES)
    pieces = {
        "# PATHS": (f'            "{path}") path="{path}" ;;' for path in candidates if path),
        "# COMPLETIONS": (
            f'        "{path}") words="{" ".join(x)}" ;;' for path, x in candidates.items()
        ),
        "@ZOO@": [" ".join(name.removeprefix(PREFIX) for name in zoo_names())],
    }
    text = resources.files("tegotae.cli").joinpath("completion.bash").read_text(encoding="utf-8")
    for place, lines in pieces.items():
        text = text.replace(place, "\n".join(lines))
    return text


def completions(
    commands: Mapping[str, Command | CommandGroup], path: str = ""
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the words that may follow others: figures after ` figure`, options after a command.

    Args:
        commands: those that may come next.
        path: the words so far, each with a blank before it.
    """
    yield path, tuple(commands)
    for name, entry in commands.items():
        if isinstance(entry, CommandGroup):
            yield from completions(entry.commands, f"{path} {name}")
        else:
            yield f"{path} {name}", tuple(options(entry))


def options(command: Command) -> Iterator[str]:
    """Yield the options of a command, such as `--out`."""
    function = command.load()
    if inspect.isfunction(function):
        kinds = options_by_subject(command).values()
        yield from dict.fromkeys(flag_of(x) for options in kinds for x in options.values())
    else:
        yield from (flag_of(x) for x in fields_of(function) if x.mark != POSITIONAL)
