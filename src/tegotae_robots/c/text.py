"""Texts of an export: templates that are filled, names, numbers and comments of C."""

from __future__ import annotations

import functools
import keyword
import re
import textwrap
import unicodedata
from collections.abc import Mapping
from importlib import resources
from typing import Any

import numpy as np

from lanewise.operations import ATOM, UNARY
from tegotae._support.spelling import IN_ASCII
from tegotae.parts._shapes import Number

WIDTH = 96
_PART = re.compile(
    r"^% (no )?(\w+)\n(.*?)^% end \2\n|@(\w+)(?:\?([^@|]*)(?:\|([^@]*))?)?@",
    re.MULTILINE | re.DOTALL,
)
_LONG_COMMENT = re.compile(r"^/\*\* (.*?) \*/$", re.MULTILINE | re.DOTALL)


@functools.cache
def template_text(name: str) -> str:
    """Return the text of a template."""
    folder = resources.files("tegotae_robots.c") / "templates"
    return (folder / name).read_text(encoding="utf-8")


def filled_template(text: str, facts: Mapping[str, Any]) -> str:
    """Fill a template with its facts.

    `@name@` is the fact of that name. Lines from `% name` to `% end name` are there if the fact is
    true; of a list once an entry, with the entry's own facts; of a function what it makes of them.
    `% no name` begins lines that are there if it is not. Within a line, `@name?yes|no@` is one of
    two texts.

    Example:
        >>> facts = {"a": 2, "legs": [{"b": 1}]}
        >>> filled_template("@a@\\n% legs\\n@b@ of @a@\\n% end legs\\n", facts)
        '2\\n1 of 2\\n'
    """

    def part(match: re.Match[str]) -> str:
        no, section, inside, name, if_true, if_not = match.groups()
        if name and if_true is not None:
            return if_true if facts[name] else if_not or ""
        if name:
            return str(facts[name])
        value: Any = facts[section]
        if no:
            return "" if value else filled_template(inside, facts)
        if callable(value):
            return str(value(filled_template(inside, facts)))
        if isinstance(value, list):
            return "".join(filled_template(inside, {**facts, **entry}) for entry in value)
        return filled_template(inside, facts) if value else ""

    return _PART.sub(part, text)


def filled_c(name: str, facts: Mapping[str, Any]) -> str:
    """Fill the template of a C file; comments that begin with `/**` are wrapped."""
    text = filled_template(template_text(name), facts)
    text = _LONG_COMMENT.sub(lambda match: comment_of(match[1]).rstrip(), text)
    return re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"


def comment_of(text: str) -> str:
    """Return a comment in C, wrapped."""
    if not text:
        return ""
    lines = textwrap.wrap(" ".join(text.split()), WIDTH - 6)
    return "/* " + "\n   ".join(lines) + " */\n"


def wrapped(line: str, indent: str = "    ") -> str:
    """Wrap a statement into as many lines as it needs."""
    return "\n".join(
        textwrap.wrap(
            line,
            WIDTH,
            initial_indent=indent,
            subsequent_indent=indent + "    ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    )


def c_number(value: Number, kind: str = "float") -> tuple[str, int]:
    """Return a constant in C, and the precedence of its expression.

    Example:
        >>> c_number(0.1), c_number(-2, "int32_t"), c_number(True, "bool")
        (('0.1f', 9), ('-2', 8), ('true', 9))
    """
    if kind == "bool":
        return ("true" if value else "false"), ATOM
    if kind == "int32_t":
        integer = int(value)
        if integer == -(2**31):
            return "INT32_MIN", ATOM
        return str(integer), ATOM if integer >= 0 else UNARY
    single = np.float32(value)
    if np.isnan(single):
        return "NAN", ATOM
    if np.isinf(single):
        return ("INFINITY", ATOM) if single > 0 else ("-INFINITY", UNARY)
    text = str(single)
    if "e" not in text and "." not in text:
        text += ".0"
    return f"{text}f", ATOM if single >= 0 and not text.startswith("-") else UNARY


def floating(value: Number) -> str:
    """Return a number of type float in C."""
    return c_number(value)[0]


_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while bool true false int32_t uint32_t main w s o y0 y1 j0 j1 jn gamma exp log sin cos tan
pow round floor ceil index time signal remainder drem scale
"""
_RESERVED = frozenset(_WORDS.split())
"""Words that no variable may be called: of C, of its library, of the code around."""


_LIBRARY = """
assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign
stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath
threads time uchar wchar wctype unistd pthread semaphore sched strings alloca malloc features
endian arduino library control_loop cmakelists
atomic mtx cnd thrd tss sem memory clock timer timespec uint8 int8 uint16 int16 uint32 int32 uint64
int64 size ptrdiff wint div ldiv lldiv file fpos va jmp sig flt dbl ldbl rand
alignas alignof asm bitint class constexpr decimal128 decimal32 decimal64 delete friend generic
imaginary namespace new noreturn nullptr operator private protected public static_assert template
this thread_local throw try typeof typeof_unqual typename using virtual
abort abs acos acosh asctime asin asinh atan atan2 atanh atexit atof atoi atol atoll bsearch calloc
cbrt clearerr copysign cosh ctime difftime erf erfc exit exp2 expm1 fabs fclose fdim feof ferror
fflush fgetc fgets fma fmax fmin fmod fopen fprintf fputc fputs fread free freopen frexp fscanf
fseek ftell fwrite getc getchar getenv gets gmtime hypot ilogb labs ldexp lgamma llabs llrint
llround localtime log10 log1p log2 logb longjmp lrint lround memchr memcmp memcpy memmove memset
mktime modf nan nearbyint nextafter nexttoward null offsetof perror printf putc putchar puts qsort
raise realloc remove rename remquo rewind rint scalbln scalbn scanf setbuf setvbuf sinh snprintf
sprintf sqrt srand sscanf stderr stdin stdout strcat strchr strcmp strcoll strcpy strcspn strerror
strftime strlen strncat strncmp strncpy strpbrk strrchr strspn strstr strtod strtof strtok strtol
strtold strtoll strtoul strtoull strxfrm system tan tanh tgamma tmpfile tmpnam trunc ungetc
vfprintf vprintf vsnprintf vsprintf
"""
_NO_PREFIX = _RESERVED | frozenset(_LIBRARY.split())
"""Words with which names and files would clash: headers of C, POSIX and Arduino, files of a
library, families such as `atomic_init`, words of C23 and C++, and functions."""


def is_c_name(text: str) -> bool:
    """Return True if it may begin names in C: a letter, then letters, digits and single
    underscores.

    A file system may take `Math.h` for `math.h`, so that capitals make no difference.

    Example:
        >>> is_c_name("left_leg"), is_c_name("2nd"), is_c_name("float"), is_c_name("Math")
        (True, False, False, False)
    """
    letters = re.fullmatch(r"[A-Za-z](?!.*_(_|$))[A-Za-z0-9_]{0,30}", text) is not None
    return letters and text.lower() not in _NO_PREFIX


def c_name(text: str, taken: set[str]) -> str:
    """Return a free name in C close to a text, and reserve it.

    Example:
        >>> c_name("swap", {"swap"}), c_name("float", set())
        ('swap_2', 'float_value')
    """
    name = re.sub(r"\W+", "_", ascii_text(text)).strip("_") or "value"
    if name[0].isdigit() or name in _RESERVED or keyword.iskeyword(name):
        name = f"{name}_value" if not name[0].isdigit() else f"x{name}"
    unique, n = name, 2
    while unique in taken:
        unique, n = f"{name}_{n}", n + 1
    taken.add(unique)
    return unique


def ascii_text(text: str) -> str:
    """Return a text in ASCII, for comments.

    Example:
        >>> ascii_text("f = σ cos φ ≤ 2")
        'f = sigma cos phi <= 2'
    """
    text = unicodedata.normalize("NFC", text)
    for letter, word in sorted(IN_ASCII.items(), key=lambda pair: -len(pair[0])):
        text = text.replace(unicodedata.normalize("NFC", letter), word)
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()


def commented(doc: str) -> str:
    """Return the first paragraph of a docstring as a comment, with the next if it announces one."""
    first, *paragraphs = doc.strip().split("\n\n")
    paragraph = f"{first} {paragraphs[0]}" if first.endswith(":") and paragraphs else first
    return ascii_text(" ".join(paragraph.split())).replace("*/", "* /").replace("/*", "/ *")
