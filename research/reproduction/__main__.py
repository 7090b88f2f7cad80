"""`python -m research.reproduction`: the whole study of the paper, and its report."""

from __future__ import annotations

from collections.abc import Mapping

from tegotae.cli import entry
from tegotae.cli.program import Command, CommandGroup

COMMANDS: Mapping[str, Command | CommandGroup] = {
    "run": Command(
        "research.reproduction.commands.study:StudyRun",
        "python -m research.reproduction run --dir study --scale smoke",
        "python -m research.reproduction run --dir study --scale quick --models 'ART*'",
    ),
    "status": Command(
        "research.reproduction.commands.study:StudyStatus",
        "python -m research.reproduction status --dir study",
        "python -m research.reproduction status --dir results/quick",
    ),
    "report": Command(
        "research.reproduction.commands.study:StudyReport",
        "python -m research.reproduction report --dir study",
        "python -m research.reproduction report --dir study --out report.html",
    ),
    "export": Command(
        "research.reproduction.commands.study:StudyExport",
        "python -m research.reproduction export --dir study --out runs.csv",
        "python -m research.reproduction export --dir study --out runs.parquet",
    ),
    "zoo": Command(
        "research.reproduction.commands.study:StudyZoo",
        "python -m research.reproduction zoo --dir study --name mine --out mine.npz",
        "python -m research.reproduction zoo --dir results/paper --name paper --out paper.npz",
    ),
    "claims": Command(
        "research.reproduction.commands.claims:StudyClaims",
        "python -m research.reproduction claims runs.csv",
        "python -m research.reproduction claims runs.csv --out claims --beside other-study.csv",
    ),
    "figures": Command(
        "research.reproduction.commands.study:StudyFigures",
        "python -m research.reproduction figures runs.csv --out figures",
        "python -m research.reproduction figures study --out figures",
    ),
    "learning": Command(
        "research.reproduction.commands.learning:StudyLearning",
        "python -m research.reproduction learning --dir results/learning --out tables/learning",
        "python -m research.reproduction learning --dir study --out tables --name study",
    ),
    "primary": Command(
        "research.reproduction.commands.learning:StudyPrimary",
        "python -m research.reproduction primary tables/study.csv",
        "python -m research.reproduction primary study.csv calibrated.csv --out tables",
    ),
    "contrasts": Command(
        "research.reproduction.commands.learning:StudyContrasts",
        "python -m research.reproduction contrasts tables/study.csv",
        "python -m research.reproduction contrasts study.csv calibrated.csv --out tables",
    ),
    "atlas": Command(
        "research.reproduction.commands.learning:StudyAtlas",
        "python -m research.reproduction atlas --dir results/paper --out tables/atlas",
        "python -m research.reproduction atlas --dir study --out tables --models 'AR*'",
    ),
    "merge": Command(
        "research.reproduction.commands.study:StudyMerge",
        "python -m research.reproduction merge other-study --dir study",
        "python -m research.reproduction merge /mnt/cluster/study --dir study",
    ),
    "readings": CommandGroup(
        "Evaluate the claims under other choices of body, work, release and budget.",
        {
            "run": Command(
                "research.reproduction.commands.readings:MultiverseRun",
                "python -m research.reproduction readings run --dir readings --scale smoke",
                "python -m research.reproduction readings run --dir readings --readings 8",
            ),
            "status": Command(
                "research.reproduction.commands.readings:MultiverseStatus",
                "python -m research.reproduction readings status --dir readings",
                "python -m research.reproduction readings status --dir readings --readings 8",
            ),
            "export": Command(
                "research.reproduction.commands.readings:MultiverseExport",
                "python -m research.reproduction readings export --dir readings --out tables",
                "python -m research.reproduction readings export --dir study --out t --readings 8",
            ),
            "figures": Command(
                "research.reproduction.commands.readings:MultiverseFigures",
                "python -m research.reproduction readings figures tables --out figures",
                "python -m research.reproduction readings figures readings --out figures --omega 8",
            ),
        },
    ),
    "gain-map": Command(
        "research.reproduction.commands.gain_map:GainMap",
        "python -m research.reproduction gain-map --resolution 40",
        "python -m research.reproduction gain-map --omega 3 9 --out gain.pdf",
    ),
    "optimum": Command(
        "research.reproduction.commands.optimum:Optimum",
        "python -m research.reproduction optimum",
        "python -m research.reproduction optimum --controller V-sector-w4 --omega 4",
    ),
    "optimum-table": Command(
        "research.reproduction.optimum.make:Make",
        "python -m research.reproduction optimum-table",
        "python -m research.reproduction optimum-table --starts 8",
    ),
    "optimum-proofs": Command(
        "research.reproduction.commands.optimum_proofs:CheckProofs",
        "python -m research.reproduction optimum-proofs",
        "python -m research.reproduction optimum-proofs --make",
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

PROG = "python -m research.reproduction"
"""The words that start it."""

if __name__ == "__main__":
    entry(REPRODUCTION, PROG)
