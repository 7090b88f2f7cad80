"""`python -m research.tuning`."""

from tegotae.cli import entry
from tegotae.cli.program import Command

TUNE = Command(
    "research.tuning.command:search",
    "python -m research.tuning ART --storage tuning.log --trials 20",
    "python -m research.tuning ART --storage tuning.log --confirm 8 --keep best.json",
    subjects={"One leg": "ART", "Several legs": "AR@quadruped-c"},
)

if __name__ == "__main__":
    entry(TUNE, "python -m research.tuning")
