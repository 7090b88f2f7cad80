"""How long training takes, and with which settings it gets to the plateau soonest.

    python docs/studies/plateau.py                      # all of it; hours on two cores
    python docs/studies/plateau.py --settings pgpe --seeds 2 --models ART-rF-tphif-w4

Every setting trains every model for the same number of episodes, plateau or not. Written are
`docs/_static/plateau.csv`, a row per setting, model and seed, with the best fitness after several
budgets and where the stopping rule of the study would have ended the run, and what it would have
missed; and `plateau.png`.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from matplotlib.figure import Figure

from tegotae.cli.status import exit_status
from tegotae.errors import unknown
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.files import output_folder, write_atomically
from tegotae.models import find
from tegotae.training.algorithms import CMAES, Algorithm, OpenES
from tegotae.training.run import Run
from tegotae.training.settings import configuration
from tegotae.training.stopping import RUNNING, Stopping

DOCS = Path(__file__).resolve().parents[1]

_OWN = configuration("pgpe").settings
_SHORT = configuration("pgpe-80x16").settings

SETTINGS: dict[str, Algorithm] = {
    "pgpe": _OWN,
    "population 64": dataclasses.replace(_OWN, population=64),
    "deviation 0.1": dataclasses.replace(_OWN, std=0.1),
    "pgpe-80x16": _SHORT,
    "cma-es": CMAES(population=32, std=0.2),
    "openai-es": OpenES(population=32),
}
"""What is compared, by name; the first is what the study takes."""

BUDGETS = (1280, 2560, 5120, 10240, 15360)
"""Episodes after which the best fitness is told."""

COLUMNS = ("setting", "model", "seed", *map(str, BUDGETS), "rule_ends", "rule_misses")


@dataclass(frozen=True)
class Plateau:
    """Train, and write the table and the figure."""

    models: tuple[str, ...] = ("AR-rF-sector-w4", "ART-rF-tphif-w4", "T-Fv")
    """What is trained."""
    settings: tuple[str, ...] = tuple(SETTINGS)
    """With which settings."""
    seeds: int = 8
    """Runs of each."""
    out: Path = DOCS / "_static"
    """Folder of table and figure."""

    def run(self) -> None:
        """Do it all."""
        for name in self.settings:
            if name not in SETTINGS:
                raise unknown("setting", name, SETTINGS)
        output_folder(self.out)
        rows: list[tuple] = []
        curves: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]] = {}
        for model in self.models:
            for name in self.settings:
                fitness = self._train(model, SETTINGS[name])
                population = SETTINGS[name].population
                episodes = population * np.arange(1, len(fitness) + 1)
                best = np.maximum.accumulate(fitness, axis=0)
                curves[name, model] = episodes, best
                rows += _rows(name, model, population, fitness, best)
                print(f"{model}, {name}: {np.round(np.sort(best[-1]), 2)}", flush=True)
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
        write_atomically(self.out / "plateau.csv", stream.getvalue())
        save_figure(draw(curves), self.out / "plateau.png")

    def _train(self, model: str, algorithm: Algorithm) -> np.ndarray:
        """Fitness of the distribution's mean, [generations, seeds]."""
        run = Run(
            experiment=find(model).experiment(),
            seeds=tuple(range(self.seeds)),
            stopping=Stopping.after(BUDGETS[-1] // algorithm.population),
            algorithm=algorithm,
        )
        return np.array([curves.centre_fitness for _, curves in run.evolve(run.start())])


def _rows(
    name: str, model: str, population: int, fitness: np.ndarray, best: np.ndarray
) -> list[tuple]:
    # The rule counts generations of 32 episodes.
    rule = Stopping()
    scale = 32 / population
    rule = dataclasses.replace(
        rule, generations=round(rule.generations * scale), least=round(rule.least * scale)
    )
    rows = []
    for seed, (curve, of_seed) in enumerate(zip(fitness.T, best.T, strict=True)):
        done = next(
            (n for n in range(1, len(curve)) if rule.reason(curve[:n]) != RUNNING), len(curve)
        )
        at = [of_seed[min(budget // population, len(of_seed)) - 1] for budget in BUDGETS]
        missed = of_seed[-1] - of_seed[done - 1]
        rows.append(
            (name, model, seed, *(f"{x:.4f}" for x in at), done * population, f"{missed:.4f}")
        )
    return rows


def draw(curves: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]) -> Figure:
    """A panel a model: the mean over runs of the best fitness so far, a line a setting."""
    models = list(dict.fromkeys(model for _, model in curves))
    with styled():
        figure = new_figure(PAGE_IN, 2.4)
        panels = figure.subplots(1, len(models), sharey=True, squeeze=False)[0]
        for panel, model in zip(panels, models, strict=True):
            names = [name for name, of in curves if of == model]
            for colour, name in zip(COLOURS, names, strict=False):
                episodes, best = curves[name, model]
                # What does not hop yet would drown what does.
                mean = np.maximum(best, 0.0).mean(axis=1)
                panel.plot(episodes, mean, color=colour, lw=1.2, label=name)
            panel.set_xscale("log")
            panel.set_title(model, loc="left", fontsize=8)
            panel.set_xlabel("episodes")
        panels[0].set_ylabel("best fitness so far [m/J]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


if __name__ == "__main__":
    sys.exit(exit_status(tyro.cli(Plateau).run))
