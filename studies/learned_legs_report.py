"""Tables in Markdown and figures of the study of learned feedback on legs."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from learned_legs_figures import draw_all
from learned_legs_plan import CELLS, TABLES, Cell
from tegotae._support.files import write_atomically
from tegotae._support.tables import read_csv
from tegotae.measures.hopping.statistics import UNBOUNDED, Range, interval

Rows = dict[str, np.ndarray]
OTHERWISE = ("-w", "+lost", "+long", "+wide")
"""What stands in the names of cells that were trained at another speed, or otherwise."""


def report(folder: Path) -> None:
    """Write `learned_legs.md`'s tables and all figures from the tables that are there."""
    judged, over = table("judged"), table("range")
    shares, curves = table("shares"), table("curves")
    texts = {
        "quadruped": summary(judged, curves, "@quadruped-c", OTHERWISE),
        "long": summary(judged, curves, "+long@quadruped-c", ()),
        "wide": summary(judged, curves, "+wide@quadruped-c", ()),
        "hexapod": summary(judged, curves, "@hexapod", ()),
        "speeds": by_speed(judged),
        "range": ranges(over),
        "plate": summary(judged, curves, "@plate-light-pitch", ()),
        "extremes": of_extremes(shares),
        "lost": of_lost(shares),
        "convergence": convergence(curves),
    }
    for name, text in texts.items():
        if text:
            write_atomically(TABLES / f"{name}.md", text)
    draw_all(curves, judged, over, shares)


def table(name: str) -> Rows:
    """A table of the study as columns; numbers where all are."""
    rows = read_csv(TABLES / f"{name}.csv")
    return {title: _numbers(column) for title, column in rows.items()}


def _numbers(column: Any) -> np.ndarray:
    cells = [str(cell) for cell in column]
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def markdown(titles: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table."""
    lines = ["| " + " | ".join(row) + " |" for row in (titles, ("---",) * len(titles), *rows)]
    return "\n".join(lines) + "\n" if rows else ""


SHARE, POSITIVE = (0.0, 1.0), (0.0, np.inf)


def sure(values: np.ndarray, digits: int = 2, within: Range = UNBOUNDED) -> str:
    """A mean and its 95 % interval."""
    found = interval(values, within=within)
    if np.isnan(found.mean):
        return "–"
    mean = f"{found.mean:.{digits}f}"
    if np.isnan(found.low) or found.count < 3:
        return mean
    return f"{mean} ({found.low:.{digits}f} … {found.high:.{digits}f})"


def cells_on(judged: Rows, ending: str, without: tuple[str, ...]) -> list[Cell]:
    """The cells of a body that are in a table, in the plan's order."""
    there = set(judged["cell"])
    return [
        cell
        for cell in CELLS
        if cell.name in there
        and cell.name.endswith(ending)
        and not any(part in cell.name for part in without)
    ]


def summary(judged: Rows, curves: Rows, ending: str, without: tuple[str, ...]) -> str:
    """A row per family: fitness, and what it does from random phases."""
    rows = []
    for cell in cells_on(judged, ending, without):
        mine = judged["cell"] == cell.name
        rows.append(
            (
                f"`{cell.name.partition('@')[0]}`",
                str(cell.experiment.controller.n_weights),
                sure(final(curves, cell.name)),
                sure(judged["upright"][mine], within=SHARE),
                sure(judged["locked"][mine], within=SHARE),
                sure(judged["lock_time_s"][mine], 0, POSITIVE),
                *(
                    (
                        sure(judged["speed_m_per_s"][mine], 3),
                        sure(judged["cost_of_transport"][mine], 2, POSITIVE),
                    )
                    if "plate" not in ending
                    else ()
                ),
                gaits(judged["gait"][mine]),
            )
        )
    walk = () if "plate" in ending else ("speed", "CoT")
    titles = ("family", "numbers", "fitness", "upright", "locked", "locks in", *walk, "gait")
    return markdown(titles, rows)


def final(curves: Rows, name: str) -> np.ndarray:
    """The best fitness of each run in the end."""
    mine = curves["cell"] == name
    last = curves["generation"][mine] == curves["generation"][mine].max()
    return curves["best_fitness"][mine][last]


def gaits(names: np.ndarray) -> str:
    """The gaits of the runs, the most common first."""
    return ", ".join(f"{name} {count}" for name, count in Counter(names.tolist()).most_common())


def by_speed(judged: Rows) -> str:
    """What was learned at each speed, and the cost of each gait that came about there."""
    rows = []
    for omega in (1.0, 2.0, 3.0):
        for family in ("V", "AR-rF"):
            # All learned ones by the same search.
            suffix = f"-w{omega:g}" if omega != 2.0 else "+wide" if family != "V" else ""
            mine = judged["cell"] == f"{family}{suffix}@quadruped-c"
            if not mine.any():
                continue
            rows.append(
                (
                    f"{omega:g}",
                    f"{0.4 * omega / np.pi:.3f}",
                    f"`{family}`",
                    sure(judged["speed_m_per_s"][mine], 3),
                    sure(judged["cost_of_transport"][mine], 2, POSITIVE),
                    sure(judged["lock_time_s"][mine], 0, POSITIVE),
                    gaits(judged["gait"][mine]),
                )
            )
    titles = ("ω", "wanted speed", "family", "speed", "CoT", "locks in", "gait")
    return markdown(titles, rows)


def ranges(over: Rows) -> str:
    """From which speed to which a controller walks: upright, locked, and faster the faster ω."""
    rows = []
    for cell in cells_on(over, "@quadruped-c", OTHERWISE):
        mine = over["cell"] == cell.name
        found = []
        for run in np.unique(over["run"][mine]):
            own = mine & (over["run"] == run)
            good = own & (over["upright"] == 1.0) & (over["locked"] >= 0.5)
            good &= over["cost_of_transport"] < 1.5
            speeds = over["speed_m_per_s"][good]
            found.append((speeds.min(), speeds.max(), good.sum()) if len(speeds) else (np.nan,) * 3)
        low, high, count = np.array(found, float).T
        name = f"`{cell.name.partition('@')[0]}`"
        rows.append(
            (
                name,
                sure(low, 2, POSITIVE),
                sure(high, 2, POSITIVE),
                sure(high / low, 1, POSITIVE),
                sure(count, 1, (0.0, 8.0)),
            )
        )
    titles = ("family", "slowest", "fastest", "ratio", "frequencies of 8")
    return markdown(titles, rows)


def of_extremes(shares: Rows) -> str:
    """What is kept under the farthest level of every disturbance on either side."""
    names = [c.name for c in CELLS if c.name in set(shares["controller"]) and not c.loses_legs]
    rows = []
    for condition in dict.fromkeys(shares["condition"].tolist()):
        at = shares["condition"] == condition
        neutral = 1.0 if shares["level"][at].min() > 0.0 and condition in RATIOS else 0.0
        levels = np.unique(shares["level"][at])
        for level in (side[pick] for side, pick in sides(levels, neutral)):
            cells = []
            for name in names:
                own = at & (shares["controller"] == name) & (shares["level"] == level)
                walks, kept = (float(shares[t][own][0]) for t in ("moves", "efficiency"))
                cells.append(f"{walks:.2f}, " + ("–" if np.isnan(kept) else f"{kept:.2f}"))
            rows.append((condition, f"{level:g}", *cells))
    titles = ("condition", "level", *(f"`{name.partition('@')[0]}`" for name in names))
    return markdown(titles, rows)


RATIOS = ("omega", "mass", "friction", "inertia")
"""Conditions whose levels are shares of what is usual."""


def sides(levels: np.ndarray, neutral: float) -> list[tuple[np.ndarray, int]]:
    """The levels below and above none of it, and where the farthest one is."""
    both = [(levels[levels < neutral], 0), (levels[levels > neutral], -1)]
    return [(side, pick) for side, pick in both if len(side)]


def of_lost(shares: Rows) -> str:
    """The share of releases in which a quadruped walks on after the loss of a leg."""
    rows = []
    lost = shares["condition"] == "lost-leg"
    for name in dict.fromkeys(shares["controller"][lost].tolist()):
        own = lost & (shares["controller"] == name)
        releases, walks = (float(shares[title][own][0]) for title in ("lanes", "moves"))
        rows.append((f"`{name.partition('@')[0]}`", f"{releases:.0f}", f"{walks:.2f}"))
    return markdown(("family", "releases", "walk on"), rows)


def convergence(curves: Rows) -> str:
    """Best fitness after a half, three quarters and all of the training."""
    rows = []
    for cell in CELLS:
        mine = curves["cell"] == cell.name
        if not mine.any() or cell.experiment.is_searched or cell.loses_legs:
            continue
        last = curves["generation"][mine].max()
        fitness_at = []
        for share in (0.5, 0.8, 1.0):
            at = mine & (np.abs(curves["generation"] - share * last) < 0.5)
            fitness_at.append(sure(curves["best_fitness"][at]))
        rows.append((f"`{cell.name}`", f"{last:.0f}", *fitness_at))
    return markdown(("cell", "generations", "half", "four fifths", "all"), rows)
