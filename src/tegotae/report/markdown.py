"""The claims as a table of Markdown."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tegotae.study.claims import Part, Verdict


def claims_table(verdicts: Iterable[Verdict]) -> str:
    """A row per claim: its verdict, and each effect with its 95 % interval and what is behind it.

    An effect that decides against the claim is marked ✗, one that supports it ✓.

    Args:
        verdicts: in the order of the rows.
    """
    rows = ["| | Claim | Verdict | Effects [95 % interval] |", "|-|-|-|-|"]
    for verdict in verdicts:
        effects = "<br>".join(map(_effect, verdict.parts)) or verdict.note
        rows.append(f"| {verdict.number} | {verdict.claim} | **{verdict.verdict}** | {effects} |")
    return "\n".join(rows) + "\n"


_MARKS = {"holds": "✓ ", "fails": "✗ "}


def _effect(part: Part) -> str:
    e = part.effect
    if np.isnan(e.mean):
        return f"{part.what}: undefined ({part.n} {part.unit})"
    value = f"{e.mean:.2f}"
    if not np.isnan(e.low):
        value += f" [{e.low:.2f}, {e.high:.2f}]"
    mark = _MARKS.get(part.verdict, "")
    return f"{mark}{part.what.replace('|', '&#124;')}: {value} ({part.n} {part.unit})"
