"""The pages of the documentation, and their fenced blocks."""

import re
from pathlib import Path

from places import ROOT
from prose_numbers import MARK
from research_pages import source_of

DOCS = ROOT / "docs"


def blocks(page: Path, language: str) -> list[tuple[int, str]]:
    """Fenced blocks of a page: the line on which each begins, and its text."""
    text = page.read_text(encoding="utf-8")
    fence = re.compile(rf"^```{language}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [(text[: m.start(1)].count("\n"), m.group(1)) for m in fence.finditer(text)]


def prose(name: str) -> str:
    """The text of a page of docs without its marks, each line break and indent one space."""
    text = MARK.sub("", source_of(DOCS / name).read_text(encoding="utf-8"))
    return re.sub(r"\s+", " ", text)
