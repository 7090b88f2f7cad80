"""The multiverse's shares as a table of Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from tegotae.figures.report.markdown import table
from tegotae.studies.paper.claims import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Part,
)
from tegotae.studies.paper.multiverse.influence import decisive, influences
from tegotae.studies.paper.multiverse.readings import Reading
from tegotae.studies.paper.multiverse.verdicts import (
    CLAIMS,
    Share,
    VerdictsByReading,
    claimed,
    of_claim,
    shares,
    words,
)


def shares_table(
    readings: Sequence[Reading], by_reading: VerdictsByReading, omega: str = "all"
) -> str:
    """A row per claim: in which share of readings it holds, with a 95 % interval, and what decides.

    Behind it stand its parts, and in how many readings each holds / is undecided / fails.

    Args:
        readings: all readings.
        by_reading: the verdicts under each.
        omega: on which ω_t, "all", "4" or "8".
    """
    rows = [["", "Claim", "Holds", "Fails", "Undecided", "Reading 0", "What decides (ρ)", _PARTS]]
    for number, text in CLAIMS.items():
        verdicts = of_claim(by_reading, number, omega)
        each = shares(verdicts.values())
        clear = decisive(influences(readings, verdicts))
        deciding = ", ".join(f"{i.choice.label} ({i.correlation:+.2f})" for i in clear)
        rows.append(
            [
                f"{number}",
                text,
                *(_share(each[word]) for word in (HOLDS, FAILS, UNDECIDED)),
                verdicts[0].verdict if 0 in verdicts else "–",
                deciding.replace("-", "−") or "–",
                "<br>".join(_parts([claimed(verdict) for verdict in verdicts.values()])),
            ]
        )
    return table(rows)


_PARTS = "Parts: holds / undecided / fails"


def _parts(readings: list[list[Part]]) -> list[str]:
    found = []
    for each in zip(*readings, strict=True):
        counts = Counter(part.verdict for part in each)
        numbers = " / ".join(f"{counts[word]}" for word in (HOLDS, UNDECIDED, FAILS))
        found.append(f"{words(each)}: {numbers}")
    return found


def _share(share: Share) -> str:
    if not share.of:
        return "–"
    return f"{share.count} of {share.of} [{share.low:.0%}, {share.high:.0%}]".replace("%", " %")
