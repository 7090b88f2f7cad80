"""The calibration on V: which readings agree, which statements exclude each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from research.reproduction.calibration.posterior import CalibrationPosterior
from research.reproduction.calibration.prior import LOGARITHMIC, PRIOR, relative_place
from research.reproduction.readings.readings import AnalysisChoice, Reading
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, styled
from tegotae.measures.objectives.fitness import HERTZ

_COLUMNS = 4
_BINS = 8
_INKS = ("0.25", COLOURS[0], COLOURS[4])


def posterior_figure(
    places: np.ndarray,
    posteriors: Mapping[str, CalibrationPosterior],
    standard: Reading,
    program: Reading,
) -> Figure:
    """Draw each choice's posterior beside its prior, in the order of `PRIOR`.

    Grey is the prior, each line the posterior by one strictness. A black triangle marks the study's
    own reading, a green one that of the co-author's program.

    Args:
        places: where all readings lie, [readings, choices].
        posteriors: posteriors by name.
        standard: the study's reading.
        program: the reading of the co-author's program.
    """
    rows = -(-len(PRIOR) // _COLUMNS)
    marks = ((standard, "black", 7, "the study's"), (program, COLOURS[5], 4, "co-author's program"))
    with styled():
        figure = new_figure(PAGE_IN, 1.45 * rows)
        panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
        for i, (choice, panel) in enumerate(zip(PRIOR, panels, strict=False)):
            edges = _edges(choice)
            _steps(panel, edges, places[:, i], np.ones(len(places)), "prior", fill=True)
            for name, ink in zip(posteriors, _INKS, strict=False):
                posterior = posteriors[name]
                _steps(
                    panel, edges, places[posterior.accepted, i], posterior.weights, name, ink=ink
                )
            for reading, ink, size, name in marks:
                position = np.clip(coordinates_of(choice, reading), 0.0, 1.0)
                panel.plot(
                    position, 0.0, "^", color=ink, ms=size, clip_on=False, label=name, zorder=5
                )
            _ticks(panel, choice)
            panel.set_title(choice.label, size=8)
            panel.set(ylim=(0.0, None), yticks=[])
        for panel in panels[len(PRIOR) :]:
            panel.set_visible(False)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def coordinates_of(choice: AnalysisChoice, reading: Reading) -> float:
    """Return a reading's position in one choice, from 0 to 1; beyond where it is outside the
    prior."""
    return relative_place(choice, getattr(reading, choice.name))


def _edges(choice: AnalysisChoice) -> np.ndarray:
    if not choice.levels:
        return np.linspace(0.0, 1.0, _BINS + 1)
    step = 1.0 / (len(choice.values) - 1)
    return np.linspace(-0.5 * step, 1.0 + 0.5 * step, len(choice.values) + 1)


def _steps(
    panel, edges: np.ndarray, x: np.ndarray, weights: np.ndarray, name: str, *, fill=False, ink=""
) -> None:
    counts, _ = np.histogram(x, edges, weights=weights / weights.sum())
    look = {"color": "0.88"} if fill else {"color": ink, "lw": 1.2}
    panel.stairs(counts * (len(edges) - 1), edges, fill=fill, label=name, **look)


def _ticks(panel, choice: AnalysisChoice) -> None:
    if choice.levels:
        places = [choice.place(value) for value in choice.values]
        panel.set_xticks(
            places, [value_label(choice.name, value) for value in choice.values], size=6
        )
    else:
        low, high = choice.values
        middle = (low * high) ** 0.5 if choice.name in LOGARITHMIC else 0.5 * (low + high)
        values = [low, HERTZ if choice.name == "frequency_weight" else middle, high]
        names = [f"{value:.2g}" for value in values]
        if choice.name == "frequency_weight":
            names[1] = "Hz²"
        panel.set_xticks([relative_place(choice, value) for value in values], names, size=6)


def value_label(name: str, value: object) -> str:
    """Return the text of a choice's value beside an axis."""
    words = {
        ("flight_damping", 0.0): "no",
        ("flight_damping", 1.0): "yes",
        ("sector_s", None): "in phase",
    }
    if (name, value) in words:
        return words[name, value]
    if name == "sector_start":
        return f"{value / np.pi:.2f}π"  # type: ignore[operator]
    if name == "sector_s":
        return f"{value:.3f} s"
    if isinstance(value, tuple):
        return "ω_t" if value == (0.0,) else "five ω"
    return str(value)


def scores_figure(
    words: Sequence[str],
    spreads: Mapping[str, np.ndarray],
    marked: Mapping[str, np.ndarray],
    levels: Mapping[str, np.ndarray],
) -> Figure:
    """Draw the scores of readings, one row per statement, with the limit from which it counts as
    met.

    Args:
        words: the statements, short.
        spreads: by name, the quantiles 5 %, 50 % and 95 % over readings, [3, statements].
        marked: by name, the scores of single readings, [statements].
        levels: by strictness, from which score on each statement is met.
    """
    rows = np.arange(len(words))
    looks = (("0.75", 6.0, "|", 11), (COLOURS[0], 2.2, "o", 4))
    marks = (("^", "black"), ("^", "white"), ("s", COLOURS[4]), ("s", "white"))
    with styled():
        figure = new_figure(PAGE_IN, 0.33 * len(words) + 1.0)
        panel = figure.subplots()
        for (name, (low, middle, high)), (ink, width, mark, size) in zip(
            spreads.items(), looks, strict=False
        ):
            panel.hlines(rows - 0.14, low, high, color=ink, lw=width, label=f"{name}: 90 %, median")
            colour = "0.35" if mark == "|" else ink
            panel.plot(middle, rows - 0.14, mark, color=colour, ms=size, zorder=4)
        for (name, scores), (mark, fill) in zip(marked.items(), marks, strict=False):
            edge = "black" if mark == "^" else COLOURS[4]
            panel.plot(
                scores, rows + 0.24, mark, ms=4.5, mfc=fill, mec=edge, ls="", label=name, zorder=5
            )
        for (name, score), dashes in zip(levels.items(), (":", "--", "-"), strict=False):
            panel.vlines(
                score, rows - 0.42, rows + 0.42, color="0.3", lw=0.8, ls=dashes, label=name
            )
        panel.set_yticks(rows, words)
        panel.set(xlim=(-0.02, 1.02), ylim=(len(words) - 0.5, -0.5), xlabel="score")
        panel.tick_params(axis="y", length=0)
        figure.legend(loc="outside lower center", ncols=3)
    return figure


def statements_figure(
    words: Sequence[str], shares: Mapping[str, np.ndarray], together: np.ndarray
) -> Figure:
    """Draw the numbers of readings that meet each statement, and the statements that exclude each
    other.

    Left: the share of readings by strictness. Right: how often two are met together over how often
    they would be by chance, from never (orange) over as by chance (white) to twice or more
    (purple).

    Args:
        words: the statements, short.
        shares: by strictness, [statements].
        together: [statements, statements], NaN where one is never met.
    """
    n = len(words)
    with styled():
        figure = new_figure(PAGE_IN, 2.9)
        bars, matrix = figure.subplots(1, 2, width_ratios=(1.0, 1.15), sharey=True)
        height = 0.8 / len(shares)
        for i, ((name, share), ink) in enumerate(zip(shares.items(), _INKS, strict=False)):
            positions = np.arange(n) - 0.4 + (i + 0.5) * height
            bars.barh(positions, share, height=0.9 * height, color=ink, lw=0, label=name)
        bars.set_yticks(range(n), words)
        bars.set(xlim=(0.0, 1.0), ylim=(n - 0.45, -0.55), xlabel="share of readings")
        bars.tick_params(axis="y", length=0)
        bars.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, handlelength=1.0)
        off_diagonal = np.where(np.eye(n, dtype=bool), np.nan, together)
        image = matrix.imshow(off_diagonal, cmap="PuOr", vmin=0.0, vmax=2.0, aspect="auto")
        for row, column in np.ndindex(n, n):
            value = off_diagonal[row, column]
            if np.isfinite(value):
                ink = "white" if abs(value - 1.0) > 0.65 else "black"
                text = f"{value:.1f}"
                matrix.text(column, row, text, ha="center", va="center", size=6, color=ink)
        matrix.set_xticks(range(n), words, rotation=45, ha="right")
        matrix.tick_params(length=0)
        matrix.spines[:].set_visible(False)
        bar = figure.colorbar(image, label="met together / by chance", ticks=(0, 1, 2))
        bar.ax.spines[:].set_visible(False)
    return figure
