"""Measure how much of a source tree speaks the field's language.

`python tests/helpers/words.py [TREE ...] [--list]` prints, for each tree, the share of docstrings
that open with a question word or a loose preposition, and the share of bound names that are a
pronoun, a participle or a particle; with `--list` also every place.
"""

import ast
import re
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from places import ROOT

OPENING = re.compile(
    r"(what|how|whether|which|where|when|why|who|whose|whatever|whoever|that|as|of|in|from|by|with"
    r"|at|on|there)\b",
    re.IGNORECASE,
)
"""Begins a docstring that names neither an action nor a thing."""
VAGUE = re.compile(
    r"_*(found|each|own|at|of|who|whom|what|how|which|why|given|asked|said|told|kept|known|one"
    r"|others?|more|rest|ways?|made|done|same|both|here|there|seen|whole|apart|alike|called|named"
    r"|picked|chosen|shown|written|wanted|left|lost|least|most|usual|used|about|before|after|then"
    r"|now|inner|outer|things?|something|nothing|anything|everything|another|such|these|those|this"
    r"|that|its?|them|they|him|her)_*"
)
"""Names that tell nothing of their value."""


class Words(NamedTuple):
    """Counts of a source tree, and the places of what is counted."""

    docstrings: int
    names: int
    questions: list[str]
    vague: list[str]

    @property
    def shares(self) -> tuple[float, float]:
        """Shares of docstrings that open with a question, and of vague names [%]."""
        return (
            100.0 * len(self.questions) / max(self.docstrings, 1),
            100.0 * len(self.vague) / max(self.names, 1),
        )


def measure(tree: Path) -> Words:
    """Measure the Python files of a folder."""
    texts: list[tuple[str, str]] = []
    names: list[tuple[str, str]] = []
    for file in sorted(tree.rglob("*.py")):
        parsed = ast.parse(file.read_text(encoding="utf-8"))
        place = file.relative_to(ROOT)
        texts += [(f"{place}:{line}", text) for line, text in _docstrings(parsed)]
        names += [(f"{place}:{line}", name) for line, name in _bound(parsed)]
    return Words(
        docstrings=len(texts),
        names=len(names),
        questions=[f"{place}: {text}" for place, text in texts if OPENING.match(text.strip())],
        vague=[f"{place}: {name}" for place, name in names if VAGUE.fullmatch(name)],
    )


def _docstrings(parsed: ast.Module) -> Iterator[tuple[int, str]]:
    """Docstrings of modules, classes and functions, and texts below fields and constants."""
    for node in ast.walk(parsed):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if text := ast.get_docstring(node):
            yield getattr(node, "lineno", 1), text
        for above, below in pairwise(node.body):
            match above, below:
                case (
                    ast.AnnAssign() | ast.Assign(),
                    ast.Expr(value=ast.Constant(value=str(text))),
                ) if isinstance(node, ast.Module | ast.ClassDef):
                    yield below.lineno, text


def _bound(parsed: ast.Module) -> Iterator[tuple[int, str]]:
    """Names of arguments, variables, functions, classes and import aliases."""
    for node in ast.walk(parsed):
        if isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.alias) and node.asname:
            yield node.lineno, node.asname


if __name__ == "__main__":
    for name in [word for word in sys.argv[1:] if word != "--list"] or ["src"]:
        words = measure(ROOT / name)
        questions, vague = words.shares
        print(
            f"{name}: questions {len(words.questions)} of {words.docstrings} docstrings, "
            f"{questions:.1f} %; vague {len(words.vague)} of {words.names} names, {vague:.1f} %"
        )
        if "--list" in sys.argv:
            print(*words.questions, *words.vague, sep="\n")
