"""Draw the map of short laws, a row a body and command and a column a form of R; and make the
tables in Markdown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image
from scipy.ndimage import gaussian_filter

from research.frame import markdown_table, write_text
from research.law_map.laws import FORMS, TURN, height_of
from tegotae._support.files import read_arrays
from tegotae.figures.style import new_figure, save_figure, styled
from tegotae.study import MOST_BYTES, Arrays

INK, PAPER, MARK = "#e8e6e3", "#0b0b12", "#7fe3ff"
TITLE = "Random short laws   φ̇ = ω − a R(N) (cos(φ − p) + o)"
ROWS = {
    ("study", 4.0): ("hopper, ω = 4 rad/s", "CoT⁻¹ [m/J]", 1.3),
    ("study", 8.0): ("hopper, ω = 8 rad/s", "CoT⁻¹ [m/J]", 1.3),
    ("calibrated", 4.0): ("calibrated body, ω = 4 rad/s", "CoT⁻¹ [m/J]", 0.42),
    ("quadruped", 2.0): ("quadruped, ω = 2 √(g/l0)", "1 / cost of transport", 5.0),
}
"""Title, measure, and the end of its colours."""
COLUMNS = {
    "load": ("R = N", "offset o"),
    "latch": ("R ∝ N − N*", "N* [weight / legs]"),
    "decay": ("R = exp(−N / N₀)", "N₀ [weight / legs]"),
}
TICKS = {
    "load": (-1.0, 0.0, 1.0),
    "latch": (-3.0, -1.0, -0.3, 0.3, 1.0, 3.0),
    "decay": (0.1, 0.3, 1.0, 3.0, 10.0),
}
LOCKS = (0.5, 1.0, 1.5)
"""Rates over ω that have a contour."""
MARKS = {"load": "o", "offset": "s", "latch": "D", "decay": "^"}
"""Markers of laws that PGPE trained."""
HARDLY = 0.03
"""Smallest share of moving laws for which a contour of their rate is drawn."""
WIDE_IN = 8.4
"""Width of the figure of all maps."""
LECTURE = "study 4 "
"""Maps of the figure for a lecture."""


def draw_all(folder: Path) -> None:
    """Draw what the tables of a folder hold, and write them as Markdown."""
    texts = {"summary": summary_text, "named": named_text, "convergence": convergence_text}
    for name, text in texts.items():
        write_text(folder / f"{name}.md", text(pd.read_csv(folder / f"{name}.csv")))
    arrays = read_arrays(folder / "map.npz", MOST_BYTES)
    maps = {name: values.astype(float) for name, values in arrays.items()}
    laws = pd.read_csv(folder / "named.csv")
    one_row = {name: values for name, values in maps.items() if name.startswith(LECTURE)}
    figures = {"law_map": (maps, WIDE_IN), "lecture": (one_row, 5.8)}
    for name, (drawn, width_in) in figures.items():
        if drawn:
            with styled():
                file = save_figure(draw(drawn, laws, width_in), folder / f"{name}.png")
            with Image.open(file) as picture:  # a fifth of the bytes, and none to see
                small = picture.convert("RGB").quantize(255, dither=Image.Dither.NONE)
            small.save(file, optimize=True)


def summary_text(summary: pd.DataFrame) -> str:
    """Tabulate the results of each form's laws, and the positions of the best two hundredth of
    them."""
    head = ["body, ω", "R", "move; locked", "99 %", "best", "p / π", "shape", "rate / ω"]
    lines = [
        [
            f"{row.subject}, {row.omega:g}",
            row.form,
            f"{100.0 * row.moves:.1f} %; {100.0 * row.locked:.0f} %",
            f"{row.merit_99:.2f}",
            f"{row.merit_best_judged:.2f}",
            f"{row.top_place_rad / np.pi:+.2f} ({row.top_place_agreement:.2f})",
            f"{row.top_shape:.2f} [{row.top_shape_low:.2f}, {row.top_shape_high:.2f}]",
            f"{row.top_lock:.2f}",
        ]
        for row in summary.itertuples()
    ]
    return markdown_table([head, *lines])


def named_text(rows: pd.DataFrame) -> str:
    """Return the text on Tegotae's law, and on the trained ones beside it."""
    merits = ("merit, best", "median", "five commands, best", "median")
    lines = [["body", "ω", "law", "runs", *merits]]
    for (subject, omega, law), group in rows.groupby(["subject", "omega", "law"], sort=False):
        around = group.merit_around.dropna()
        values = (group.merit.max(), group.merit.median(), around.max(), around.median())
        cells = ("–" if np.isnan(value) else f"{value:.2f}" for value in values)
        lines.append([subject, f"{omega:g}", law, f"{len(group)}", *cells])
    return markdown_table(lines)


def convergence_text(convergence: pd.DataFrame) -> str:
    """Return the shares of laws that move, for half of the laws and all, and for some in longer
    episodes.
    """
    longer = ("1 ×", "2 ×", "4 ×", "same at 4 ×")
    lines = [["body, ω", "R", "half; all", "maps of both", *longer]]
    for row in convergence.itertuples():
        shares = (row.moves_half, row.moves, row.moves_1, row.moves_2, row.moves_4, row.same_4)
        half, full, *correlations = (f"{100.0 * share:.1f} %" for share in shares)
        name, maps = f"{row.subject}, {row.omega:g}", f"{row.map_correlation:.3f}"
        lines.append([name, row.form, f"{half}; {full}", maps, *correlations])
    return markdown_table(lines)


def draw(maps: Arrays, laws: pd.DataFrame, width_in: float = WIDE_IN) -> Figure:
    """Draw the figure of the existing maps; the narrower it is, the larger is its text beside
    them.
    """
    drawn_rows = [row for row in ROWS if f"{row[0]} {row[1]:g} load merit" in maps]
    narrow, row_in = width_in < WIDE_IN, 2.3 * width_in / WIDE_IN
    figure = new_figure(width_in, 1.45 + row_in * len(drawn_rows) + 0.25 * narrow)
    figure.set_layout_engine("none")
    figure.set_facecolor(PAPER)
    tall = figure.get_figheight()
    grid = figure.subplots(
        len(drawn_rows), 4, squeeze=False, width_ratios=(1.0, 1.0, 1.0, 0.045),
        gridspec_kw={"left": 0.095, "right": 0.92, "top": 1.0 - 0.75 / tall,
                     "bottom": (0.95 if narrow else 0.7) / tall,
                     "wspace": 0.42 if narrow else 0.27, "hspace": 0.1},
    )  # fmt: skip
    for panels, (subject, omega) in zip(grid, drawn_rows, strict=True):
        title, measure, upper = ROWS[subject, omega]
        rows = laws[(laws.subject == subject) & (laws.omega == omega)]
        for axes, form in zip(panels[:3], FORMS, strict=True):
            arrays = {
                n: maps[f"{subject} {omega:g} {form} {n}"] for n in ("merit", "moves", "lock")
            }
            image = _panel(axes, form, arrays, upper)
            _marks(axes, form, rows[rows.form == form])
        bar = figure.colorbar(image, cax=panels[3], ticks=_ticks(upper))
        bar.set_label(measure, color=INK)
        bar.outline.set_visible(False)
        bar.ax.tick_params(colors=INK, length=2)
        panels[0].annotate(
            title, (-0.33, 0.5), xycoords="axes fraction", rotation=90, ha="center", va="center",
            color=INK, fontsize=10,
        )  # fmt: skip
    for axes, form in zip(grid[0], FORMS, strict=False):
        axes.set_title(COLUMNS[form][0], color=INK, fontsize=10, pad=6)
    for panels in grid[:-1]:
        for axes in panels[:3]:
            axes.tick_params(labelbottom=False)
    for axes in grid[-1, :3]:
        axes.set_xlabel("place p of the cosine [rad]", color=INK)
    figure.text(0.5, 1.0 - 0.2 / tall, TITLE, color=INK, fontsize=12, ha="center", va="center")
    _legend(figure, ncols=4 if narrow else 7)
    return figure


def _ticks(upper: float) -> np.ndarray:
    step = next(step for step in (0.1, 0.25, 1.0) if upper < 6.0 * step)
    return np.arange(0.0, upper + 0.01, step)


def _centres(count: int, low: float, high: float) -> np.ndarray:
    return low + (np.arange(count) + 0.5) * (high - low) / count


def _panel(axes: Axes, form: str, arrays: Arrays, upper: float) -> QuadContourSet:
    """Draw the merit in colours, and the rate over ω as lines."""
    places, shapes = arrays["merit"].shape
    # The circle is closed at the panel's sides.
    x = _centres(places + 2, -np.pi - TURN / places, np.pi + TURN / places)
    y = _centres(shapes, 0.0, 1.0)
    y[[0, -1]] = 0.0, 1.0

    def smooth(values: np.ndarray, bins: float) -> np.ndarray:
        return gaussian_filter(values, bins, mode=("wrap", "nearest"))

    def closed(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values[-1:], values, values[:1]]).T

    axes.set_facecolor("black")
    merit = smooth(np.nan_to_num(arrays["merit"]), 0.8)
    levels = np.linspace(0.0, upper, 27)
    image = axes.contourf(x, y, closed(merit), levels, cmap="inferno", extend="max")
    moving = arrays["moves"] * np.isfinite(arrays["lock"])
    under = smooth(moving, 1.5)
    rate = smooth(moving * np.nan_to_num(arrays["lock"]), 1.5) / np.maximum(under, 1e-9)
    rates = closed(np.where(under > HARDLY, rate, np.nan))
    lines = axes.contour(x, y, rates, LOCKS, colors="white", linewidths=(0.5, 1.0, 0.5), alpha=0.8)
    axes.clabel(lines, fmt="%g", fontsize=5.5)
    axes.set(xlim=(-np.pi, np.pi), ylim=(0.0, 1.0))
    axes.set_yticks(height_of(form, np.array(TICKS[form])), [f"{tick:g}" for tick in TICKS[form]])
    axes.set_xticks(np.pi * np.array([-1, -0.5, 0, 0.5, 1]), ["−π", "−π/2", "0", "π/2", "π"])
    axes.set_ylabel(COLUMNS[form][1], color=INK, fontsize=7, labelpad=1)
    axes.tick_params(colors=INK, length=2)
    axes.spines[:].set_visible(False)
    return image


def _marks(axes: Axes, form: str, rows: pd.DataFrame) -> None:
    """Mark Tegotae's law, and the trained laws that hop or walk; and with R = N the laws whose
    feedback is zero at φ = -π/2, just before the push of the study's hopper."""
    if form == "load" and {*rows.subject} == {"study"}:
        place = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 64)
        axes.plot(place, height_of(form, np.sin(place)), **_ZERO)
    if form != "decay":
        axes.plot(0.0, 0.5, "*", ms=12, mfc=MARK, mec="black", mew=0.8, zorder=5)
    for law, mark in MARKS.items():
        laws = rows[(rows.law == law) & (rows.merit > 0.0)]
        height = np.clip(height_of(form, laws["shape"].to_numpy()), 0.0, 1.0)
        axes.plot(laws.place_rad, height, mark, **_STYLE, clip_on=False, zorder=4)


_ZERO = {"color": MARK, "ls": (0, (4, 3)), "lw": 0.9}
_STYLE = {"ms": 3.5, "mfc": MARK, "mec": "black", "mew": 0.5, "ls": ""}


def _legend(figure: Figure, ncols: int) -> None:
    star = Line2D([], [], marker="*", ms=9, mfc=MARK, mec="black", mew=0.6, ls="")
    trained = [Line2D([], [], marker=mark, **_STYLE) for mark in MARKS.values()]
    lines = [Line2D([], [], **_ZERO), Line2D([], [], color="white", lw=1.0)]
    laws = [f"{law}, trained" for law in MARKS]
    names = ["Tegotae's cosine", *laws, "o = sin p", "rate / ω"]
    figure.legend(
        [star, *trained, *lines], names, loc="lower center", ncols=ncols, labelcolor=INK,
        handletextpad=0.3, columnspacing=1.2,
    )  # fmt: skip
