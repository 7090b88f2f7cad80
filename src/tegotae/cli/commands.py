"""The commands of `tegotae`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from tegotae.cli.program import Command, CommandGroup

_QUESTIONS: Mapping[str, Mapping[str, list[str]]] = tomllib.loads(
    Path(__file__).with_name("commands.toml").read_text(encoding="utf-8")
)
"""By the module of its question each command, and what a user can type after its name."""

_GROUPS: Mapping[str, str] = {
    "wiring": "Put controllers on a leg of your own: a MuJoCo model, or any environment.",
    "figure": "Draw a figure that explains a controller, and write its numbers.",
    "gait": "Study the gaits of a body with several legs.",
    "export": "Export a controller to a robot.",
    "benchmark": "Score controllers of any kind on the same bodies.",
}
"""What the commands of two words are for, by the first."""


def _command(name: str, module: str, *examples: str) -> Command:
    """The command of a question, which is called alike: `figure_surface` for figure surface."""
    home = module if "." in module else f"tegotae.questions.{module}"
    place = f"{home}:{name.replace(' ', '_').replace('-', '_')}"
    return Command(place, *(f"tegotae {name} {words}".rstrip() for words in examples))


def _commands() -> dict[str, Command | CommandGroup]:
    made = {
        name: _command(name, module, *examples)
        for module, questions in _QUESTIONS.items()
        for name, examples in questions.items()
    }
    commands: dict[str, Command | CommandGroup] = {}
    for name in made:
        first, _, grouped = name.partition(" ")
        if grouped:
            inner = {n.partition(" ")[2]: made[n] for n in made if n.startswith(f"{first} ")}
            commands[first] = CommandGroup(_GROUPS[first], inner)
        else:
            commands[name] = made[name]
    commands["completion"] = Command(
        "tegotae.cli.completion:Completion",
        "tegotae completion bash > tegotae-completion.bash",
        "tegotae completion zsh > _tegotae",
    )
    return commands


COMMANDS: Mapping[str, Command | CommandGroup] = _commands()
SECTIONS: Mapping[str, tuple[str, ...]] = {
    "See a controller move": ("simulate", "models"),
    "Learn one": ("train", "wiring", "template", "identify"),
    "Measure and compare": ("evaluate", "compare", "measure", "generalise", "benchmark"),
    "Understand one": ("explain", "figure", "gait"),
    "Use one on a robot": ("export",),
    "Get help, cite": ("doctor", "completion", "cite"),
}
"""The commands by what one wants to do, for the list of them."""

TEGOTAE = CommandGroup(
    "Train, simulate and compare learned Tegotae feedback in central pattern generators.",
    COMMANDS,
    SECTIONS,
)
"""The program."""
