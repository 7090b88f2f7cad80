"""The claims over the readings of the paper: an overview, and a specification curve per claim."""

from __future__ import annotations

import math
from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from tegotae.figures.style import COLOURS, DIVERGING, PAGE_IN, SEQUENTIAL, new_figure, styled
from tegotae.studies.paper.claims import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Part,
    Verdict,
)
from tegotae.studies.paper.multiverse.influence import SIGNIFICANT, Influence, influences
from tegotae.studies.paper.multiverse.readings import AnalysisChoice, Reading
from tegotae.studies.paper.multiverse.verdicts import (
    CLAIMS,
    VerdictsByReading,
    claimed,
    of_claim,
    shares,
    words,
)

VERDICT_COLOURS = {HOLDS: COLOURS[5], UNDECIDED: "0.75", FAILS: COLOURS[4]}
"""Green holds, grey is undecided, orange fails; they differ in lightness, too."""


def overview_figure(
    readings: Sequence[Reading], by_reading: VerdictsByReading, omega: str = "all"
) -> Figure:
    """Per claim the share of readings in which it holds, and what goes with that.

    Left: how many readings say what; the line below a bar is the 95 % interval of the share that
    holds. Right: how each choice correlates with the claim's margin, in numbers where that is more
    than chance.

    Args:
        readings: all readings.
        by_reading: the verdicts under each.
        omega: on which ω_t, "all", "4" or "8".
    """
    found = {number: of_claim(by_reading, number, omega) for number in CLAIMS}
    with styled():
        figure = new_figure(PAGE_IN, 3.1)
        bars, matrix = figure.subplots(1, 2, width_ratios=(1.0, 1.7), sharey=True)
        for row, verdicts in enumerate(found.values()):
            _bar(bars, row, list(verdicts.values()))
        bars.set_yticks(range(len(CLAIMS)), [f"{text} ({n})" for n, text in CLAIMS.items()])
        bars.set(xlim=(0.0, 1.0), ylim=(len(CLAIMS) - 0.45, -0.55), xlabel="share of readings")
        bars.tick_params(axis="y", length=0)
        bars.legend(
            handles=[Patch(color=c, label=word) for word, c in VERDICT_COLOURS.items()],
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=3,
            handlelength=1.0,
        )
        every = [influences(readings, verdicts) for verdicts in found.values()]
        _matrix(figure, matrix, every)
    return figure


def _bar(panel, row: int, verdicts: list[Verdict]) -> None:
    left = 0.0
    each = shares(verdicts)
    for word, colour in VERDICT_COLOURS.items():
        part = each[word]
        if not part.count:
            continue
        panel.barh(row, part.mean, left=left, height=0.7, color=colour, lw=0)
        ink = "black" if word == UNDECIDED else "white"
        panel.text(
            left + part.mean / 2, row, f"{part.count}", ha="center", va="center", color=ink, size=7
        )
        left += part.mean
    if not math.isnan(each[HOLDS].low):
        ends = [each[HOLDS].low, each[HOLDS].high]
        panel.plot(ends, [row + 0.43] * 2, color="black", lw=1.0, clip_on=False)


def _matrix(figure: Figure, panel, found: list[list[Influence]]) -> None:
    values = np.array([[i.correlation for i in row] for row in found])
    image = panel.imshow(values, cmap=DIVERGING, vmin=-1.0, vmax=1.0, aspect="auto")
    labels = [influence.choice.label for influence in found[0]]
    panel.set_xticks(range(len(labels)), labels, rotation=45, ha="right")
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    for row, each in enumerate(found):
        for column, influence in enumerate(each):
            _cell(panel, column, row, influence)
    bar = figure.colorbar(image, label="rank correlation", ticks=(-1, 0, 1))
    bar.ax.spines[:].set_visible(False)


def _cell(panel, x: float, y: float, influence: Influence) -> None:
    rho = influence.correlation
    if np.isnan(rho):
        panel.text(x, y, "–", ha="center", va="center", color="0.6", size=6)
        return
    if influence.p < SIGNIFICANT:
        text = f"{rho:+.2f}".replace("-", "−").replace("0.", ".")
        ink = "white" if abs(rho) > 0.65 else "black"
        panel.text(x, y, text, ha="center", va="center", size=6, weight="bold", color=ink)


def curve_figure(
    readings: Sequence[Reading], by_reading: VerdictsByReading, number: int, omega: str = "all"
) -> Figure:
    """One claim under every reading: its effects, sorted, and the choices behind each.

    Above, a panel for each part of the claim, with the claimed range shaded; every effect and its
    interval in the colour of its verdict; and a strip with the verdict of the whole. All are in the
    order of the first part's effect. Below, what each reading chooses: dark is the first value of a
    choice or the low end of its range, light the last; at the right, how it goes with the claim.

    Args:
        readings: all readings.
        by_reading: the verdicts under each.
        number: the claim's.
        omega: on which ω_t, "all", "4" or "8".
    """
    verdicts = of_claim(by_reading, number, omega)
    order = sorted(verdicts, key=lambda n: _key(claimed(verdicts[n])[0]))
    parts = len(claimed(verdicts[order[0]])) if order else 0
    with styled():
        heights = [0.16, *[1.0] * parts, 1.5]
        figure = new_figure(PAGE_IN, 0.35 + 0.95 * sum(heights))
        figure.suptitle(f"{number}. {CLAIMS[number]}", x=0.01, ha="left", fontsize=8, weight="bold")
        panels = figure.subplots(len(heights), 1, height_ratios=heights, sharex=True)
        strip, *effects, matrix = panels
        for x, n in enumerate(order):
            strip.bar(x, 1.0, width=0.9, color=VERDICT_COLOURS[verdicts[n].verdict], lw=0)
        strip.set(
            yticks=[0.5], yticklabels=["claim"], ylim=(0.0, 1.0), xlim=(-0.7, len(order) - 0.3)
        )
        strip.spines[:].set_visible(False)
        strip.tick_params(length=0)
        for i, panel in enumerate(effects):
            _effects(panel, [claimed(verdicts[n])[i] for n in order])
        _choices(matrix, [readings[n] for n in order], order, influences(readings, verdicts))
        figure.align_ylabels(effects)
    return figure


def _key(part: Part) -> float:
    return -math.inf if math.isnan(part.effect.mean) else part.effect.mean


def _effects(panel, parts: list[Part]) -> None:
    means = [p.effect.mean for p in parts if not math.isnan(p.effect.mean)]
    bounds = [b for p in parts[:1] for b in (p.low, p.high) if math.isfinite(b)]
    ends = [e for p in parts for e in (p.effect.low, p.effect.high) if not math.isnan(e)]
    # The means decide the scale: one interval of two runs must not press all others flat.
    inside = [*means, *bounds]
    room = 0.5 * (max(inside) - min(inside) or 1.0)
    low = max(min([*inside, *ends]), min(inside) - room)
    high = min(max([*inside, *ends]), max(inside) + room)
    margin = 0.06 * (high - low or 1.0)
    panel.set_ylim(low - margin, high + margin)
    for part in parts[:1]:
        panel.axhspan(
            max(part.low, low - margin), min(part.high, high + margin), color="0.93", lw=0
        )
    for bound in bounds:
        panel.axhline(bound, color="0.5", lw=0.6)
    for x, part in enumerate(parts):
        effect, colour = part.effect, VERDICT_COLOURS.get(part.verdict, "0.9")
        if math.isnan(effect.mean):
            panel.text(x, low, "–", ha="center", va="bottom", color="0.5")
            continue
        if not math.isnan(effect.low):
            panel.plot([x, x], [effect.low, effect.high], color=colour, lw=1.4)
        panel.plot(x, effect.mean, "o", ms=3, color=colour, mec="black", mew=0.4)
    panel.set_title(words(parts), loc="left", fontsize=7, pad=2)
    panel.tick_params(axis="x", length=0, labelbottom=False)


def _choices(panel, readings: list[Reading], numbers: list[int], found: list[Influence]) -> None:
    colours = matplotlib.colormaps[SEQUENTIAL]
    for row, influence in enumerate(found):
        choice = influence.choice
        for x, reading in enumerate(readings):
            place = choice.place(getattr(reading, choice.name))
            panel.plot(x, row, "s", ms=4, color=colours(0.95 * place), mew=0)
        panel.text(
            len(readings) - 0.2,
            row,
            _words(influence),
            va="center",
            fontsize=6,
            weight="bold" if influence.p < SIGNIFICANT else "normal",
        )
    panel.set_yticks(range(len(found)), [_range(i.choice) for i in found], fontsize=6)
    panel.set_ylim(len(found) - 0.4, -0.6)
    panel.set_xticks(range(len(numbers)), [str(n) for n in numbers], fontsize=5)
    panel.set_xlabel("reading (0 is the study's)")
    panel.spines[:].set_visible(False)
    panel.tick_params(length=0)


def _words(influence: Influence) -> str:
    if np.isnan(influence.correlation):
        return ""
    p = "p < 0.001" if influence.p < 0.001 else f"p = {influence.p:.2g}"
    return f"ρ {influence.correlation:+.2f}".replace("-", "−") + f", {p}"


def _range(choice: AnalysisChoice) -> str:
    def word(value) -> str:
        known = {True: "yes", False: "no", math.inf: "plateau"}
        return known[value] if isinstance(value, bool) or value == math.inf else f"{value}"

    first, last = word(choice.values[0]), word(choice.values[-1])
    return f"{choice.label}, {first} … {last}"
