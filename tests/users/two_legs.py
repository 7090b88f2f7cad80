"""A user's experiment with several limbs: two legs under a bar, each with its own weights."""

from __future__ import annotations

import dataclasses

from tegotae import Experiment, System, Timing
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.bodies import Bar
from tegotae.parts.couplings import LearnedCoupling
from tegotae.systems.recipe import recipe
from tegotae.systems.system import Release

experiment = Experiment(
    name="two-legs",
    system=System(
        controller=dataclasses.replace(
            recipe("ART").controller(20),
            limbs=2,
            sharing=(0, 1),
            wiring=(1, 0),
            coupling=LearnedCoupling(),
        ),
        omega=8.0,
        body=Bar(inertia_ratio=0.6),
        release=Release(phase_rad=(0.0, 2.0), initial_pose=(("pitch_rad", 0.05),)),
        timing=Timing(duration_s=2.0, tick_s=0.004),
    ),
    objective=Fitness(settle_s=0.5),
)
