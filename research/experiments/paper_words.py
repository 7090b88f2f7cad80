"""Hashes of the paper's runs of words, by which the tests see that quotations stand in it.

    python -m research.experiments.paper_words PAPER.txt --out tests/kept/paper-words.txt

PAPER.txt is the paper as text. It is not part of the project, and the hashes do not restore it.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from research.reproduction.claims.quotations import hashes_of
from tegotae._support.files import write_atomically


def main(words: Sequence[str] | None = None) -> None:
    """Read the paper, write the hashes."""
    parser = argparse.ArgumentParser(description="Hash the paper's runs of words.")
    parser.add_argument("paper", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args(words)
    hashes = sorted(hashes_of(arguments.paper.read_text(encoding="utf-8")))
    write_atomically(arguments.out, "\n".join(hashes) + "\n")
    print(f"wrote {len(hashes)} hashes to {arguments.out}")


if __name__ == "__main__":
    main()
