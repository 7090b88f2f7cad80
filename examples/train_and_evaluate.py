"""Train a controller of 96 weights from two seeds, and evaluate it beside the vanilla one.

Twenty generations show that it learns. Hundreds are needed to reach the plateau, and before it hops
alike hop after hop there is no limit cycle: its CoT⁻¹ is then NaN.
"""

import dataclasses

import numpy as np

from tegotae import Timing
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.objectives.fitness import Fitness
from tegotae.systems.recipe import recipe
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import tuned

METRICS = ("cot_inverse", "limit_cycle_share", "failed_share")

model = recipe("ART-rF-tphif-w8")
experiment = model.experiment(
    timing=Timing(duration_s=8.0, tick_s=0.002), objective=Fitness(settle_s=4.0)
)
learner = Evolution(
    algorithm=dataclasses.replace(tuned("pgpe"), population=64), stopping=Stopping.after(20)
)
states = list(Run(experiment=experiment, seeds=(0, 1), learner=learner).learn())
curves = np.array([[point.fitness for point in state.new] for state in states])
learned = [saved.weights for saved in states[-1].learned]

protocol = Protocol(undisturbed_s=12.0, disturbed_s=8.0, offsets=(0.0,))
for name, weights in (("V-reflex-w8", [[2.0]]), (model.name, learned)):
    controller = recipe(name).controller()
    evaluation = evaluate(controller, np.array(weights), 8.0, protocol=protocol, metrics=METRICS)
    means = {
        metric: round(float(statistics.mean), 2)
        for metric, statistics in evaluation.summary().items()
    }
    print(name, means)

with styled():
    figure = new_figure(4.0, 2.4)
    axes = figure.subplots()
    for seed, curve in enumerate(np.maximum.accumulate(curves).T):
        axes.plot(curve, "-" if seed == 0 else "--", color=COLOURS[seed], label=f"seed {seed}")
    axes.set(xlabel="generation", ylabel="best fitness so far [m/J]")
    axes.legend()
save_figure(figure, "train_and_evaluate.png")
assert (curves.max(axis=0) > curves[0]).all()  # both seeds have learned something
