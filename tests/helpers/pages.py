"""The pages of the documentation, and their fenced blocks."""

from __future__ import annotations

import re
from pathlib import Path

from places import ROOT

DOCS = ROOT / "docs"


def blocks(page: Path, language: str) -> list[tuple[int, str]]:
    """Fenced blocks of a page: the line on which each begins, and its text."""
    text = page.read_text(encoding="utf-8")
    fence = re.compile(rf"^```{language}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [(text[: m.start(1)].count("\n"), m.group(1)) for m in fence.finditer(text)]
