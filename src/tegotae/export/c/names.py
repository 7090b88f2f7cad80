"""Names in C, and the functions that generated code calls."""

from __future__ import annotations

import ast
import keyword
import re
import unicodedata
from dataclasses import dataclass
from pathlib import Path

from tegotae.lowering.nodes import Node, Place


@dataclass(eq=False)
class Procedure:
    """A function that the traced one calls by name: scalars in, scalars out."""

    name: str
    parameters: tuple[str, ...]
    inputs: tuple[Node, ...]
    results: tuple[Node, ...]
    about: str = ""
    """What its docstring says it does."""


@dataclass(eq=False)
class LoopProcedure(Procedure):
    """A procedure that goes round: while a condition holds, new values for some parameters."""

    carried: int = 0
    """How many of its parameters, the last ones, get new values; its results are their last."""
    goes_on: Node | None = None
    """The condition."""
    onwards: tuple[Node, ...] = ()
    """The new values."""


@dataclass(eq=False)
class Call:
    """One call of a procedure."""

    procedure: Procedure
    inputs: tuple[Node, ...]
    place: Place | None


HELPERS: dict[str, str] = {
    "larger": """\
/* The larger of two; not a number, if one of them is none. */
static float larger(float a, float b)
{
    return ((a > b) || (a != a)) ? a : b;
}
""",
    "smaller": """\
/* The smaller of two; not a number, if one of them is none. */
static float smaller(float a, float b)
{
    return ((a < b) || (a != a)) ? a : b;
}
""",
    "sign_of": """\
/* -1, 0 or 1. */
static float sign_of(float x)
{
    return (x > 0.0f) ? 1.0f : ((x < 0.0f) ? -1.0f : x);
}
""",
    "as_int32": """\
/* A whole number, cut off towards zero; the nearest there is beyond the range, 0 for no number. */
static int32_t as_int32(float x)
{
    int32_t whole = 0;
    if (x >= 2147483648.0f) {
        whole = INT32_MAX;
    } else if (x <= -2147483648.0f) {
        whole = INT32_MIN;
    } else if (x == x) {
        whole = (int32_t)x;
    } else {
        whole = 0;
    }
    return whole;
}
""",
    "sum_of": """\
/* The sum, modulo 2^32. */
static int32_t sum_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}
""",
    "difference_of": """\
/* The difference, modulo 2^32. */
static int32_t difference_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}
""",
    "product_of": """\
/* The product, modulo 2^32. */
static int32_t product_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a * (uint32_t)b);
}
""",
    "is_finite": """\
/* Whether it is a number, and not an infinite one. */
static bool is_finite(float x)
{
    return (x <= FLT_MAX) && (x >= -FLT_MAX);
}
""",
}
"""By their names."""


UNITS = {
    "spring_force": ("n", "N"),
    "spring_force_rate": ("n_per_s", "N/s"),
    "velocity": ("m_per_s", "m/s"),
    "speed": ("m_per_s", "m/s"),
    "height": ("m", "m"),
    "pitch": ("rad", "rad"),
    "roll": ("rad", "rad"),
    "yaw": ("rad", "rad"),
    "twist": ("rad", "rad"),
    "pitch_rate": ("rad_per_s", "rad/s"),
    "roll_rate": ("rad_per_s", "rad/s"),
    "yaw_rate": ("rad_per_s", "rad/s"),
    "twist_rate": ("rad_per_s", "rad/s"),
    "feedback": ("rad_per_s", "rad/s"),
    "force": ("n", "N"),
    "foot_x": ("m", "m"),
    "foot_z": ("m", "m"),
    "phase": ("rad", "rad"),
}
"""Units of what is sensed and commanded: as part of a name, and as people write them."""

WHAT = {
    "spring_force": "force of the leg's spring F_k, 0 in flight; not the force of contact",
    "spring_force_rate": "its rate of change",
    "velocity": "velocity of the hip, upwards",
    "speed": "forward speed of the body",
    "height": "height of the hip over the ground",
    "pitch": "pitch of the body",
    "roll": "roll of the body",
    "pitch_rate": "rate of pitch",
    "roll_rate": "rate of roll",
}
"""What the senses of the package's bodies are."""

_LETTERS = {
    **{"φ": "phi", "ω": "omega", "σ": "sigma", "α": "alpha", "κ": "kappa", "ψ": "psi", "π": "pi"},
    **{"δ": "delta", "τ": "tau", "η": "eta", "θ": "theta", "ρ": "rho", "Ω": "Omega", "μ": "mu"},
    **{"′": "'", "·": "*", "≤": "<=", "≥": ">=", "∈": "in", "Σ": "sum", "√": "sqrt", "²": "^2"},
    **{"½": "1/2", "−": "-", "–": "-", "…": "...", "∞": "inf", "`": "", "Δ": "Delta", "β": "beta"},
    **{"φ̇": "phi_dot", "ẏ": "y_dot", "ȧ": "a_dot", "×": "x", "∘": "*", "≠": "!="},
}
_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while bool true false int32_t uint32_t main w s o y0 y1 j0 j1 jn gamma exp log sin cos tan
pow round floor ceil index time signal remainder drem scale
"""
_RESERVED = frozenset(_WORDS.split())
"""Words that no variable may be called: of C, of its library, of the code around."""


def docstring(source: str) -> str:
    """The first line of a function's docstring, from what a trace says of it: NAME at FILE:LINE."""
    name, _, place = source.partition(" at ")
    file = Path(place.rpartition(":")[0])
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return ""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name == name:
            first = (ast.get_docstring(node) or "").split("\n\n")[0]
            return plain(re.sub(r"\s+", " ", first)).replace("*/", "* /")
    return ""


def is_c_name(text: str) -> bool:
    """Whether it may begin names in C: a letter, and then letters, digits and underscores.

    Example:
        >>> is_c_name("left_leg"), is_c_name("2nd"), is_c_name("float")
        (True, False, False)
    """
    return re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", text) is not None and text not in _RESERVED


def c_name(text: str, taken: set[str]) -> str:
    """A name in C near to a text, that is not taken yet; it is from then on.

    Example:
        >>> c_name("swap", {"swap"}), c_name("float", set())
        ('swap_2', 'float_value')
    """
    name = re.sub(r"\W+", "_", plain(text)).strip("_") or "value"
    if name[0].isdigit() or name in _RESERVED or keyword.iskeyword(name):
        name = f"{name}_value" if not name[0].isdigit() else f"x{name}"
    unique, n = name, 2
    while unique in taken:
        unique, n = f"{name}_{n}", n + 1
    taken.add(unique)
    return unique


def plain(text: str) -> str:
    """A text in ASCII, for comments.

    Example:
        >>> plain("f = σ cos φ ≤ 2")
        'f = sigma cos phi <= 2'
    """
    text = unicodedata.normalize("NFC", text)
    for letter, word in sorted(_LETTERS.items(), key=lambda pair: -len(pair[0])):
        text = text.replace(unicodedata.normalize("NFC", letter), word)
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()


def first_line(part: object) -> str:
    """What a part's docstring says it is, in ASCII."""
    doc = (type(part).__doc__ or type(part).__name__).strip()
    first, *rest = doc.split("\n\n")
    whole = f"{first} {rest[0]}" if first.endswith(":") and rest else first
    return plain(re.sub(r"\s+", " ", whole)).replace("*/", "* /").replace("/*", "/ *")
