"""The paper's claims, one sentence and one effect each, fixed before the runs that judge them.

Each has the paper's own words, the effect that they are about and the sign that they claim. None
has a threshold: the paper sets none. Where its words have a size ("vastly") the size of the effect
stands beside that of what it is compared with, and decides nothing. Where they claim that two
things are alike ("on par") there is no sign, and `EQUIVALENCE` decides.

The list was fixed before anything was computed by it. Tables of an earlier study were there, and
had been judged by other rules; those of later studies were not. It is not changed to suit results:
a claim that was read wrongly is marked so, and stays. Three things came later, when the results of
the others were known: the claims of `LATER`, `EQUIVALENCE`, and that `ar-cot`, which says that AR
"has the potential", is about the best run. Later still PGPE was compared with SAC and PPO after
equal simulated time, in place of its plateau.

`claims.toml` has the list. A group of architectures is written `AR ART`, which sense [F_k],
`AR ART on Fv`, or `AR ART on any`.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.reproduction.claims.effects import (
    ArchitectureGroup,
    Correlation,
    Difference,
    DoubleDifference,
    Effect,
    OfGainMap,
    OfGaits,
    OfTrainings,
    Unmeasured,
)

MORE, LESS, ALIKE = 1, -1, 0
"""The claimed sign of an effect; that two things are alike has none."""

EQUIVALENCE = (0.8, 1.25)
"""Two things are alike if the one is this share of the other. The paper has no margin; this is that
of bioequivalence."""

OMISSION = "[…]"
"""Marks words of the paper that a quotation leaves out."""


@dataclass(frozen=True, kw_only=True)
class AtomicClaim:
    """One statement of the paper that one number can support or contradict.

    Args:
        name: short and unique, such as `vg-cot`.
        title: the claim in a few words, for figures and tables.
        words: the paper's, verbatim but for `OMISSION`.
        section: where they stand.
        effect: the number.
        sign: that the paper claims: `MORE`, `LESS`, or `ALIKE`, within `EQUIVALENCE`.
        size: the paper's word for how large the effect is; empty if it has none.
        headline: whether it is what the paper says of itself in abstract or conclusion.
        run: the run that it is about, such as `research.reproduction.claims.counting.BEST`; empty
            if the paper does not say.
        note: what a reader of the verdict should know.
    """

    name: str
    title: str
    words: str
    section: str
    effect: Effect
    sign: int
    size: str = ""
    headline: bool = False
    run: str = ""
    note: str = ""


_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(Difference, DoubleDifference, Correlation),
        *(OfTrainings, OfGainMap, OfGaits, Unmeasured),
    )
}
_SIGNS = {"more": MORE, "less": LESS, "alike": ALIKE}


def _group(text: str | list[str]) -> Any:
    """Return the group of architectures that a text describes, or those of several texts."""
    if isinstance(text, list):
        return tuple(map(_group, text))
    names, _, senses = text.partition(" on ")
    return ArchitectureGroup(tuple(names.split()), {"": "F", "any": ""}.get(senses, senses))


def _effect(entry: dict[str, dict[str, Any]]) -> Effect:
    ((kind, values),) = entry.items()
    if kind in ("Difference", "DoubleDifference", "OfGaits"):
        values |= {side: _group(values[side]) for side in ("ours", "theirs") if side in values}
    return _KINDS[kind](**values)


def _claims(later: bool | None = None) -> tuple[AtomicClaim, ...]:
    """Return the claims of the list, or those that came later."""
    listed = tomllib.loads(Path(__file__).with_name("claims.toml").read_text("utf-8"))["claim"]
    entries = [entry for entry in listed if entry.pop("later", False) or not later]
    return tuple(
        AtomicClaim(**entry | {"effect": _effect(entry["effect"]), "sign": _SIGNS[entry["sign"]]})
        for entry in entries
    )


ATOMIC_CLAIMS = _claims()
"""The claims, the paper's own account of itself first."""
LATER = _claims(later=True)
"""Claims that came to the list when the results of the others were known."""
