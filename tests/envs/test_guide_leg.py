"""The walk from a model of one's own to its measures is short."""

from pages import DOCS
from readers import typed

LONGEST = 40
"""Lines of code and commands of a walk."""


def test_the_walk_from_a_model_to_its_measures_is_short():
    blocks = [
        text for language, text in typed(DOCS / "guides" / "your-leg.md") if language != "text"
    ]
    assert sum(len(text.splitlines()) for text in blocks) <= LONGEST
