"""`python -m benchmarks`."""

from tegotae.cli import entry
from tegotae.cli.program import Command

BENCH = Command(
    "benchmarks.command:Bench",
    "python -m benchmarks --legs",
    "python -m benchmarks --lanes 256 --json",
)

if __name__ == "__main__":
    entry(BENCH, "python -m benchmarks")
