"""`tegotae completion`: commands, options and trained controllers for the TAB key of a shell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import tyro

from tegotae.cli.asking import Question, options_by_subject
from tegotae.cli.commands import COMMANDS
from tegotae.cli.help_texts import SWITCHES
from tegotae.cli.parsing import flags_of
from tegotae.cli.program import Command, CommandGroup
from tegotae.systems.zoo import PREFIX, names

_BASH = """\
# Completion of tegotae. In bash: source this file, such as in ~/.bashrc.
_tegotae() {{
    local word path="" words=""
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        case "$path $word" in
{paths}
        esac
    done
    case "$path" in
{completions}
    esac
    local typed="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[*]:0:COMP_CWORD}}" zoo="{zoo}"
    # Bash splits words at colons, and completes what follows the last one.
    if [[ "$before" == *" zoo :" ]]; then
        COMPREPLY=($(compgen -W "$zoo" -- "$typed"))
        return
    elif [[ "$before" == *" zoo" && "$typed" == ":" ]]; then
        COMPREPLY=($(compgen -W "$zoo"))
        return
    elif [[ "$typed" == zoo:* ]]; then
        COMPREPLY=($(compgen -P zoo: -W "$zoo" -- "${{typed#zoo:}}"))
        return
    fi
    COMPREPLY=($(compgen -W "$words" -- "$typed"))
    if [[ "$path" && "$typed" && zoo: == "$typed"* ]]; then
        COMPREPLY+=(zoo:)
        compopt -o nospace 2> /dev/null
    fi
    if [[ "$path" && "$typed" != -* ]]; then
        local IFS=$'\\n' marks=$'["\\'\\\\\\\\]'  # a name with blanks is typed with these
        COMPREPLY+=($(compgen -f -- "${{typed//$marks/}}"))
    fi
}}
complete -o filenames -F _tegotae tegotae
"""

_ZSH = """\
# Completion of tegotae. In zsh: source this file, such as in ~/.zshrc.
autoload -U +X bashcompinit && bashcompinit
"""


@dataclass(frozen=True)
class Completion:
    """Print a script that completes commands, options and trained controllers with the TAB key."""

    shell: Annotated[Literal["bash", "zsh"], tyro.conf.Positional]
    """Shell of the script."""

    def run(self) -> None:
        """Print the script."""
        print((_ZSH if self.shell == "zsh" else "") + script(), end="")


def script() -> str:
    """The script for bash."""
    known = dict(completions(COMMANDS))
    known[""] += tuple(switch.split()[0] for switch in SWITCHES)
    paths = (f'            "{path}") path="{path}" ;;' for path in known if path)
    words = (f'        "{path}") words="{" ".join(each)}" ;;' for path, each in known.items())
    zoo = " ".join(name.removeprefix(PREFIX) for name in names())
    return _BASH.format(paths="\n".join(paths), completions="\n".join(words), zoo=zoo)


def completions(
    commands: Mapping[str, Command | CommandGroup], path: str = ""
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What may follow the words so far: ` figure` is followed by figures, a command by options.

    Args:
        commands: those that may come next.
        path: the words so far, each with a blank before it.
    """
    yield path, tuple(commands)
    for name, entry in commands.items():
        if isinstance(entry, CommandGroup):
            yield from completions(entry.commands, f"{path} {name}")
        else:
            yield f"{path} {name}", tuple(options(entry.load()))


def options(command: Any) -> Iterator[str]:
    """The options of a command, such as `--out`."""
    if isinstance(command, Question):
        known = (name for own in options_by_subject(command).values() for name in own)
        yield from dict.fromkeys(f"--{name.replace('_', '-')}" for name in known)
    else:
        yield from (flag for flag, *_ in flags_of(command) if flag.startswith("--"))
