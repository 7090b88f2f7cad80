"""A user's experiment with several limbs: two legs under a bar, each with its own weights."""

from __future__ import annotations

import dataclasses

from tegotae import Experiment, Timing, build
from tegotae.bodies import Bar
from tegotae.couplings import LearnedCoupling
from tegotae.training.fitness import Fitness

experiment = Experiment(
    name="two-legs",
    controller=dataclasses.replace(
        build("ART", 20), limbs=2, sharing=(0, 1), wiring=(1, 0), coupling=LearnedCoupling()
    ),
    omega=8.0,
    body=Bar(inertia_ratio=0.6),
    phase_rad=(0.0, 2.0),
    posture=(("pitch_rad", 0.05),),
    timing=Timing(duration_s=2.0, tick_s=0.004),
    fitness=Fitness(settle_s=0.5),
)
