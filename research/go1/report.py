"""Tables and figures of Go1's laws, from the kept rows."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure

from research.frame import markdown_table, write_rows, write_text
from research.go1.plan import (
    ADAPTED,
    BALANCED,
    CHECKS,
    CONDITIONS,
    FOLDER,
    HARD,
    LAWS,
    OPEN_LOOP,
    PPO,
    RANDOM_PHASES,
    SELECTED,
    SPEEDS,
    UNDISTURBED,
    Law,
)
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.statistics import share_interval

SLOW = 0.5
"""A law lags below this share of the commanded speed."""
ASTRAY_RAD = math.pi / 2
"""A heading that is farther than this from that of the start is lost."""


def report() -> None:
    """Write the tables and figures of the page."""
    records, checks = pd.read_csv(FOLDER / "rows.csv"), pd.read_csv(FOLDER / "checks.csv")
    write_text(FOLDER / "speeds.md", laws_table(records))
    write_text(FOLDER / "headings.md", headings(records))
    write_text(FOLDER / "checks.md", checks_table(records, checks))
    save_figure(figure(records), FOLDER / "speeds.png")
    save_figure(frontier(records), FOLDER / "frontier.png")
    costs = cost_at(reached(records[records.law == PPO]), records).rename("cost_of_transport")
    write_rows(FOLDER / "equal_speeds.csv", costs.reset_index().to_dict("records"), digits=4)


def checks_table(records: pd.DataFrame, checks: pd.DataFrame) -> str:
    """Return the falls of the final law under the conditions of the checks, of all runs and of
    the selected one.
    """
    rows = records[(records.law == ADAPTED) & records.condition.isin(HARD)]
    falls = checks.groupby("check").fell.mean()
    selected = rows[rows.run == SELECTED].fell.mean()
    cells = [rows.fell.mean(), selected, *(falls[name] for name in CHECKS)]
    head = ["starts of the table, all runs", "selected run", *CHECKS]
    return markdown_table([head, [f"{share:.1%}" for share in cells]])


def behind(rows: pd.DataFrame) -> pd.Series:
    """Return True for episodes without a fall whose speed is below half of the command."""
    return (rows.fell == 0) & (rows.speed_m_per_s < SLOW * rows.wanted_m_per_s)


def reached(rows: pd.DataFrame) -> np.ndarray:
    """Return the mean speeds [m/s] of a law on the undisturbed robot, by command."""
    undisturbed = rows[rows.condition == UNDISTURBED]
    return undisturbed.groupby("wanted_m_per_s").speed_m_per_s.mean().to_numpy()


def cost_at(speeds: np.ndarray, rows: pd.DataFrame) -> pd.Series:
    """Return the mean cost of transport at these speeds [m/s] on the undisturbed robot, of every
    law and run.

    It is linear between the speeds of two commands; what is slower than the fastest of these speeds
    has the cost of its own fastest there.
    """
    upright = rows[(rows.condition == UNDISTURBED) & (rows.fell == 0)]
    means = upright.groupby(["law", "run", "wanted_m_per_s"])[
        ["speed_m_per_s", "cost_of_transport"]
    ]
    runs = means.mean().groupby(["law", "run"], sort=False)
    return runs.apply(lambda x: np.interp(speeds, x.speed_m_per_s, x.cost_of_transport).mean())


def laws_table(records: pd.DataFrame) -> str:
    """Return one row per law: all conditions but random phases, whose falls have a column of their
    own.
    """
    head = ["law", "sensors", "parameters", "falls [95 % interval]", "random phases", "speed [m/s]"]
    head += ["lags", "CoT, at PPO's speeds"]
    lines, speeds = [head], reached(records[records.law == PPO])
    for name, law in LAWS.items():
        rows = records[records.law == name]
        lines.append([f"{name} ({rows.run.nunique()})", *line_of(law, rows, speeds)])
        if name in (BALANCED, ADAPTED):
            lines.append(["· selected run", *line_of(law, rows[rows.run == SELECTED], speeds)])
    return markdown_table(lines)


def astray(rows: pd.DataFrame) -> pd.Series:
    """Return True for episodes without a fall that end more than 90° off the initial heading."""
    return rows.heading_rad.abs() > ASTRAY_RAD


def headings(records: pd.DataFrame) -> str:
    """Return one row per law: the headings at the end of episodes, under all conditions but random
    phases.
    """
    share, runs = "more than 90° off [95 % interval]", "episodes of each run"
    lines = [["law", share, runs, "median error [rad]", "undisturbed"]]
    from_trot = records[records.condition != RANDOM_PHASES]
    for name in LAWS:
        rows = from_trot[from_trot.law == name]
        off_course, error = astray(rows), rows.heading_rad.abs()
        off = share_interval(int(off_course.sum()), len(rows))
        lines.append(
            [
                f"{name} ({rows.run.nunique()})",
                f"{off.mean:.1%} [{off.low:.1%}, {off.high:.1%}]",
                " ".join(map(str, off_course.groupby(rows.run).sum())),
                f"{error.median():.2f}",
                f"{error[rows.condition == UNDISTURBED].median():.2f}",
            ]
        )
    return markdown_table(lines)


def line_of(law: Law, rows: pd.DataFrame, speeds: np.ndarray) -> list[str]:
    """Return the table's line for rows of a law, with its cost at these speeds, too."""
    from_trot, free = (
        rows[rows.condition != RANDOM_PHASES],
        rows[rows.condition == RANDOM_PHASES],
    )
    undisturbed = rows[rows.condition == UNDISTURBED]
    fell = share_interval(int(from_trot.fell.sum()), len(from_trot))
    by_command = undisturbed.groupby("wanted_m_per_s").speed_m_per_s.mean()
    cost = undisturbed.cost_of_transport.mean()
    return [
        law.senses,
        str(law.parameters),
        f"{fell.mean:.1%} [{fell.low:.1%}, {fell.high:.1%}]",
        f"{free.fell.mean():.0%}",
        " ".join(f"{x:.2f}" for x in by_command),
        f"{behind(from_trot).mean():.1%}",
        f"{cost:.2f}, {cost_at(speeds, undisturbed).mean():.2f}",
    ]


@styled()
def figure(rows: pd.DataFrame) -> Figure:
    """Draw one row per law: falls under every condition; speed and cost on the undisturbed
    robot.
    """
    names = list(LAWS)
    drawn = new_figure(PAGE_IN, 0.3 * PAGE_IN + 0.17 * len(names))
    falls, *gait = drawn.subplots(1, 3, sharey=True, width_ratios=(2.0, 1.0, 1.0))
    shares = rows.groupby(["law", "condition"]).fell.mean().unstack()
    shares = shares.reindex(index=names, columns=list(CONDITIONS))
    image = falls.imshow(shares, vmin=0.0, vmax=1.0, cmap="magma_r", aspect="auto")
    falls.set_xticks(range(len(CONDITIONS)), list(CONDITIONS), rotation=90)
    falls.set_yticks(range(len(names)), names)
    titles = {"speed_m_per_s": "speed [m/s]", "cost_of_transport": "cost of transport"}
    means = (
        rows[rows.condition == UNDISTURBED].groupby(["law", "wanted_m_per_s"])[list(titles)].mean()
    )
    shades = colormaps["viridis"](np.linspace(0.9, 0.1, len(SPEEDS)))
    for axes, (column, title) in zip(gait, titles.items(), strict=True):
        pivot = means[column].unstack().reindex(names)
        axes.hlines(range(len(names)), 0.0, pivot.max(axis=1), color="0.85", lw=1.0, zorder=0)
        for x, shade in zip(SPEEDS, shades, strict=True):
            axes.plot(pivot[x], range(len(names)), "o", color=shade, ms=3.5, label=f"{x:g}")
        axes.set(xlabel=title, xlim=(0.0, None))
    drawn.colorbar(image, ax=falls, label="share that falls in 30 s", location="top", aspect=30)
    drawn.legend(
        *gait[0].get_legend_handles_labels(),
        title="commanded [m/s]",
        loc="upper right",
        ncols=len(SPEEDS),
        columnspacing=0.8,
        handletextpad=0.1,
    )
    return drawn


@styled()
def frontier(rows: pd.DataFrame) -> Figure:
    """Draw falls over cost at the same speeds, one dot per run."""
    drawn = new_figure(0.7 * PAGE_IN, 0.45 * PAGE_IN)
    axes = drawn.subplots()
    from_trot = rows[rows.condition != RANDOM_PHASES]
    runs = from_trot.groupby(["law", "run"]).fell.mean().to_frame()
    runs["cost"] = cost_at(reached(rows[rows.law == PPO]), rows)
    titles = {
        PPO: "PPO",
        OPEN_LOOP: OPEN_LOOP,
        BALANCED: "balance reflexes",
        ADAPTED: "with step adaptation",
    }
    for law, title in titles.items():
        axes.plot(runs.loc[law].cost, runs.loc[law].fell, "o", ms=4, label=title)
    axes.set(
        xlabel="cost of transport at PPO's speeds",
        ylabel="share that falls in 30 s",
        ylim=(-0.005, None),
    )
    axes.legend()
    return drawn
