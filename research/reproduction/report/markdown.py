"""Tables of Markdown, and how the runs of a study ended as one."""

from __future__ import annotations

from collections.abc import Mapping

from research.reproduction.endings import RunEndings


def endings_table(by: Mapping[str, RunEndings]) -> str:
    """A row per group of runs: how many never hop, stay in a local optimum, or hit the cap."""
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


def markdown_table(rows: list[list[str]]) -> str:
    """Rows of cells as a table, the first being its head."""
    lines = [
        "|" + "".join(f" {cell} |" if cell else " |" for cell in cells).rstrip() for cells in rows
    ]
    return "\n".join([lines[0], "|" + "-|" * len(rows[0]), *lines[1:]]) + "\n"
