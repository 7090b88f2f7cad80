"""The claims over the readings of the paper: an overview, and a specification curve per claim."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from research.reproduction.calibration.prior import relative_place
from research.reproduction.claims.counting import ALL
from research.reproduction.claims.estimates import EffectEstimate
from research.reproduction.claims.findings import (
    OPPOSITE,
    REPRODUCED,
    SELECTED_FOR,
    TOO_SMALL,
    Finding,
)
from research.reproduction.figures.calibration import value_label
from research.reproduction.readings.designs import selecting
from research.reproduction.readings.influence import SIGNIFICANT, Influence, influences
from research.reproduction.readings.readings import AnalysisChoice, Reading
from research.reproduction.readings.verdicts import (
    CLAIMS,
    FindingsByReading,
    of_claim,
    outcome_counts,
)
from research.reproduction.report.atomic import effect_in_words
from tegotae.figures.style import COLOURS, PAGE_IN, SEQUENTIAL, new_figure, styled
from tegotae.measures.statistics import share_interval

OUTCOME_COLOURS = {REPRODUCED: COLOURS[5], TOO_SMALL: "0.75", OPPOSITE: COLOURS[4]}
"""Green is reproduced, grey too small to tell, orange opposite; they differ in lightness, too."""

_SELECTED = COLOURS[0]
"""Instead of green where the readings were chosen to agree with a claim."""


def overview_figure(
    readings: Sequence[Reading], by_reading: FindingsByReading, omega: str = ALL
) -> Figure:
    """Draw, for each claim, the share of readings in which it is reproduced, and the choices
    correlated with it.

    Left: how many readings say what; the line below a bar is the 95 % interval of the share that
    agrees. Right: how each choice correlates with the claim's margin, in numbers
    where that is more than chance. Claims that no reading measures are left out.

    Args:
        readings: all readings.
        by_reading: what comes of the claims under each.
        omega: on which ω_t, "both", "4" or "8".
    """
    by_claim = {claim.name: of_claim(by_reading, claim.name, omega) for claim in CLAIMS}
    by_claim = {name: findings for name, findings in by_claim.items() if findings}
    selected = selecting(readings)
    with styled():
        figure = new_figure(PAGE_IN, 1.2 + 0.21 * len(by_claim))
        bars, matrix = figure.subplots(1, 2, width_ratios=(1.0, 1.7), sharey=True)
        for row, (name, findings) in enumerate(by_claim.items()):
            agreeing = _SELECTED if name in selected else OUTCOME_COLOURS[REPRODUCED]
            _bar(bars, row, list(findings.values()), OUTCOME_COLOURS | {REPRODUCED: agreeing})
        titles = [claim.title for claim in CLAIMS if claim.name in by_claim]
        bars.set_yticks(range(len(by_claim)), titles, size=6)
        bars.set(xlim=(0.0, 1.0), ylim=(len(by_claim) - 0.45, -0.55), xlabel="share of readings")
        bars.tick_params(axis="y", length=0)
        figure.legend(
            handles=_handles(selected=any(name in selected for name in by_claim)),
            loc="outside upper left",
            ncols=5,
            handlelength=1.0,
        )
        _matrix(figure, matrix, [influences(readings, findings) for findings in by_claim.values()])
    return figure


def _handles(*, selected: bool) -> list[Patch | Line2D]:
    colours = OUTCOME_COLOURS | ({SELECTED_FOR: _SELECTED} if selected else {})
    patches: list[Patch | Line2D] = [Patch(color=c, label=word) for word, c in colours.items()]
    bar = Line2D([], [], color="black", lw=1.0, label="95 % interval of the left share")
    return [*patches, bar]


def _bar(panel, row: int, findings: list[Finding], colours: Mapping[str, str]) -> None:
    start = 0.0
    counts = outcome_counts(findings)
    total = sum(counts.values())
    for word, colour in colours.items():
        count = counts[word]
        if not count:
            continue
        share = count / total
        panel.barh(row, share, left=start, height=0.7, color=colour, lw=0)
        ink = "black" if word == TOO_SMALL else "white"
        panel.text(start + share / 2, row, f"{count}", ha="center", va="center", color=ink, size=6)
        start += share
    if total:
        reproduced = share_interval(counts[REPRODUCED], total)
        ends = [reproduced.low, reproduced.high]
        panel.plot(ends, [row + 0.43] * 2, color="black", lw=1.0, clip_on=False)


def _matrix(figure: Figure, panel, rows: list[list[Influence]]) -> None:
    values = np.array([[i.correlation for i in row] for row in rows])
    image = panel.imshow(values, cmap="PuOr", vmin=-1.0, vmax=1.0, aspect="auto")
    labels = [influence.choice.label for influence in rows[0]]
    panel.set_xticks(range(len(labels)), labels, rotation=45, ha="right")
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    for row, entries in enumerate(rows):
        for column, influence in enumerate(entries):
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
        panel.text(x, y, text, ha="center", va="center", size=5, weight="bold", color=ink)


def curve_figure(readings: Sequence[Reading], findings: Mapping[int, Finding]) -> Figure:
    """Draw one claim under every reading: its effect, sorted, and the choices behind each.

    Above, every effect and its interval in the colour of its outcome, with the claimed side of zero
    shaded. Below, what each reading chooses: dark is the first value of a choice or the low end of
    its range, light the last; at the right, how it goes with the claim.

    Args:
        readings: all readings.
        findings: what comes of the claim, by the number of the reading, at least one.
    """
    claim = next(iter(findings.values())).claim
    order = sorted(findings, key=lambda n: _key(_first(findings[n])))
    with styled():
        figure = new_figure(PAGE_IN, 3.1)
        figure.suptitle(claim.title, x=0.01, ha="left", fontsize=8, weight="bold")
        effects, choices = figure.subplots(2, 1, height_ratios=(1.0, 1.5), sharex=True)
        _effects(effects, [findings[n] for n in order])
        effects.set_title(effect_in_words(claim.effect), loc="left", fontsize=7, pad=2)
        _choices(choices, [readings[n] for n in order], order, influences(readings, findings))
    return figure


def _first(finding: Finding) -> EffectEstimate:
    return next(iter(finding.by_count.values()))


def _key(estimate: EffectEstimate) -> float:
    return estimate.effect if estimate.is_known else -math.inf


def _effects(panel, findings: list[Finding]) -> None:
    defined = [estimate for estimate in map(_first, findings) if estimate.is_known]
    # The effects decide the scale: one interval of two runs must not press all others flat.
    inside = [0.0, *(estimate.effect for estimate in defined)]
    room = 0.5 * (max(inside) - min(inside) or 1.0)
    low = max(min([*inside, *(estimate.low for estimate in defined)]), min(inside) - room)
    high = min(max([*inside, *(estimate.high for estimate in defined)]), max(inside) + room)
    edge = 0.06 * (high - low or 1.0)
    low, high = low - edge, high + edge
    panel.set_ylim(low, high)
    panel.axhspan(*((0.0, high) if findings[0].claim.sign > 0 else (low, 0.0)), color="0.93", lw=0)
    panel.axhline(0.0, color="0.5", lw=0.6)
    for x, finding in enumerate(findings):
        estimate, colour = _first(finding), OUTCOME_COLOURS.get(finding.outcome, "0.9")
        if not estimate.is_known:
            panel.text(x, low, "–", ha="center", va="bottom", color="0.5")
            continue
        panel.plot([x, x], [estimate.low, estimate.high], color=colour, lw=1.4)
        panel.plot(x, estimate.effect, "o", ms=3, color=colour, mec="black", mew=0.4)
    panel.tick_params(axis="x", length=0, labelbottom=False)


def _choices(panel, readings: list[Reading], numbers: list[int], entries: list[Influence]) -> None:
    colours = matplotlib.colormaps[SEQUENTIAL]
    for row, influence in enumerate(entries):
        choice = influence.choice
        for x, reading in enumerate(readings):
            position = relative_place(choice, getattr(reading, choice.name))
            panel.plot(x, row, "s", ms=4, color=colours(0.95 * position), mew=0)
        panel.text(
            len(readings) - 0.2,
            row,
            _words(influence),
            va="center",
            fontsize=6,
            weight="bold" if influence.p < SIGNIFICANT else "normal",
        )
    panel.set_yticks(range(len(entries)), [_range(i.choice) for i in entries], fontsize=6)
    panel.set_ylim(len(entries) - 0.4, -0.6)
    panel.set_xticks(range(len(numbers)), [str(n) for n in numbers], fontsize=5)
    panel.set_xlabel("reading" + (" (0 is the study's)" if Reading() in readings else ""))
    panel.spines[:].set_visible(False)
    panel.tick_params(length=0)


def _words(influence: Influence) -> str:
    if np.isnan(influence.correlation):
        return ""
    p = "p < 0.001" if influence.p < 0.001 else f"p = {influence.p:.2g}"
    return f"ρ {influence.correlation:+.2f}".replace("-", "−") + f", {p}"


def _range(choice: AnalysisChoice) -> str:
    labels = {True: "yes", False: "no", math.inf: "plateau"}

    def word(value) -> str:
        is_known = isinstance(value, bool) or value == math.inf
        return labels[value] if is_known else value_label(choice.name, value)

    return f"{choice.label}, {word(choice.values[0])} … {word(choice.values[-1])}"
