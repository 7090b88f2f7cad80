"""The claims as a table of Markdown."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tegotae.study.claims import FAILS, HOLDS, Part, Verdict


def claims_table(verdicts: Iterable[Verdict]) -> str:
    """A row per claim: its verdict, and each effect with its 95 % interval and what is behind it.

    An effect that decides against the claim is marked ✗, one that supports it ✓; those without a
    mark are undecided, or for information. Then follow what is claimed of it, the runs that define
    it and those behind it.

    Args:
        verdicts: in the order of the rows.
    """
    rows = ["| | Claim | Verdict | Effects: mean [95 % interval] |", "|-|-|-|-|"]
    for verdict in verdicts:
        effects = "<br>".join(map(_effect, verdict.parts))
        note = _plain(f"({verdict.note})") if verdict.note else ""
        cell = "<br>".join(filter(None, (effects, note)))
        rows.append(f"| {verdict.number} | {verdict.claim} | **{verdict.verdict}** | {cell} |")
    return "\n".join(rows) + "\n"


_MARKS = {HOLDS: "✓ ", FAILS: "✗ "}


def _effect(part: Part) -> str:
    e = part.effect
    value = "undefined" if np.isnan(e.mean) else f"{e.mean:.2f}"
    if not np.isnan(e.low):
        value += f" [{e.low:.2f}, {e.high:.2f}]"
    claimed = [
        f"{sign} {bound:.3g}"
        for sign, bound in ((">", part.low), ("<", part.high))
        if np.isfinite(bound)
    ]
    words = [f"claimed {' and '.join(claimed)}"] if claimed else []
    words.append(f"{e.count} of {part.n} {part.unit}")
    if part.without_cycle:
        words.append(f"{part.without_cycle} without a limit cycle")
    mark = _MARKS.get(part.verdict, "")
    return f"{mark}{_plain(part.what)}: {value} ({'; '.join(words)})"


def _plain(text: str) -> str:
    return text.replace("|", "&#124;")
