"""The commands of `tegotae`."""

from __future__ import annotations

from collections.abc import Mapping

from tegotae.cli.program import Command, CommandGroup, Program

COMMANDS: Mapping[str, Command | CommandGroup] = {
    "models": Command(
        "tegotae.cli.models",
        "Models",
        ("tegotae models '*@quadruped-c'", "tegotae models 'ART*' --zoo"),
    ),
    "train": Command(
        "tegotae.cli.train",
        "Train",
        (
            "tegotae train ART --seeds 4 --out runs/art",
            "tegotae train AR@quadruped-c --generations 40",
        ),
    ),
    "tune": Command(
        "tegotae.cli.tune",
        "Tune",
        (
            "tegotae tune ART --storage tuning.log --trials 20",
            "tegotae tune ART --storage tuning.log --confirm 8 --keep best.json",
        ),
    ),
    "wiring": CommandGroup(
        "Put controllers on a leg of your own: a MuJoCo model, or any environment.",
        {
            "suggest": Command(
                "tegotae.cli.wiring.suggest",
                "WiringSuggest",
                (
                    "tegotae wiring suggest my_leg.xml",
                    "tegotae wiring suggest robot.xml --settings ground=true --out robot.toml",
                ),
            ),
            "baseline": Command(
                "tegotae.cli.wiring.baseline",
                "WiringBaseline",
                (
                    "tegotae wiring baseline --env my_leg.xml --wiring my_leg.toml",
                    "tegotae wiring baseline --env leg --frequencies 8 10 12 --duration 6",
                ),
            ),
        },
    ),
    "simulate": Command(
        "tegotae.cli.simulate",
        "Simulate",
        (
            "tegotae simulate V-sector-w4 --plot hop.png --animate hop.gif",
            "tegotae simulate quadruped-c --out walk",
        ),
    ),
    "evaluate": Command(
        "tegotae.cli.evaluate",
        "Evaluate",
        ("tegotae evaluate V-sector-w4", "tegotae evaluate runs/art --csv runs.csv"),
    ),
    "compare": Command(
        "tegotae.cli.compare",
        "Compare",
        (
            "tegotae compare V-sector-w4 V-reflex-w4",
            "tegotae compare runs/art runs/ar --metric cot_inverse",
        ),
    ),
    "measure": Command(
        "tegotae.cli.measure",
        "Measure",
        (
            "tegotae measure walk.csv --rest-length 1 --omega 5 --plot walk.png",
            "tegotae measure walk.csv --preset paper --json",
        ),
    ),
    "figure": CommandGroup(
        "Draw a figure that explains a controller, and write its numbers.",
        {
            "gain-map": Command(
                "tegotae.cli.figure.gain_map",
                "GainMap",
                (
                    "tegotae figure gain-map --resolution 40",
                    "tegotae figure gain-map --omega 3 9 --out gain.pdf",
                ),
            ),
            "surface": Command(
                "tegotae.cli.figure.surface",
                "SurfaceFigure",
                (
                    "tegotae figure surface V-sector-w4",
                    "tegotae figure surface runs/art/ART-rF-tphif-w8-seed0.json --out surface.pdf",
                ),
            ),
            "portrait": Command(
                "tegotae.cli.figure.portrait",
                "Portrait",
                (
                    "tegotae figure portrait V-sector-w4",
                    "tegotae figure portrait V-reflex-w8 --heights 1.1 1.5 2",
                ),
            ),
            "phase-locking": Command(
                "tegotae.cli.figure.phase_locking",
                "PhaseLocking",
                (
                    "tegotae figure phase-locking --resolution 40",
                    "tegotae figure phase-locking --actuation reflex --cut 3",
                ),
            ),
            "phase-response": Command(
                "tegotae.cli.figure.phase_response",
                "PhaseResponseFigure",
                (
                    "tegotae figure phase-response V-sector-w4",
                    "tegotae figure phase-response V-sector-w8 --push 0.01 -0.01",
                ),
            ),
            "basin": Command(
                "tegotae.cli.figure.basin",
                "Basin",
                (
                    "tegotae figure basin V-sector-w4",
                    "tegotae figure basin quadruped-c --starts 64",
                ),
            ),
            "poincare": Command(
                "tegotae.cli.figure.poincare",
                "PoincareFigure",
                (
                    "tegotae figure poincare V-sector-w4",
                    "tegotae figure poincare V-reflex-w8 --turns 20",
                ),
            ),
            "learning-curves": Command(
                "tegotae.cli.figure.learning_curves",
                "LearningCurves",
                (
                    "tegotae figure learning-curves runs/art",
                    "tegotae figure learning-curves runs/art runs/ar --out curves.pdf",
                ),
            ),
            "optimum": Command(
                "tegotae.cli.figure.optimum",
                "Optimum",
                (
                    "tegotae figure optimum",
                    "tegotae figure optimum --controller V-sector-w4 --omega 4",
                ),
            ),
        },
    ),
    "gait": CommandGroup(
        "Study the gaits of a body with several legs.",
        {
            "sweep": Command(
                "tegotae.cli.gait.sweep",
                "Sweep",
                (
                    "tegotae gait sweep quadruped-c --levels 0.7 3.5",
                    "tegotae gait sweep bar-light --levels 2 6 --count 8 --out bar",
                ),
            ),
            "map": Command(
                "tegotae.cli.gait.map",
                "Map",
                (
                    "tegotae gait map bar-light --x inertia_ratio 0.4 1.6 --y omega 2 6",
                    "tegotae gait map quadruped-c --x com_x_m -0.3 0.3 --y omega 0.7 3.5",
                ),
            ),
            "front": Command(
                "tegotae.cli.gait.front",
                "Front",
                (
                    "tegotae gait front quadruped-c",
                    'tegotae gait front hexapod --family vanilla "forced tripod"',
                ),
            ),
            "stability": Command(
                "tegotae.cli.gait.stability",
                "Stability",
                (
                    "tegotae gait stability bar-light --over inertia_ratio 0.4 1.6",
                    "tegotae gait stability quadruped-c --over omega 0.7 3.5 --gaits trot walk",
                ),
            ),
            "lesion": Command(
                "tegotae.cli.gait.lesion",
                "Lesion",
                (
                    "tegotae gait lesion hexapod --lose L2 R2",
                    "tegotae gait lesion quadruped-c --drop 0.05",
                ),
            ),
        },
    ),
    "generalise": Command(
        "tegotae.cli.generalise",
        "Generalise",
        ("tegotae generalise --list", "tegotae generalise runs/art --conditions delay noise"),
    ),
    "study": CommandGroup(
        "Run the whole study of the paper, and report on it.",
        {
            "run": Command(
                "tegotae.cli.study",
                "StudyRun",
                (
                    "tegotae study run --dir study --scale smoke",
                    "tegotae study run --dir study --scale quick --models 'ART*'",
                ),
            ),
            "status": Command(
                "tegotae.cli.study",
                "StudyStatus",
                ("tegotae study status --dir study", "tegotae study status --dir results/quick"),
            ),
            "report": Command(
                "tegotae.cli.study",
                "StudyReport",
                (
                    "tegotae study report --dir study",
                    "tegotae study report --dir study --out report.html",
                ),
            ),
            "export": Command(
                "tegotae.cli.study",
                "StudyExport",
                (
                    "tegotae study export --dir study --out runs.csv",
                    "tegotae study export --dir study --out runs.parquet",
                ),
            ),
            "zoo": Command(
                "tegotae.cli.study",
                "StudyZoo",
                (
                    "tegotae study zoo --dir study --name mine --out mine.npz",
                    "tegotae study zoo --dir results/paper --name paper --out paper.npz",
                ),
            ),
            "claims": Command(
                "tegotae.cli.claims",
                "StudyClaims",
                (
                    "tegotae study claims runs.csv",
                    "tegotae study claims runs.csv --out claims --beside other-study.csv",
                ),
            ),
            "figures": Command(
                "tegotae.cli.study",
                "StudyFigures",
                (
                    "tegotae study figures runs.csv --out figures",
                    "tegotae study figures study --out figures",
                ),
            ),
            "merge": Command(
                "tegotae.cli.study",
                "StudyMerge",
                (
                    "tegotae study merge other-study --dir study",
                    "tegotae study merge /mnt/cluster/study --dir study",
                ),
            ),
            "multiverse": CommandGroup(
                "Evaluate the claims under other choices of body, work, release and budget.",
                {
                    "run": Command(
                        "tegotae.cli.multiverse",
                        "MultiverseRun",
                        (
                            "tegotae study multiverse run --dir readings --scale smoke",
                            "tegotae study multiverse run --dir readings --readings 8",
                        ),
                    ),
                    "status": Command(
                        "tegotae.cli.multiverse",
                        "MultiverseStatus",
                        (
                            "tegotae study multiverse status --dir readings",
                            "tegotae study multiverse status --dir readings --readings 8",
                        ),
                    ),
                    "export": Command(
                        "tegotae.cli.multiverse",
                        "MultiverseExport",
                        (
                            "tegotae study multiverse export --dir readings --out tables",
                            "tegotae study multiverse export --dir readings --out t --readings 8",
                        ),
                    ),
                    "figures": Command(
                        "tegotae.cli.multiverse",
                        "MultiverseFigures",
                        (
                            "tegotae study multiverse figures tables --out figures",
                            "tegotae study multiverse figures readings --out figures --omega 8",
                        ),
                    ),
                },
            ),
        },
    ),
    "export": CommandGroup(
        "Export a controller to a robot.",
        {
            "c": Command(
                "tegotae.cli.export.c",
                "ExportC",
                (
                    "tegotae export c V-sector-w4 --out robot",
                    "tegotae export c runs/art/ART-rF-tphif-w8-seed0.json --out robot --tick 0.002",
                ),
            ),
            "native": Command(
                "tegotae.cli.export.native",
                "ExportNative",
                (
                    "tegotae export native V-sector-w4 --out leg.native",
                    "tegotae export native quadruped-c --out walker.native",
                ),
            ),
            "cost": Command(
                "tegotae.cli.export.cost",
                "ExportCost",
                (
                    "tegotae export cost --model V-sector-w4 ART-rF-tphif-w8",
                    "tegotae export cost --json",
                ),
            ),
        },
    ),
    "playground": Command(
        "tegotae.cli.playground",
        "Playground",
        ("tegotae playground", "tegotae playground V-sector-w4 V-reflex-w8 --out page.html"),
    ),
    "bench": Command(
        "tegotae.cli.bench", "Bench", ("tegotae bench --legs", "tegotae bench --lanes 256 --json")
    ),
    "doctor": Command("tegotae.cli.doctor", "Doctor", ("tegotae doctor", "tegotae doctor --json")),
    "completion": Command(
        "tegotae.cli.completion",
        "Completion",
        ("tegotae completion bash > tegotae-completion.bash", "tegotae completion zsh > _tegotae"),
    ),
    "cite": Command("tegotae.cli.cite", "Cite", ("tegotae cite", "tegotae cite --bibtex")),
}

SECTIONS: Mapping[str, tuple[str, ...]] = {
    "See a controller move": ("simulate", "playground", "models"),
    "Learn one": ("train", "tune", "wiring"),
    "Measure and compare": ("evaluate", "compare", "measure", "generalise"),
    "Understand one": ("figure", "gait"),
    "Repeat the study of the paper": ("study",),
    "Use one on a robot": ("export",),
    "Get help, cite": ("doctor", "bench", "completion", "cite"),
}
"""The commands by what one wants to do, for the list of them."""

TEGOTAE = Program(
    summary="Train, simulate and compare learned Tegotae feedback in central pattern generators.",
    commands=COMMANDS,
    name="tegotae",
    sections=SECTIONS,
)
"""The program of this package."""
