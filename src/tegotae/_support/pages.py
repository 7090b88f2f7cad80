"""Pages of HTML: templates that are filled, and data that no page mistakes for markup."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping


def filled_page(template: str, pieces: Mapping[str, str]) -> str:
    """Return a template with each comment `<!--NAME-->` replaced by the piece of that name.

    The template is read once, so that a placeholder's name in a piece, such as that of a user's
    file, is left as it is.

    Args:
        template: the text, in which no other comments may be.
        pieces: texts by name.

    Raises:
        KeyError: for a placeholder without a piece.

    Example:
        >>> filled_page("<!--A--> <!--B-->", {"A": "<!--B-->", "B": "b"})
        '<!--B--> b'
    """
    return re.sub("<!--([A-Z]+)-->", lambda match: pieces[match[1]], template)


def as_script(data: object) -> str:
    """Return JSON for a script element of HTML, which no text in it can end or hide.

    Example:
        >>> as_script(["</script>"])
        '["\\\\u003c/script\\\\u003e"]'
    """
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text
