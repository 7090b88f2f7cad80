"""Test that a quotation is the paper's, without the paper.

Kept is a hash of every run of `RUN` words of its text, in no order: enough to see that a quotation
is verbatim, and nothing that could be read.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection

from research.reproduction.claims.atomic import OMISSION

RUN = 5
"""Words in a row that are hashed together; no part of a quotation may be shorter."""

_MATHS = str.maketrans({"$": "", "{": "", "}": "", "*": "", "^": " "})
_DIGITS = 8


def words_of(text: str) -> list[str]:
    """Return the words of a text in small letters, without its marks of mathematics and
    punctuation.

    Example:
        >>> words_of("the CoT^{-1} of $s = [F_k]$")
        ['the', 'cot', '1', 'of', 's', 'f_k']
    """
    plain = text.replace("\\dot", " dot ").replace("\\", " ").translate(_MATHS)
    return re.findall(r"\w+", plain.lower())


def hashes_of(text: str) -> set[str]:
    """Return the hash of every run of words of a text, or none for a text shorter than one run."""
    words = words_of(text)
    runs = (" ".join(words[i : i + RUN]) for i in range(len(words) - RUN + 1))
    return {hashlib.sha256(run.encode()).hexdigest()[:_DIGITS] for run in runs}


def stands_in(quotation: str, hashes: Collection[str]) -> bool:
    """Return whether every run of words of a quotation occurs in a text.

    Args:
        quotation: with `OMISSION` where words are left out.
        hashes: `hashes_of` the text.

    Example:
        >>> text = hashes_of("It is visible how the oscillator is slowed down.")
        >>> stands_in("the oscillator is slowed down", text), stands_in("it is sped up", text)
        (True, False)
    """
    parts = [hashes_of(part) for part in quotation.split(OMISSION)]
    return all(part and part <= set(hashes) for part in parts)
