"""Measure how many parameters PGPE trains: 96 to 1024, with unchanged and with scaled settings.

    python -m research.experiments.parameter_limit

writes `parameter_limit.csv`, `parameter_limit_curves.csv` and `parameter_limit.png` to
`research/experiments`. The trainings are kept in
`results/parameter_limit`: interrupted and called again, it goes on from there.

One model is trained at every size, from random weights, with the fitness of all trainings
(CoT⁻¹ + ΔΩ), each run to its plateau. Compared are three ways to choose PGPE's settings:

- `as for 96`: those tuned for 96 parameters, whatever the size;
- `scaled`: the same, but a standard deviation per weight that shrinks with the square root of their
  number. A network's output is a sum over its neurons, so a deviation per weight changes it in
  proportion to the square root of the number of weights. ClipUp's step is a length, that of the
  whole step, and so needs no scaling;
- `pgpelib`: the settings of that library's examples, which the paper may have started from.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import main, write_rows
from tegotae._support.files import output_folder
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.statistics import Interval, interval
from tegotae.systems.recipe import recipe
from tegotae.systems.term_sets import BUDGET
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned

DOCS = Path(__file__).resolve().parents[2] / "docs"
SIZES = (96, 128, 256, 1024)
LARGEST = {"as for 96": 256, "pgpelib": 256}
"""Largest number of parameters of a rule: 1024 take as long as all the rest, and one rule is
enough."""


def unscaled(size: int) -> PGPE:
    """Return the settings tuned for 96 weights, for any number of weights."""
    return tuned("pgpe")


def scaled(size: int) -> PGPE:
    """Return the tuned settings with a deviation for this many weights."""
    settings = tuned("pgpe")
    return dataclasses.replace(settings, std=settings.std * math.sqrt(BUDGET / size))


def pgpelib(size: int) -> PGPE:
    """Step sizes and deviation of pgpelib's examples, with the tuned population."""
    return PGPE(
        population=tuned("pgpe").population,
        std=0.08,
        std_lr=0.1,
        learning_rate=0.075,
        max_speed=0.15,
    )


WAYS: dict[str, Callable[[int], PGPE]] = {
    "as for 96": unscaled,
    "scaled": scaled,
    "pgpelib": pgpelib,
}


@dataclass(frozen=True)
class Trained:
    """The trainings of one size in one way."""

    way: str
    size: int
    n_weights: int
    settings: PGPE
    episode_s: float
    best: np.ndarray
    """Fitness of the best distribution so far, shape [generations, seeds]; NaN if all failed."""
    cot_inverse: np.ndarray
    """CoT⁻¹ of the best distribution in the end [m/J], shape [seeds]."""

    @property
    def simulated_s(self) -> np.ndarray:
        """Simulated time spent after each generation [s]."""
        return np.arange(1, len(self.best) + 1) * self.settings.population * self.episode_s

    @property
    def untrained(self) -> Interval:
        """Fitness of the random weights that the trainings start from."""
        return interval(self.best[0])

    @property
    def fitness(self) -> Interval:
        """Fitness in the end."""
        return interval(self.best[-1])


@dataclass(frozen=True)
class ParameterLimit:
    """Train, and write tables and figure."""

    model: str = "ART-rF-tphif-w4"
    """Model to train."""
    sizes: tuple[int, ...] = SIZES
    """Parameters."""
    ways: tuple[str, ...] = tuple(WAYS)
    """Rules by which PGPE's settings are chosen."""
    seeds: int = 6
    """Trainings of each."""
    generations: int = 480
    """Generations of a training at most."""
    work: Path = Path("results/parameter_limit")
    """Folder of the trainings."""
    out: Path = DOCS.parent / "research" / "experiments"
    """Folder of tables and figure."""

    def run(self) -> None:
        """Run the whole study."""
        output_folder(self.out)
        trainings = [
            self._train(rule, size)
            for size in self.sizes
            for rule in self.ways
            if size <= LARGEST.get(rule, size)
        ]
        write_tables(trainings, self.out)
        save_figure(draw(trainings), self.out / "parameter_limit.png")

    def _train(self, rule: str, size: int) -> Trained:
        model, settings = recipe(self.model), WAYS[rule](size)
        experiment = model.experiment(budget=size)
        episode_s = experiment.timing.duration_s
        stopping = Stopping(generations=self.generations)
        run = Run(
            experiment=experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(algorithm=settings, stopping=stopping),
        )
        folder = self.work / f"{model.name}-{size}-{rule.replace(' ', '-')}"
        train(run, folder)
        curves = pd.read_csv(folder / "curves.csv")
        curves["generation"] = curves.groupby("seed").cumcount()

        def column(name: str) -> np.ndarray:
            """Return a column, [generations, seeds]; NaN after a run's end."""
            return curves.pivot(index="generation", columns="seed", values=name).to_numpy(float)

        fitness = column("fitness")
        # A rollout that failed has a fitness of minus a million, which says nothing in a mean.
        fitness = np.where(fitness > 0.5 * FAILED_FITNESS, fitness, np.nan)
        best = (np.nan_to_num(fitness, nan=FAILED_FITNESS).argmax(axis=0), np.arange(self.seeds))
        return Trained(
            rule,
            size,
            model.controller(size).n_weights,
            settings,
            episode_s,
            np.fmax.accumulate(fitness, axis=0),
            column("cot_inverse")[best],
        )


def write_tables(trainings: list[Trained], out: Path) -> None:
    """Write `parameter_limit.csv`, a row per training, and `parameter_limit_curves.csv`, means over
    seeds.
    """
    rows, curves = [], []
    for t in trainings:
        size = {"way": t.way, "parameters": t.n_weights}
        settings = {
            name: getattr(t.settings, name) for name in ("population", "std", "learning_rate")
        }
        settings |= {name: float(f"{settings[name]:.4g}") for name in ("std", "learning_rate")}
        for seed, (first, last) in enumerate(zip(t.best[0], t.best[-1], strict=True)):
            first, last = np.nan_to_num([first, last], nan=FAILED_FITNESS)
            numbers = {"untrained_fitness": first, "fitness": last}
            numbers["cot_inverse_m_per_j"] = t.cot_inverse[seed]
            rows.append(size | settings | {"seed": seed} | numbers)
        for time_s, row in zip(t.simulated_s, t.best, strict=True):
            i = interval(row)
            numbers = {"simulated_s": time_s, "fitness": i.mean, "low": i.low, "high": i.high}
            curves.append(size | numbers)
    write_rows(out / "parameter_limit.csv", rows, digits=5)
    write_rows(out / "parameter_limit_curves.csv", curves, digits=5)


def draw(trainings: list[Trained]):
    """Draw fitness over the number of parameters, and the learning curves of the scaled
    settings.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.6)
        left_axes, right_axes = figure.subplots(1, 2)
        for shift, rule in enumerate(dict.fromkeys(t.way for t in trainings)):
            selection = [t for t in trainings if t.way == rule]
            x = np.array([t.n_weights for t in selection]) * 1.04 ** (shift - 1)
            i = [t.fitness for t in selection]
            mean = np.array([estimate.mean for estimate in i])
            errors = [
                mean - [estimate.low for estimate in i],
                [estimate.high for estimate in i] - mean,
            ]
            left_axes.errorbar(x, mean, errors, marker="os^"[shift], ms=3, capsize=2, label=rule)
        first = {t.n_weights: t.untrained.mean for t in trainings}
        left_axes.plot(list(first), list(first.values()), ":", color="0.5", label="untrained")
        left_axes.axvline(128, color="0.8", lw=0.8, zorder=0)
        left_axes.set(xscale="log", xlabel="parameters", ylabel="fitness", yscale="symlog")
        left_axes.set_xticks(list(first), [str(n) for n in first])
        left_axes.minorticks_off()
        left_axes.legend()
        drawn_rule = "scaled" if any(t.way == "scaled" for t in trainings) else trainings[0].way
        for t in trainings:
            if t.way == drawn_rule:
                right_axes.plot(
                    t.simulated_s / 1e3, np.nanmean(t.best, axis=1), label=f"{t.n_weights}"
                )
        right_axes.set(
            xlabel="simulated time [1000 s]", title=f"settings {drawn_rule}", yscale="symlog"
        )
        right_axes.legend(title="parameters")
    return figure


if __name__ == "__main__":
    main(ParameterLimit)
