"""The commands of `tegotae`."""

from __future__ import annotations

from collections.abc import Mapping

from tegotae.cli.program import Command, CommandGroup

_QUESTIONS: Mapping[str, tuple[str, ...]] = {
    "models": ("listing", "'*@quadruped-c'", "'ART*' --zoo"),
    "train": (
        "training",
        "ART --seeds 4 --out runs/art",
        "AR@quadruped-c --generations 40",
    ),
    "wiring suggest": (
        "wiring",
        "my_leg.xml",
        "robot.xml --settings ground=true --out robot.toml",
    ),
    "wiring baseline": (
        "wiring",
        "my_leg.xml --wiring my_leg.toml",
        "leg --frequencies 8 10 12 --duration 6",
    ),
    "simulate": (
        "verbs",
        "V-sector-w4 --plot hop.png --animate hop.gif",
        "quadruped-c --out walk",
    ),
    "evaluate": ("verbs", "V-sector-w4", "runs/art --csv runs.csv"),
    "compare": ("verbs", "V-sector-w4 V-reflex-w4", "runs/art runs/ar --metric cot_inverse"),
    "explain": ("explaining", "V-sector-w4", "runs/art/ART-rF-tphif-w8-seed0.json --out page"),
    "measure": (
        "measuring",
        "walk.csv --rest-length 1 --omega 5 --plot walk.png",
        "walk.csv --preset paper --json",
    ),
    "figure surface": (
        "drawing",
        "V-sector-w4",
        "runs/art/ART-rF-tphif-w8-seed0.json --out surface.pdf",
    ),
    "figure portrait": ("drawing", "V-sector-w4", "V-reflex-w8 --heights 1.1 1.5 2"),
    "figure phase-locking": ("drawing", "--resolution 40", "paper-reflex --cut 3"),
    "figure phase-response": ("drawing", "V-sector-w4", "V-sector-w8 --push 0.01 -0.01"),
    "figure basin": ("drawing", "V-sector-w4", "quadruped-c --starts 64"),
    "figure poincare": ("drawing", "V-sector-w4", "V-reflex-w8 --turns 20"),
    "figure learning-curves": ("drawing", "runs/art", "runs/art runs/ar --out curves.pdf"),
    "gait sweep": (
        "gaits",
        "quadruped-c --levels 0.7 3.5",
        "bar-light --levels 2 6 --count 8 --out bar",
    ),
    "gait map": (
        "gaits",
        "bar-light --x inertia_ratio 0.4 1.6 --y omega 2 6",
        "quadruped-c --x com_x_m -0.3 0.3 --y omega 0.7 3.5",
    ),
    "gait front": ("gaits", "quadruped-c", 'hexapod --family vanilla "forced tripod"'),
    "gait stability": (
        "gaits",
        "bar-light --over inertia_ratio 0.4 1.6",
        "quadruped-c --over omega 0.7 3.5 --gaits trot",
    ),
    "gait lesion": ("gaits", "hexapod --lose LM RM", "quadruped-c --drop 0.05"),
    "generalise": ("generalising", "--list", "runs/art --conditions delay noise"),
    "export c": (
        "exporting",
        "V-sector-w4 --out robot",
        "runs/art/ART-rF-tphif-w8-seed0.json --out robot --tick 0.002",
    ),
    "export native": (
        "exporting",
        "V-sector-w4 --out leg.native",
        "quadruped-c --out walker.native",
    ),
    "export cost": ("exporting", "V-sector-w4 ART-rF-tphif-w8", "--json"),
    "doctor": ("about", "", "--json"),
    "cite": ("about", "", "--bibtex"),
}
"""Of each command the module of its question, and what a user can type after its name."""

_GROUPS: Mapping[str, str] = {
    "wiring": "Put controllers on a leg of your own: a MuJoCo model, or any environment.",
    "figure": "Draw a figure that explains a controller, and write its numbers.",
    "gait": "Study the gaits of a body with several legs.",
    "export": "Export a controller to a robot.",
}
"""What the commands of two words are for, by the first."""


def _command(name: str, module: str, *examples: str) -> Command:
    """The command of a question, which is called alike: `figure_surface` for figure surface."""
    place = f"tegotae.questions.{module}:{name.replace(' ', '_').replace('-', '_')}"
    return Command(place, *(f"tegotae {name} {words}".rstrip() for words in examples))


def _commands() -> dict[str, Command | CommandGroup]:
    made = {name: _command(name, *row) for name, row in _QUESTIONS.items()}
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
    "Learn one": ("train", "wiring"),
    "Measure and compare": ("evaluate", "compare", "measure", "generalise"),
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
