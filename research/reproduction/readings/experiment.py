"""A model under a reading of the paper, as an experiment."""

from __future__ import annotations

import dataclasses

from research.reproduction.readings.readings import Reading
from tegotae.measures.evaluation import Protocol
from tegotae.measures.objectives.fitness import EPISODE, SETTLE_S, Fitness
from tegotae.parts.fields import replace
from tegotae.simulation.rollout import Timing
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import Recipe


def experiment_under(
    reading: Reading,
    model: Recipe,
    *,
    timing: Timing = EPISODE,
    settle_s: float = SETTLE_S,
    protocol: Protocol | None = None,
) -> Experiment:
    """Return the training and evaluation of a model as a reading has them.

    Args:
        reading: what is chosen of all that the paper leaves open.
        model: which of the paper's.
        timing: an episode of training.
        settle_s: time in it before it is evaluated [s].
        protocol: of the evaluation; drop, release and work are the reading's.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> experiment_under(Reading(mass_kg=0.2), recipe("ART")).body.mass_kg
        0.2
    """
    hopper, protocol = reading.hopper, protocol or Protocol()
    length = hopper.rest_length_m
    experiment = model.experiment(
        body=hopper,
        height_m=reading.release * length,
        timing=timing,
        objective=Fitness(
            settle_s=settle_s,
            work=reading.work,
            frequency_weight=reading.frequency_weight,
        ),
        protocol=dataclasses.replace(
            protocol,
            drop_m=reading.drop * length,
            release_m=reading.release * length,
            work=reading.work,
        ),
        search_offsets=reading.tuned_over,
    )
    controller = experiment.controller
    actuation = reading.actuation(controller.actuation)
    if actuation == controller.actuation:
        return experiment
    return replace(experiment, {"controller": dataclasses.replace(controller, actuation=actuation)})
