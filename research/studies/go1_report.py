"""Tables and figure of Go1's study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from go1_plan import (
    AGENTS,
    BEST,
    CONDITIONS,
    LAWS,
    OMEGAS,
    OUT,
    OWN_STRIDE,
    POPULATION,
    RUNS,
    SEEDS,
    TRAINED_S,
    again_of,
)
from kept import write_rows, write_text
from tegotae._support.tables import read_csv
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.statistics import interval

LEARNED = (*LAWS, *AGENTS)
WALKS_M_PER_S = 0.05
"""A slower law has no cost of transport."""
ALL = (BEST, OWN_STRIDE, *LEARNED)


def report() -> None:
    """Write the tables and figures from the kept results; the curves from the runs, if they are
    here."""
    rows = [row for name in LEARNED for row in curve(name)]
    write_rows(OUT / "go1_curves.csv", rows, digits=4, by=("law",))
    write_text(OUT / "go1_judged.md", judged_text())
    write_text(OUT / "go1_conditions.md", conditions_text())
    picture()


def curve(name: str) -> list[dict[str, Any]]:
    """Return per second over simulated time: of the search's centre, or of the agent's mean."""
    rows: list[dict[str, Any]] = []
    for seed in SEEDS:
        if (file := RUNS / name / f"seed{seed}" / "curves.csv").exists():
            for k, value in enumerate(read_csv(file)["fitness"].astype(float)):
                time_s = k * POPULATION * len(OMEGAS) * TRAINED_S
                rows.append(point(name, seed, time_s, value))
        if (file := RUNS / name / f"seed{seed}.npz").exists():
            with np.load(file) as record:
                pairs = zip(record["time_s"], record["fitness"], strict=True)
                rows += [point(name, seed, *map(float, pair)) for pair in pairs]
    return rows


def point(law: str, seed: int, time_s: float, fitness: float) -> dict[str, Any]:
    """A point of a curve."""
    return {"law": law, "seed": seed, "time_s": time_s, "return_per_s": fitness / TRAINED_S}


def numbers(column: np.ndarray) -> np.ndarray:
    """A column's numbers; NaN where there is none."""
    return np.array([float(x) if x else np.nan for x in column])


def of_seeds(law: str, condition: str, column: str) -> list[float]:
    """A number of a law under a condition, mean over frequencies; one for each seed."""
    table = read_csv(OUT / "go1_judged.csv")
    mask = (table["law"] == law) & (table["condition"] == condition)
    values = numbers(table[column])[mask]
    seeds = table["seed"][mask]
    return [float(np.mean(values[seeds == seed])) for seed in dict.fromkeys(seeds)]


def cost_of_seeds(law: str, condition: str) -> list[float]:
    """The cost of transport over all frequencies together; NaN for a seed that hardly moves."""
    table = read_csv(OUT / "go1_judged.csv")
    mask = (table["law"] == law) & (table["condition"] == condition)
    costs = []
    for seed in dict.fromkeys(table["seed"][mask]):
        rows = np.flatnonzero(mask & (table["seed"] == seed))
        speed = table["speed_m_per_s"][rows].astype(float)
        if (speed < WALKS_M_PER_S).any():
            costs.append(float("nan"))
            continue
        cost = table["cost_of_transport"][rows].astype(float)
        costs.append(float((cost * speed).sum() / speed.sum()))
    return costs


def spelled(
    values: Sequence[float], digits: int = 2, within: tuple[float, float] = (-np.inf, np.inf)
) -> str:
    """Mean and 95 % interval."""
    values = np.asarray(values)
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return "–"
    if len(values) == 1:
        return f"{values[0]:.{digits}f}"
    estimate = interval(values, within=within)
    text = f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"
    return text.replace("-", "−")


def judged_laws() -> list[str]:
    """Return the laws that are evaluated."""
    present = set(read_csv(OUT / "go1_judged.csv")["law"])
    return [name for name in ALL if name in present]


def judged_text() -> str:
    """Unseen starts at the frequencies of training."""
    lines = [
        "| law | seeds | return per second | speed [m/s] | cost of transport | falls [%] "
        "| in the first 4 s [%] |",
        "|---" * 7 + "|",
    ]
    for law in judged_laws():
        columns = {
            name: of_seeds(law, "unseen starts", name)
            for name in ("return_per_s", "speed_m_per_s", "fell", "fell_early")
        }
        columns["cost_of_transport"] = cost_of_seeds(law, "unseen starts")
        seeds = len(columns["fell"]) if law in LEARNED else "–"
        paid, speed = (spelled(columns[n]) for n in ("return_per_s", "speed_m_per_s"))
        cost = spelled(columns["cost_of_transport"])
        shares = ([100.0 * x for x in columns[name]] for name in ("fell", "fell_early"))
        fell, early = (spelled(share, 0, (0.0, 100.0)) for share in shares)
        lines.append(f"| {law} | {seeds} | {paid} | {speed} | {cost} | {fell} | {early} |")
    return "\n".join(lines) + "\n"


def conditions_text() -> str:
    """Return per second under all conditions."""
    names = {"unseen omega": "ω 10 and 14"}
    titles = [names.get(name, name.replace(" x ", " × ")) for name in CONDITIONS]
    lines = ["| law | " + " | ".join(titles) + " |", "|---" * (1 + len(titles)) + "|"]
    for law in judged_laws():
        cells = [spelled(of_seeds(law, name, "return_per_s")) for name in CONDITIONS]
        lines.append(f"| {law} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def picture() -> None:
    """Learning, speed over the frequency, and cost over the speed."""
    colours = dict(zip(ALL, ("0.25", "0.6", *COLOURS[:2], *COLOURS[4:6]), strict=True))
    with styled():
        figure = new_figure(PAGE_IN, 2.5)
        axes = figure.subplots(1, 3)
        _learning(axes[0], colours)
        _speeds(axes[1], colours)
        _costs(axes[2], colours)
        handles, labels = axes[1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
        save_figure(figure, OUT / "go1.png")


def _learning(ax, colours) -> None:
    curves, sweep = read_csv(OUT / "go1_curves.csv"), read_csv(OUT / "go1_vanilla.csv")
    for law in LEARNED:
        for seed in SEEDS:
            mask = (curves["law"] == law) & (curves["seed"].astype(int) == seed)
            time_s, value = (curves[n][mask].astype(float) for n in ("time_s", "return_per_s"))
            ax.plot(time_s, value, color=colours[law], linewidth=0.8)
    omega, paid = sweep["omega"].astype(float), again_of(sweep)
    level = np.mean([paid[omega == level_omega].max() for level_omega in OMEGAS])
    ax.axhline(level, color=colours[BEST], linestyle="--")
    ax.set_xlabel("simulated time [s]")
    ax.set_ylabel("return per second")


def _speeds(ax, colours) -> None:
    table = read_csv(OUT / "go1_judged.csv")
    omega, speed = (table[name].astype(float) for name in ("omega", "speed_m_per_s"))
    undisturbed = np.isin(table["condition"], ["unseen starts", "unseen omega"])
    for k, law in enumerate(judged_laws()):
        mask = undisturbed & (table["law"] == law)
        every = np.unique(omega[mask])
        estimates = [interval(speed[mask & (omega == command)]) for command in every]
        means = np.array([estimate.mean for estimate in estimates])
        ends = np.nan_to_num([(x.mean - x.low, x.high - x.mean) for x in estimates]).T
        style = {"marker": "o", "markersize": 2.5, "elinewidth": 0.8}
        ax.errorbar(every + 0.12 * (k - 2.5), means, ends, color=colours[law], label=law, **style)
    ax.set_xlabel("ω [rad/s]")
    ax.set_ylabel("speed [m/s]")


def _costs(ax, colours) -> None:
    sweep, judged = read_csv(OUT / "go1_vanilla.csv"), read_csv(OUT / "go1_judged.csv")
    pair = ("speed_m_per_s", "cost_of_transport")
    ax.plot(*(numbers(sweep[name]) for name in pair), ".", color="0.8", markersize=2)
    undisturbed = np.isin(judged["condition"], ["unseen starts", "unseen omega"])
    for law in judged_laws():
        mask = undisturbed & (judged["law"] == law)
        ax.plot(*(numbers(judged[n])[mask] for n in pair), "o", color=colours[law], markersize=2)
    ax.set_ylim(0.0, 6.0)
    ax.set_xlim(left=0.0)
    ax.set_xlabel("speed [m/s]")
    ax.set_ylabel("cost of transport")
