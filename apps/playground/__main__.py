"""`python -m apps.playground`."""

from tegotae.cli import entry
from tegotae.cli.program import Command

PLAYGROUND = Command(
    "apps.playground.command:Playground",
    "python -m apps.playground",
    "python -m apps.playground V-sector-w4 V-reflex-w8 --out page.html",
)

if __name__ == "__main__":
    entry(PLAYGROUND, "python -m apps.playground")
