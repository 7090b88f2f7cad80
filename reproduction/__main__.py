"""`python -m reproduction`: the whole study of the paper, and its report."""

from __future__ import annotations

from collections.abc import Mapping

from tegotae.cli import entry
from tegotae.cli.program import Command, CommandGroup

COMMANDS: Mapping[str, Command | CommandGroup] = {
    "run": Command(
        "reproduction.commands.study:StudyRun",
        "python -m reproduction run --dir study --scale smoke",
        "python -m reproduction run --dir study --scale quick --models 'ART*'",
    ),
    "status": Command(
        "reproduction.commands.study:StudyStatus",
        "python -m reproduction status --dir study",
        "python -m reproduction status --dir results/quick",
    ),
    "report": Command(
        "reproduction.commands.study:StudyReport",
        "python -m reproduction report --dir study",
        "python -m reproduction report --dir study --out report.html",
    ),
    "export": Command(
        "reproduction.commands.study:StudyExport",
        "python -m reproduction export --dir study --out runs.csv",
        "python -m reproduction export --dir study --out runs.parquet",
    ),
    "zoo": Command(
        "reproduction.commands.study:StudyZoo",
        "python -m reproduction zoo --dir study --name mine --out mine.npz",
        "python -m reproduction zoo --dir results/paper --name paper --out paper.npz",
    ),
    "claims": Command(
        "reproduction.commands.claims:StudyClaims",
        "python -m reproduction claims runs.csv",
        "python -m reproduction claims runs.csv --out claims --beside other-study.csv",
    ),
    "figures": Command(
        "reproduction.commands.study:StudyFigures",
        "python -m reproduction figures runs.csv --out figures",
        "python -m reproduction figures study --out figures",
    ),
    "learning": Command(
        "reproduction.commands.learning:StudyLearning",
        "python -m reproduction learning --dir results/learning --out docs/_static/learning",
        "python -m reproduction learning --dir study --out tables --name study",
    ),
    "primary": Command(
        "reproduction.commands.learning:StudyPrimary",
        "python -m reproduction primary tables/study.csv",
        "python -m reproduction primary study.csv calibrated.csv --out tables",
    ),
    "atlas": Command(
        "reproduction.commands.learning:StudyAtlas",
        "python -m reproduction atlas --dir results/paper --out docs/_static/atlas",
        "python -m reproduction atlas --dir study --out tables --models 'AR*'",
    ),
    "merge": Command(
        "reproduction.commands.study:StudyMerge",
        "python -m reproduction merge other-study --dir study",
        "python -m reproduction merge /mnt/cluster/study --dir study",
    ),
    "readings": CommandGroup(
        "Evaluate the claims under other choices of body, work, release and budget.",
        {
            "run": Command(
                "reproduction.commands.readings:MultiverseRun",
                "python -m reproduction readings run --dir readings --scale smoke",
                "python -m reproduction readings run --dir readings --readings 8",
            ),
            "status": Command(
                "reproduction.commands.readings:MultiverseStatus",
                "python -m reproduction readings status --dir readings",
                "python -m reproduction readings status --dir readings --readings 8",
            ),
            "export": Command(
                "reproduction.commands.readings:MultiverseExport",
                "python -m reproduction readings export --dir readings --out tables",
                "python -m reproduction readings export --dir readings --out t --readings 8",
            ),
            "figures": Command(
                "reproduction.commands.readings:MultiverseFigures",
                "python -m reproduction readings figures tables --out figures",
                "python -m reproduction readings figures readings --out figures --omega 8",
            ),
        },
    ),
    "gain-map": Command(
        "reproduction.commands.gain_map:GainMap",
        "python -m reproduction gain-map --resolution 40",
        "python -m reproduction gain-map --omega 3 9 --out gain.pdf",
    ),
    "optimum": Command(
        "reproduction.commands.optimum:Optimum",
        "python -m reproduction optimum",
        "python -m reproduction optimum --controller V-sector-w4 --omega 4",
    ),
    "optimum-table": Command(
        "reproduction.optimum.make:Make",
        "python -m reproduction optimum-table",
        "python -m reproduction optimum-table --starts 8",
    ),
    "optimum-proofs": Command(
        "reproduction.commands.optimum_proofs:CheckProofs",
        "python -m reproduction optimum-proofs",
        "python -m reproduction optimum-proofs --make",
    ),
}

SECTIONS: Mapping[str, tuple[str, ...]] = {
    "Run the study": ("run", "status", "merge"),
    "Report on it": (
        "report",
        "claims",
        "learning",
        "primary",
        "atlas",
        "figures",
        "export",
        "zoo",
    ),
    "Try other readings of the paper": ("readings",),
    "Know the limits of the body": ("gain-map", "optimum", "optimum-table", "optimum-proofs"),
}
"""The commands by what one wants to do, for the list of them."""

REPRODUCTION = CommandGroup(
    "Run the whole study of the paper, and report on it.", COMMANDS, SECTIONS
)
"""The program."""

PROG = "python -m reproduction"
"""The words that start it."""

if __name__ == "__main__":
    entry(REPRODUCTION, PROG)
