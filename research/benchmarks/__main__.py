"""`python -m research.benchmarks`."""

from tegotae.cli import entry
from tegotae.cli.program import Command

BENCH = Command(
    "research.benchmarks.command:Bench",
    "python -m research.benchmarks --legs",
    "python -m research.benchmarks --lanes 256 --json",
)

if __name__ == "__main__":
    entry(BENCH, "python -m research.benchmarks")
