"""The program of a lane as C: what a page runs, before it is WebAssembly."""

from __future__ import annotations

from apps.playground.functions import EngineFunction, functions
from apps.playground.layout import LayoutEntry
from apps.playground.loops import LoopLibrary
from apps.playground.program import Program
from tegotae_robots.c.statements import (
    Library,
    Statements,
    comment_of,
    wrapped,
)
from tegotae_robots.c.text import ascii_text

_OWN = (
    "l",
    "lane",
    "count",
    "i",
    "lane_block",
    "ticked",
    "recorded",
    "quiet",
    "released",
    "answer",
)

MATHS = (
    *("expf", "exp2f", "expm1f", "logf", "log1pf", "sinf", "cosf", "tanf", "asinf", "acosf"),
    *("atanf", "sinhf", "coshf", "tanhf", "asinhf", "acoshf", "atanhf", "erff", "cbrtf"),
)
"""Functions of one number that no instruction computes; a page lends them to the program."""
MATHS_OF_TWO = ("atan2f", "fmodf", "powf")
"""And those of two."""

_HEAD = """\
#include <stdbool.h>
#include <stdint.h>
#include <float.h>

#define INFINITY (__builtin_inff())
#define NAN (__builtin_nanf(""))
#define sqrtf __builtin_sqrtf
#define fabsf __builtin_fabsf
#define floorf __builtin_floorf
#define ceilf __builtin_ceilf
#define rintf __builtin_rintf
"""

_EXPORTS = """\
/* A release: what the page says is put in place, and recorded. */
__attribute__((export_name("release"))) void release(lane_block *lane)
{
    lane->ticks[0] = 0;
    released(lane);
    recorded(lane);
}

/* A frame: as many control ticks, and then what is recorded of it. */
__attribute__((export_name("advance"))) void advance(lane_block *lane, int32_t count)
{
    quiet(lane);
    for (int32_t i = 0; i < count; ++i) {
        ticked(lane);
        lane->ticks[0] += 1;
    }
    recorded(lane);
}

/* The force of the first leg at a point of the actuation surface [N]. */
__attribute__((export_name("surface"))) float surface(lane_block *lane, float phase, float spring,
    float velocity)
{
    return answer(lane, phase, spring, velocity);
}
"""


def program_source(program: Program) -> str:
    """Return the text of the program.

    Raises:
        TegotaeError: for an operation that has no C, by its name.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> from tegotae.systems.recipe import recipe
        >>> program = Program(recipe("V-reflex-w8").controller(), Hopper())
        >>> "static void ticked(lane_block *l)" in program_source(program)
        True
    """
    library = LoopLibrary()
    library.taken |= {*_OWN, *MATHS, *MATHS_OF_TWO}
    texts = [_function(library, function) for function in functions(program)]
    code = [*library.texts(), *texts, _EXPORTS]
    imports = [_lent(name, "float") for name in MATHS if _calls(code, name)]
    imports += [_lent(name, "float, float") for name in MATHS_OF_TWO if _calls(code, name)]
    head = comment_of(
        ascii_text(
            f"{type(program.controller.actuation).__name__} on a {type(program.body).__name__}, "
            f"{program.limbs} legs. Written by tegotae from the code that its simulator runs."
        )
    )
    blocks = [head + _HEAD, *imports, program.layout.struct(), *code]
    return "\n".join(blocks)


def _lent(name: str, takes: str) -> str:
    where = f'import_module("maths"), import_name("{name}")'
    return f"__attribute__(({where})) extern float {name}({takes});"


def _calls(texts: list[str], name: str) -> bool:
    return any(f"{name}(" in text for text in texts)


def _function(library: Library, function: EngineFunction) -> str:
    statements = Statements(library, (*_OWN, *function.takes))
    back = [] if function.returns is None else [function.returns]
    outputs = [node for _, nodes in function.writes for node in nodes]
    results = statements.all([*outputs, *back])
    lines = [wrapped(line) for line in statements.lines]
    # All is computed before anything is put in place: it may be read until then.
    for number, (node, text) in enumerate(zip(outputs, results, strict=False)):
        lines.append(wrapped(f"const {node.kind} to_{number} = {text};"))
    words = [(entry, i) for entry, nodes in function.writes for i in range(len(nodes))]
    lines += [
        f"    {_place(entry, i)} = {_state_text(entry, n)};" for n, (entry, i) in enumerate(words)
    ]
    lines += [wrapped(f"return {text};") for text in results[len(outputs) :]]
    parameters = ", ".join(["lane_block *l", *(f"float {name}" for name in function.takes)])
    kind = "void" if function.returns is None else "float"
    body = "\n".join(lines)
    comment = comment_of(function.description)
    return f"{comment}static {kind} {function.name}({parameters})\n{{\n{body}\n}}\n"


def _place(entry: LayoutEntry, word: int) -> str:
    return f"l->{entry.member}[{word}]"


def _state_text(entry: LayoutEntry, number: int) -> str:
    return f"to_{number} ? 1.0f : 0.0f" if entry.kind == "bool" else f"to_{number}"
