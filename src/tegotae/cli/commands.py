"""The commands of `tegotae`."""

from __future__ import annotations

from collections.abc import Mapping

from tegotae.cli.program import Command, CommandGroup

COMMANDS: Mapping[str, Command | CommandGroup] = {
    "models": Command(
        "tegotae.questions.listing:models",
        "tegotae models '*@quadruped-c'",
        "tegotae models 'ART*' --zoo",
    ),
    "train": Command(
        "tegotae.questions.training:train",
        "tegotae train ART --seeds 4 --out runs/art",
        "tegotae train AR@quadruped-c --generations 40",
    ),
    "wiring": CommandGroup(
        "Put controllers on a leg of your own: a MuJoCo model, or any environment.",
        {
            "suggest": Command(
                "tegotae.questions.wiring:wiring_suggest",
                "tegotae wiring suggest my_leg.xml",
                "tegotae wiring suggest robot.xml --settings ground=true --out robot.toml",
            ),
            "baseline": Command(
                "tegotae.questions.wiring:wiring_baseline",
                "tegotae wiring baseline my_leg.xml --wiring my_leg.toml",
                "tegotae wiring baseline leg --frequencies 8 10 12 --duration 6",
            ),
        },
    ),
    "simulate": Command(
        "tegotae.questions.verbs:simulate",
        "tegotae simulate V-sector-w4 --plot hop.png --animate hop.gif",
        "tegotae simulate quadruped-c --out walk",
    ),
    "evaluate": Command(
        "tegotae.questions.verbs:evaluate",
        "tegotae evaluate V-sector-w4",
        "tegotae evaluate runs/art --csv runs.csv",
    ),
    "compare": Command(
        "tegotae.questions.verbs:compare",
        "tegotae compare V-sector-w4 V-reflex-w4",
        "tegotae compare runs/art runs/ar --metric cot_inverse",
    ),
    "measure": Command(
        "tegotae.questions.verbs:measure",
        "tegotae measure walk.csv --rest-length 1 --omega 5 --plot walk.png",
        "tegotae measure walk.csv --preset paper --json",
    ),
    "figure": CommandGroup(
        "Draw a figure that explains a controller, and write its numbers.",
        {
            "surface": Command(
                "tegotae.questions.drawing:figure_surface",
                "tegotae figure surface V-sector-w4",
                "tegotae figure surface runs/art/ART-rF-tphif-w8-seed0.json --out surface.pdf",
            ),
            "portrait": Command(
                "tegotae.questions.drawing:figure_portrait",
                "tegotae figure portrait V-sector-w4",
                "tegotae figure portrait V-reflex-w8 --heights 1.1 1.5 2",
            ),
            "phase-locking": Command(
                "tegotae.questions.drawing:figure_phase_locking",
                "tegotae figure phase-locking --resolution 40",
                "tegotae figure phase-locking paper-reflex --cut 3",
            ),
            "phase-response": Command(
                "tegotae.questions.drawing:figure_phase_response",
                "tegotae figure phase-response V-sector-w4",
                "tegotae figure phase-response V-sector-w8 --push 0.01 -0.01",
            ),
            "basin": Command(
                "tegotae.questions.drawing:figure_basin",
                "tegotae figure basin V-sector-w4",
                "tegotae figure basin quadruped-c --starts 64",
            ),
            "poincare": Command(
                "tegotae.questions.drawing:figure_poincare",
                "tegotae figure poincare V-sector-w4",
                "tegotae figure poincare V-reflex-w8 --turns 20",
            ),
            "learning-curves": Command(
                "tegotae.questions.drawing:figure_learning_curves",
                "tegotae figure learning-curves runs/art",
                "tegotae figure learning-curves runs/art runs/ar --out curves.pdf",
            ),
        },
    ),
    "gait": CommandGroup(
        "Study the gaits of a body with several legs.",
        {
            "sweep": Command(
                "tegotae.questions.gaits:gait_sweep",
                "tegotae gait sweep quadruped-c --levels 0.7 3.5",
                "tegotae gait sweep bar-light --levels 2 6 --count 8 --out bar",
            ),
            "map": Command(
                "tegotae.questions.gaits:gait_map",
                "tegotae gait map bar-light --x inertia_ratio 0.4 1.6 --y omega 2 6",
                "tegotae gait map quadruped-c --x com_x_m -0.3 0.3 --y omega 0.7 3.5",
            ),
            "front": Command(
                "tegotae.questions.gaits:gait_front",
                "tegotae gait front quadruped-c",
                'tegotae gait front hexapod --family vanilla "forced tripod"',
            ),
            "stability": Command(
                "tegotae.questions.gaits:gait_stability",
                "tegotae gait stability bar-light --over inertia_ratio 0.4 1.6",
                "tegotae gait stability quadruped-c --over omega 0.7 3.5 --gaits trot",
            ),
            "lesion": Command(
                "tegotae.questions.gaits:gait_lesion",
                "tegotae gait lesion hexapod --lose LM RM",
                "tegotae gait lesion quadruped-c --drop 0.05",
            ),
        },
    ),
    "generalise": Command(
        "tegotae.questions.verbs:generalise",
        "tegotae generalise --list",
        "tegotae generalise runs/art --conditions delay noise",
    ),
    "export": CommandGroup(
        "Export a controller to a robot.",
        {
            "c": Command(
                "tegotae.questions.exporting:export_c",
                "tegotae export c V-sector-w4 --out robot",
                "tegotae export c runs/art/ART-rF-tphif-w8-seed0.json --out robot --tick 0.002",
            ),
            "native": Command(
                "tegotae.questions.exporting:export_native",
                "tegotae export native V-sector-w4 --out leg.native",
                "tegotae export native quadruped-c --out walker.native",
            ),
            "cost": Command(
                "tegotae.questions.exporting:export_cost",
                "tegotae export cost V-sector-w4 ART-rF-tphif-w8",
                "tegotae export cost --json",
            ),
        },
    ),
    "doctor": Command("tegotae.questions.about:doctor", "tegotae doctor", "tegotae doctor --json"),
    "completion": Command(
        "tegotae.cli.completion:Completion",
        "tegotae completion bash > tegotae-completion.bash",
        "tegotae completion zsh > _tegotae",
    ),
    "cite": Command("tegotae.questions.about:cite", "tegotae cite", "tegotae cite --bibtex"),
}

SECTIONS: Mapping[str, tuple[str, ...]] = {
    "See a controller move": ("simulate", "models"),
    "Learn one": ("train", "wiring"),
    "Measure and compare": ("evaluate", "compare", "measure", "generalise"),
    "Understand one": ("figure", "gait"),
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
