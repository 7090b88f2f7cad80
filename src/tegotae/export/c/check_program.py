"""The test program: golden vectors through the compiled controller, and then what is no number."""

from __future__ import annotations

import textwrap

import numpy as np

from tegotae.export.c.golden import Golden, outputs_of
from tegotae.export.c.lower import number, wrapped
from tegotae.export.c.plan import Export, member

TOLERANCE = 1e-5
"""Largest error allowed, relative to the golden number or to its column's size."""


def check_program(export: Export, golden: Golden) -> str:
    """The text of test_PREFIX.c."""
    prefix, upper = export.prefix, export.prefix.upper()
    rows = ",\n".join(
        wrapped("{" + ", ".join(number(x, "float")[0] for x in row) + "}") for row in golden.rows
    )
    sizes = np.maximum(np.abs(golden.rows).max(axis=0), np.float32(1e-6))
    scale = wrapped(", ".join(number(x, "float")[0] for x in sizes))
    limbs = f"{upper}_LIMBS"
    at = "" if export.limbs == 1 else "[i]"
    columns = len(golden.columns)
    names = export.tracer.state_names

    def loop(lines: list[str]) -> str:
        """A loop over limbs, in which k goes on by one each."""
        return "".join(
            f"    for (int i = 0; i < {limbs}; ++i) {{\n        {line}\n    }}\n" for line in lines
        )

    put = loop([f"state.oscillator{at}.{n} = row[k++];" for n in names])
    put += loop([f"in.{member(n)}{at} = row[k++];" for n in export.senses])

    def compared(text: str, turns: bool) -> str:
        return f"worst = worse(worst, {'around' if turns else 'error'}({text}, row, k)); ++k;"

    got = loop([compared(f"out.{n}{at}", n == "phase_rad") for n in outputs_of(export)])
    got += loop([compared(f"state.oscillator{at}.{n}", n == "phase") for n in names])
    first = f"static const float PHASES[{limbs}] = {{0.0f}};\n\n" if names and at else ""
    phases = "" if not names else ", PHASES" if at else ", 0.0f"
    force = export.commands == ("force",)
    low, high = ("0.0f", f"{upper}_MAX_FORCE_N") if force else ("-FLT_MAX", "FLT_MAX")
    bounded = loop(
        [f"held = held && (out.{member(n)}{at} >= {low}) && (out.{member(n)}{at} <= {high});"
         for n in export.commands]
    )  # fmt: skip
    bounded = textwrap.indent(bounded, " " * 8)
    zero = "{0.0f}" if at else "0.0f"
    senses = [member(n) for n in export.senses] or ["unused"]
    nothing = ", ".join(f".{name} = {zero if export.senses else '0.0f'}" for name in senses)
    bad = "".join(
        f"            for (int i = 0; i < {limbs}; ++i) {{\n                in.{member(n)}{at} = "
        "BAD[(i + n) % BADS];\n            }\n"
        for n in export.senses
    )
    wraps = "phase_rad" in outputs_of(export) or "phase" in names
    around = _AROUND if wraps else ""
    return f"""\
/* test_{prefix}.c: {len(golden.rows)} ticks of a run of the simulator, one by one through
   the C, and inputs that are no numbers. Exit status 0 if all is as it should be. */
#include "{prefix}.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#define ROWS {len(golden.rows)}
#define COLUMNS {columns}
#define TOLERANCE {number(TOLERANCE, "float")[0]}
#define BADS 6

{first}/* {", ".join(golden.columns)}. */
static const float GOLDEN[ROWS][COLUMNS] = {{
{rows}
}};

/* The largest size of each column. */
static const float SIZE[COLUMNS] = {{
{scale}
}};

static const float BAD[BADS] = {{NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.0e30f}};

static float worse(float a, float b)
{{
    return (b <= a) ? a : b;
}}

/* The error of a number, relative to the golden one or to its column. */
static float error(float found, const float *row, int k)
{{
    const float golden = fabsf(row[k]);
    return fabsf(found - row[k]) / ((golden > SIZE[k]) ? golden : SIZE[k]);
}}

{around}static float vector(const float *row)
{{
    {prefix}_state state;
    {prefix}_inputs in = {{{nothing}}};
    {prefix}_outputs out;
    float worst = 0.0f;
    int k = 0;
    {prefix}_init(&state{phases});
{put}    {prefix}_step(&state, &in, &out);
{got}    return out.fault ? INFINITY : worst;
}}

static bool bounded(void)
{{
    {prefix}_state state;
    {prefix}_inputs in = {{{nothing}}};
    {prefix}_outputs out;
    bool held = true;
    {prefix}_init(&state{phases});
    for (int turn = 0; turn < 100; ++turn) {{
        for (int n = 0; n < BADS; ++n) {{
{bad}            {prefix}_step(&state, &in, &out);
{bounded}        }}
    }}
    return held;
}}

int main(void)
{{
    float worst = 0.0f;
    for (int i = 0; i < ROWS; ++i) {{
        worst = worse(worst, vector(GOLDEN[i]));
    }}
    printf("%d golden vectors, largest error %.2g (allowed %.2g)\\n", ROWS, (double)worst,
        (double)TOLERANCE);
    const bool held = bounded();
    printf("outputs of inputs that are no numbers: %s\\n", held ? "bounded" : "OUT OF RANGE");
    return ((worst <= TOLERANCE) && held) ? 0 : 1;
}}
"""


_AROUND = """\
/* The same of an angle, of which whole turns do not count. */
static float around(float found, const float *row, int k)
{
    const float turn = 6.2831855f;
    float gap = fabsf(found - row[k]);
    gap = (turn - gap < gap) ? fabsf(turn - gap) : gap;
    return gap / turn;
}

"""
