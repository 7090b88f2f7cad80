"""Pages that stand in `research` beside their scripts and tables, read as pages of these docs.

The page in `docs` is one line with a link to the page in `research`. Its address is that of the
docs; its links and pictures are relative to `research`.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

STUB = re.compile(r"The page is \[research/\S+\]\((\S+)\)\.\n")
"""Text of a page in `docs` that stands in `research`."""
_BEFORE = r"\]\(|\{(?:image|include|literalinclude)\} |^:file: |\{download\}`[^<`]*<"
LINK = re.compile(rf"({_BEFORE})([^>)\s#:]+)(?=[>)#\s])", re.MULTILINE)
"""A relative link of a page: the text before its path, and the path."""


def source_of(page: Path) -> Path:
    """Return the file with the text of a page of the docs."""
    stub = STUB.fullmatch(page.read_text(encoding="utf-8"))
    return (page.parent / stub[1]).resolve() if stub else page


def page_text(page: Path) -> str:
    """Return the text of a page of the docs, with links that are relative to it."""
    source = source_of(page)
    text = source.read_text(encoding="utf-8")
    if source == page:
        return text
    root = os.path.relpath(source.parent, page.parent)
    return LINK.sub(lambda link: link[1] + os.path.normpath(os.path.join(root, link[2])), text)
