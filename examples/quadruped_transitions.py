"""A quadruped changes its gait with the frequency; nothing couples its oscillators but its body."""

import numpy as np

from tegotae.analysis.gaits.sweep import sweep
from tegotae.figures.gaits.lags import sweep_figure
from tegotae.figures.style import save_figure
from tegotae.systems.resolve import legged_system as system

sweeps = sweep(system("quadruped-a"), np.linspace(1.5, 2.6, 6), dwell_s=30.0, starts=2)
save_figure(sweep_figure(sweeps, "quadruped-a"), "quadruped_transitions.png")

levels = sweeps.frame.groupby(["direction", "omega_rad_per_s"])
for (direction, omega), rows in levels:
    print(f"{direction} at {omega:.2f} rad/s: {', '.join(sorted(set(rows.gait)))}")
speed = levels.speed_m_per_s.median()["up"]
assert speed.iloc[-1] > speed.iloc[0]  # faster legs, faster walk
