"""`python -m playground`."""

from tegotae.cli import entry
from tegotae.cli.program import Command

PLAYGROUND = Command(
    "playground.command:Playground",
    "python -m playground",
    "python -m playground V-sector-w4 V-reflex-w8 --out page.html",
)

if __name__ == "__main__":
    entry(PLAYGROUND, "python -m playground")
