"""Map the efficiency of vanilla controllers over gain and frequency: a small copy of Fig. 4."""

import numpy as np

from research.reproduction.figures.gain_map import gain_map_figure
from research.reproduction.ridge import one_to_one_ridge
from tegotae import Timing
from tegotae.analysis.maps import sweep_gain
from tegotae.figures.style import save_figure
from tegotae.systems.recipe import recipe

sigma = np.linspace(0.0, 12.0, 20)  # [rad/(s N)]
omega = np.linspace(2.0, 10.0, 20)  # [rad/s]
sweeps = {
    actuation: sweep_gain(
        recipe(f"V-{actuation}-w4").controller(),
        sigma,
        omega,
        timing=Timing(duration_s=20.0, tick_s=0.002),
    )
    for actuation in ("sector", "reflex")
}
ridges = {name: one_to_one_ridge(table) for name, table in sweeps.items()}
save_figure(gain_map_figure(sweeps, ridges), "gain_map.png")

for name, ridge in ridges.items():
    print(f"{name}: best σ = {ridge.intercept:.2f} + {ridge.slope:.2f} ω")
assert ridges["sector"].slope > 0.0  # the best gain grows with the frequency
