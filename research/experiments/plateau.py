"""Measure the length of training, and find the settings that reach the plateau soonest.

    python -m research.experiments.plateau                      # all of it; 15 min of CPU time
    python -m research.experiments.plateau --settings pgpe --seeds 2 --models ART-rF-tphif-w4

Every setting trains every model for the same number of episodes, plateau or not. Written are
`research/experiments/plateau.csv`, a row per setting, model and seed, with the best fitness after
several budgets and where the first study's stopping rule would have ended the run, and what it
would have missed; the means over runs (`plateau.md`); and `plateau.png`. It is what the study's
settings were chosen by: variants are those of the first study's, whose search began with a
deviation of 0.2.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from research.frame import main, markdown_table, write_text
from tegotae._support.errors import require_known
from tegotae._support.files import output_folder
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import CMAES, Algorithm, OpenES
from tegotae.training.evolution import RUNNING, Evolution, Progress, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import configuration

_OWN = configuration("pgpe").settings
_FIRST = replace(_OWN, std=0.2)
_FIRST_RULE = Stopping(generations=400, least=120)
_SHORT = configuration("pgpe-80x16").settings

Stages = tuple[tuple[Algorithm, float], ...]
"""Algorithms, each with its share of the episodes; each begins at the best mean of the last."""

SETTINGS: dict[str, Stages] = {
    "deviation 0.2": ((_FIRST, 1.0),),
    "population 64": ((replace(_FIRST, population=64), 1.0),),
    "pgpe": ((_OWN, 1.0),),
    "deviation anew": ((_FIRST, 0.5), (_FIRST, 0.5)),
    "64 late": ((_FIRST, 0.5), (replace(_FIRST, population=64, std=0.05), 0.5)),
    "pgpe-80x16": ((_SHORT, 1.0),),
    "cma-es": ((CMAES(population=32, std=0.2), 1.0),),
    "openai-es": ((OpenES(population=32), 1.0),),
}
"""Compared settings, by name: first those of the first study, and as `pgpe` the present ones."""

RESTARTS = "best of two"
"""The first setting once more: of two runs, with half of the episodes each, the better."""

BUDGETS = (1280, 2560, 5120, 10240, 15360)
"""Episodes after which the best fitness is listed."""

COLUMNS = ("setting", "model", "seed", *map(str, BUDGETS), "rule_ends", "rule_misses")


@dataclass(frozen=True)
class Plateau:
    """Train, and write the table and the figure."""

    models: tuple[str, ...] = ("AR-rF-sector-w4", "ART-rF-tphif-w4", "T-Fv")
    """Models to train."""
    settings: tuple[str, ...] = tuple(SETTINGS)
    """Names of the settings."""
    seeds: int = 8
    """Runs of each."""
    out: Path = Path(__file__).parent
    """Folder of table and figure."""

    tables_only: bool = False
    """Only write the means and the figure of the table that is there."""

    def run(self) -> None:
        """Run the whole study."""
        if self.tables_only:
            self._tell()
            return
        for name in self.settings:
            require_known("setting", name, SETTINGS)
        output_folder(self.out)
        rows: list[tuple] = []
        curves: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]] = {}
        for model in self.models:
            for name in self.settings:
                episodes, fitness = self._train(model, SETTINGS[name])
                best = np.maximum.accumulate(fitness, axis=0)
                curves[name, model] = episodes, best
                rows += _rows(name, model, episodes, fitness, best)
                print(f"{model}, {name}: {np.round(np.sort(best[-1]), 2)}", flush=True)
            first = next(iter(SETTINGS))
            if first in self.settings and self.seeds > 1:
                episodes, best = _best_of_two(*curves[first, model])
                curves[RESTARTS, model] = episodes, best
                rows += _rows(RESTARTS, model, episodes, best, best)
        table = pd.DataFrame(rows, columns=list(COLUMNS))
        write_text(self.out / "plateau.csv", table.to_csv(index=False, lineterminator="\n"))
        self._tell()

    def _tell(self) -> None:
        """Write the means of the kept table, and its figure, as the docs show them."""
        table = pd.read_csv(self.out / "plateau.csv")
        save_figure(draw(table), self.out / "plateau.png")
        models = table.model.unique()
        lines = [["", *(title for m in models for title in (f"{m}, 5120", "15 360"))]]
        for name, rows in table.groupby("setting", sort=False):
            cells = []
            for model, budget in itertools.product(models, ("5120", "15360")):
                best = rows[budget][rows.model == model].clip(lower=0.0)
                cells.append(f"{best.mean():.2f} ({best.min():.2f})")
            lines.append([name, *cells])
        write_text(self.out / "plateau.md", markdown_table(lines))

    def _train(self, model: str, stages: Stages) -> tuple[np.ndarray, np.ndarray]:
        """Return the number of episodes after each generation, and the mean's fitness
        [generations, seeds].
        """
        weights, generation = None, 0
        episodes: list[int] = []
        fitness: list[np.ndarray] = []
        for stage, (algorithm, share) in enumerate(stages):
            run = Run(
                experiment=recipe(model).experiment(),
                seeds=tuple(1000 * stage + seed for seed in range(self.seeds)),
                learner=Evolution(
                    algorithm=algorithm,
                    stopping=Stopping.after(round(share * BUDGETS[-1]) // algorithm.population),
                ),
            )
            begun = (
                run.learner.start(run.experiment, run.seeds)
                if weights is None
                else _from(run, weights)
            )
            for reached, curves in run.learner.evolve(run.experiment, run.seeds, begun):
                generation += algorithm.population
                episodes.append(generation)
                fitness.append(curves.centre_fitness)
                weights = np.asarray(reached.best_weights)
        return np.array(episodes), np.array(fitness)


def _from(run: Run, weights: np.ndarray) -> Progress:
    """Return the start of a search around these weights, [seeds, n_weights]."""
    start = run.learner.start(run.experiment, run.seeds)
    keys = jax.vmap(jax.random.key)(jnp.asarray(run.seeds))
    search = jax.vmap(run.learner.algorithm.start)(keys, jnp.asarray(weights))
    return start._replace(search=search, best_weights=weights)


def _best_of_two(episodes: np.ndarray, best: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the better run of each pair, after half of the episodes each."""
    pairs = best[:, : best.shape[1] // 2 * 2].reshape(len(best), -1, 2).max(axis=2)
    half = np.searchsorted(episodes, 0.5 * episodes, side="right") - 1
    return episodes, np.where(half[:, None] >= 0, pairs[half], -np.inf)


def _rows(
    name: str, model: str, episodes: np.ndarray, fitness: np.ndarray, best: np.ndarray
) -> list[tuple]:
    rule = _FIRST_RULE
    rows = []
    for seed, (curve, of_seed) in enumerate(zip(fitness.T, best.T, strict=True)):
        best_at_budget = [
            of_seed[np.searchsorted(episodes, budget, side="right") - 1] for budget in BUDGETS
        ]
        values = [f"{x:.4f}" for x in best_at_budget]
        ends, misses = "", ""
        if name != RESTARTS:
            # The rule counts generations of 32 episodes.
            at_32 = np.searchsorted(episodes, np.arange(32, episodes[-1] + 1, 32))
            score = curve[np.minimum(at_32, len(curve) - 1)]
            solved = next(
                (n for n in range(1, len(score)) if rule.reason(score[:n]) != RUNNING), len(score)
            )
            reached = of_seed[np.searchsorted(episodes, 32 * solved, side="right") - 1]
            ends, misses = 32 * solved, f"{of_seed[-1] - reached:.4f}"
        rows.append((name, model, seed, *values, ends, misses))
    return rows


def draw(table: pd.DataFrame) -> Figure:
    """Draw one panel per model and one row per setting: the best fitness of every run at the end,
    and the means over runs there and after 5120 episodes.
    """
    models, names = table.model.unique(), table.setting.unique()
    with styled():
        figure = new_figure(PAGE_IN, 0.9 + 0.22 * len(names))
        panels = figure.subplots(1, len(models), sharey=True, squeeze=False)[0]
        for panel, model in zip(panels, models, strict=True):
            for row, name in enumerate(names):
                rows = table[(table.setting == name) & (table.model == model)]
                # What does not hop yet would drown what does.
                early, last = (rows[title].clip(lower=0.0) for title in ("5120", "15360"))
                panel.plot(last, np.full(len(last), row), ".", color="0.6", ms=3)
                panel.plot(early.mean(), row, "|", color=COLOURS[1], ms=9, mew=1.6)
                panel.plot(last.mean(), row, "|", color=COLOURS[0], ms=9, mew=1.6)
            panel.set_title(model, loc="left", fontsize=8)
            panel.set_xlabel("best fitness [m/J]")
            panel.tick_params(axis="y", length=0)
        panels[0].set_yticks(range(len(names)), names)
        panels[0].invert_yaxis()
        means = ("a run after 15 360 episodes", "mean after 5120", "mean after 15 360")
        figure.legend(panels[0].lines[:3], means, loc="outside lower center", ncols=3)
    return figure


if __name__ == "__main__":
    main(Plateau)
