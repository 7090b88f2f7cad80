"""The claims, and how the runs behind them ended, as tables of Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from tegotae.studies.paper.claims import (
    FAILS,
    HOLDS,
    Part,
    Verdict,
)
from tegotae.studies.paper.endings import Endings


def claims_table(
    verdicts: Iterable[Verdict], others: Mapping[str, Iterable[Verdict]] | None = None
) -> str:
    """A row per claim: its verdict, and each effect with its 95 % interval and what is behind it.

    An effect that decides against the claim is marked ✗, one that supports it ✓; those without a
    mark are undecided, or for information. Then follow what is claimed of it, the runs that define
    it and those behind it.

    Args:
        verdicts: in the order of the rows.
        others: verdicts from other data, each a column beside, by its heading.
    """
    beside = _verdicts_by_number(others or {})
    rows = [["", "Claim", "Verdict", *beside, "Effects: mean [95 % interval]"]]
    for verdict in verdicts:
        effects = "<br>".join(map(_effect, verdict.parts))
        note = _plain(f"({verdict.note})") if verdict.note else ""
        cell = "<br>".join(filter(None, (effects, note)))
        there = [found.get(verdict.number, "") for found in beside.values()]
        rows.append([f"{verdict.number}", verdict.claim, f"**{verdict.verdict}**", *there, cell])
    return table(rows)


def verdicts_table(by: Mapping[str, Iterable[Verdict]]) -> str:
    """A row per claim, and a column with its verdict for each set of data, by its heading."""
    by = {heading: list(verdicts) for heading, verdicts in by.items()}
    found = _verdicts_by_number(by)
    claims = {verdict.number: verdict.claim for each in by.values() for verdict in each}
    rows = [["", "Claim", *by]]
    for number, claim in sorted(claims.items()):
        rows.append([f"{number}", claim, *(each.get(number, "") for each in found.values())])
    return table(rows)


def endings_table(by: Mapping[str, Endings]) -> str:
    """A row per group of runs: how many never hop, stay in a local optimum, or hit the cap."""
    rows = [["", "Runs", "Never hop", "Local optimum", "At the cap", "No limit cycle"]]
    for name, found in by.items():
        counts = (
            found.runs,
            found.never_hop,
            found.local_optimum,
            found.at_cap,
            found.without_cycle,
        )
        rows.append([name, *("–" if count is None else f"{count}" for count in counts)])
    return table(rows)


def _verdicts_by_number(by: Mapping[str, Iterable[Verdict]]) -> dict[str, dict[int, str]]:
    return {heading: {v.number: v.verdict for v in each} for heading, each in by.items()}


def table(rows: list[list[str]]) -> str:
    """Rows of cells as a table, the first being its head."""
    lines = [
        "|" + "".join(f" {cell} |" if cell else " |" for cell in cells).rstrip() for cells in rows
    ]
    return "\n".join([lines[0], "|" + "-|" * len(rows[0]), *lines[1:]]) + "\n"


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
