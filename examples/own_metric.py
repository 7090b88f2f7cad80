"""A metric of your own in a study: the mean force that each trained controller gives."""

import dataclasses
from pathlib import Path

import jax.numpy as jnp

from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from research.reproduction.runner import run_study
from research.reproduction.table import tabulate
from tegotae import register
from tegotae.figures.style import new_figure, save_figure, styled
from tegotae.measures.check import check
from tegotae.measures.hopping import Episode, GaitMetric
from tegotae.study import run_locally


def compute(episode: Episode) -> jnp.ndarray:
    """The metric of each lane."""
    return jnp.mean(episode.trajectory.actuator_force_n, axis=0)


mean_force = GaitMetric(
    name="mean_force_n",
    label="mean force",
    unit="N",
    about="mean actuator force",
    more_is_better=False,
    range=(0.0, float("inf")),
    channels=("actuator_force_n",),
    compute=compute,
)
register(mean_force)
check(mean_force)

small = dataclasses.replace(plan("smoke", "ART-*"), metrics=(mean_force,))
run_study(small, Path("study"), run_locally)  # in this process; without it on all cores
records, _ = Folder(Path("study")).all()
table = tabulate(records)

with styled():
    figure = new_figure(4.0, 1.8)
    axes = figure.subplots()
    bars = axes.barh([f"run {run}" for run in table["run"]], table["mean_force_n"], 0.5)
    axes.bar_label(bars, [f"fitness {x:.3f} m/J" for x in table["best_fitness"]], padding=4)
    axes.set(xlabel="mean force [N]", title=table["model"][0], xlim=(0, 0.4))
save_figure(figure, "own_metric.png")
for row in range(len(table)):
    print(f"{table['model'][row]}, run {table['run'][row]}: {table['mean_force_n'][row]:.2f} N")
assert (
    (table["mean_force_n"] > 0.0) & (table["mean_force_n"] <= 4.0)
).all()  # no more than the actuator has
