"""Race to a fitness: core-seconds of programs that train the same law, with a cold start.

    python -m research.benchmarks --race docs/_static/benchmarks

Plan, set before the first run: ART with 96 weights on the paper's hopper at 4 rad/s, episodes of
24 s, fitness CoT⁻¹ + ΔΩ. A run is a process without compiled code of earlier ones
(`TEGOTAE_CACHE=off`). It ends when the weights that it has learned, evaluated by this package
outside of the clock, reach 0.6 m/J, or after 60 generations or 190 episodes. Its clock is the
process's CPU time, imports and compilation included. PPO has no reward for a frequency, and
counts by its CoT⁻¹ alone. With seeds side by side the CPU time of a seed is its share of the
process's when it reaches the fitness. The first two programs have ten seeds, one by one and side
by side; the others have five. MJX simulates a hundredth of an episode in each of four generations
of two seeds; its time is extrapolated to the number of generations of ours. Programs alternate,
seed by seed.

The programs are in `rivals.py`. Runs that `race.csv` has are not repeated.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from research.benchmarks.rivals import RIVALS, Rival
from research.frame import Row, Table, markdown_table, with_interval, write_text
from tegotae._support.compiled import VARIABLE as KEPT
from tegotae._support.progress import Console
from tegotae.figures.style import new_figure, save_figure, styled
from tegotae.simulation.rollout import Rollout
from tegotae.systems.recipe import recipe

TARGET = 0.6
"""Fitness at which a run ends [m/J]."""


def run_seeds(name: str, seeds: list[int]) -> list[Row]:
    """Learn in this process, and return one row for each step of each seed."""
    rival, rows, evaluating_s = RIVALS[name], [], 0.0
    reached = np.zeros(len(seeds), bool)
    for step, weights in enumerate(rival.learn(seeds)):
        stepped_s = time.process_time()
        core_s = (stepped_s - evaluating_s) / len(seeds)
        fitness, cot_inverse = evaluated(rival, weights)
        for seed, finished, *values in zip(seeds, reached, fitness, cot_inverse, strict=True):
            if not finished:
                measured = dict(zip(("fitness", "cot_inverse"), map(float, values), strict=True))
                rows.append({"program": name, "seed": seed, "step": step, "core_s": core_s})
                rows[-1] |= measured
        reached |= (cot_inverse if rival.law != RIVALS["tegotae"].law else fitness) >= TARGET
        evaluating_s += time.process_time() - stepped_s
        if step + 1 == rival.steps or (rival.share == 1.0 and reached.all()):
            break
    return rows


def evaluated(rival: Rival, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return fitness and CoT⁻¹ of weights [m/J], [seeds] each; NaN where episodes are not whole."""
    if rival.share < 1.0:
        return np.full(len(weights), np.nan), np.full(len(weights), np.nan)
    trained = recipe(rival.law).experiment()
    rollout = Rollout(controller=rival.controller, timing=trained.timing, summary=trained.measure)
    scores = rollout.run(weights, trained.scenario, trained.body)
    return scores["fitness"], scores["cot_inverse"]


def race(folder: Path) -> Path:
    """Run what the folder's table lacks, and write the table and the picture of the page."""
    table = Table(folder / "race.csv", ("program", "seed"))
    missing = [x.package for x in RIVALS.values() if x.package and not _installed(x.package)]
    for package in missing:
        Console().print(f"the program that needs {package} is left out; install it to run it")
    firsts = [
        (name, seed)
        for seed in range(max(rival.seeds for rival in RIVALS.values()))
        for name, rival in RIVALS.items()
        if rival.package not in missing and seed < rival.seeds and seed % rival.together == 0
    ]
    table.measure(firsts, _measured)
    rows = table.read()
    write_text(folder / "race.md", tabulate(rows))
    return draw(rows, folder / "race.png")


def _installed(module: str) -> bool:
    """Return True if a module can be imported; one inside of a package needs that."""
    package, _, inside = module.partition(".")
    return find_spec(package) is not None and (not inside or find_spec(module) is not None)


def _measured(name: str, seed: int) -> list[Row]:
    """Return the rows of a process that begins with this seed."""
    seeds = [str(seed + k) for k in range(RIVALS[name].together)]
    completed = subprocess.run(
        [sys.executable, "-m", "research.benchmarks.race", name, *seeds],
        env=os.environ | {KEPT: "off"},
        stdout=subprocess.PIPE,
        text=True,
    )
    if completed.returncode:
        Console().print(f"{name} failed with seed {seed}, and is left out")
        return []
    return json.loads(completed.stdout.strip().splitlines()[-1])


def summarise(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one row per run: its start, its cost of a step, its steps, and its core-seconds until
    the fitness is reached, NaN if it is not."""
    ours = rows[rows["program"] == "tegotae"].groupby("seed").size().to_dict()
    runs, by_run = [], list[Any](rows.groupby(["program", "seed"], sort=False))
    for (name, seed), run in by_run:
        rival, core_s = RIVALS[name], run["core_s"].to_numpy()
        step_s = np.median(np.diff(core_s)) if len(core_s) > 1 else np.nan
        start_s = core_s[0] - step_s
        if rival.share < 1.0:
            steps = ours.get(seed, np.nan)
            total = start_s + steps * step_s / rival.share
            step_s = step_s / rival.share
        else:
            value = run["fitness" if rival.law == RIVALS["tegotae"].law else "cot_inverse"]
            steps, total = len(run), core_s[-1] if value.iloc[-1] >= TARGET else np.nan
        runs.append([name, seed, start_s, step_s, steps, total])
    titles = ["program", "seed", "start_s", "step_s", "steps", "core_s"]
    return pd.DataFrame(runs, columns=titles)


def tabulate(rows: pd.DataFrame) -> str:
    """Return the table of the page."""
    runs = summarise(rows)
    ours = runs.loc[runs["program"] == "tegotae", "core_s"].mean()
    titles = ["program", "reached in", "steps", "start [core-s]", "a step [core-s]"]
    lines = [[*titles, "core-s to 0.6 m/J", "this / tegotae"]]
    for name, rival in RIVALS.items():
        part: Any = runs[runs["program"] == name]
        if part.empty:
            continue
        total = part["core_s"].dropna()
        extrapolated = rival.share < 1.0
        reached = "extrapolated" if extrapolated else f"{len(total)} of {len(part)}"
        numbers = [f"{part[x].median():.3g}" for x in ("steps", "start_s", "step_s")]
        ratio = f"{total.mean() / ours:.3g}" if len(total) else ""
        seconds = (
            f"{total.mean():.3g}" if extrapolated else with_interval(total, ".3g", (0.0, np.inf))
        )
        lines.append([rival.title, reached, *numbers, seconds, ratio])
    return markdown_table(lines)


@styled()
def draw(rows: pd.DataFrame, file: Path) -> Path:
    """Draw the best fitness so far over core-seconds, a line per run, a panel per program."""
    names = [name for name, x in RIVALS.items() if x.share == 1.0 and name in set(rows["program"])]
    columns = 4
    figure = new_figure(7.0, 1.9 * -(-len(names) // columns))
    panels = figure.subplots(
        -(-len(names) // columns), columns, sharex=True, sharey=True, squeeze=False
    ).ravel()
    for panel, name in zip(panels, names, strict=False):
        by_frequency = RIVALS[name].law == RIVALS["tegotae"].law
        value = "fitness" if by_frequency else "cot_inverse"
        program: Any = rows[rows["program"] == name]
        for _, run in program.groupby("seed"):
            best = np.maximum.accumulate(run[value].to_numpy())
            panel.step(run["core_s"], best, color="black", linewidth=0.6, where="post")
            panel.plot(run["core_s"].iloc[-1], best[-1], "o", color="black", markersize=2.5)
        panel.axhline(TARGET, color="grey", linewidth=0.6, linestyle=":")
        panel.set_title(RIVALS[name].title.replace(", ", ",\n"), fontsize=7)
        panel.set_xscale("log")
        panel.set_ylim(-1.0, 1.1)
    for panel in panels[len(names) :]:
        panel.remove()
    figure.supxlabel("core-seconds of a seed", fontsize=8)
    figure.supylabel("best fitness so far [m/J]", fontsize=8)
    return save_figure(figure, file)


if __name__ == "__main__":
    print(json.dumps(run_seeds(sys.argv[1], [int(seed) for seed in sys.argv[2:]])))
