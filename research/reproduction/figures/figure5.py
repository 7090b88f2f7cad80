"""Fig. 5 of the paper: the actuation surfaces of eight controllers, and their limit cycles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from research.frame import markdown_table
from research.reproduction.best_gait import best_run, recorded_controller, recorded_orbit
from research.reproduction.claims.designs import DRIVES
from research.reproduction.record import Record
from research.reproduction.table import StudyTable, record_place
from tegotae._support.errors import TegotaeError
from tegotae.analysis.orbit import Orbit
from tegotae.analysis.surface import Surface, actuation_surface
from tegotae.figures.cycles import broken, draw_path, phase_axis
from tegotae.figures.style import COLOURS, PAGE_IN, SEQUENTIAL, new_figure, styled
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.parts.bodies import Hopper

PANELS = (
    ("I", "V", "f"),
    ("II", "V", "φ"),
    ("III", "VT", "φ"),
    ("IV", "VG", "f"),
    ("V", "AR", "f"),
    ("VI", "ARG", "φ"),
    ("VII", "ART", "φf"),
    ("VIII", "ARGT", "f"),
)
"""Number, architecture and input of the actuation of each panel. The paper's text names those of I
(reflex), II (sector), IV (a gain on vanilla terms), VI (actuation coupled to the oscillator), VII
and VIII (actuation by feedback); III and V are the architectures that then remain."""

NORMALISED = ("cot_inverse", "t0_s", "t1_s", "cpgu")
"""Metrics that stand above a panel, from 0 (lowest of all runs) to 1 (highest)."""
SHARES = ("feedback_share", "phase_share")
"""Metrics shown beside them as they are."""

_ROWS = 90


@dataclass(frozen=True)
class PolicyPanel:
    """One panel: a model's best run.

    Args:
        number: the paper's, such as "IV".
        architecture: of the model.
        drive: what the actuation follows, "φ", "f" or "φf".
        model: the model's name.
        run: the run of highest fitness.
        surface: its actuation surface.
        orbit: its limit cycle at the training frequency.
        metrics: its `NORMALISED` and `SHARES`, by name.
        max_force_n: largest actuator force α [N].
    """

    number: str
    architecture: str
    drive: str
    model: str
    run: int
    surface: Surface
    orbit: Orbit
    metrics: dict[str, float]
    max_force_n: float


def policy_panels(records: Sequence[Record], table: StudyTable) -> list[PolicyPanel]:
    """Return the panels that a study has runs for: on [F_k], of the best fitness among those that
    settle.

    Args:
        records: of the study.
        table: their table, a row a run.
    """
    panels = []
    for number, architecture, drive in PANELS:
        matching = [
            record
            for record in records
            if (labels := record_place(record))["architecture"] == architecture
            and labels["observation"] == "F"
            and DRIVES.get(labels["actuation"]) == drive
            and isinstance(record.experiment.body, Hopper)
        ]
        for record in sorted(matching, key=lambda candidate: -float(candidate.best_fitness.max())):
            orbit = recorded_orbit(record) if record.gait else None
            if orbit is not None:
                panels.append(_panel(number, architecture, drive, record, orbit, table))
                break
    return panels


def _panel(
    number: str, architecture: str, drive: str, record: Record, orbit: Orbit, table: StudyTable
) -> PolicyPanel:
    run = best_run(record.best_fitness)
    saved = recorded_controller(record, run)
    body = saved.body
    assert isinstance(body, Hopper)
    limit_n = min(1.1 * float(orbit.spring_force_n.max()), body.most_spring_n)
    row = int(np.flatnonzero((table["model"] == record.model) & (table["run"] == run))[0])
    return PolicyPanel(
        number,
        architecture,
        drive,
        record.model,
        run,
        actuation_surface(saved, np.linspace(0.0, limit_n, _ROWS), columns=_ROWS),
        orbit,
        _normalised(table, row),
        float(body.max_force_n),
    )


def _normalised(table: StudyTable, row: int) -> dict[str, float]:
    numbers = {}
    for name in NORMALISED:
        values = table[name]
        lowest, highest = np.nanmin(values), np.nanmax(values)
        numbers[name] = (
            float((values[row] - lowest) / (highest - lowest)) if highest > lowest else np.nan
        )
    return numbers | {n: float(table[n][row]) for n in SHARES if n in table.columns}


def policies_figure(panels: Sequence[PolicyPanel]) -> Figure:
    """Draw two plots per panel: F_a over phase and spring force with the limit cycle; F_a and f
    below.

    Raises:
        TegotaeError: if there is no panel.
    """
    if not panels:
        raise TegotaeError("no model of the study settles that Fig. 5 has a panel for")
    across = min(4, len(panels))
    rows = -(-len(panels) // across)
    with styled():
        figure = new_figure(PAGE_IN, 0.4 + 2.9 * rows)
        axes = figure.subplots(2 * rows, across, squeeze=False, height_ratios=(1.5, 1.0) * rows)
        for unused in range(len(panels), rows * across):
            for part in range(2):
                axes[2 * (unused // across) + part, unused % across].set_visible(False)
        for i, panel in enumerate(panels):
            row, column = divmod(i, across)
            _surface(axes[2 * row, column], panel, column == 0)
            _cycle(axes[2 * row + 1, column], panel, column == 0, column == across - 1)
        shade = ScalarMappable(Normalize(0.0, 1.0), SEQUENTIAL)
        label, ticks = "force $F_a/\\alpha$ of the surfaces", (0.0, 0.5, 1.0)
        figure.colorbar(shade, ax=axes, label=label, ticks=ticks, shrink=0.5)
        figure.legend(
            handles=[
                Line2D([], [], color=COLOURS[0], label="force $F_a/\\alpha$"),
                Line2D([], [], color=COLOURS[4], label="feedback f [rad/s]"),
            ],
            loc="outside lower center",
            ncols=2,
        )
    return figure


def policies_table(panels: Iterable[PolicyPanel]) -> str:
    """Return one row per panel: its model and run, its metrics as Fig. 5 normalises them, and the
    shares.
    """
    names = (*NORMALISED, *SHARES)
    rows = [["", "Model", *(HOPPING.find(name).label for name in names)]]
    for panel in panels:
        values = [panel.metrics.get(name, np.nan) for name in names]
        name = f"{panel.model}, run {panel.run}"
        rows.append([panel.number, name, *map(_number, values)])
    return markdown_table(rows)


def _surface(axes: Axes, panel: PolicyPanel, labelled: bool) -> None:
    surface = panel.surface
    assert surface.phase_rad is not None  # the single network has no panel
    axes.pcolormesh(
        surface.phase_rad,
        surface.spring_force_n,
        surface.actuator_force_n,
        vmin=0.0,
        vmax=panel.max_force_n,
        cmap=SEQUENTIAL,
        rasterized=True,
    )
    draw_path(axes, broken(panel.orbit.phase_rad), panel.orbit.spring_force_n)
    phase_axis(axes, "")
    axes.tick_params(labelbottom=False, labelsize=6)
    axes.set_ylim(0.0, surface.spring_force_n[-1])
    if labelled:
        axes.set_ylabel("$F_k$ [N]")
    words = [
        f"{HOPPING.find(name).label} {_number(value)}" for name, value in panel.metrics.items()
    ]
    lines = [f"{panel.number}. {panel.architecture}, T({panel.drive})"]
    lines += [", ".join(words[i : i + 2]) for i in range(0, len(words), 2)]
    axes.set_title("\n".join(lines), fontsize=6)


def _cycle(axes: Axes, panel: PolicyPanel, left: bool, right: bool) -> None:
    order = np.argsort(panel.orbit.phase_rad)
    phase = panel.orbit.phase_rad[order]
    axes.plot(
        phase, panel.orbit.actuator_force_n[order] / panel.max_force_n, ".", ms=1, color=COLOURS[0]
    )
    axes.set_ylim(-0.05, 1.05)
    feedback = axes.twinx()
    feedback.plot(phase, panel.orbit.feedback_rad_per_s[order], ".", ms=1, color=COLOURS[4])
    largest = max(float(np.abs(panel.orbit.feedback_rad_per_s).max()), 0.1)
    feedback.set_ylim(-1.1 * largest, 1.1 * largest)
    for panel_axes in (axes, feedback):
        panel_axes.tick_params(labelsize=6)
    phase_axis(axes)
    if left:
        axes.set_ylabel("$F_a/\\alpha$")
    if right:
        feedback.set_ylabel("f [rad/s]")


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"
