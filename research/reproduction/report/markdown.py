"""Endings of the runs of a study as a table in Markdown."""

from __future__ import annotations

from collections.abc import Mapping

from research.frame import markdown_table
from research.reproduction.endings import RunEndings


def endings_table(by: Mapping[str, RunEndings]) -> str:
    """Return one row per group of runs: how many never hop, stay in a local optimum, or hit the
    cap.
    """
    rows = [["", "Runs", "Never hop", "Local optimum", "At the cap", "No limit cycle"]]
    for name, endings in by.items():
        counts = (
            endings.runs,
            endings.never_hop,
            endings.local_optimum,
            endings.at_cap,
            endings.without_cycle,
        )
        rows.append([name, *("–" if count is None else f"{count}" for count in counts)])
    return markdown_table(rows)
