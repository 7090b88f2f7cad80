"""Output that every console takes: plain spellings of what its encoding lacks."""

from __future__ import annotations

import codecs
import io
import sys

from tegotae._support.errors import shortened

PLAIN = "tegotae.plain"
"""Name of the error handler (`codecs.register_error`) that spells plainly."""

_SPELLINGS = {
    "⁻": "^-",
    "¹": "1",
    "²": "^2",
    "·": "*",
    "×": "x",
    "≥": ">=",
    "≤": "<=",
    "±": "+-",
    "√": "sqrt ",
    "∞": "inf",
    "–": "-",
    "—": "-",
    "−": "-",
    "…": "...",
    "•": "*",
    "→": "->",
    "′": "'",
    "°": " deg",
    "α": "alpha",
    "Δ": "Delta",
    "λ": "lambda",
    "π": "pi",
    "σ": "sigma",
    "φ": "phi",
    "Ω": "Omega",
    "ω": "omega",
    "ẏ": "y'",
    "\u0307": "'",
    **dict.fromkeys("─━╌╴╶╸╺", "-"),
    **dict.fromkeys("│┃╎", "|"),
    **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼╞╡╪", "+"),
}


def make_safe() -> None:
    """Have standard output and error spell plainly what they cannot show, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=PLAIN)


def one_line(text: str) -> str:
    r"""The same in one line, with control characters (such as a terminal's commands) made visible.

    Example:
        >>> print(one_line("no file\ncalled \x1b[31mred"))
        no file called \x1b[31mred
    """
    joined = " ".join(shortened(text).split())
    return "".join(c if c.isprintable() or c == " " else _escaped(c) for c in joined)


def shown(text: str, encoding: str) -> str:
    """A text as a console of this encoding will have it, so that its width is known.

    Example:
        >>> shown("CoT⁻¹ [m/J]", "ascii")
        'CoT^-1 [m/J]'
    """
    text = "".join(c if c.isprintable() else _escaped(c) for c in text)
    return text.encode(encoding, PLAIN).decode(encoding)


def _escaped(character: str) -> str:
    return (
        character.encode("ascii", "backslashreplace").decode()
        if ord(character) > 126
        else (f"\\x{ord(character):02x}")
    )


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_SPELLINGS.get(c, _escaped(c)) for c in lacking), error.end


codecs.register_error(PLAIN, _plainly)
