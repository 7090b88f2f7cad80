"""The claims' effects in every way to count, as a table in a file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

from research.reproduction.cells import require_once
from research.reproduction.claims.atomic import ATOMIC_CLAIMS
from research.reproduction.claims.counting import Count
from research.reproduction.claims.estimates import EffectEstimate
from research.reproduction.claims.findings import SELECTED_FOR, Finding
from tegotae._support import tables
from tegotae._support.errors import TegotaeError

DIGITS = 6
"""Significant digits of the effects in the file."""

_COUNT = tuple(field.name for field in fields(Count))
_EFFECT = tuple(field.name for field in fields(EffectEstimate))
_VERDICT = "verdict"
_KIND = "table that python -m research.reproduction claims wrote"


def effect_columns(findings: Iterable[Finding]) -> dict[str, list[Any]]:
    """Return one row per claim and way to count: the effect, its 95 % intervals, its size, the
    verdict.
    """
    columns: dict[str, list[Any]] = {name: [] for name in ("claim", *_COUNT, *_EFFECT, _VERDICT)}
    for finding in findings:
        verdicts = finding.verdicts
        for count, estimate in finding.by_count.items():
            columns["claim"].append(finding.claim.name)
            for name in _COUNT:
                columns[name].append(getattr(count, name))
            for name in _EFFECT:
                columns[name].append(getattr(estimate, name))
            columns[_VERDICT].append(verdicts[count])
    return columns


def effects_csv(findings: Iterable[Finding]) -> str:
    """Return the table as the text of a CSV file."""
    return tables.csv_text(effect_columns(findings), digits=DIGITS)


def read_effects(path: Path) -> list[Finding]:
    """Read the finding of each claim from a table that `effects_csv` made.

    Raises:
        TegotaeError: if it cannot be read, is no such table, names a claim that is not there, or
            has an effect twice.
    """
    cells = tables.read_csv(path, ("claim", *_COUNT, *_EFFECT, _VERDICT), kind=_KIND)
    require_once(path, {name: cells[name] for name in ("claim", *_COUNT)})
    claims = {claim.name: claim for claim in ATOMIC_CLAIMS}
    estimates: dict[str, dict[Count, EffectEstimate]] = {}
    try:
        numbers = [tables.parse_numbers(cells[name]).tolist() for name in _EFFECT]
        counts = zip(*(cells[name].tolist() for name in _COUNT), strict=True)
        rows = zip(cells["claim"].tolist(), counts, *numbers, strict=True)
        for name, count, *values in rows:
            estimates.setdefault(name, {})[Count(*count)] = EffectEstimate(*values)
        selected = {*cells["claim"][cells[_VERDICT] == SELECTED_FOR].tolist()}
        return [
            Finding(claims[name], by_count, name in selected)
            for name, by_count in estimates.items()
        ]
    except (KeyError, ValueError):
        raise TegotaeError(f"{path} is no {_KIND}") from None
