"""Hashes of the paper's runs of words, by which the tests see that quotations stand in it.

    python -m research.experiments.paper_words PAPER.txt --out tests/kept/paper-words.txt

PAPER.txt is the paper as text. It is not part of the project, and the hashes do not restore it.
"""

from __future__ import annotations

from pathlib import Path

from research.frame import Place, main, write_text
from research.reproduction.claims.quotations import hashes_of


def run(paper: Place, out: Path) -> None:
    """Read the paper, and write the hashes."""
    hashes = sorted(hashes_of(paper.read_text(encoding="utf-8")))
    write_text(out, "\n".join(hashes) + "\n")
    print(f"wrote {len(hashes)} hashes to {out}")


if __name__ == "__main__":
    main(run)
