"""A hopper under vanilla Tegotae feedback; the ground drops by 0.2 m, and it hops on."""

import numpy as np

from tegotae import Scenario, Timing, build
from tegotae.figures.rollout import rollout_figure
from tegotae.figures.style import save_figure
from tegotae.systems.simulation import Simulation

simulation = Simulation(
    controller=build("V-reflex-w8"),
    weights=np.array([2.0]),  # the gain σ [rad/(s N)]
    scenario=Scenario(omega=8.0, drop_m=0.2, drop_time_s=8.0),
    timing=Timing(duration_s=16.0),
)
result = simulation.run()
save_figure(rollout_figure(result), "hopper.png")

time_s, apex_m, _ = result.apexes
before, after = apex_m[time_s < 8.0][-1], apex_m[-1]
print(f"apex {before:.3f} m before the drop, {after:.3f} m after it")
assert abs(after - (before - 0.2)) < 0.01  # the same hop, 0.2 m lower
