"""Measure the robustness of vanilla controllers to conditions that they were not made for.

Each line is a set of eight gains σ; a panel shows the share of them that keep their gait.
"""

import dataclasses

import numpy as np

from tegotae import System, Timing
from tegotae.analysis.generalisation.disturbances import disturbances_named
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import measure_retention
from tegotae.figures.generalisation import curves_figure
from tegotae.figures.style import save_figure
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.recipe import recipe

GAINS = np.linspace(1.0, 6.0, 8)[:, None]
disturbances = disturbances_named(["mass=0.5/0.8/1.25/2", "strength=0.9/0.7/0.5/0.3"])

tables = []
for actuation in ("sector", "reflex"):
    system = System(controller=recipe(f"V-{actuation}-w8").controller(), omega=8.0)
    gains = ControllerSet(actuation, system, GAINS, tuple(f"σ {x:.1f}" for x in GAINS[:, 0]))
    subject = dataclasses.replace(
        ControllersUnderTest.from_runs(gains), looked_at=Timing(duration_s=20.0, tick_s=0.002)
    )
    tables.append((subject, measure_retention(subject, disturbances)))
save_figure(curves_figure(tables, disturbances), "generalise.png")

shares = {}
for subject, outcome in tables:
    weak = outcome.table.query("condition == 'strength' and level == 0.3 and had")
    shares[subject.name] = weak["keeps"].mean()
    print(f"{subject.name}: {shares[subject.name]:.0%} keep their gait with 30 % of the force")
assert shares["reflex"] > shares["sector"]  # the reflex uses less than all of the force
